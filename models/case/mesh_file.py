"""The `[bladed_disk.mesh]` of a case: a mesh file, and what its groups mean."""

from __future__ import annotations

import os
import re
from typing import Annotated, Any

from pydantic import (
    BeforeValidator,
    Field,
    PlainSerializer,
    PlainValidator,
    StrictStr,
    TypeAdapter,
    ValidationError,
)

from bladewhirl.models.case.materials import BeamSection
from bladewhirl.models.inputs.fields import EXPECTED, Length, expectation
from bladewhirl.models.inputs.table import Table


def _path(value: object) -> str:
    """An absolute path, so that the case means the same file wherever it is read again."""
    if not isinstance(value, str | os.PathLike) or "\0" in os.fspath(value):
        raise expectation('the path of a mesh file such as "stage.msh"')
    return os.path.abspath(value)


class LengthUnit(float):
    """A unit of length [m] that knows how the user wrote it, as messages and files have it."""

    given: object

    def __new__(cls, metres: float, given: object) -> LengthUnit:
        """The unit of so many metres."""
        unit = super().__new__(cls, metres)
        unit.given = given
        return unit

    def __getnewargs__(self) -> Any:
        """What a copy is made of."""
        return float(self), self.given


_LENGTH = TypeAdapter[float](Length)


def _unit(value: object) -> LengthUnit:
    """ "mm" is "1 mm"."""
    if isinstance(value, LengthUnit):
        return value
    named = isinstance(value, str) and re.match(r"\s*[A-Za-zµ]", value)
    try:
        return LengthUnit(_LENGTH.validate_python(f"1 {value}" if named else value), value)
    except ValidationError as error:
        raise expectation(error.errors()[0]["ctx"][EXPECTED]) from None


class MeshSection(BeamSection):
    """What the lines of a group are made of; its sizes have no defaults."""

    width: Length = Field(description="Size out of the plane of motion [m].")
    thickness: Length = Field(description="Size in the plane of motion [m].")


class MeshTable(Table):
    """A mesh file of lines in the plane z = const, and what its groups mean.

    Its groups of nodes and of lines are the stage's sets, by their names.
    """

    file: Annotated[str, BeforeValidator(_path)] = Field(
        description="Gmsh's .msh, .vtu or Abaqus's .inp; its path from the case file's folder."
    )
    unit: Annotated[float, PlainValidator(_unit), PlainSerializer(lambda unit: unit.given)] = Field(
        default=LengthUnit(1.0, 1.0), description='Unit of length in the file, such as "mm" [m].'
    )
    tips: StrictStr = Field(
        default="tips",
        description="Group of nodes: the blade tips, in any order. Blade 0 is the one nearest to"
        " +x, others follow counter-clockwise.",
    )
    centre: StrictStr = Field(
        default="centre", description="Group of nodes: the one at the origin, on the shaft."
    )
    sections: dict[str, MeshSection] = Field(
        default={},
        description="Section of each group of lines, { width, thickness, material }, the last where"
        " it is one of material.named. Lines left out have their sections in the file.",
    )
    tip_radius: Length | None = Field(
        default=None,
        description="Radius that the clearance counts from [m]; the largest of the tips' own when"
        " left out.",
    )

    def __hash__(self) -> int:
        """Of what it holds: a table with a mapping has no hash by itself."""
        return hash(self.model_dump_json())

"""Rectangular beam sections and the stiffnesses they give along a mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Annotated, ClassVar

import numpy as np
from pydantic import ConfigDict

from bladewhirl.meshes import LineMesh
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case_fields import quantity


@dataclass(frozen=True, kw_only=True)
class Section:
    """A rectangular section of one material.

    Raises:
        ValueError: a size or a material constant is not positive.
    """

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid")  # where a case holds one

    width: Annotated[float, quantity("m")]  #: size out of the plane [m]
    thickness: Annotated[float, quantity("m")]  #: size in the plane of motion [m]
    young_modulus: Annotated[float, quantity("Pa")]  #: [Pa]
    density: Annotated[float, quantity("kg/m3")]  #: [kg/m3]

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value > 0.0:
                raise ValueError(f"section {name} must be positive; got {value}")

    @property
    def axial_stiffness(self) -> float:
        """E A [N]."""
        return self.young_modulus * self.width * self.thickness

    @property
    def bending_stiffness(self) -> float:
        """E I for bending in the plane [N m2]."""
        return self.young_modulus * self.width * self.thickness**3 / 12.0

    @property
    def line_mass(self) -> float:
        """Mass per unit length [kg/m]."""
        return self.density * self.width * self.thickness


Taper = Sequence[Section]
"""Sections at equal distances along a member, from end to end, linear in between."""

QUANTITIES = tuple(field.name for field in fields(Section))


def along(sections: Section | Taper, share: FloatArray) -> FloatArray:
    """Width, thickness, Young's modulus and density along a member, (4, shares).

    Args:
        sections: one for the whole member, or a taper.
        share: where, from 0 at the first end to 1 at the second.
    """
    stations = [sections] if isinstance(sections, Section) else list(sections)
    table = np.array([[getattr(station, name) for station in stations] for name in QUANTITIES])
    at = np.linspace(0.0, 1.0, len(stations))
    return np.stack([np.interp(share, at, row) for row in table])


@dataclass(frozen=True, kw_only=True)
class LineProperties:
    """What each line of a mesh is made of: a rectangular section, constant along the line."""

    width: FloatArray  #: out of the plane [m], (lines,)
    thickness: FloatArray  #: in the plane [m], (lines,)
    young_modulus: FloatArray  #: [Pa], (lines,)
    density: FloatArray  #: [kg/m3], (lines,)

    @property
    def axial_stiffness(self) -> FloatArray:
        """E A [N], (lines,)."""
        return self.young_modulus * self.width * self.thickness

    @property
    def bending_stiffness(self) -> FloatArray:
        """E I [N m2], (lines,)."""
        return self.young_modulus * self.width * self.thickness**3 / 12.0

    @property
    def line_mass(self) -> FloatArray:
        """Mass per unit length, rho A [kg/m], (lines,)."""
        return self.density * self.width * self.thickness


def line_properties(mesh: LineMesh, sections: Mapping[str, Section]) -> LineProperties:
    """Spread sections, given by line set, over the lines of a mesh.

    Raises:
        ValueError: a line has no section, or a section names a set the mesh does not have.
    """
    unknown = sorted(set(sections) - set(mesh.line_sets))
    if unknown:
        raise ValueError(
            f"section for unknown line set {unknown[0]!r}; mesh has {[*mesh.line_sets]}"
        )
    table = np.full((len(QUANTITIES), len(mesh.lines)), np.nan)
    for name, section in sections.items():
        table[:, mesh.line_sets[name]] = along(section, np.zeros(1))
    bare = np.flatnonzero(np.isnan(table[0]))
    if bare.size:
        raise ValueError(f"line {bare[0]} (of set {mesh.line_parts[bare[0]]!r}) has no section")
    return LineProperties(**dict(zip(QUANTITIES, table, strict=True)))

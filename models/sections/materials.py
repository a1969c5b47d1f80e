"""The `{ width, thickness }` of a rectangular beam section in a case, and its material."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field, StrictStr

from bladewhirl.models.inputs.fields import Density, Length, Modulus, rows
from bladewhirl.models.inputs.table import Inconsistency, Table


class BeamSection(Table):
    """A rectangular beam section."""

    width: Length = 0.1
    """Size out of the plane of motion [m]."""
    thickness: Length = 0.01
    """Size in the plane of motion [m]."""
    material: StrictStr | None = None
    """Name in material.named; the material of the case by default."""


class NamedMaterial(Table):
    """A material that sections may ask for by name."""

    name: StrictStr
    """Name for use in sections."""
    young_modulus: Modulus
    """Young's modulus [Pa]."""
    density: Density
    """Density [kg/m3]."""
    yield_strength: Modulus | None = Field(default=None, examples=['"600 MPa"'])
    """Stress at which it yields [Pa]: the summary of a run says where that is passed. Nothing
    yields in the model."""


class Material(Table):
    """Material of the bladed disk and the casing, where their sections name no other."""

    young_modulus: Modulus = 2.1e11
    """Young's modulus [Pa] (the paper: "steel")."""
    density: Density = 7800.0
    """Density [kg/m3] (the paper: "steel")."""
    yield_strength: Modulus | None = Field(default=None, examples=['"600 MPa"'])
    """Stress at which it yields [Pa]: the summary of a run says where that is passed. Nothing
    yields in the model."""
    named: Annotated[
        tuple[NamedMaterial, ...],
        rows('{ name = "titanium", young_modulus = "114 GPa", density = 4430.0 }'),
    ] = ()
    """More materials, rows of { name = "titanium", young_modulus = "114 GPa", density = 4430.0 },
    for sections that ask for one: { material = "titanium", ... }."""

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield names that two materials share."""
        names = [one.name for one in self.named]
        if len(set(names)) < len(names):
            yield Inconsistency("named", "a name of its own for each material", ())

    @property
    def lowest_yield_strength(self) -> float | None:
        """Lowest yield strength of the materials that specify one [Pa]."""
        given = [self.yield_strength, *(one.yield_strength for one in self.named)]
        return min((value for value in given if value is not None), default=None)

    def find(self, name: str | None) -> Material | NamedMaterial:
        """A material by name, this one for None.

        Raises:
            KeyError: there is none of that name.
        """
        return self if name is None else {one.name: one for one in self.named}[name]

"""Rectangular beam sections, their materials, and the stiffness and mass of lines of a mesh."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Annotated, ClassVar, Generic, TypeVar

import numpy as np
from pydantic import ConfigDict, Field, StrictStr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.inputs.fields import Density, Length, Modulus, positive, rows
from bladewhirl.models.inputs.table import Table


class BeamSection(Table):
    """A rectangular beam section."""

    width: Length = 0.1
    """Size out of the plane of motion [m]."""
    thickness: Length = 0.01
    """Size in the plane of motion [m]."""
    material: StrictStr | None = None
    """Name in material.named; the material of the case by default."""


class MaterialProperties(Table):
    """Elastic constants, density and limits of the stress; the model remains elastic."""

    young_modulus: Modulus
    """Young's modulus [Pa]."""
    density: Density
    """Density [kg/m3]."""
    yield_strength: Modulus | None = Field(default=None, examples=['"600 MPa"'])
    """Yield strength [Pa]. The summary of a run states where the stress of the motion exceeds it;
    the static stress of centrifugal forces comes in addition, except for a superelement with
    effects of rotation, whose stress includes it."""
    endurance: Modulus | None = Field(default=None, examples=['"250 MPa"'])
    """Endurance limit [Pa], the alternating stress without a mean stress that a blade withstands.
    With the strength it gives the margin against fatigue of every blade."""
    strength: Modulus | None = Field(default=None, examples=['"900 MPa"'])
    """Tensile strength [Pa], which limits the mean stress."""


LIMITS = ("yield_strength", "endurance", "strength")  #: names of the limits of the stress


class NamedMaterial(MaterialProperties):
    """A material to which sections refer by name."""

    name: StrictStr
    """Name by which sections refer to the material."""


class Material(MaterialProperties):
    """Material of all sections of bladed disk and casing that do not name another material."""

    young_modulus: Modulus = 2.1e11
    """Young's modulus [Pa] (the paper: "steel")."""
    density: Density = 7800.0
    """Density [kg/m3] (the paper: "steel")."""
    named: Annotated[
        tuple[NamedMaterial, ...],
        rows('{ name = "titanium", young_modulus = "114 GPa", density = 4430.0 }'),
    ] = ()
    """More materials, rows of { name = "titanium", young_modulus = "114 GPa", density = 4430.0 },
    for sections that name a material: { material = "titanium", ... }."""

    @property
    def lowest_limits(self) -> dict[str, float]:
        """Lowest of the values that the materials give for each limit of the stress [Pa]."""
        each = {name: [getattr(one, name) for one in (self, *self.named)] for name in LIMITS}
        given = {name: [one for one in values if one is not None] for name, values in each.items()}
        return {name: min(values) for name, values in given.items() if values}

    def find(self, name: str | None) -> "Material | NamedMaterial":
        """Return the material with a name; this material if the name is None.

        Raises:
            KeyError: no material has that name.
        """
        return self if name is None else {one.name: one for one in self.named}[name]

    def section(self, given: BeamSection) -> "Section":
        """Return a section of the case together with the properties of its material."""
        named = self.find(given.material)
        return Section(
            width=given.width,
            thickness=given.thickness,
            young_modulus=named.young_modulus,
            density=named.density,
        )


Size = TypeVar("Size", float, FloatArray)


@dataclass(frozen=True, kw_only=True)
class Rectangle(Generic[Size]):
    """Rectangular sections; all quantities are numbers, or arrays of the same shape."""

    width: Size  #: size out of the plane of motion [m]
    thickness: Size  #: size in the plane of motion [m]
    young_modulus: Size  #: Young's modulus [Pa]
    density: Size  #: density [kg/m3]

    @property
    def axial_stiffness(self) -> Size:
        """Axial stiffness E A [N]."""
        return self.young_modulus * self.width * self.thickness

    @property
    def bending_stiffness(self) -> Size:
        """Stiffness E I for bending in the plane [N m2]."""
        return self.young_modulus * self.width * self.thickness**3 / 12.0

    @property
    def line_mass(self) -> Size:
        """Mass per unit length, rho A [kg/m]."""
        return self.density * self.width * self.thickness


@dataclass(frozen=True, kw_only=True, init=False)
class Section(Rectangle[float]):
    """A rectangular section of one material.

        Section(width="120 mm", thickness="8 mm", material=Material())

    Values are numbers in SI units, or text with a unit.

    Args:
        width: size out of the plane of motion [m].
        thickness: size in the plane of motion [m].
        young_modulus: Young's modulus [Pa].
        density: density [kg/m3].
        material: material with Young's modulus and density, in place of these two arguments;
            `Material()` is steel. The material must have no limits of the stress, which are given
            in the case.

    Raises:
        CaseError: a value is not positive, has a wrong unit, is missing or is given twice, or the
            material has limits of the stress.
    """

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid")  # for sections in a case

    width: Length  #: size out of the plane of motion [m]
    thickness: Length  #: size in the plane of motion [m]
    young_modulus: Modulus  #: Young's modulus [Pa]
    density: Density  #: density [kg/m3]

    def __init__(
        self,
        *,
        width: float | str,
        thickness: float | str,
        young_modulus: float | str | None = None,
        density: float | str | None = None,
        material: Material | NamedMaterial | None = None,
    ) -> None:
        if material is not None:
            if young_modulus is not None or density is not None:
                expected = "either material, or young_modulus and density, not both"
                raise CaseError([Fault(key="section.material", expected=expected)])
            if limits := [name for name in LIMITS if getattr(material, name) is not None]:
                expected = (
                    f"a material without {limits[0]}, which belongs in the case:"
                    f' sketch.case(material={{"{limits[0]}": ...}})'
                )
                raise CaseError([Fault(key="section.material", expected=expected)])
            young_modulus, density = material.young_modulus, material.density
        elif young_modulus is None or density is None:
            expected = "a material, such as Material() for steel, or young_modulus and density"
            raise CaseError([Fault(key="section", expected=expected)])
        given = {
            "width": (width, "m"),
            "thickness": (thickness, "m"),
            "young_modulus": (young_modulus, "Pa"),
            "density": (density, "kg/m3"),
        }
        for name, (value, unit) in given.items():
            object.__setattr__(self, name, positive(f"section.{name}", value, unit))


Taper = Sequence[Section]
"""Sections at equal distances from end to end of a member, with linear interpolation between."""

QUANTITIES = tuple(each.name for each in fields(Section))

CHANGES = tuple(f"{name}_change" for name in QUANTITIES)
"""Names, in `LineProperties` and mesh files, of the changes of the quantities along a line."""


def along(sections: Section | Taper, share: FloatArray) -> FloatArray:
    """Return width, thickness, Young's modulus and density along a member, (4, shares).

    Args:
        sections: one section for the entire member, or a taper.
        share: positions from 0 at the first end to 1 at the second, (shares,).
    """
    stations = [sections] if isinstance(sections, Section) else list(sections)
    table = np.array([[getattr(station, name) for station in stations] for name in QUANTITIES])
    at = np.linspace(0.0, 1.0, len(stations))
    return np.stack([np.interp(share, at, row) for row in table])


def along_elements(sections: Section | Taper, elements: int) -> tuple[FloatArray, FloatArray]:
    """Approximate the sections along a member by a linear function in each of its equal elements.

    If a section of a taper is inside an element, the linear function is the least-squares fit. The
    slope of the fit is limited so that no end value is below half of the smallest value of the
    taper in that element.

    Returns:
        values at the middles of the elements, and changes from end to end, both (4, elements).
    """
    if isinstance(sections, Section) or len(sections) == 1:
        return along(sections, np.full(elements, 0.5)), np.zeros((len(QUANTITIES), elements))
    edges = np.linspace(0.0, 1.0, elements + 1)
    corners = np.union1d(edges, np.linspace(0.0, 1.0, len(sections)))
    values = along(sections, corners)
    element = np.clip(np.searchsorted(edges, corners[:-1], side="right") - 1, 0, elements - 1)
    starts = np.searchsorted(element, np.arange(elements))
    # Ends of each interval without a kink, from -1/2 to 1/2 in the element that contains it.
    low, high = (side * elements - element - 0.5 for side in (corners[:-1], corners[1:]))
    first, second = values[:, :-1], values[:, 1:]
    middle = (high - low) * (first + second) / 2.0
    moment = (low * first + (low + high) * (first + second) + high * second) / 6.0
    mean = np.add.reduceat(middle, starts, axis=1)
    change = 12.0 * np.add.reduceat((high - low) * moment, starts, axis=1)
    smallest = np.minimum.reduceat(np.minimum(first, second), starts, axis=1)
    largest = np.maximum.reduceat(np.maximum(first, second), starts, axis=1)
    constant = smallest == largest  # then `smallest` is free of rounding errors
    largest_end = np.where(constant, 0.0, 2.0 * mean - smallest)
    return np.where(constant, smallest, mean), np.clip(change, -largest_end, largest_end)


@dataclass(frozen=True, kw_only=True)
class LineProperties(Rectangle[FloatArray]):
    """Sections of the lines of a mesh: values at the middles of the lines, (lines,), and linear
    changes from the first to the second end."""

    width_change: FloatArray  #: change [m], (lines,)
    thickness_change: FloatArray  #: change [m], (lines,)
    young_modulus_change: FloatArray  #: change [Pa], (lines,)
    density_change: FloatArray  #: change [kg/m3], (lines,)

    def at(self, places: FloatArray) -> Rectangle[FloatArray]:
        """Return the sections at positions along every line, arrays (lines, places).

        Args:
            places: positions from 0 at the first end of a line to 1 at the second, (places,).
        """
        shift = np.asarray(places) - 0.5
        return Rectangle(
            **{
                name: getattr(self, name)[:, None] + getattr(self, change)[:, None] * shift
                for name, change in zip(QUANTITIES, CHANGES, strict=True)
            }
        )

    @property
    def mean_line_mass(self) -> FloatArray:
        """Mean mass per unit length of each line [kg/m], (lines,)."""
        ends = self.at(np.array([0.0, 1.0])).line_mass
        return np.asarray((ends.sum(axis=1) + 4.0 * self.line_mass) / 6.0)  # exact for cubics

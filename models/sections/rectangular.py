"""Rectangular beam sections and the stiffnesses they give along a mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Annotated, ClassVar

import numpy as np
from pydantic import ConfigDict

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.fields import quantity


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

QUANTITIES = tuple(each.name for each in fields(Section))

CHANGES = tuple(f"{name}_change" for name in QUANTITIES)
"""Changes of the quantities along a line, as `LineProperties` and mesh files hold them."""


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


def along_elements(sections: Section | Taper, elements: int) -> tuple[FloatArray, FloatArray]:
    """What equal elements of a member are made of, linear in each: values at the middles of the
    elements and changes from end to end, both (4, elements).

    Where a station of a taper lies inside an element, its straight line is the one nearest in the
    mean square, made less steep where it would fall below half of the least that is there.
    """
    if isinstance(sections, Section) or len(sections) == 1:
        return along(sections, np.full(elements, 0.5)), np.zeros((len(QUANTITIES), elements))
    edges = np.linspace(0.0, 1.0, elements + 1)
    corners = np.union1d(edges, np.linspace(0.0, 1.0, len(sections)))
    values = along(sections, corners)
    element = np.clip(np.searchsorted(edges, corners[:-1], side="right") - 1, 0, elements - 1)
    starts = np.searchsorted(element, np.arange(elements))
    # Places of the corners in their element, -1/2 to 1/2, at both ends of each straight piece.
    low, high = (side * elements - element - 0.5 for side in (corners[:-1], corners[1:]))
    first, second = values[:, :-1], values[:, 1:]
    middle = (high - low) * (first + second) / 2.0
    moment = (low * first + (low + high) * (first + second) + high * second) / 6.0
    mean = np.add.reduceat(middle, starts, axis=1)
    change = 12.0 * np.add.reduceat((high - low) * moment, starts, axis=1)
    smallest = np.minimum.reduceat(np.minimum(first, second), starts, axis=1)
    largest = np.maximum.reduceat(np.maximum(first, second), starts, axis=1)
    room = np.where(smallest == largest, 0.0, 2.0 * mean - smallest)  # constant without rounding
    return np.where(smallest == largest, smallest, mean), np.clip(change, -room, room)


@dataclass(frozen=True, kw_only=True)
class SectionArrays:
    """Rectangular sections at many places, arrays of one shape."""

    width: FloatArray  #: out of the plane [m]
    thickness: FloatArray  #: in the plane [m]
    young_modulus: FloatArray  #: [Pa]
    density: FloatArray  #: [kg/m3]

    @property
    def axial_stiffness(self) -> FloatArray:
        """E A [N]."""
        return self.young_modulus * self.width * self.thickness

    @property
    def bending_stiffness(self) -> FloatArray:
        """E I [N m2]."""
        return self.young_modulus * self.width * self.thickness**3 / 12.0

    @property
    def line_mass(self) -> FloatArray:
        """Mass per unit length, rho A [kg/m]."""
        return self.density * self.width * self.thickness


def _unset() -> FloatArray:
    return np.zeros(0)


@dataclass(frozen=True, kw_only=True)
class LineProperties(SectionArrays):
    """What each line of a mesh is made of: sections at the middles of the lines, (lines,), and how
    much they change from the first to the second end, linear in between: not at all, if left out.
    """

    width_change: FloatArray = field(default_factory=_unset)  #: [m], (lines,)
    thickness_change: FloatArray = field(default_factory=_unset)  #: [m], (lines,)
    young_modulus_change: FloatArray = field(default_factory=_unset)  #: [Pa], (lines,)
    density_change: FloatArray = field(default_factory=_unset)  #: [kg/m3], (lines,)

    def __post_init__(self) -> None:
        for name in CHANGES:
            if not len(getattr(self, name)):
                object.__setattr__(self, name, np.zeros(len(self.width)))

    def at(self, places: FloatArray) -> SectionArrays:
        """Sections at places of every line, 0 at its first end to 1, arrays (lines, places)."""
        shift = np.asarray(places) - 0.5
        return SectionArrays(
            **{
                name: getattr(self, name)[:, None] + getattr(self, change)[:, None] * shift
                for name, change in zip(QUANTITIES, CHANGES, strict=True)
            }
        )

    @property
    def mean_line_mass(self) -> FloatArray:
        """Mass over length of each line [kg/m], (lines,)."""
        ends = self.at(np.array([0.0, 1.0])).line_mass
        return np.asarray((ends.sum(axis=1) + 4.0 * self.line_mass) / 6.0)  # a cubic: exact

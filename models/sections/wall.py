"""The wall of a casing: its section as a function of the angle, and what elements make of it.

Stiffness and mass are integrated with the section at the quadrature points, so a smooth wall
converges as a uniform one does (fourth order in the frequencies). A quadrature point stands for
the stretch of its element that its weight covers. Where an arc ends inside such a stretch, the
point takes each side's stiffness and mass in proportion: masses are exact and nothing jumps as
the end is moved, but the elements can't bend as the true wall does there. Arcs that end at nodes
keep the fourth order; others have the first (a per cent, where the thickness doubles inside an
element of 9 degrees).

All sections are centred on the same circle: a one-sided rib bends the wall less than in truth.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import RingMesh
from bladewhirl.models.inputs.fields import Angle, Density, Length, LengthOrZero, Modulus, count
from bladewhirl.models.inputs.table import Inconsistency, Table
from bladewhirl.models.sections.rectangular import Rectangle, Section

FINE = 7200
"""Angles at which the smallest value is looked for: a twentieth of a degree apart."""


class Lobe(Table):
    """Waves around the ring: amplitude * cos(lobes * (angle - phase)); 2 lobes are an ellipse."""

    lobes: Annotated[int, count(1)]
    """Number of waves around the ring."""
    amplitude: LengthOrZero
    """Height of a crest [m]."""
    phase: Angle = 0.0
    """Angle of a crest from the x axis [rad]."""


@dataclass(frozen=True, kw_only=True)
class RingProfile:
    """A function of the angle: linear between stations, or constant, plus lobes."""

    mean: float  #: where there are no stations
    lobes: tuple[Lobe, ...] = ()
    stations: tuple[tuple[float, float], ...] = ()  #: angle [rad] and value; replace the mean

    def value(self, angle: ArrayLike) -> FloatArray:
        """Values at angles [rad], of their shape."""
        theta = np.asarray(angle, dtype=np.float64)
        total = np.full(theta.shape, self.mean)
        if self.stations:
            places, values = np.array(self.stations).T
            total = np.interp(theta, places, values, period=2.0 * np.pi)
        for wave in self.lobes:
            total = total + wave.amplitude * np.cos(wave.lobes * (theta - wave.phase))
        return np.asarray(total)

    def lobe_slope(self, angle: ArrayLike) -> FloatArray:
        """Derivative of the lobes by the angle, at angles [rad]."""
        theta = np.asarray(angle, dtype=np.float64)
        slope = np.zeros(theta.shape)
        for wave in self.lobes:
            slope -= wave.amplitude * wave.lobes * np.sin(wave.lobes * (theta - wave.phase))
        return slope

    @property
    def smallest(self) -> float:
        """Smallest value on the ring, to the second order of a twentieth of a degree."""
        return float(self.value(np.linspace(0.0, 2.0 * np.pi, FINE, endpoint=False)).min())


TURN = 2.0 * np.pi


@dataclass(frozen=True, kw_only=True)
class WallProperties:
    """Stiffness and mass of a wall, arrays of one shape: (elements,) or (elements, points)."""

    axial_stiffness: FloatArray  #: E A [N]
    bending_stiffness: FloatArray  #: E I [N m2]
    line_mass: FloatArray  #: rho A [kg/m]
    thickness: FloatArray  #: in the plane [m]
    width: FloatArray  #: out of the plane [m]
    young_modulus: FloatArray  #: [Pa]

    def mean(self, weights: FloatArray) -> WallProperties:
        """Means over the points of each element, whose weights have sum one."""
        return WallProperties(**{name: values @ weights for name, values in vars(self).items()})


class Arc(Table):
    """A stretch of wall of another section or material; keys left out are as elsewhere."""

    start: Angle
    """Angle from the x axis at which it begins [rad]."""
    end: Angle
    """Angle at which it ends, at most a turn further on [rad]."""
    thickness: Length | None = None
    """Size in the plane [m]."""
    width: Length | None = None
    """Size out of the plane [m]."""
    young_modulus: Modulus | None = None
    """Young's modulus [Pa]."""
    density: Density | None = None
    """Density [kg/m3]."""

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """An arc without length or of more than a turn."""
        if not 0.0 < self.end - self.start <= TURN:
            expected = f"more than start = {self.start:.6g} rad and at most a turn further on"
            yield Inconsistency("end", expected, ("start",))

    def share(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the share of the intervals from ``low`` to ``high`` (within [0, 2 pi]) inside the
        arc."""
        start = np.mod(self.start, TURN)
        inside = np.zeros(np.broadcast_shapes(low.shape, high.shape))
        for turn in (-TURN, 0.0):  # it begins in [0, 2 pi), so it may reach into a second turn
            first, last = start + turn, start + turn + self.end - self.start
            inside += np.maximum(0.0, np.minimum(high, last) - np.maximum(low, first))
        return np.asarray(inside / (high - low))


@dataclass(frozen=True, kw_only=True)
class Wall:
    """A wall: one section all around, with a thickness that varies and arcs that differ."""

    section: Section
    thickness: RingProfile | None = None  #: replaces that of the section [m]
    arcs: tuple[Arc, ...] = ()  #: they do not overlap

    def properties(self, mesh: RingMesh, points: FloatArray, weights: FloatArray) -> WallProperties:
        """Properties at points of each element, (elements, points).

        Args:
            mesh: the ring.
            points: places of the points in an element, 0 to 1, ascending, (points,).
            weights: of the points, with sum one.
        """
        pitch = TURN / mesh.elements
        edges = np.concatenate([[0.0], np.cumsum(weights)])
        low, high = (mesh.angles[:, None] + pitch * edge for edge in (edges[:-1], edges[1:]))
        thickness = np.full((mesh.elements, len(points)), self.section.thickness)
        if self.thickness is not None:
            thickness = self.thickness.value(mesh.angles[:, None] + pitch * points)
        shares = [arc.share(low, high) for arc in self.arcs]
        mixed = {
            name: (1.0 - np.sum(shares, axis=0)) * values
            for name, values in _quantities(self.section, thickness).items()
        }
        for arc, share in zip(self.arcs, shares, strict=True):
            for name, values in _quantities(self.section, thickness, arc).items():
                mixed[name] = mixed[name] + share * values
        return WallProperties(**mixed)


def _quantities(
    section: Section, thickness: FloatArray, arc: Arc | None = None
) -> dict[str, FloatArray]:
    """Fields of `WallProperties` for a section with that thickness, or for an arc."""

    def given(name: str, otherwise: float | FloatArray) -> FloatArray:
        value = None if arc is None else getattr(arc, name)
        return np.broadcast_to(otherwise if value is None else value, thickness.shape)

    values = Rectangle(
        thickness=given("thickness", thickness),
        **{
            name: given(name, getattr(section, name))
            for name in ("width", "young_modulus", "density")
        },
    )
    return {item.name: getattr(values, item.name) for item in fields(WallProperties)}

"""The wall of a casing: its section as a function of the angle, and the mean over elements.

Stiffness and mass are integrated with the section at the quadrature points. The frequencies of a
smooth wall therefore converge with fourth order, as for a uniform wall. A quadrature point
represents a part of its element, in proportion to its weight. If an arc ends inside this part, the
stiffness and mass of both sides are averaged by length: masses are exact and results do not jump
when the end is moved, but the element bends differently from the true wall. The order remains four
if all arcs end at nodes; otherwise it is one (an error of one per cent where the thickness doubles
inside an element of 9 degrees).

All sections are centred on the same circle. The model therefore omits the additional bending due to
the eccentricity of a one-sided rib.
"""

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import RingMesh
from bladewhirl.models.inputs.fields import (
    Angle,
    Density,
    Length,
    LengthOrZero,
    Modulus,
    count,
    rows,
)
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.sections.rectangular import Rectangle, Section

TURN = 2.0 * np.pi

FINE = 7200  #: number of angles at which a profile is evaluated to find its smallest value


class Lobe(Table):
    """Waves around the ring: amplitude * cos(lobes * (angle - phase)); 2 lobes are an ellipse."""

    lobes: Annotated[int, count(1)]
    """Number of waves around the ring."""
    amplitude: LengthOrZero
    """Height of a crest [m]."""
    phase: Angle = 0.0
    """Angle of a crest from the x axis [rad]."""


LobeRows = Annotated[
    tuple[Lobe, ...], rows('{ lobes = 2, amplitude = "0.2 mm", phase = "30 deg" }')
]


@dataclass(frozen=True, kw_only=True)
class RingProfile:
    """A function of the angle: a constant, a linear interpolation between stations, or a periodic
    cubic spline through points; and lobes, which are added."""

    mean: float  #: constant value, used without stations and points
    lobes: tuple[Lobe, ...] = ()
    stations: tuple[tuple[float, float], ...] = ()  #: angles [rad] and values that replace `mean`
    points: tuple[tuple[float, float], ...] = ()  #: angles [rad] and values that replace `mean`

    @cached_property
    def _spline(self) -> Any:
        from scipy.interpolate import CubicSpline  # long to load

        angles, values = np.array(self.points).T
        angles = np.mod(angles, TURN)
        order = np.argsort(angles)
        closed = [*order.tolist(), int(order[0])]
        places = np.append(angles[order], angles[order[0]] + TURN)
        return CubicSpline(places, values[closed], bc_type="periodic")

    def value(self, angle: ArrayLike) -> FloatArray:
        """Return the values at angles [rad], in the shape of the angles."""
        theta = np.asarray(angle, dtype=np.float64)
        total = np.full(theta.shape, self.mean)
        if self.stations:
            places, values = np.array(self.stations).T
            total = np.interp(theta, places, values, period=2.0 * np.pi)
        elif self.points:
            total = self._spline(theta)
        for wave in self.lobes:
            total = total + wave.amplitude * np.cos(wave.lobes * (theta - wave.phase))
        return np.asarray(total)

    def slope(self, angle: ArrayLike) -> FloatArray:
        """Return d(value)/d(angle), per rad, at angles [rad], in the shape of the angles: the slope
        of the spline through `points` plus that of `lobes`. The slope between `stations` is not
        included."""
        theta = np.asarray(angle, dtype=np.float64)
        slope = self._spline(theta, 1) if self.points else np.zeros(theta.shape)
        for wave in self.lobes:
            slope = slope - wave.amplitude * wave.lobes * np.sin(wave.lobes * (theta - wave.phase))
        return np.asarray(slope)

    @property
    def smallest(self) -> float:
        """Smallest of the values on the ring at steps of a twentieth of a degree."""
        return float(self.value(np.linspace(0.0, TURN, FINE, endpoint=False)).min())


@dataclass(frozen=True, kw_only=True)
class WallProperties:
    """Stiffness and mass of a wall; all arrays have the shape (elements,) or (elements, points)."""

    axial_stiffness: FloatArray  #: E A [N]
    bending_stiffness: FloatArray  #: E I [N m2]
    line_mass: FloatArray  #: rho A [kg/m]
    thickness: FloatArray  #: size in the plane [m]
    width: FloatArray  #: size out of the plane [m]
    young_modulus: FloatArray  #: Young's modulus [Pa]

    def mean(self, weights: FloatArray) -> "WallProperties":
        """Return the weighted means over the points of each element; the weights add up to one."""
        return WallProperties(**{name: values @ weights for name, values in vars(self).items()})


class Arc(Table):
    """An arc of wall with another section or material. Keys that are left out have the values of
    the wall."""

    start: Angle
    """Angle from the x axis at which the arc begins [rad]."""
    end: Angle
    """Angle at which the arc ends, at most one turn after `start` [rad]."""
    thickness: Length | None = None
    """Size in the plane [m]."""
    width: Length | None = None
    """Size out of the plane [m]."""
    young_modulus: Modulus | None = None
    """Young's modulus [Pa]."""
    density: Density | None = None
    """Density [kg/m3]."""

    def share(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the share of each interval that is inside the arc, in the shape of the intervals.

        Args:
            low: start of each interval, from 0 to 2 pi [rad].
            high: end of each interval, from 0 to 2 pi [rad].
        """
        start = np.mod(self.start, TURN)
        inside = np.zeros(np.broadcast_shapes(low.shape, high.shape))
        for turn in (-TURN, 0.0):  # the arc begins in [0, 2 pi) and may reach into a second turn
            first, last = start + turn, start + turn + self.end - self.start
            inside += np.maximum(0.0, np.minimum(high, last) - np.maximum(low, first))
        return np.asarray(inside / (high - low))


@dataclass(frozen=True, kw_only=True)
class Wall:
    """A wall with a section, a varying thickness and arcs of other sections."""

    section: Section
    thickness: RingProfile | None = None  #: replaces the thickness of the section [m]
    arcs: tuple[Arc, ...] = ()  #: arcs of other sections, which do not overlap

    def properties(self, mesh: RingMesh, points: FloatArray, weights: FloatArray) -> WallProperties:
        """Return the properties at points of each element, arrays (elements, points).

        Args:
            mesh: the ring.
            points: positions of the points in an element, from 0 to 1, ascending, (points,).
            weights: weights of the points, with sum one, (points,).
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
    """Return the fields of `WallProperties` for a section of a given thickness, or for an arc."""

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

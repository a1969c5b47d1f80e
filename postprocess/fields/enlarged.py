"""Drawn positions of rotor and casing, with displacements and clearance multiplied by one factor.

A clearance of 1 mm on a radius of 0.5 m is invisible, and so are displacements of this size. Both
the displacements and the clearance are therefore multiplied by the same factor: the inner wall of
the casing is drawn at tip radius + factor (clearance + w), a tip at tip radius + factor u_r. The
drawn gap is the factor times the true gap, so bodies touch in the picture exactly when they touch
in the run. If a tip does not lie on the tip radius, its distance from that radius is multiplied by
the factor as well. Thicknesses are true to scale. The end of a blade is cut parallel to the wall
that it faces, so that no corner of the blade reaches the wall before the tip does.

Small displacements are no longer small after multiplication. Each body is therefore first shifted
along a straight line by its mean motion: the motion of the centre for the rotor, the mean over the
circumference for the casing. The remaining displacement is drawn in polar coordinates about the
shifted centre, (r, theta) -> (r + factor u_r, theta + factor u_theta / r). A bent blade thus swings
along an arc and keeps its length, as it does in the linear model. With `contact.foreshortening` the
distance d by which each point of a blade draws back, of second order in the true displacement, is
drawn with the same factor, r + factor (u_r - d), so that the drawn gap remains the factor times the
gap of the march.

Points of a surface are drawn in the same way, and their axial displacement is multiplied as well.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.models.case.casing import Casing
from bladewhirl.postprocess.fields import kinematics
from bladewhirl.postprocess.fields.blades import line_blades, with_recess
from bladewhirl.postprocess.fields.drawback import drawn_back
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, history
from bladewhirl.postprocess.fields.lost_blades import Lost, lost_blades
from bladewhirl.postprocess.fields.strains import rotor_sections

#: drawn clearance divided by the tip radius, if the factor is chosen automatically
DRAWN_CLEARANCE = 0.1
#: largest drawn displacement divided by the tip radius, if the factor is chosen automatically
DRAWN_MOTION = 0.25
#: drawn thickness of a rigid wall divided by the tip radius
RIGID = 0.02

MOST = 1e9  #: largest factor; 1 / MOST is the smallest factor


class EnlargedWall:
    """Drawn positions of the wall at chosen records, in static axes, with displacements and
    clearance multiplied. A rigid wall has no motion of its own.

    Args:
        dataset: a result.
        records: numbers of records.
        factor: factor of displacements and clearance; chosen by `round_factor` when None.
        per_element: number of pieces into which each element of the casing, or a whole rigid wall,
            is divided.

    Raises:
        ViewError: the factor is not positive, larger than `MOST`, or smaller than the inverse of
            `MOST`.
    """

    def __init__(
        self, dataset: xr.Dataset, records: IntArray, *, factor: float | None, per_element: int
    ) -> None:
        if factor is not None and not 1.0 / MOST <= factor <= MOST:
            raise ViewError(
                f"exaggeration must be a positive number, {1.0 / MOST:g} to {MOST:g}, got {factor}"
            )
        self._dataset = dataset
        self.factor = factor or 1.0
        self._chosen = factor
        self.tip_radius = float(dataset.attrs["tip_radius"])
        #: angle from the casing's to the rotor's axes (record,) [rad]
        self.turns = kinematics.turn(dataset, records)
        self.angle = kinematics.wall_angles(dataset, per_element)
        if "casing_shape" in dataset:
            ring = kinematics.combine(
                history(dataset, "casing_displacement", records),
                kinematics.casing_rows(dataset, self.angle),
            )
            self.ring_displacement = rotate(ring, self.angle)
            self.wall_thickness = np.repeat(dataset["casing_thickness"].values, per_element)
        else:
            self.ring_displacement = np.zeros((len(records), per_element, 2))
            self.wall_thickness = np.full(per_element, RIGID * self.tip_radius)
        self._closure = kinematics.closure_change(dataset, records, self.angle)
        coating = kinematics.table_of_result(dataset, "casing", Casing).coating
        if "coating_strain" not in dataset:
            coating = None
        self.coating = coating.thickness if coating else 0.0  #: thickness of the coating [m]
        #: removed depth of the coating (record, track, station) [m]; without it there is no track
        self.wear = np.zeros((len(records), 0, len(self.angle)))
        if coating is not None:
            self.wear = self.coating * kinematics.track_strains(dataset, records, self.angle)

    def _enlarge(self, size: float, radius: float, rotor_displacement: float) -> None:
        """Choose the factor for a stage or blade of a size [m] from the largest displacement of the
        rotor [m] and of the wall, and from the clearance, which is measured from a radius [m]."""
        ring = float(np.linalg.norm(self.ring_displacement, axis=-1).max())
        self.largest_displacement = max(rotor_displacement, ring)
        clearance = kinematics.clearance_at(self._dataset, self.angle)
        recess = float(np.max(self._dataset["tip_recess"].values, initial=0.0))
        self.factor = self._chosen or round_factor(
            size,
            (DRAWN_CLEARANCE, float(clearance.max() + recess)),
            (DRAWN_MOTION, self.largest_displacement),
        )
        self.inner_radius = radius + self.factor * clearance

    def outward_reach(self) -> float:
        """Return the largest outward displacement of the casing, times the factor [m]."""
        outward = (self.ring_displacement * directions(self.angle)).sum(axis=-1)
        return self.factor * max(0.0, float(outward.max()))

    def inner(self, index: int, removed: Array | float) -> Array:
        """Return the inner surface (station, 2) [m] of the drawn casing where a depth of its
        coating is removed (station,) [m]."""
        ring = self.ring_displacement[index]
        radius = self.inner_radius + self.factor * (self._closure[index] + removed)
        rest = radius[:, None] * directions(self.angle)
        return magnify(rest, ring, ring.mean(axis=0), self.factor)

    def wall(self, index: int) -> Array:
        """Return inner and outer surface (station, side, 2) [m] of the drawn casing, with the
        largest depth that is removed in any track."""
        inner = self.inner(index, self.wear[index].max(axis=0, initial=0.0))
        tangent = np.roll(inner, -1, axis=0) - np.roll(inner, 1, axis=0)
        outward = -rotate(unit(tangent), np.pi / 2)
        return np.stack([inner, inner + self.wall_thickness[:, None] * outward], axis=1)

    def wall_at_rest(self) -> Array:
        """Return the outer surface of the drawn casing at rest (station, 2) [m]."""
        radius = self.inner_radius + self.wall_thickness
        return np.asarray(radius[:, None] * directions(self.angle))


class EnlargedStage(EnlargedWall):
    """Drawn positions of beams and casing at chosen records: the rotor in rotating axes, the casing
    in static axes, with displacements and clearance multiplied.

    Args:
        dataset: a result.
        records: numbers of records.
        factor: factor of displacements and clearance; chosen by `round_factor` when None.
        per_line: number of pieces into which each beam is divided.
        per_element: number of pieces into which each element of the casing is divided.

    Raises:
        ViewError: the factor is not positive, larger than `MOST`, or smaller than the inverse of
            `MOST`.
    """

    def __init__(
        self,
        dataset: xr.Dataset,
        records: IntArray,
        *,
        factor: float | None,
        per_line: int,
        per_element: int,
    ) -> None:
        super().__init__(dataset, records, factor=factor, per_element=per_element)
        self.line, rows = kinematics.line_rows(dataset, per_line)
        self._thickness = rotor_sections(dataset, "thickness", per_line)
        q = history(dataset, "rotor_displacement", records)
        self.rotor_displacement = kinematics.combine(q, rows.reshape(-1, 2, rows.shape[-1]))
        self._node = kinematics.combine(q, dataset["rotor_shape"].values[:, :2])
        self._lost = lost_blades(dataset)
        self._gone = np.zeros(len(records), dtype=np.bool_)
        if self._lost is not None:
            self._gone = self._lost.gone(dataset["time"].values[records])
            self._hide(self._lost)
        self.centre = self._node[:, int(dataset["centre_node"])]
        self._moved = self.rotor_displacement
        stations = (len(records), *self.line.shape)
        drawn = drawn_back(dataset, records, self.line, self._moved.reshape(stations))
        if drawn is not None:
            self._draw_back(drawn)
        largest = float(np.linalg.norm(self.rotor_displacement, axis=-1).max())
        self._enlarge(self.tip_radius, self.tip_radius, largest)
        self.nodes = dataset["rotor_point"].values  #: drawn nodes at rest (rotor_node, 2) [m]
        recess = dataset["tip_recess"].values
        shift = self.factor * recess - kinematics.recess_at_rest(dataset)
        if shift.any():
            self.nodes, self.line = with_recess(dataset, self.line, shift)

    def _hide(self, lost: Lost) -> None:
        """Let lost beams and nodes, whose motion has no meaning, move as the fracture does."""
        shape, gone = (len(self._gone), *self.line.shape), np.flatnonzero(self._gone)
        moved = self.rotor_displacement.reshape(shape)
        at_cut = self._node[np.ix_(gone, lost.line_cuts)][:, :, None]
        moved[np.ix_(gone, lost.lines)] = at_cut
        self._node[np.ix_(gone, lost.nodes)] = self._node[np.ix_(gone, lost.node_cuts)]

    def _draw_back(self, drawn: Array) -> None:
        """Reduce the radial displacements of stations and nodes by the distances `drawn` by which
        the blades draw back, (record, rotor_line, station) [m]."""
        flat, nodes = self.line.reshape(-1, 2), self._dataset["rotor_point"].values
        self._moved = self._moved - drawn.reshape(len(drawn), -1, 1) * unit(flat)
        of_nodes = np.zeros(self._node.shape[:2])
        of_nodes[:, self._dataset["rotor_line"].values] = drawn[:, :, [0, -1]]
        self._node = self._node - of_nodes[..., None] * unit(nodes)

    @property
    def largest_bend(self) -> float:
        """Largest displacement relative to the centre [m]."""
        bent = self.rotor_displacement - self.centre[:, None]
        return float(np.linalg.norm(bent, axis=-1).max())

    def rotor_line(self, index: int) -> Array:
        """Return drawn stations of beams (rotor_line, station, 2) [m] at the index-th record; those
        of lost blades are at the fracture."""
        shift = self.centre[index]
        flat = self.line.reshape(-1, 2)
        line = magnify(flat, self._moved[index], shift, self.factor).reshape(self.line.shape)
        if self._lost is not None and self._gone[index]:
            line[self._lost.lines] = self.rotor_nodes(index)[self._lost.line_cuts][:, None]
        return line

    def rotor_nodes(self, index: int) -> Array:
        """Return the drawn nodes (rotor_node, 2) [m] at the index-th record."""
        nodes = magnify(self.nodes, self._node[index], self.centre[index], self.factor)
        if self._lost is not None and self._gone[index]:
            nodes[self._lost.nodes] = nodes[self._lost.node_cuts]
        return nodes

    def rotor_sides(self, index: int, line: Array, wall: Array) -> Array:
        """Return the right and left side of each beam (rotor_line, station, side, 2) [m].

        Args:
            index: position among the chosen records.
            line: drawn stations of the beams, from `rotor_line`.
            wall: drawn casing, from `wall`; the ends of blades are cut parallel to it.
        """
        along = unit(np.gradient(line, axis=1, edge_order=2))
        half = self._thickness[..., None] / 2 * rotate(along, np.pi / 2)
        sides = np.stack([line - half, line + half], axis=2)
        beams, stations = self._ends
        corner, middle = sides[beams, stations], line[beams, stations][:, None]
        wall_angle, wall_radius = _polar(wall[:, 0])
        (angle, _), (at_tip, radius) = _polar(corner), _polar(middle)
        facing, before = (
            np.interp(place + self.turns[index], wall_angle, wall_radius, period=2 * np.pi)
            for place in (angle, at_tip)
        )
        sides[beams, stations] = (radius + facing - before)[..., None] * directions(angle)
        return sides

    @cached_property
    def _ends(self) -> tuple[IntArray, IntArray]:
        """Numbers of the beams that end at a blade tip, and for each the station at the tip."""
        lines, tips = self._dataset["rotor_line"].values, self._dataset["tip_node"].values
        ending = np.isin(lines, tips) & (line_blades(self._dataset) >= 0)[:, None]
        beams, end = np.nonzero(ending)
        return beams, np.where(end == 1, self.line.shape[1] - 1, 0)


def magnify(points: Array, displacement: Array, shift: Array, factor: float) -> Array:
    """Return drawn positions (point, 2) of points moved by `factor` times their displacement.
    `shift` (2,), the part of the displacement common to all points, is drawn along a straight line,
    the remaining displacement in polar coordinates, see the module docstring. A point at the
    centre, where polar coordinates are undefined, is moved by the shift only.
    """
    radius, outward = np.linalg.norm(points, axis=-1), unit(points)
    rest = displacement - shift
    radial = np.sum(rest * outward, axis=-1)
    tangential = np.sum(rest * rotate(outward, np.pi / 2), axis=-1)
    swing = np.divide(factor * tangential, radius, out=np.zeros_like(radius), where=radius > 0)
    return np.asarray(factor * shift + (radius + factor * radial)[:, None] * rotate(outward, swing))


def round_factor(size: float, *drawn: tuple[float, float]) -> float:
    """Return the largest factor, 1, 2 or 5 times a power of ten, with which no drawn length is
    larger than its share of a size; at least 1.

    Args:
        size: size of the picture [m].
        drawn: share of the size, and true length [m], which can be zero.
    """
    limits = [share * size / length for share, length in drawn if length > 0]
    return rounded_down(min(max(1.0, min(limits, default=1.0)), MOST))


def rounded_down(value: float) -> float:
    """Return the largest number of 1, 2 or 5 times a power of ten that is not above a value."""
    decade = 10.0 ** np.floor(np.log10(value))
    # Without the tolerance 1e-9 a rounding error could turn a limit of exactly 50 into 20.
    return float(decade * max(step for step in (1, 2, 5) if step * decade <= value * (1 + 1e-9)))


def rounded_up(value: float, steps: Sequence[float] = (1, 2, 5, 10)) -> float:
    """Return the least number of a step times a power of ten that is not below a value."""
    decade = 10.0 ** np.floor(np.log10(value))
    # With the tolerance a value of 1.2000000000000002, a rounded 1.2, gives 1.2.
    return float(decade * min(step for step in steps if step * decade >= value * (1 - 1e-9)))


def _polar(points: Array) -> tuple[Array, Array]:
    """Return angles [rad] and radii of points (..., 2)."""
    return np.arctan2(points[..., 1], points[..., 0]), np.linalg.norm(points, axis=-1)

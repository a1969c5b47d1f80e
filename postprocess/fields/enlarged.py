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

The axial displacement is multiplied as well.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.models.case.casing import Casing
from bladewhirl.models.stage.coating import axial_tracks, track_edges
from bladewhirl.postprocess.fields import kinematics
from bladewhirl.postprocess.fields.by_blade import blade_means
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, history
from bladewhirl.postprocess.fields.mitres import mitred
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.points import contact_nodes, points_of

#: drawn clearance divided by the tip radius, if the factor is chosen automatically
DRAWN_CLEARANCE = 0.1
#: largest drawn displacement divided by the tip radius, if the factor is chosen automatically
DRAWN_MOTION = 0.25
#: drawn thickness of a coating divided by the tip radius, likewise
DRAWN_COATING = 0.3
#: drawn thickness of a rigid wall divided by the tip radius
RIGID = 0.02

BEYOND = 0.15  #: part of the wall that is drawn beyond the contact nodes, by their axial distance
NARROW = 0.01  #: smallest such part, relative to the tip radius
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
        if has(dataset, "casing"):
            ring = kinematics.combine(
                history(dataset, "casing_displacement", records),
                kinematics.casing_rows(dataset, self.angle),
            )
            self.ring_displacement = rotate(ring, self.angle)
            self.wall_thickness = np.repeat(dataset["casing_thickness"].values, per_element)
            self.wall_width = float(dataset["casing_width"].values.max())
        else:
            self.ring_displacement = np.zeros((len(records), per_element, 2))
            self.wall_thickness = np.full(per_element, RIGID * self.tip_radius)
            self.wall_width = 0.0  #: axial width [m]; 0 for a rigid wall, whose width is not known
        self._closure = kinematics.closure_change(dataset, records, self.angle)
        coating = kinematics.table_of_result(dataset, "casing", Casing).coating
        if not has(dataset, "coating"):
            coating = None
        #: depth of the coating at which tips touch the metal [m]
        self.coating = coating.limit * coating.thickness if coating else 0.0
        #: removed depth of the coating (record, track, station) [m]; without it there is no track
        self.wear = np.zeros((len(records), 0, len(self.angle)))
        if coating is not None:
            strains = kinematics.track_strains(dataset, records, self.angle)
            self.wear = coating.thickness * strains

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
            (DRAWN_COATING, self.coating),
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
        return np.stack([inner, self.outer(inner)], axis=1)

    def outer(self, inner: Array) -> Array:
        """Return the outer surface of a wall with an inner surface (station, 2) [m]."""
        tangent = np.roll(inner, -1, axis=0) - np.roll(inner, 1, axis=0)
        outward = -rotate(unit(tangent), np.pi / 2)
        return np.asarray(inner + self.wall_thickness[:, None] * outward)

    def wall_at_rest(self) -> Array:
        """Return the outer surface of the drawn casing at rest (station, 2) [m]."""
        radius = self.inner_radius + self.wall_thickness
        return np.asarray(radius[:, None] * directions(self.angle))


class EnlargedStage(EnlargedWall):
    """Drawn positions of points, contact nodes and wall at chosen records: the bladed disk in
    rotating axes, the wall in static axes, with displacements and clearance multiplied.

    Args:
        dataset: a result.
        records: numbers of records.
        factor: factor of displacements and clearance; chosen by `round_factor` when None.
        pieces: number of pieces into which each beam is divided.
        per_element: number of pieces into which each element of the casing is divided.

    Raises:
        ViewError: the factor is not positive, larger than `MOST`, or smaller than the inverse of
            `MOST`; or the stage has no points.
    """

    def __init__(
        self,
        dataset: xr.Dataset,
        records: IntArray,
        *,
        factor: float | None,
        pieces: int,
        per_element: int,
    ) -> None:
        super().__init__(dataset, records, factor=factor, per_element=per_element)
        self.body = body = points_of(dataset, pieces)
        #: whether the lost blades are gone at each record (record,)
        self.gone = dataset["time"].values[records] >= body.lost_from
        self._motion = history(dataset, "rotor_displacement", records)
        self.centre = self._motion @ body.centre.T  #: displacement of the centre (record, 2) [m]
        largest = self.largest_bend = 0.0  #: largest displacement relative to the centre [m]
        for index, centre in enumerate(self.centre):
            moved = self.displacement(index)
            largest = max(largest, _largest(moved))
            self.largest_bend = max(self.largest_bend, _largest(moved - np.append(centre, 0.0)))
        self._node_motion = rotate(
            history(dataset, "contact_displacement", records), dataset["tip_angle"].values
        )
        self._drawn_back = body.drawn_back(records)
        self.size = float(min(self.tip_radius, np.ptp(body.of_copy, axis=0).max()))
        recess = dataset["tip_recess"].values
        #: radius from which the clearance is measured, at each contact node (contact_node,) [m]
        self.wall_radius = dataset["contact_radius"].values + recess
        self._enlarge(self.size, float(self.wall_radius.max()), largest)
        shift = (self.factor - 1.0) * recess
        #: drawn contact nodes at rest (contact_node, 3) [m]
        self.nodes = _moved_in(contact_nodes(dataset), shift)
        self.rest = _moved_in(body.rest, self._along_blades(blade_means(dataset, shift)))
        """Drawn points at rest (point, 3) [m]."""
        axial = dataset["axial_position"].values
        margin = BEYOND * np.ptp(axial) + NARROW * self.tip_radius
        self.edges = float(axial.min() - margin), float(axial.max() + margin)
        """Axial positions of the edges of the drawn wall [m]."""
        if self.wall_width:
            middle = 0.5 * float(axial.min() + axial.max())
            self.edges = middle - 0.5 * self.wall_width, middle + 0.5 * self.wall_width

    def _along_blades(self, whole: Array) -> Array:
        """Return distances at all points (point,) that grow along the radius of each blade from
        zero to `whole` (blade,), so that the blade is shortened evenly."""
        radius, along = np.hypot(*self.body.rest[:, :2].T), np.zeros(len(self.body.rest))
        first = int(self._dataset["blade"].values[0])  # of a further wheel not 0
        for blade in np.intersect1d(np.flatnonzero(whole), self.body.blade - first):
            own = self.body.blade - first == blade
            root, tip = radius[own].min(), radius[own].max()
            along[own] = whole[blade] * (radius[own] - root) / (tip - root)
        return along

    def displacement(self, index: int) -> Array:
        """Return the true displacement of all points at the index-th record (point, 3) [m]. Lost
        points, whose motion has no meaning, move as the fracture does."""
        moved = self.body.moved(self._motion[index])
        if self.gone[index]:
            moved[self.body.lost] = moved[self.body.cut]
        return moved

    def points(self, index: int) -> Array:
        """Return the drawn points (point, 3) [m] at the index-th record; lost points are at the
        fracture."""
        points = self._magnified(self.rest, self.displacement(index), self._drawn_back, index)
        if self.gone[index]:
            points[self.body.lost] = points[self.body.cut]
        return points

    def contact_nodes(self, index: int) -> Array:
        """Return the drawn contact nodes (contact_node, 3) [m] at the index-th record."""
        drawn = (
            self._drawn_back if self._drawn_back is None else self._drawn_back[:, self.body.contact]
        )
        return self._magnified(self.nodes, self._node_motion[index], drawn, index)

    def sides(self, index: int, points: Array, wall: Array) -> Array:
        """Return the right and left side of each beam (line, station, side, 2) [m].

        Args:
            index: position among the chosen records.
            points: drawn points, from `points`.
            wall: drawn casing, from `wall`; the ends of blades are cut parallel to it. Other ends
                are mitred where beams go on from each other.
        """
        line = self.body.stations(points)[..., :2]
        if not len(line):
            return np.zeros((*line.shape[:2], 2, 2))
        along = unit(np.gradient(line, axis=1, edge_order=min(2, line.shape[1] - 1)))
        half = self.body.thickness[..., None] / 2 * rotate(along, np.pi / 2)
        sides = np.stack([line - half, line + half], axis=2)
        sides = mitred(sides, along, line, self.body.thickness, self.body.mitres)
        beams, stations = np.divmod(self.body.ends, line.shape[1])
        corner, middle = sides[beams, stations], line[beams, stations][:, None]
        wall_angle, wall_radius = _polar(wall[:, 0])
        (angle, _), (at_tip, radius) = _polar(corner), _polar(middle)
        facing, before = (
            np.interp(place + self.turns[index], wall_angle, wall_radius, period=2 * np.pi)
            for place in (angle, at_tip)
        )
        sides[beams, stations] = (radius + facing - before)[..., None] * directions(angle)
        return sides

    def strips(self) -> list[tuple[int, float, float]]:
        """Return the strips of the drawn coating: the number of the track, -1 beside the tracks,
        and the axial positions of both edges [m]."""
        first, last = self.edges
        axial, _ = axial_tracks(
            self._dataset["axial_position"].values, self._dataset["contact_radius"].values
        )
        ends = np.array([first, last])
        if len(axial) > 1:
            ends = track_edges(axial)
        strips = list(zip(range(len(axial)), ends[:-1].tolist(), ends[1:].tolist(), strict=True))
        beside = [(-1, first, float(ends[0])), (-1, float(ends[-1]), last)]
        return [*strips, *(each for each in beside if each[1] < each[2])]

    def wall_edge(self, wall: Array, axial: float | Array) -> Array:
        """Return a line on the inner surface of the wall (station, 3) [m] at axial positions. The
        radius of a wall that is a cone follows from the contact nodes.

        Args:
            wall: points of the drawn wall at the largest radius of contact nodes (station, 2) [m].
            axial: axial position of the line, or of each station [m].
        """
        position = self._dataset["axial_position"].values
        slope = 0.0
        if np.ptp(position) > 0.0:
            slope = np.polyfit(position, self.wall_radius, 1)[0]
        at_largest = position[np.argmax(self.wall_radius)]
        place = np.broadcast_to(axial, len(wall))
        inner = wall + slope * (place - at_largest)[:, None] * unit(wall)
        return np.column_stack([inner, place])

    def _magnified(self, rest: Array, moved: Array, drawn: Array | None, index: int) -> Array:
        """Return drawn positions (point, 3) of points at rest that move, and draw back by distances
        `drawn` (record, point), at the index-th record [m]."""
        plane = moved[:, :2]
        if drawn is not None:
            plane = plane - drawn[index, :, None] * unit(rest[:, :2])
        flat = magnify(rest[:, :2], plane, self.centre[index], self.factor)
        return np.column_stack([flat, rest[:, 2] + self.factor * moved[:, 2]])


def _largest(vectors: Array) -> float:
    return float(np.linalg.norm(vectors, axis=-1).max())


def _moved_in(points: Array, shift: Array) -> Array:
    """Return points (point, 3) moved towards the axis by `shift` (point,) [m]."""
    return np.column_stack([points[:, :2] - shift[:, None] * unit(points[:, :2]), points[:, 2]])


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

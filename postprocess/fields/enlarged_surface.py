"""Drawn positions of the points of a surface, its contact nodes and the wall around it."""

import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.models.stage.coating import axial_tracks
from bladewhirl.postprocess.fields.by_blade import blade_means
from bladewhirl.postprocess.fields.enlarged import EnlargedWall, magnify
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, history
from bladewhirl.postprocess.fields.lost_blades import lost_blades
from bladewhirl.postprocess.fields.nodes import (
    copy_coordinates,
    placed_contact_nodes,
    placed_points,
    point_blades,
    point_vectors,
)

BEYOND = 0.15  #: part of the wall that is drawn beyond the contact nodes, by their axial distance
NARROW = 0.01  #: smallest such part, relative to the tip radius


class EnlargedSurface(EnlargedWall):
    """Drawn positions of points, contact nodes and wall at chosen records, see `EnlargedWall`: the
    rotor in rotating axes, the wall in static axes.

    Raises:
        ViewError: the factor is invalid.
    """

    def __init__(
        self, dataset: xr.Dataset, records: IntArray, *, factor: float | None, per_element: int
    ) -> None:
        super().__init__(dataset, records, factor=factor, per_element=per_element)
        rest, node = placed_points(dataset), placed_contact_nodes(dataset)
        self.blade = point_blades(dataset)  #: blade of each point (point,)
        lost = lost_blades(dataset)
        self._lost = np.zeros(0, dtype=np.int64) if lost is None else lost.blades
        self._gone = np.zeros(len(records), dtype=np.bool_)
        if lost is not None:
            self._gone = lost.gone(dataset["time"].values[records])
        self._motion = copy_coordinates(dataset, "rotor_displacement", records)
        self.centre = np.zeros((len(records), 2))  #: displacement of the centre (record, 2) [m]
        if "centre_shape" in dataset:
            self.centre = self._motion[:, 0] @ dataset["centre_shape"].values.T
        moved = history(dataset, "contact_displacement", records)
        self._node_motion = rotate(moved, dataset["tip_angle"].values)
        largest = self.largest_bend = 0.0  #: largest displacement relative to the centre [m]
        for index, centre in enumerate(self.centre):
            moved = self.displacement(index)
            largest = max(largest, float(np.linalg.norm(moved, axis=-1).max()))
            moved = moved - np.append(centre, 0.0)
            self.largest_bend = max(self.largest_bend, float(np.linalg.norm(moved, axis=-1).max()))
        self.size = float(min(self.tip_radius, np.ptp(dataset["point"].values, axis=0).max()))
        recess = dataset["tip_recess"].values
        #: radius from which the clearance is measured, at each contact node (contact_node,) [m]
        self.wall_radius = dataset["contact_radius"].values + recess
        self._enlarge(self.size, float(self.wall_radius.max()), largest)
        shift = (self.factor - 1.0) * recess
        self.nodes = _moved_in(node, shift)  #: drawn contact nodes at rest (contact_node, 3) [m]
        axial = dataset["axial_position"].values
        margin = BEYOND * np.ptp(axial) + NARROW * self.tip_radius
        self.edges = float(axial.min() - margin), float(axial.max() + margin)
        """Axial positions of the edges of the drawn wall [m]."""
        if "casing_width" in dataset:
            half = 0.5 * float(dataset["casing_width"].values.max())
            middle = 0.5 * float(axial.min() + axial.max())
            self.edges = middle - half, middle + half
        radius, whole = np.hypot(rest[:, 0], rest[:, 1]), blade_means(dataset, shift)[self.blade]
        share = (radius - radius.min()) / (radius.max() - radius.min())
        self.rest = _moved_in(rest, share * whole)  #: drawn points at rest (point, 3) [m]

    def displacement(self, index: int) -> Array:
        """Return the true displacement of all points at the index-th record (point, 3) [m]."""
        return point_vectors(self._dataset, self._motion[index])

    def points(self, index: int) -> Array:
        """Return the drawn points (point, 3) [m] at the index-th record; those of a lost blade are
        all at one point of its root."""
        points = self._magnified(self.rest, self.displacement(index), index)
        for blade in self._lost if self._gone[index] else ():
            own = np.flatnonzero(self.blade == blade)
            points[own] = points[own[np.hypot(*self.rest[own, :2].T).argmin()]]
        return points

    def contact_nodes(self, index: int) -> Array:
        """Return the drawn contact nodes (contact_node, 3) [m] at the index-th record."""
        return self._magnified(self.nodes, self._node_motion[index], index)

    def strips(self) -> list[tuple[int, float, float]]:
        """Return the strips of the drawn coating: the number of the track, -1 beside the tracks,
        and the axial positions of both edges [m]."""
        first, last = self.edges
        axial, _ = axial_tracks(
            self._dataset["axial_position"].values, self._dataset["contact_radius"].values
        )
        ends = np.array([first, last])
        if len(axial) > 1:
            ends = np.concatenate([axial[:1], 0.5 * (axial[1:] + axial[:-1]), axial[-1:]])
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

    def _magnified(self, points: Array, moved: Array, index: int) -> Array:
        plane = magnify(points[:, :2], moved[:, :2], self.centre[index], self.factor)
        return np.column_stack([plane, points[:, 2] + self.factor * moved[:, 2]])


def _moved_in(points: Array, shift: Array) -> Array:
    """Return points (point, 3) moved towards the axis by `shift` (point,) [m]."""
    outward = directions(np.arctan2(points[:, 1], points[:, 0]))
    return np.column_stack([points[:, :2] - shift[:, None] * outward, points[:, 2]])

"""Solids in space around a surface of triangles: the wall, its coating, and a hub."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import pyvista
from numpy.typing import NDArray
from scipy.spatial import KDTree

from bladewhirl.meshes.coincident import places_of
from bladewhirl.meshes.plane import directions, unit
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.points import Points

CORNERS = 4  #: number of corners of the cross-section of a tube
HUB_STATIONS = 96
METAL = "#b4bbc3"  #: colour of a hub
HUB_DEPTH = 0.2  #: radial thickness of a hub, relative to its radius
SAME = 1e-6  #: largest distance of points of two sectors that are one node, by their radius
NO_STATIONS = np.zeros(0, dtype=np.int64)
SHARP = 35.0  #: angle between triangles from which an edge is drawn [deg]


@dataclass(frozen=True, kw_only=True)
class Solid:
    """A part of the stage in space, of triangles."""

    triangles: IntArray  #: points of each triangle (triangle, 3)
    shows: Literal["disk", "wall"] | None = None
    """Scale of the values that colour it; None if it has the colour `colour`."""
    colour: str = METAL
    hides: bool = True  #: whether it hides dots and numbers behind it
    edges: str = ""  #: colour of its sharp edges, ink if empty


class Placed(NamedTuple):
    """Positions of a solid at a record."""

    points: Array  #: places, and distance towards the viewer (point, 3) [m]
    stations: IntArray = NO_STATIONS
    """Station of the walls, or point of the disks, whose value is at each point, -1 for none
    (point,)."""


def tube(*corners: Array) -> Array:
    """Return the points (station x corner, 3) of a tube of the lines (station, 3) of its
    corners."""
    return np.stack(corners, axis=1).reshape(-1, 3)


def tube_triangles(stations: int, *, corners: int = CORNERS, ring: bool = False) -> IntArray:
    """Return the corner numbers (triangle, 3) of a tube of `stations` with closed ends, whose
    cross-section is convex, or of a ring, whose last station is followed by the first one."""
    here = np.arange(stations if ring else stations - 1)[:, None]
    first, second = corners * here, corners * ((here + 1) % stations)
    corner = np.arange(corners)
    after = (corner + 1) % corners
    quads = np.stack([first + corner, first + after, second + after, second + corner], axis=-1)
    quads = quads.reshape(-1, 4)
    triangles = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    if ring:
        return triangles
    end = np.column_stack([0 * corner[2:], corner[1:-1], corner[2:]])
    return np.vstack([triangles, end[:, ::-1], end + corners * (stations - 1)])


HUB = Solid(triangles=tube_triangles(HUB_STATIONS, ring=True))


def hub_of(points: Points, rest: Array, least: float) -> Array | None:
    """Return the points of a ring below separate blades, which their file does not contain; None
    for other structures, and for roots inside the radius `least` [m].

    Args:
        points: points of the blades.
        rest: their drawn places at rest (point, 3) [m].
        least: smallest radius of the roots [m].
    """
    copies = len(points.copy_angle)
    if copies < 2:
        return None
    each = rest.reshape(copies, -1, 3)
    radius = np.hypot(*each[0, :, :2].T)
    apart = KDTree(each[1]).query(each[0])[0].min()
    if apart < SAME * radius.max() or radius.min() < least:
        return None
    top, bottom = radius.min() * 1.004, radius.min() * (1.0 - HUB_DEPTH)
    root = each[0, radius < radius.min() + 0.1 * np.ptp(radius), 2]
    low, high = root.min(), root.max()
    circle = directions(2.0 * np.pi / HUB_STATIONS * np.arange(HUB_STATIONS))
    sides = ((bottom, low), (bottom, high), (top, high), (top, low))
    return tube(*(np.column_stack([r * circle, np.full(len(circle), z)]) for r, z in sides))


def surface_of(points: Array, triangles: IntArray) -> pyvista.PolyData:
    """Return a surface of triangles, whose points at one place are one point, with the number of
    each point as `origin`."""
    place = places_of(points, SAME * np.ptp(points))
    first = np.unique(place, return_index=True)[1]
    mesh = pyvista.PolyData.from_regular_faces(points, first[place][triangles])
    mesh.point_data["origin"] = np.arange(len(points))
    return mesh


def smooth_parts(points: Array, triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Split a surface of triangles at its sharp edges into smooth parts.

    Returns:
        points of each triangle (triangle, 3), counter-clockwise as seen from outside, where a point
        belongs to one smooth part; the original point of each of these points (point,).
    """
    parts = surface_of(points, triangles).compute_normals(
        cell_normals=False,
        split_vertices=True,
        feature_angle=SHARP,
        consistent_normals=True,
        auto_orient_normals=True,
    )
    return np.asarray(parts.regular_faces), np.asarray(parts.point_data["origin"])


def normals(points: Array, triangles: IntArray) -> Array:
    """Return the mean of the normals of the triangles at each point (point, 3), weighted by their
    areas."""
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    of_triangle = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    corners = triangles.ravel()
    sums = [np.bincount(corners, part, minlength=len(points)) for part in of_triangle.T]
    return unit(np.stack(sums, axis=-1))


def behind(points: Array, surfaces: Iterable[Array], margin: float) -> NDArray[np.bool_]:
    """Return whether points (point, 3) [m], the last coordinate towards the viewer, lie behind
    triangles.

    Args:
        points: places.
        surfaces: corners of the triangles of each surface (triangle, corner, 3) [m].
        margin: a triangle hides a point if it is nearer to the viewer by more [m].
    """
    hidden = np.zeros(len(points), dtype=np.bool_)
    for corners in surfaces:
        along, across = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        facing = corners[np.cross(along, across)[:, 2] != 0.0]  # others are seen from their edges
        numbers = np.arange(3 * len(facing)).reshape(-1, 3)
        mesh = pyvista.PolyData.from_regular_faces(facing.reshape(-1, 3), numbers)
        top = facing[..., 2].max(initial=-np.inf)
        for number, (x, y, depth) in enumerate(points):
            if depth + margin < top:
                _, met = mesh.ray_trace((x, y, depth + margin), (x, y, top + margin))
                hidden[number] |= met.size > 0
    return hidden


def sharp_edges(points: Array, triangles: IntArray) -> IntArray:
    """Return the end points (edge, 2) of the edges at which a surface of triangles is bent, or
    ends. Points at one place count as one."""
    edges = surface_of(points, triangles).extract_feature_edges(
        SHARP, non_manifold_edges=False, manifold_edges=False
    )
    return np.asarray(edges.point_data["origin"][edges.lines.reshape(-1, 3)[:, 1:]])

"""Solids in space around a surface of triangles: the wall, its coating, and a hub."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.spatial import KDTree

from bladewhirl.meshes.plane import directions, unit
from bladewhirl.postprocess.fields.kinematics import Array, IntArray

CORNERS = 4  #: number of corners of the cross-section of a tube
HUB_STATIONS = 96
METAL = "#b4bbc3"  #: colour of a hub
HUB_DEPTH = 0.2  #: radial thickness of a hub, relative to its radius
SAME = 1e-6  #: largest distance of points of two sectors that are one node, by their radius
SHARP = np.cos(
    np.radians(35.0)
)  #: cosine of the angle between triangles from which an edge is drawn


@dataclass(frozen=True, kw_only=True)
class Solid:
    """A solid of triangles; its colour is that of the field if it is None."""

    triangles: IntArray  #: points of each triangle (triangle, 3)
    colour: str | None = None


class Placed(NamedTuple):
    """Positions of a solid at a record."""

    points: Array  #: places, and distance towards the viewer (point, 3) [m]
    stations: IntArray  #: station of the wall whose value is at each point, -1 for none (point,)


def tube(*corners: Array) -> Array:
    """Return the points (station x corner, 3) of a tube of the lines (station, 3) of its four
    corners."""
    return np.stack(corners, axis=1).reshape(-1, 3)


def tube_triangles(stations: int, *, ring: bool = False) -> IntArray:
    """Return the corner numbers (triangle, 3) of a tube of `stations`, with closed ends, or of a
    ring, whose last station is followed by the first one."""
    here = np.arange(stations if ring else stations - 1)[:, None]
    first, second = CORNERS * here, CORNERS * ((here + 1) % stations)
    corner = np.arange(CORNERS)
    after = (corner + 1) % CORNERS
    quads = np.stack([first + corner, first + after, second + after, second + corner], axis=-1)
    quads = quads.reshape(-1, 4)
    if not ring:
        quads = np.vstack([quads, corner[::-1], corner + CORNERS * (stations - 1)])
    return np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


HUB = Solid(triangles=tube_triangles(HUB_STATIONS, ring=True), colour=METAL)


def hub_of(dataset: xr.Dataset, points: Array, least: float) -> Array | None:
    """Return the points of a ring below separate blades, which their file does not contain; None
    for other structures, and for roots inside the radius `least` [m].

    Args:
        dataset: result of a superelement.
        points: points of all blades at rest (point, 3) [m].
        least: smallest radius of the roots [m].
    """
    copies = dataset.sizes["copy"]
    if copies < 2:
        return None
    each = points.reshape(copies, -1, 3)
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


def sharp_edges(points: Array, triangles: IntArray) -> IntArray:
    """Return the end points (edge, 2) of the edges at which a surface of triangles is bent, or
    ends. Points at one place count as one."""
    near = np.round(points / (SAME * np.ptp(points)))
    _, first, number = np.unique(near, axis=0, return_index=True, return_inverse=True)
    triangles = first[number.ravel()][triangles]
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    normal = unit(np.cross(b - a, c - a))
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, which, count = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    total = np.zeros((len(edges), 3))
    np.add.at(total, which.ravel(), np.repeat(normal, 3, axis=0))
    # Two unit normals with the cosine c between them have a sum of the squared length 2 + 2 c.
    bent = np.sum(total**2, axis=1) < 2.0 + 2.0 * SHARP
    return np.asarray(edges[(count == 1) | ((count == 2) & bent)])

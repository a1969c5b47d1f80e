"""Mode shapes of bodies that are surfaces of triangles, or points, in panels of a figure."""

from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from bladewhirl.meshes.coincident import places_of
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import directions, unit
from bladewhirl.postprocess.fields.points import Points
from bladewhirl.postprocess.plotting.style import COLOUR_MAPS

MOST = 20_000
"""Largest number of triangles of a picture; larger surfaces are drawn as points."""

SAME = 1e-6  #: largest distance of nodes at one place, by the size of the surface
SHARE_OF_PITCH = 0.25  #: largest displacement that is drawn, by the distance of neighbouring tips
DRAWN = 0.2  #: largest displacement in a picture, divided by the radius
ZOOM = 1.5  #: factor by which the panels of matplotlib in space are filled better
ELEVATION, AZIMUTH = 55.0, -60.0  #: direction of the view [degrees]
DARKEST = 0.3  #: share of the colour that a surface loses which is seen from its edge

SMOOTH = 8000  #: number of pieces up to which triangles are divided

LARGEST_DOT = 100.0  #: size of a drawn point times the root of the number of points [pt2]


class SurfaceShape:
    """Surface, or points, displaced for given modal coordinates."""

    columns = 3  #: largest number of panels side by side
    projection = "3d"  #: kind of the panels

    def __init__(self, points: Points) -> None:
        self.rest = points.rest
        self._triangles = points.cells if points.cells.shape[1] == 3 else np.zeros((0, 3), int)
        self._shape = points.shape
        self._middle = 0.5 * (self.rest.max(axis=0) + self.rest.min(axis=0))
        self._reach = 0.5 * float(np.ptp(self.rest, axis=0).max())
        blades = int(points.blade.max()) + 1
        pitch = 2.0 * np.pi / blades if blades > 1 else np.inf
        #: largest drawn displacement [m]; neighbours do not reach each other
        self._drawn = self._reach * min(DRAWN, SHARE_OF_PITCH * pitch)

    def largest(self, coordinates: FloatArray) -> float:
        """Return the largest displacement of any point for all `coordinates` (..., modes)."""
        return float(np.linalg.norm(self._shape @ np.atleast_2d(coordinates).T, axis=1).max())

    def centre_share(self, coordinates: FloatArray) -> None:
        """Return that the motion of the centre is not known."""

    def draw(self, axes: Any, coordinates: FloatArray, motion: FloatArray) -> Any:
        """Draw the displaced surface, coloured by displacement, see `mode_shapes.Outline.draw`."""
        colours, norm = COLOUR_MAPS["magnitude"], Normalize(0.0, 1.0)
        moved = (self._shape @ coordinates) / self.largest(motion)
        drawn = self.rest + self._drawn * moved
        if 0 < len(self._triangles) <= MOST:
            seen, facing = facing_triangles(drawn, self._triangles)
            pieces = _divided(np.column_stack([drawn, moved])[seen])
            faces = colours(norm(np.linalg.norm(pieces[..., 3:].mean(axis=1), axis=1)))
            light = 1.0 - DARKEST * (1.0 - facing)
            faces[:, :3] *= np.repeat(light, len(pieces) // len(seen))[:, None]
            look = {"facecolors": faces, "edgecolors": faces, "linewidths": 0.2}  # without seams
            look["clip_on"] = False  # a panel may be smaller than its body
            axes.add_collection3d(Poly3DCollection(pieces[..., :3], **look))
        else:
            dot = np.clip(LARGEST_DOT / np.sqrt(len(drawn)), 0.5, 6.0)
            shade = colours(norm(np.linalg.norm(moved, axis=1)))
            axes.scatter(*drawn.T, c=shade, s=dot, linewidths=0.0, rasterized=True)
        bounds = [(centre - self._reach, centre + self._reach) for centre in self._middle]
        axes.set(xlim=bounds[0], ylim=bounds[1], zlim=bounds[2])
        axes.set_box_aspect((1.0, 1.0, 1.0), zoom=ZOOM)
        axes.view_init(elev=ELEVATION, azim=AZIMUTH)
        axes.set_axis_off()
        return ScalarMappable(norm, colours)

    def describe(self, axes: Any, name: str, words: list[str]) -> None:
        """Write the name of a mode and further lines."""
        axes.set_title("\n".join([name, *words]))


def facing_triangles(points: FloatArray, triangles: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the triangles that face the viewer (seen, 3), and the cosine of the angle between the
    normal of each and the view (seen,).

    If the surface is not closed, or its triangles have no common orientation, all are returned.

    Args:
        points: points of the surface (point, 3).
        triangles: points of each triangle (triangle, 3).
    """
    height, angle = np.radians([ELEVATION, AZIMUTH])
    view = np.append(np.cos(height) * directions(angle), np.sin(height))
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    facing = unit(np.cross(b - a, c - a)) @ view
    place = places_of(points, SAME * np.ptp(points))  # faces of sectors have nodes at one place
    sides = place[triangles][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    there, back = (np.unique(one, axis=0) for one in (sides, sides[:, ::-1]))
    if len(there) < len(sides) or not np.array_equal(there, back):
        return triangles, np.abs(facing)
    facing *= np.sign(np.sum(a * np.cross(b, c)))  # outward: the volume inside is positive
    seen = facing > 0.0
    return triangles[seen], facing[seen]


def _divided(corners: FloatArray) -> FloatArray:
    """Return triangles divided into four until there are enough for smooth colours, those of a
    triangle one after another; `corners` are places and displacements, (triangle, 3, 6)."""
    while 0 < 4 * len(corners) <= SMOOTH:
        a, b, c = np.moveaxis(corners, 1, 0)
        d, e, f = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = [np.stack(part, axis=1) for part in ((a, d, f), (d, b, e), (f, e, c), (d, e, f))]
        corners = np.stack(parts, axis=1).reshape(-1, *corners.shape[1:])
    return corners

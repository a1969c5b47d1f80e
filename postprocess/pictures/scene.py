"""Stage in a pyvista plotter.

The graphical objects are created once; for another record their points and colours are changed.
"""

from typing import Any, NamedTuple

import numpy as np
import pyvista

from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.pictures import appearance as look
from bladewhirl.postprocess.pictures.colouring import Scale
from bladewhirl.postprocess.pictures.drawing import Drawing, Picture, Surface, arrows, widened
from bladewhirl.postprocess.pictures.solids import Solid, normals, sharp_edges, smooth_parts
from bladewhirl.postprocess.pictures.symbols import MASS, Symbols

DISC_CORNERS = 32
BAR_STEPS = 65  #: number of stations of a colour scale
FRONT = 1.5  #: layer before which the layers of ribbons lie, and after which all others lie
DEPTH = 2.0  #: distance of these layers from the middle of surfaces, relative to the stage
AMBIENT, DIFFUSE = 0.5, 0.54
"""Parts of the light on surfaces: from all directions, and from lamps."""
EDGE_OFFSET = 8.0  #: distance of edges in front of their surface [units of the depth buffer]
CIRCLE = directions(2 * np.pi * np.arange(DISC_CORNERS) / DISC_CORNERS)


class Body(NamedTuple):
    """Drawn surface of triangles."""

    mesh: pyvista.PolyData
    origin: IntArray  #: point of the picture at each point of the mesh
    triangles: IntArray  #: points of the mesh of each triangle (triangle, 3)
    edges: pyvista.PolyData  #: its sharp edges, with all points of the picture


class StageScene:
    """Stage in a `pyvista.Plotter`, on the screen or off-screen.

    Colours show the true values of the field. Dots mark the shaft and the first blade if `marks` is
    true and the centre is in the picture. Objects lie in layers at different z, with surfaces of
    triangles in front of the wall, so the view must be along z, see `aim`.
    """

    def __init__(self, plotter: pyvista.Plotter, drawing: Drawing, *, marks: bool = True) -> None:
        self.plotter = plotter
        self.drawing = drawing
        stage, contact = drawing.reach()
        #: distance from the middle to the edge of the picture [m]
        self.size = max(stage, contact / (1 - look.LONGEST_ARROW))  # arrows end on the tips
        marks = marks and drawing.around
        self.metres_per_newton = look.metres_per_newton(drawing.largest_force, self.size)
        """Length of arrows."""
        first = drawing.picture(0)
        disk, wall = drawing.colouring.disk, drawing.colouring.wall
        self._depth = DEPTH * self.size * bool(drawing.solids)
        self._bodies = [
            self._add_body(placed, solid, drawing.colouring.shade(solid))
            for placed, solid in zip(first.solids, drawing.solids, strict=True)
        ]
        self._outlines, self._ribbons = [], []
        for ribbon, scale in ((first.casing, wall), (first.rotor, disk)):
            lines, stations = ribbon.values.shape[:2]
            outline = _strip_quads(lines, stations, 1)
            self._outlines.append(self._add(ribbon.values.size, outline, layer=0, color=look.INK))
            halves = _strip_quads(lines, stations, 2)
            self._ribbons.append(self._add(2 * ribbon.values.size, halves, layer=1, color=scale))
        # Strokes have light edges to be visible on parts of any colour.
        self._edges, self._strokes = (
            {
                name: self._add(
                    4 * len(strokes),
                    np.arange(4 * len(strokes)).reshape(-1, 4),
                    layer=layer,
                    color=shade or colour,
                )
                for name, _, colour, strokes in look.strokes_of(first.symbols)
            }
            for layer, shade in ((1.7, look.BACKGROUND), (2, ""))
        )
        blades: IntArray = np.arange(len(first.tips))[:, None]
        disc = disc_triangles(1)
        masses = len(first.symbols.masses)
        self._masses = [
            self._add(masses * DISC_CORNERS, disc_triangles(masses), layer=layer, color=colour)
            for layer, colour in ((3, look.INK), (4, look.MASS_COLOUR))
        ]
        (self._hub_rim, self._hub), (self._mark_rim, self._mark) = (
            [
                self._add(DISC_CORNERS, disc, layer=layer, color=colour, shown=marks)
                for layer, colour in ((5, look.BACKGROUND), (5.5, look.INK))
            ]
            for _ in range(2)
        )
        nodes = blades.size * bool(np.isfinite(drawing.colouring.nodes).any())
        self._nodes = [
            self._add(nodes * DISC_CORNERS, disc_triangles(nodes), layer=layer, color=colour)
            for layer, colour in ((5.7, look.INK), (5.8, disk))
        ]
        self._discs = self._add(
            blades.size * DISC_CORNERS,
            disc_triangles(blades.size),
            layer=6,
            color=look.FORCE_COLOUR,
        )
        self._arrows = self._add(
            7 * blades.size,
            7 * blades + np.array([0, 1, 5, 6]),
            7 * blades + np.array([2, 3, 4]),
            layer=7,
            color=look.FORCE_COLOUR,
        )
        self.show(first)

    def show(self, picture: Picture) -> None:
        """Show a picture: change the points and colours of all objects in place."""
        circle = self.size * CIRCLE
        # The outline of the inner surface lies inside the wall, so that gaps keep their size.
        edge = look.OUTLINE * self.size
        for outline, mesh, ribbon, inner in zip(
            self._outlines, self._ribbons, (picture.casing, picture.rotor), (0.0, edge), strict=True
        ):
            _move(outline, widened(ribbon.sides, inner, edge))
            # Each half of a ribbon has the colour of its surface throughout: a gradient across the
            # thickness would hardly be visible.
            sides = widened(ribbon.sides, inner - edge, 0.0)
            middle = sides.mean(axis=2)
            _move(mesh, np.stack([sides[:, :, 0], middle, middle, sides[:, :, 1]], axis=2))
            self._colour(mesh, np.repeat(ribbon.values, 2, axis=-1))
        for (mesh, origin, triangles, edges), seen in zip(
            self._bodies, picture.solids, strict=True
        ):
            edges.points[:] = seen.points
            mesh.points[:] = seen.points[origin]
            mesh.point_data["Normals"][:] = normals(mesh.points, triangles)
            if "value" in mesh.point_data:
                self._colour(mesh, seen.values[origin])
        for name, width, _, strokes in look.strokes_of(picture.symbols):
            _move(self._edges[name], stroke_corners(strokes, (width + 2 * look.EDGE) * self.size))
            _move(self._strokes[name], stroke_corners(strokes, width * self.size))
        for mesh, share in zip(self._masses, (MASS + look.OUTLINE, MASS), strict=True):
            _move(mesh, picture.symbols.masses[:, None] + share * circle)
        shaft, mark = ~picture.hidden[-2:]
        for mesh, middle, share in (
            (self._hub_rim, picture.shaft, shaft * (look.HUB + look.RIM)),
            (self._hub, picture.shaft, shaft * look.HUB),
            (self._mark_rim, picture.mark, mark * (look.MARK + look.RIM)),
            (self._mark, picture.mark, mark * look.MARK),
        ):
            _move(mesh, middle + share * circle)
        known = np.isfinite(picture.tip_values)[:, None, None]
        for mesh, share in zip(
            self._nodes, (look.NODE_DISC + look.EDGE, look.NODE_DISC), strict=True
        ):
            if mesh.n_points:
                _move(mesh, picture.tips[:, None] + share * known * circle)
        if mesh.n_points:
            self._colour(mesh, np.repeat(picture.tip_values, DISC_CORNERS))
        touching = np.any(picture.forces, axis=1)[:, None, None]
        _move(self._discs, picture.tips[:, None] + look.CONTACT_DISC * touching * circle)
        width = look.ARROW_WIDTH * self.size
        _move(self._arrows, arrows(picture.tips, picture.forces, self.metres_per_newton, width))

    def dots(self, middles: Array, size: float, colour: str, *, layer: int) -> None:
        """Add outlined discs at points (dot, 2) [m]; `size` is a radius, relative to the stage."""
        faces = disc_triangles(len(middles))
        for step, share, shade in ((0, size + look.OUTLINE, look.INK), (1, size, colour)):
            mesh = self._add(len(middles) * DISC_CORNERS, faces, layer=layer + step, color=shade)
            _move(mesh, middles[:, None] + share * self.size * CIRCLE)

    def symbols(self, symbols: Symbols) -> None:
        """Add symbols that are the same in all pictures."""
        for _, width, colour, strokes in look.strokes_of(symbols):
            quads = np.arange(4 * len(strokes)).reshape(-1, 4)
            mesh = self._add(4 * len(strokes), quads, layer=2, color=colour)
            _move(mesh, stroke_corners(strokes, width * self.size))

    def bar(self, low: Array, high: Array, scale: Scale) -> None:
        """Add the colours of a scale between two corners (2,) [m], upward."""
        share = np.linspace(0.0, 1.0, BAR_STEPS)
        mesh = self._add(2 * BAR_STEPS, _strip_quads(1, BAR_STEPS, 1), layer=0, color=scale)
        up = low[1] + (high[1] - low[1]) * share
        _move(mesh, np.array([[[x, y] for x in (low[0], high[0])] for y in up]))
        first, last = scale.limits
        self._colour(mesh, np.repeat(first + (last - first) * share, 2) / scale.factor)

    def aim(self) -> None:
        """Set the view along the axis, with the stage in the left part of the window."""
        aside = self.place(0.5, 0.5)[0]
        self.plotter.enable_parallel_projection()
        self.plotter.camera_position = [(aside, 0, 10 * self.size), (aside, 0, 0), (0, 1, 0)]
        self.plotter.camera.parallel_scale = self._half_height
        self.plotter.reset_camera_clipping_range()

    def place(self, across: float, up: float) -> Array:
        """Return the point of the drawing plane [m] at a position in the window;
        `across` and `up` are from 0 to 1."""
        width, height = self.plotter.window_size
        half = self._half_height * width / height
        middle = (1 - look.SQUARE) * half
        return np.array([middle + (2 * across - 1) * half, (2 * up - 1) * self._half_height])

    @property
    def _half_height(self) -> float:
        """Half of the height of the window, measured in the drawing plane [m]."""
        width, height = self.plotter.window_size
        return float(look.MARGIN * self.size * max(1.0, height / (look.SQUARE * width)))

    def _add(
        self,
        points: int,
        *faces: IntArray,
        layer: float | None,
        color: str | Scale,
        shown: bool = True,
    ) -> pyvista.PolyData:
        """Add a mesh of polygons without lighting in a layer, or a smooth lit surface if `layer` is
        None; with a colour, or coloured by the field on a scale."""
        space = np.zeros((points, 3))
        if layer is not None:
            space[:, 2] = 1e-3 * layer * self.size + np.copysign(self._depth, layer - FRONT)
        cells = np.concatenate([np.insert(f, 0, f.shape[1], axis=1).ravel() for f in faces])
        mesh = pyvista.PolyData(space, cells)
        coloured: dict[str, Any] = {"color": color}
        if isinstance(color, Scale):
            mesh.point_data["value"] = np.zeros(points)
            coloured = {"scalars": "value", "cmap": color.colours}
            coloured["clim"] = [end / color.factor for end in color.limits]
        if not (points and shown):
            return mesh
        actor = self.plotter.add_mesh(
            mesh,
            **coloured,
            nan_color=look.NO_VALUE,
            interpolate_before_map=True,
            lighting=layer is None,
            ambient=AMBIENT if layer is None else 0.0,
            diffuse=DIFFUSE if layer is None else 1.0,
            show_scalar_bar=False,
        )
        if layer is None:
            mesh.point_data.active_normals = np.zeros((points, 3))
            actor.prop.interpolation = "Phong"
        return mesh

    def _add_body(self, surface: Surface, solid: Solid, colour: str | Scale) -> Body:
        """Add a lit surface of triangles, and its sharp edges as lines."""
        smooth, origin = smooth_parts(surface.points, solid.triangles)
        mesh = self._add(len(origin), smooth, layer=None, color=colour)
        return Body(mesh, origin, smooth, self._add_edges(surface.points, solid))

    def _add_edges(self, points: Array, solid: Solid) -> pyvista.PolyData:
        """Add the sharp edges of a solid as lines; return the mesh of all points."""
        mesh = pyvista.PolyData(points.copy())
        edges = sharp_edges(points, solid.triangles)
        mesh.lines = np.insert(edges, 0, 2, axis=1).ravel()
        mesh.verts = np.zeros(0, np.int64)
        actor = self.plotter.add_mesh(
            mesh, color=solid.edges or look.INK, line_width=look.EDGE_WIDTH
        )
        actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        actor.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, -EDGE_OFFSET)
        return mesh

    @staticmethod
    def _colour(mesh: pyvista.PolyData, values: Array) -> None:
        mesh.point_data["value"][:] = values.ravel()


def stroke_corners(strokes: Array, width: float) -> Array:
    """Return corners (stroke, 4, 2) of strokes with given end points (stroke, 2, 2) and width [m].

    Each stroke is lengthened by half its width at both ends, so that the strokes of a zigzag join.
    """
    along = unit(strokes[:, 1] - strokes[:, 0]) * width / 2
    aside = rotate(along, np.pi / 2)
    start, end = strokes[:, 0] - along, strokes[:, 1] + along
    return np.stack([start - aside, end - aside, end + aside, start + aside], axis=1)


def _strip_quads(lines: int, stations: int, strips: int) -> IntArray:
    """Return the corner numbers of quadrilaterals (quad, 4) for ribbons that consist of strips; the
    points are in the order (line, station, strip, side)."""
    across = 2 * strips
    start = across * (np.arange(lines)[:, None] * stations + np.arange(stations - 1))
    corners = np.array([0, 1, across + 1, across])
    quads: IntArray = start[..., None, None] + 2 * np.arange(strips)[:, None] + corners
    return quads.reshape(-1, 4)


def disc_triangles(discs: int) -> IntArray:
    """Return the corner numbers (triangle, 3) of the triangles that form discs. The discs are not
    polygons, because VTK cannot triangulate a polygon of zero size."""
    corner = np.arange(1, DISC_CORNERS - 1)
    fan = np.column_stack([np.zeros_like(corner), corner, corner + 1])
    triangles: IntArray = (DISC_CORNERS * np.arange(discs)[:, None, None] + fan).reshape(-1, 3)
    return triangles


def _move(mesh: pyvista.PolyData, points: Array) -> None:
    mesh.points[:, :2] = points.reshape(-1, 2)

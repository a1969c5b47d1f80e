"""What is drawn of a stage: beams with supports in a ring, or solids in space: the bladed disk, the
wall with its coating, a hub, a shaft line with its bearings."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple, get_args

import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.enlarged_wheels import EnlargedDisk, enlarged_wheels
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.wheels import each_wheel, wheels_without_wall
from bladewhirl.postprocess.pictures.choices import View
from bladewhirl.postprocess.pictures.shaft import ShaftSolids
from bladewhirl.postprocess.pictures.solids import HUB, Placed, Solid, hub_of, tube, tube_triangles
from bladewhirl.postprocess.pictures.symbols import StageSymbols, Symbols

NO_SURFACE = "expected a superelement whose file has points, recovery and triangles"

BEAM_STATIONS = 6  #: number of straight pieces of a beam
RING_STATIONS = 720  #: smallest number of straight pieces of the casing
MARK = 0.7  #: radius of the mark on the first blade, relative to the tip radius

TOWARDS = {"oblique": (0.42, -0.5, 0.75), "axial": (0.0, 0.0, 1.0), "side": (0.2, -0.85, 0.45)}
"""Direction from surfaces around the axis to the viewer."""
OPEN = 0.3
"""The wall is cut open where the cosine between its normal and the direction to the viewer is
larger, so that tips are seen."""
LEAN, SWING = 0.35, 1.1  #: inclination of the view of a single blade, to the root and to an edge
ABOVE = 0.1  #: distance of the middle of a picture from that of a single blade, by its size
COATING = "#c8a165"  #: colour of a coating
OPEN_EDGE = "#8d959d"  #: colour of the edges of the wall where it is cut open
ARC = 0.06  #: angle over which the wall is drawn on each side of a single blade [rad]
ARC_STATIONS, WALL_STATIONS = 41, 241
THREAD = 0.004  #: thickness of the edges of the wall where it is cut open, relative to its radius


class Shape(NamedTuple):
    """Drawn positions at one record in the axes of the picture."""

    ribbons: Array  #: both sides of beams (line, station, side, 2) [m]
    wall: Array
    """Both sides of the wall around beams (line, station, side, 2) [m]; no line in space."""
    stations: IntArray
    """Station of the wall whose colour is at each of these stations (line, station)."""
    tips: Array  #: contact nodes, with their distance towards the viewer (node, 3) [m]
    centre: Array  #: likewise (3,) [m]
    mark: Array  #: likewise (3,) [m]
    symbols: Symbols
    solids: list[Placed]  #: positions of the solids of the body


class Group(NamedTuple):
    """Solids that are placed together."""

    solids: list[Solid]
    place: Callable[[int, float, float], list[Placed]]
    """Function of the number of a record, and of the angles of the rotor and of the casing in the
    axes of the picture [rad]."""


class Body:
    """Stage of which `Drawing` makes pictures: beams with their supports in the ring of the wall,
    seen along the axis; or surfaces of triangles, one for each wheel of a shaft line, with the
    inner face of the wall around each.

    Args:
        dataset: a result, of several wheels one `with_surfaces`.
        records: numbers of the records.
        factor: factor of displacements and clearance, chosen when None.
        around: true to show the wall around the axis, cut open in front of the tips; false for the
            wall near a single blade, in an oblique view of its face, where its bending is visible.
            Beams have the whole wall.
        view: direction of the view; oblique when None, of beams axial.

    Raises:
        ViewError: the factor or the view is invalid, or the stage has no surface.
    """

    def __init__(
        self,
        dataset: xr.Dataset,
        records: IntArray,
        factor: float | None,
        *,
        around: bool,
        view: View | None = None,
    ) -> None:
        views = [each for each in get_args(View) if each != "line"]
        if view not in (None, *views):
            raise ViewError(f"view must be one of {', '.join(views)}, got {view!r}")
        #: result of each wheel, those without a wall last
        self.wheels = each_wheel(dataset)
        per_element = -(-RING_STATIONS // self.wheels[0].sizes.get("casing_node", 1))
        #: drawn positions of each wheel
        self.stages = enlarged_wheels(
            self.wheels, records, factor=factor, pieces=BEAM_STATIONS, per_element=per_element
        )
        self.stage = stage = self.stages[0]  #: those of the first
        bare = wheels_without_wall(dataset)
        self.wheels += bare
        #: drawn positions of the disks of these wheels, and of wheels without a wall after them
        self.disks: list[EnlargedStage | EnlargedDisk] = [
            *self.stages,
            *(EnlargedDisk(one, records, factor=stage.factor) for one in bare),
        ]
        points = stage.body
        if points.cells.shape[1] == 1:
            raise ViewError(NO_SURFACE)
        if points.flat and view not in (None, "axial"):
            raise ViewError(f'view = "{view}": beams lie in a plane; expected "axial"')
        target = MARK * stage.nodes[self.wheels[0]["blade"].values == 0].mean(axis=0)
        away = np.linalg.norm(stage.rest - target, axis=1)
        self._mark = int(np.argmin(np.where(points.blade == 0, away, away + 2 * stage.tip_radius)))
        self._groups: list[Group] = []
        self._axes, self._focus = np.eye(3), np.zeros(3)
        self._symbols: StageSymbols | None = None
        if points.flat:
            self._symbols = StageSymbols(dataset, stage.angle, stage.outward_reach())
        else:
            self._look(dataset, records, view or "oblique", around=around)
        self.solids = tuple(solid for group in self._groups for solid in group.solids)
        """Parts of the stage in space; beams and their wall are ribbons."""
        nodes = [each.rest if points.flat else each.nodes for each in self.stages]
        self.nodes = self._placed(np.concatenate(nodes), 0.0)[..., :2]
        """Points of beams, nodes first, or contact nodes of a surface, at rest (node, 2) [m]."""

    def _look(self, dataset: xr.Dataset, records: IntArray, view: View, *, around: bool) -> None:
        """Choose the axes of the picture, and the solids, for a view of a surface."""
        stage, angle = self.stage, dataset["tip_angle"].values
        self._axes, self._focus = axes_of_view(stage, view, around=around)
        gap, ahead = opening(self._axes[2])
        #: angles at which the wall is drawn, in the axes of the picture [rad]
        self._arc = np.linspace(ahead + gap, ahead + 2 * np.pi - gap, WALL_STATIONS)
        if not around:
            # From the side, the wall in front of the tip is left out.
            start = angle.max() if view == "side" else angle.min() - ARC
            self._arc = np.linspace(start, angle.max() + ARC, ARC_STATIONS)
        self._strips = stage.strips() if stage.coating else []
        around_arc = tube_triangles(len(self._arc))
        # The wall is cut open in front of the tips, whose nodes lie at its inner face.
        wall = Solid(triangles=around_arc, shows="wall", hides=False)
        strips = [Solid(triangles=around_arc, colour=COATING, hides=False) for _ in self._strips]
        disks = [Solid(triangles=each.body.cells, shows="disk") for each in self.disks]
        self._groups = [Group(disks, self._disks)]
        for number in range(len(self.stages)):
            self._groups.append(Group([wall, *strips], partial(self._walls, number)))
        if around and gap:
            self._open = np.linspace(ahead - gap, ahead + gap, WALL_STATIONS)
            thread = Solid(triangles=around_arc, colour=OPEN_EDGE, edges=OPEN_EDGE, hides=False)
            for each in self.stages:
                self._groups.append(Group([thread, thread], partial(self._threads, each)))
        for each in self.stages if around else ():
            hub = hub_of(each.body, each.rest, 0.5 * each.tip_radius)
            if hub is not None:
                self._groups.append(Group([HUB], partial(self._hub, hub)))
        if has(dataset, "wheel") and around:
            shaft = ShaftSolids(dataset, records, stage)
            rests = [each.rest for each in self.disks]
            self._focus = middle_of([*rests, *shaft.places(0, 0.0, 0.0)], self._axes)
            self._groups.append(
                Group(
                    shaft.solids,
                    lambda *at: [Placed(self._placed(each, 0.0)) for each in shaft.places(*at)],
                )
            )

    def shape(self, index: int, rotor: float, casing: float) -> Shape:
        """Return the drawn positions at the index-th record, with the rotor and the casing turned
        by angles [rad]."""
        stage, wall = self.stage, self.stage.wall(index)
        stations, edges, symbols = np.zeros((0, 1), np.int64), np.zeros((0, 1, 2, 2)), Symbols()
        points, centre = stage.points(index), stage.factor * stage.centre[index]
        if self._symbols is not None:
            stations = np.append(np.arange(len(wall)), 0)[None]  # the first one also at the end
            edges = rotate(wall[stations], casing)
            groups = self._symbols.drawn(
                wall[:, 1], stage.wall_at_rest(), centre, points[:, :2], float(stage.turns[index])
            )
            symbols = self._symbols.together(groups, casing, rotor)
        return Shape(
            ribbons=rotate(stage.sides(index, points, wall), rotor),
            wall=edges,
            stations=stations,
            tips=np.concatenate(
                [self._placed(each.contact_nodes(index), rotor) for each in self.stages]
            ),
            centre=self._placed(np.append(centre, 0.0), rotor),
            mark=self._placed(points[self._mark], rotor),
            symbols=symbols,
            solids=[each for group in self._groups for each in group.place(index, rotor, casing)],
        )

    def _disks(self, index: int, rotor: float, _: float) -> list[Placed]:
        """Return the bladed disks at the index-th record, turned by an angle [rad]; stations are
        their points, of one disk after another."""
        first, placed = 0, list[Placed]()
        for disk in self.disks:
            stations = first + np.arange(len(disk.rest))
            placed.append(Placed(self._placed(disk.points(index), rotor), stations))
            first += len(stations)
        return placed

    def _hub(self, hub: Array, _: int, rotor: float, __: float) -> list[Placed]:
        """Return a hub, turned by an angle [rad]."""
        return [Placed(self._placed(hub, rotor))]

    def _walls(self, wheel: int, index: int, _: float, casing: float) -> list[Placed]:
        """Return the wall of a wheel at the index-th record, turned by an angle [rad], and the
        strips of its coating if there is one; stations are those of one wall, or of one track of
        the only coating, after another."""
        stage, at = self.stages[wheel], self._arc - casing
        wall = stage.wall(index)[:, 0]
        number = np.round(at * len(wall) / (2 * np.pi)).astype(np.int64) % len(wall)
        number += wheel * len(wall)

        metal = _radius(stage.inner(index, stage.coating), at)
        none = np.full_like(number, -1)  # a coating has values on its inner face only
        outer = metal + stage.wall_thickness[number % len(wall)]
        layers = [(metal, outer, np.repeat(number, 4), *stage.edges)]
        for track, first, last in self._strips:
            worn = stage.wear[index, track] if track >= 0 else 0.0
            values = number + track * len(wall) if track >= 0 else none
            values = np.column_stack([values, values, none, none]).ravel()
            layers.append((_radius(stage.inner(index, worn), at), metal, values, first, last))

        def line(radius: Array, axial: float) -> Array:
            return self._placed(stage.wall_edge(radius[:, None] * directions(at), axial), casing)

        return [
            Placed(
                tube(line(low, first), line(low, last), line(high, last), line(high, first)),
                stations,
            )
            for low, high, stations, first, last in layers
        ]

    def _threads(self, stage: EnlargedStage, index: int, _: float, casing: float) -> list[Placed]:
        """Return both edges of the inner face of a wall where it is cut open, as thin threads, at
        the index-th record, turned by an angle [rad]."""
        at = self._open - casing
        face, thick = stage.wall(index)[:, 0], THREAD * stage.tip_radius

        def line(edge: float, out: float, aside: float) -> Array:
            radius = _radius(face, at) + out * thick
            places = stage.wall_edge(radius[:, None] * directions(at), edge + aside * thick)
            return self._placed(places, casing)

        sides = (0.0, -0.5), (0.0, 0.5), (1.0, 0.5), (1.0, -0.5)
        return [Placed(tube(*(line(edge, *side) for side in sides))) for edge in stage.edges]

    def seen(self, vectors: Array) -> Array:
        """Return vectors (..., 2 or 3) as they are seen in the picture (..., 2)."""
        return self.turned(vectors)[..., :2]

    def turned(self, vectors: Array) -> Array:
        """Return vectors (..., 2 or 3) in the axes of the picture (..., 3)."""
        return np.asarray(vectors @ self._axes[:, : vectors.shape[-1]].T)

    def _placed(self, points: Array, turn: float) -> Array:
        """Return points (..., 3) turned by an angle [rad], in the axes of the view [m]."""
        return np.asarray((rotate(points, turn) - self._focus) @ self._axes.T)


def _radius(face: Array, at: Array) -> Array:
    """Return the radius of a face (station, 2) at angles [rad]."""
    return np.interp(at, np.arctan2(face[:, 1], face[:, 0]), np.hypot(*face.T), period=2 * np.pi)


def axes_of_view(stage: EnlargedStage, view: View, *, around: bool) -> tuple[Array, Array]:
    """Return the axes (3, 3) and the middle (3,) [m] of a view of a surface, see `Body`; the third
    axis points to the viewer."""
    if not around:
        return _view_of_blade(stage.rest, stage.size, view)
    up = np.array([0.0, 1.0, 0.0] if view != "side" else [0.0, 0.0, 1.0])
    return _axes(np.array(TOWARDS[view]), up), np.zeros(3)


def middle_of(parts: Sequence[Array], axes: Array) -> Array:
    """Return the middle of a picture of parts (point, 3) in axes (3, 3), (3,) [m]."""
    seen = np.vstack(parts) @ axes.T
    return np.asarray(0.5 * (seen.min(axis=0) + seen.max(axis=0)) @ axes)


def opening(towards: Array) -> tuple[float, float]:
    """Return half the angle over which the wall is cut open, and the angle of the middle of the
    opening [rad], for the direction (3,) to the viewer."""
    across = float(np.hypot(*towards[:2]))
    ahead = float(np.arctan2(towards[1], towards[0]))
    return (float(np.arccos(OPEN / across)) if across > OPEN else 0.0), ahead


def _axes(towards: Array, up: Array) -> Array:
    """Return the axes of a view from the direction to the viewer and a direction that is drawn
    upward (3, 3)."""
    forward = unit(towards)
    right = unit(np.cross(up, forward))
    return np.stack([right, np.cross(forward, right), forward])


def _view_of_blade(points: Array, size: float, view: View) -> tuple[Array, Array]:
    """Return axes and middle of a view of a blade of points (point, 3) and of a size [m]; an
    oblique view is one of its face, from the side and slightly from the root."""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    out = np.append(unit(middle[:2]), 0.0)
    focus = middle + ABOVE * size * out
    if view == "axial":
        return _axes(np.array([0.0, 0.0, 1.0]), out), focus
    if view == "side":
        return _axes(np.cross(out, [0.0, 0.0, 1.0]), out), focus
    face = np.linalg.svd(points - middle, full_matrices=False)[2][2]  # normal to the blade
    face = face if face[2] >= 0.0 else -face
    return _axes(face - LEAN * out + SWING * np.cross(out, face), out), focus

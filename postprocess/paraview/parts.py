"""Grids of the parts of a stage at some records: bladed disk, wall, coating, tips and supports.

The points of a grid are at their positions at rest, turned with the body. The array `displacement`
has its true size. The array `warp` moves the points to their positions in a picture, see
`EnlargedStage`: clearance and displacement are multiplied by one factor, so that bodies touch in
ParaView exactly when they touch in the run. Lines and boxes of beams have the same arrays.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import meshio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.meshes.plane import directions, rotate
from bladewhirl.postprocess.fields import kinematics, rotation
from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.enlarged_wheels import EnlargedDisk
from bladewhirl.postprocess.fields.joint_nodes import JOINT_FIELDS, at_joint_nodes
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, history
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.points import contact_nodes
from bladewhirl.postprocess.paraview.boxes import (
    ARC_POINTS,
    BEAM_PIECES,
    SIDES,
    Boxes,
    casing_boxes,
    rotor_boxes,
)
from bladewhirl.postprocess.paraview.shaft_line import LineGrids
from bladewhirl.postprocess.pictures.solids import CORNERS, HUB, hub_of, tube
from bladewhirl.postprocess.pictures.symbols import StageSymbols

#: kinds of symbols that are written; struts include rigid links
HOLDERS = ("springs", "dampers", "struts")
PORTION = 300  #: largest number of records for which drawn positions are prepared together
UP = np.array([0.0, 0.0, 1.0])


class StageParts:
    """Grids of the parts `rotor`, `casing`, `contact` and, if there are any, `coating`, `supports`,
    `hub`, the disk below blades whose file does not contain it, and `shaft` and `bearings` of a
    shaft line.

    Args:
        dataset: a result of one wheel with a casing, see `with_wall`.
        records: numbers of records.
        surface: true for boxes of true thickness and width of beams, false for lines.
        rotating: true for rotating axes, false for static axes.
        exaggeration: factor of clearance and displacement in `warp`; chosen when None, as for a
            picture of these records.

    Raises:
        ViewError: the exaggeration is not positive, or the stage has no points.
        ResultError: the result is of an old format without cross-sections.
    """

    def __init__(
        self,
        dataset: xr.Dataset,
        records: IntArray,
        *,
        surface: bool,
        rotating: bool,
        exaggeration: float | None = None,
    ) -> None:
        self._dataset, self._rotating = dataset, rotating
        self._pieces = BEAM_PIECES if surface else 1
        self._per_element = -(-ARC_POINTS // dataset.sizes["casing_node"])
        # In portions, so that memory does not grow with the number of records.
        self._portions = np.array_split(records, -(-len(records) // PORTION))
        stages = (self._enlarged(portion, exaggeration) for portion in self._portions)
        factors, largest = zip(*((each.factor, _largest(each)) for each in stages), strict=True)
        self.exaggeration: float = min(factors)
        #: largest deformation of rotor and casing, and wear of the coating, over all records [m]
        self.largest = dict(
            zip(("rotor", "casing", "coating"), np.max(largest, axis=0).tolist(), strict=True)
        )
        #: the first record, with the true and with the enlarged clearance
        self._still = [self._enlarged(records[:1], factor) for factor in (1.0, self.exaggeration)]
        self._true, self.drawn = true, _ = self._still
        self.body = body = true.body  #: points of the bladed disk at rest
        self._beams: Boxes | None = None
        if body.flat:
            self._beams = replace(rotor_boxes(dataset, self._pieces), solid=surface)
        self._wall = casing_boxes(dataset, ARC_POINTS)
        element, piece = np.arange(self._wall.shape[0])[:, None], np.arange(self._wall.shape[1])
        #: station of the drawn wall at each station of each element
        self._around = ((self._per_element * element + piece) % len(true.angle)).ravel()
        self._strips = true.strips() if true.coating else []
        self._clearance = float(dataset["clearance"].mean() + dataset["tip_recess"].mean())
        self._front = np.zeros(3)
        if body.flat:  # so that arrows are visible
            self._front = float(dataset["rotor_width"].max()) / 2 * surface * UP
        self._hub = None if body.flat else hub_of(body, body.rest, 0.5 * true.tip_radius)
        self._line: LineGrids | None = None
        if has(dataset, "wheel"):
            self._line = LineGrids(dataset, rotating=rotating, exaggeration=self.exaggeration)
        #: names of parts; the array `part` contains positions in this list
        self.names = [*body.parts, "casing", *HOLDERS]
        self._symbols = StageSymbols(dataset, true.angle) if body.flat else None
        #: symbols at rest, with the true and with the enlarged clearance
        self._symbols_at_rest = [
            self._symbols.drawn(outer, outer, np.zeros(2), each.rest[:, :2])
            for each, outer in ((each, each.wall_at_rest()) for each in self._still)
            if self._symbols is not None
        ]
        self.grid_names = tuple(self._grids(self._still[1], 0, int(records[0])))

    @property
    def shaft(self) -> Array:
        """Points of a shaft line at rest, without one none, (point, 3) [m]."""
        return np.zeros((0, 3)) if self._line is None else self._line.surface.rest

    def tips(self, record: int) -> Array:
        """Return the drawn contact nodes at a record in rotating axes (contact_node, 3) [m]."""
        return self._enlarged(np.array([record]), self.exaggeration).contact_nodes(0)

    def grids(self) -> Iterator[dict[str, meshio.Mesh]]:
        """Yield the grids of the parts, by name, for each record."""
        for records in self._portions:
            stage = self._enlarged(records, self.exaggeration)
            for index, record in enumerate(records):
                yield self._grids(stage, index, int(record))

    def _grids(self, stage: EnlargedStage, index: int, record: int) -> dict[str, meshio.Mesh]:
        ahead = float(stage.turns[index])
        turn, back = (0.0, -ahead) if self._rotating else (ahead, 0.0)
        points, wall = stage.points(index), stage.wall(index)
        grids = {
            "rotor": self._rotor(stage, index, record, turn, points, wall),
            "casing": self._casing(stage, index, record, back),
            "contact": self._contact(stage, index, record, turn),
        }
        if self._strips:
            grids["coating"] = self._coating(stage, index, back)
        if self._hub is not None:
            still = {name: np.zeros_like(self._hub) for name in ("displacement", "warp")}
            triangles = [("triangle", HUB.triangles)]
            grids["hub"] = meshio.Mesh(rotate(self._hub, turn), triangles, still)
        if self._line is not None:
            grids |= self._line.at(record)
        supports = self._supports(stage, index, wall, points[:, :2], (back, turn))
        return grids if supports is None else {**grids, "supports": supports}

    def _enlarged(self, records: IntArray, factor: float | None) -> EnlargedStage:
        return EnlargedStage(
            self._dataset,
            records,
            factor=factor,
            pieces=self._pieces,
            per_element=self._per_element,
        )

    def _rotor(
        self, stage: EnlargedStage, index: int, record: int, turn: float, points: Array, wall: Array
    ) -> meshio.Mesh:
        """Return the bladed disk at a record, turned by an angle [rad], without lost cells."""
        dataset, body, boxes, records = self._dataset, stage.body, self._beams, np.array([record])
        if boxes is None:
            return surface_grid(
                *(dataset, stage, index, record, turn, points), rotating=self._rotating
            )
        spin = 0.0 if self._rotating else rotation.speeds(dataset)[record]
        lost = body.lost if stage.gone[index] else body.lost[:0]
        rest, line = boxes.points(), body.stations(points)
        sides = stage.sides(index, points, wall)[:, :, SIDES] if boxes.solid else line[..., :2]
        drawn = np.column_stack([sides.reshape(-1, 2), rest[:, 2]])
        fields = self._strained(boxes, rest, records, spin, turn)
        element = {
            "part": body.stations(body.part)[:, 0],
            "blade": body.stations(body.blade)[:, 0],
            "thickness": dataset["rotor_thickness"].values,
        }
        gap = history(dataset, "gap", records)[0]
        of_lines = np.where(element["blade"] >= 0, gap[element["blade"]], self._clearance)
        fields["gap"] = np.repeat(of_lines, len(rest) // len(of_lines))
        first = len(body.rest) - body.thickness.size
        gone = np.isin(first + len(line[0]) * np.arange(len(line)), lost)
        kept = boxes.on_cells(~gone)
        kind, cells = "hexahedron" if boxes.solid else "line", boxes.cells()
        of_cells = {name: boxes.on_cells(values) for name, values in element.items()}
        fields |= _drawn(rest, drawn, fields["displacement"], stage.centre[index], turn)
        shown = {name: [values[kept]] for name, values in of_cells.items()}
        return meshio.Mesh(rotate(rest, turn), [(kind, cells[kept])], fields, shown)

    def _strained(
        self, boxes: Boxes, rest: Array, records: IntArray, spin: float, turn: float
    ) -> dict[str, Array]:
        """Return the fields of beams or of the wall on corners (corner, ...) at a record, as in
        `series.export_vtk`, in axes of the series that have turned by an angle [rad]."""
        moved, rate = (
            np.pad(boxes.vectors(self._dataset, name, records)[0], ((0, 0), (0, 1)))
            for name in ("displacement", "velocity")
        )
        strains, modulus = boxes.strains(self._dataset, records), boxes.modulus
        bend = strains.bending[..., None] * np.where(SIDES == 0, 1.0, -1.0)
        if not boxes.solid:  # a line has the stress of the surface with the larger magnitude
            bend = np.copysign(strains.bending, strains.axial)[..., None]
        surface = strains.axial[..., None] + bend
        corners = len(rest) // strains.axial[0].size
        recovered = {"surface_stress": (modulus[..., None] * surface).ravel()}
        for name, strain in (("axial", strains.axial), ("bending", strains.bending)):
            for kind, values in (("strain", strain), ("stress", modulus * strain)):
                recovered[f"{name}_{kind}"] = np.repeat(values.ravel(), corners)
        return _fields(rest, moved, rate + spin * np.cross(UP, moved), turn, recovered)

    def _casing(self, stage: EnlargedStage, index: int, record: int, turn: float) -> meshio.Mesh:
        """Return the wall without its coating as a solid ring, turned by an angle [rad]."""
        boxes = self._wall
        faces = [self._face(stage, index, stage.coating, outer=outer) for outer in (False, True)]
        rest, drawn = self._ring(stage, faces, stage.edges, self._around)
        spin = -rotation.speeds(self._dataset)[record] if self._rotating else 0.0
        fields = self._strained(boxes, rest, np.array([record]), spin, turn)
        shift = stage.ring_displacement[index].mean(axis=0)
        fields |= _drawn(rest, drawn, fields["displacement"], shift, turn)
        elements = boxes.shape[0]
        of_cells = {
            "part": np.full(elements, self.names.index("casing")),
            "blade": np.full(elements, -1),
            "thickness": self._dataset["casing_thickness"].values,
        }
        return meshio.Mesh(
            rotate(rest, turn),
            [("hexahedron", boxes.cells())],
            fields,
            {name: [boxes.on_cells(values)] for name, values in of_cells.items()},
        )

    def _coating(self, stage: EnlargedStage, index: int, turn: float) -> meshio.Mesh:
        """Return the strips of the coating, turned by an angle [rad], with the depth `wear` that is
        removed from each track and the number of the track, -1 beside the tracks."""
        stations = np.arange(len(stage.angle))
        metal, new = (
            self._face(stage, index, depth, outer=False) for depth in (stage.coating, 0.0)
        )
        moved = np.pad(stage.ring_displacement[index], ((0, 0), (0, 1)))
        places, shifts, cells, tracks = (list[NDArray[Any]]() for _ in range(4))
        fields = list[dict[str, Array]]()
        for track, *edges in self._strips:
            depth = stage.wear[index, track] if track >= 0 else np.zeros(len(stage.angle))
            worn = new[0], self._face(stage, index, depth, outer=False)[1]
            rest, drawn = self._ring(stage, [worn, metal], edges, stations)
            ahead = np.roll(stations, -1)  # inside out, as axial positions come after radii
            ends = [
                CORNERS * each[:, None] + np.arange(CORNERS)[::-1] for each in (stations, ahead)
            ]
            cells.append(len(rest) * len(places) + np.hstack(ends))
            tracks.append(np.full(len(cells[-1]), track))
            left = np.repeat(np.stack([depth, stage.coating - depth]), CORNERS, axis=1)
            whole = np.repeat(moved, CORNERS, axis=0)
            names = dict(zip(("wear", "remaining_thickness"), left, strict=True))
            fields.append(_fields(rest, whole, None, turn, names))
            places.append(rest)
            shifts.append(drawn - rest)
        joined = {name: np.concatenate([each[name] for each in fields]) for name in fields[0]}
        joined["warp"] = rotate(np.concatenate(shifts), turn)
        return meshio.Mesh(
            rotate(np.concatenate(places), turn),
            [("hexahedron", np.concatenate(cells))],
            joined,
            {"track": [np.concatenate(tracks)]},
        )

    def _face(
        self, stage: EnlargedStage, index: int, depth: Array | float, *, outer: bool
    ) -> tuple[Array, Array]:
        """Return a face of the wall at rest, in true size, and as it is drawn (station, 2) [m]: the
        inner face where a depth of the coating is removed, or the outer face."""
        true = self._true
        rest = (true.inner_radius + depth)[:, None] * directions(true.angle)
        moved = stage.inner(index, depth)
        return (true.outer(rest), stage.outer(moved)) if outer else (rest, moved)

    def _ring(
        self,
        stage: EnlargedStage,
        faces: Sequence[tuple[Array, Array]],
        edges: Sequence[float],
        stations: IntArray,
    ) -> list[Array]:
        """Return the corners (corner, 3) [m] of stations of a ring between two faces and two axial
        positions [m], in the order of those of `Boxes`, at rest and as they are drawn."""
        places = []
        for each, face in ((self._true, 0), (stage, 1)):
            (low, high), (first, last) = (side[face][stations] for side in faces), edges
            around = ((low, first), (high, first), (high, last), (low, last))
            places.append(tube(*(each.wall_edge(*corner) for corner in around)))
        return places

    def _contact(self, stage: EnlargedStage, index: int, record: int, turn: float) -> meshio.Mesh:
        """Return the contact nodes that are not lost, turned by an angle [rad]."""
        dataset, records = self._dataset, np.array([record])
        rest, angle = contact_nodes(dataset) + self._front, dataset["tip_angle"].values
        moved = rotate(history(dataset, "contact_displacement", records)[0], angle)
        rows = kinematics.tip_rows(dataset) @ history(dataset, "rotor_velocity", records)[0]
        spin = 0.0 if self._rotating else rotation.speeds(dataset)[record]
        rate = rotate(rows.T, angle) + spin * np.cross(UP, moved)
        force = kinematics.contact_forces(dataset, records, rotating=self._rotating)[0]
        blade = dataset["blade"].values
        lost = stage.body.blade[stage.body.lost] if stage.gone[index] else np.zeros(0, np.int64)
        kept = np.flatnonzero(~np.isin(blade, lost))
        fields = {
            "displacement": rotate(moved, turn),
            "velocity": rotate(rate, turn),
            "gap": history(dataset, "gap", records)[0],
            "contact_force": force,
            "warp": rotate(stage.contact_nodes(index) + self._front - rest, turn),
        }
        if has(dataset, "joints"):
            for name in JOINT_FIELDS:
                values = at_joint_nodes(dataset, name, records)[0]
                fields[name.replace("-", "_")] = values
        cells = [("vertex", kept[:, None])]
        return meshio.Mesh(rotate(rest, turn), cells, fields, {"blade": [blade[kept]]})

    def _supports(
        self,
        stage: EnlargedStage,
        index: int,
        wall: Array,
        nodes: Array,
        angles: tuple[float, float],
    ) -> meshio.Mesh | None:
        """Return springs, dampers, struts and links as lines; None if the stage has none of these.

        An end that is attached to a body has the `warp` of the body, and the `displacement` of the
        body except for terms of second order in the displacement.
        """
        if self._symbols is None:
            return None
        centre = stage.factor * stage.centre[index]
        ahead = float(stage.turns[index])
        moved = self._symbols.drawn(wall[:, 1], stage.wall_at_rest(), centre, nodes, ahead)
        rest, enlarged, drawn = (
            [getattr(self._symbols.together(symbols, *angles), name) for name in HOLDERS]
            for symbols in (*self._symbols_at_rest, moved)
        )
        count = [len(strokes) for strokes in rest]
        if not sum(count):
            return None
        places = [np.concatenate(strokes).reshape(-1, 2) for strokes in (rest, enlarged, drawn)]
        first = self.names.index(HOLDERS[0])
        return meshio.Mesh(
            points=_in_space(places[0]),
            cells=[("line", np.arange(len(places[0])).reshape(-1, 2))],
            point_data={
                "warp": _in_space(places[2] - places[0]),
                "displacement": _in_space((places[2] - places[1]) / self.exaggeration),
            },
            cell_data={"part": [first + np.repeat(np.arange(len(HOLDERS)), count)]},
        )


def surface_grid(
    dataset: xr.Dataset,
    disk: EnlargedStage | EnlargedDisk,
    index: int,
    record: int,
    turn: float,
    points: Array,
    *,
    rotating: bool,
) -> meshio.Mesh:
    """Return the surface of a bladed disk at a record, turned by an angle, without lost cells.

    Args:
        dataset: result of the wheel.
        disk: its drawn positions at several records.
        index: position of the record among these.
        record: number of the record.
        turn: angle [rad].
        points: drawn points (point, 3) [m].
        rotating: true for velocities in rotating axes.
    """
    body, records = disk.body, np.array([record])
    spin = 0.0 if rotating else rotation.speeds(dataset)[record]
    lost = body.lost if disk.gone[index] else body.lost[:0]
    moved, rate = (
        body.moved(dataset[f"rotor_{name}"][record].values) for name in ("displacement", "velocity")
    )
    recovered = {
        field.name.lower().replace(" ", "_"): field.at(records)[0, :, 0]
        for field in body.recovered.values()
    }
    fields = _fields(body.rest, moved, rate + spin * np.cross(UP, moved), turn, recovered)
    fields |= _drawn(body.rest, points, fields["displacement"], disk.centre[index], turn)
    kind, cells = {1: "vertex", 3: "triangle"}[body.cells.shape[1]], body.cells
    kept = ~np.isin(cells, lost).all(axis=1)
    shown = {"part": [body.part[cells[kept, 0]]], "blade": [body.blade[cells[kept, 0]]]}
    return meshio.Mesh(rotate(body.rest, turn), [(kind, cells[kept])], fields, shown)


def _fields(
    rest: Array, moved: Array, rate: Array | None, turn: float, others: dict[str, Array]
) -> dict[str, NDArray[Any]]:
    """Return displacement, radial displacement and velocity of points, in axes that have turned by
    an angle [rad], and other fields."""
    fields = {
        "displacement": rotate(moved, turn),
        "radial_displacement": kinematics.radial_part(moved[:, :2], rest[:, :2]),
        **others,
    }
    return fields if rate is None else {**fields, "velocity": rotate(rate, turn)}


def _drawn(rest: Array, drawn: Array, moved: Array, shift: Array, turn: float) -> dict[str, Array]:
    """Return `deformation`, the displacement without the `shift` of the body (2,), and `warp` of
    points, in axes that have turned by an angle [rad], as the displacement `moved` has."""
    rigid = np.append(rotate(shift, turn), 0.0)
    return {"deformation": moved - rigid, "warp": rotate(drawn - rest, turn)}


def _largest(stage: EnlargedStage) -> tuple[float, float, float]:
    """Return the largest deformation of rotor and casing, and wear of the coating [m]."""
    ring = stage.ring_displacement - stage.ring_displacement.mean(axis=1, keepdims=True)
    wall = float(np.linalg.norm(ring, axis=-1).max())
    return stage.largest_bend, wall, float(np.max(stage.wear, initial=0.0))


def _in_space(vectors: Array) -> Array:
    """Return plane vectors (..., 2) with a zero third component, as required by VTK."""
    return np.concatenate([vectors, np.zeros_like(vectors[..., :1])], axis=-1)

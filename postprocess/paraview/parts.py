"""Grids of the parts of a stage at some records: bladed disk, casing, tips and supports.

The points of a grid are at their positions at rest, turned with the body. The array `displacement`
has its true size. The array `warp` moves the points to their positions in a picture, see
`EnlargedStage`: clearance and displacement are multiplied by one factor, so that bodies touch in
ParaView exactly when they touch in the run. Lines and boxes have the same arrays.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import meshio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.meshes.plane import rotate
from bladewhirl.postprocess.fields import kinematics, rotation
from bladewhirl.postprocess.fields.blades import line_blades
from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, history
from bladewhirl.postprocess.fields.lost_blades import lost_beams, lost_blades
from bladewhirl.postprocess.paraview.boxes import (
    ARC_POINTS,
    BEAM_PIECES,
    LINE_ARC_POINTS,
    SIDES,
    Boxes,
    casing_boxes,
    rotor_boxes,
)
from bladewhirl.postprocess.pictures.symbols import StageSymbols
from bladewhirl.postprocess.run.wear import coating_of

GRIDS = ("rotor", "casing", "contact", "supports")
#: kinds of symbols that are written; struts include rigid links
HOLDERS = ("springs", "dampers", "struts")
PORTION = 300  #: largest number of records computed together
PORTION_POINTS = 1_000_000  #: largest number of points computed together


class StageParts:
    """Grids of the parts `rotor`, `casing`, `contact` and, if there are any, `supports`.

    Args:
        dataset: a result.
        records: numbers of records.
        surface: true for boxes of true thickness and width, false for lines.
        rotating: true for rotating axes, false for static axes.
        exaggeration: factor of clearance and displacement in `warp`; chosen when None, as for a
            picture of these records.

    Raises:
        ViewError: the exaggeration is not positive.
        ResultError: the result is of an old format without cross-sections.
    """

    grid_names = GRIDS

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
        self._lost = lost_blades(dataset)
        if self._lost is not None:
            self._lost_lines = lost_beams(dataset, self._lost).lines
        self.size = float(dataset.attrs["tip_radius"])  #: half the size of the stage [m]
        beam_pieces, arc_points = (BEAM_PIECES, ARC_POINTS) if surface else (1, LINE_ARC_POINTS)
        self._per_element = -(-arc_points // dataset.sizes["casing_node"])
        self._per_line = beam_pieces
        rotor, casing = rotor_boxes(dataset, beam_pieces), casing_boxes(dataset, arc_points)
        self._bodies = [replace(body, solid=surface) for body in (rotor, casing)]
        self._rest = [body.points() for body in self._bodies]
        # In portions, so that memory does not grow with the number of records.
        together = max(1, min(PORTION, PORTION_POINTS // sum(map(len, self._rest))))
        self._portions = np.array_split(records, -(-len(records) // together))
        stages = (self._enlarged(portion, exaggeration) for portion in self._portions)
        factors, largest = zip(*((s.factor, s.largest_displacement) for s in stages), strict=True)
        self.exaggeration: float = min(factors)
        self.largest_displacement: float = max(largest)  #: over all records [m]
        self._nodes = dataset["rotor_point"].values
        self._tips = dataset["tip_node"].values
        front = float(dataset["rotor_width"].max()) / 2 * surface
        self._tips_at_rest = np.pad(
            self._nodes[self._tips], ((0, 0), (0, 1)), constant_values=front
        )
        parts = dict.fromkeys(map(str, dataset["rotor_part"].values))
        #: names of parts; the array `part` contains positions in this list
        self.names = [*(name or "other beams" for name in parts), "casing", *HOLDERS]
        self._cells = [
            {name: [body.on_cells(values)] for name, values in self._cell_data(body).items()}
            for body in self._bodies
        ]
        self._faces = [body.quads() if surface else body.lines() for body in self._bodies]
        still = [self._enlarged(records[:1], factor) for factor in (1.0, self.exaggeration)]
        self._symbols = StageSymbols(dataset, still[0].angle)
        #: symbols at rest, with the true and with the enlarged clearance
        outer = [stage.wall_at_rest() for stage in still]
        self._still = [
            self._symbols.drawn(wall, wall, np.zeros(2), stage.rest[:, :2])
            for wall, stage in zip(outer, still, strict=True)
        ]

    def grids(self) -> Iterator[dict[str, meshio.Mesh]]:
        """Yield the grids of the parts, by name, for each record."""
        for records in self._portions:
            stage = self._enlarged(records, self.exaggeration)
            ahead = stage.turns
            turns = (0 * ahead, -ahead) if self._rotating else (ahead, 0 * ahead)
            bodies = [
                self._body_fields(boxes, rest, records, angle)
                for boxes, rest, angle in zip(self._bodies, self._rest, turns, strict=True)
            ]
            tips = self._tip_fields(records, turns[0])
            for index in range(len(records)):
                wall, points = stage.wall(index), stage.points(index)
                nodes, tips_drawn = points[:, :2], stage.contact_nodes(index)
                drawn = self._drawn(stage, index, points, wall)
                grids = {
                    boxes.body: self._body(
                        number,
                        drawn[number],
                        turns[number][index],
                        fields,
                        index,
                        gone=bool(stage.gone[index]),
                    )
                    for number, (boxes, fields) in enumerate(zip(self._bodies, bodies, strict=True))
                }
                if "coating_strain" in self._dataset:
                    remaining = self._remaining_thickness(records[[index]])
                    grids["casing"].cell_data["remaining_thickness"] = [remaining]
                tips_here = np.arange(len(self._tips))
                if self._lost is not None and stage.gone[index]:
                    tips_here = np.setdiff1d(tips_here, self._lost.blades)
                grids["contact"] = self._contact(
                    tips_drawn, turns[0][index], tips, index, tips_here
                )
                supports = self._supports(stage, index, wall, nodes, turns)
                if supports is not None:
                    grids["supports"] = supports
                yield grids

    def _enlarged(self, records: IntArray, factor: float | None) -> EnlargedStage:
        return EnlargedStage(
            self._dataset,
            records,
            factor=factor,
            pieces=self._per_line,
            per_element=self._per_element,
        )

    def _drawn(self, stage: EnlargedStage, index: int, points: Array, wall: Array) -> list[Array]:
        """Return the drawn corners (corner, 2) [m] of rotor and casing, each in its own axes."""
        pieces = np.arange(self._per_element + 1)
        stations = self._per_element * np.arange(self._dataset.sizes["casing_node"])[:, None]
        around = (stations + pieces) % len(wall)
        if not self._bodies[0].solid:
            line = stage.body.stations(points)[..., :2]
            return [line.reshape(-1, 2), wall[around, 0].reshape(-1, 2)]
        sides = stage.sides(index, points, wall)
        return [sides[:, :, SIDES].reshape(-1, 2), wall[around][:, :, SIDES].reshape(-1, 2)]

    def _body_fields(
        self, boxes: Boxes, rest: Array, records: IntArray, angle: Array
    ) -> dict[str, Array]:
        """Return the fields of a body on points (record, corner, ...), as in `series.export_vtk`.

        The field `gap` [m] of the rotor is the gap at the tip of a blade for all points of the
        blade, and the mean clearance for all other points.
        """
        dataset, count = self._dataset, len(records)
        moved = boxes.vectors(dataset, "displacement", records)
        turning = (boxes.body == "rotor") != self._rotating
        sense = (1.0 if boxes.body == "rotor" else -1.0) * turning
        spin = sense * rotation.speeds(dataset)[records][:, None, None]
        rate = boxes.vectors(dataset, "velocity", records) + spin * rotate(moved, np.pi / 2)
        strains, modulus = boxes.strains(dataset, records), boxes.modulus
        bend = strains.bending[..., None] * np.where(SIDES == 0, 1.0, -1.0)
        if not boxes.solid:  # a line has the stress of the surface with the larger magnitude
            bend = np.copysign(strains.bending, strains.axial)[..., None]
        surface = strains.axial[..., None] + bend
        corners = len(rest) // strains.axial[0].size
        fields = {
            "displacement": _in_space(rotate(moved, angle[:, None])),
            "velocity": _in_space(rotate(rate, angle[:, None])),
            "radial_displacement": kinematics.radial_part(moved, rest[None, :, :2]),
            "surface_stress": (modulus[..., None] * surface).reshape(count, -1),
        }
        for name, strain in (("axial", strains.axial), ("bending", strains.bending)):
            for kind, values in (("strain", strain), ("stress", modulus * strain)):
                fields[f"{name}_{kind}"] = np.repeat(values.reshape(count, -1), corners, axis=1)
        if boxes.body == "rotor":
            blade, gap = line_blades(dataset), history(dataset, "gap", records)
            clearance = float(dataset["clearance"].mean() + dataset["tip_recess"].mean())
            of_lines = np.where(blade >= 0, gap[:, blade], clearance)
            fields["gap"] = np.repeat(of_lines, len(rest) // len(blade), axis=1)
        return fields

    def _body(
        self,
        number: int,
        drawn: Array,
        angle: float,
        fields: dict[str, Array],
        index: int,
        *,
        gone: bool,
    ) -> meshio.Mesh:
        """Return the grid of bladed disk or casing; `drawn` contains its drawn corners (corner, 2)
        in the axes of the body [m]. If lost blades are `gone`, their cells are left out."""
        rest, boxes = self._rest[number], self._bodies[number]
        kept = np.ones(len(self._faces[number]), dtype=np.bool_)
        if boxes.body == "rotor" and self._lost is not None and gone:
            kept = boxes.on_cells(~np.isin(np.arange(boxes.shape[0]), self._lost_lines))
        return meshio.Mesh(
            points=rotate(rest, angle),
            cells=[("quad" if boxes.solid else "line", self._faces[number][kept])],
            point_data={
                "warp": _in_space(rotate(drawn - rest[:, :2], angle)),
                **{name: values[index] for name, values in fields.items()},
            },
            cell_data={name: [each[0][kept]] for name, each in self._cells[number].items()},
        )

    def _cell_data(self, boxes: Boxes) -> dict[str, NDArray[Any]]:
        """Return the numbers `part` and `blade` (-1 for no blade) and `thickness` [m] of every
        element."""
        dataset = self._dataset
        if boxes.body == "casing":
            elements = dataset.sizes["casing_node"]
            part, blade = np.full(elements, self.names.index("casing")), np.full(elements, -1)
        else:
            names = dataset["rotor_part"].values.astype(str)
            part = np.array([self.names.index(name or "other beams") for name in names])
            blade = line_blades(dataset)
        return {
            "part": part,
            "blade": blade,
            "thickness": dataset[f"{boxes.body}_thickness"].values,
        }

    def _remaining_thickness(self, record: IntArray) -> Array:
        """Return the thickness of the coating that is left on every cell of the casing [m]."""
        dataset, boxes = self._dataset, self._bodies[1]
        coating = coating_of(dataset)
        station = kinematics.station_angles(dataset, boxes.shape[1] - 1)
        middle = (station[:, 1:] + station[:, :-1]) / 2.0
        strain = kinematics.coating_strain_at(dataset, record, middle.ravel())[0]
        return boxes.on_cells(coating.thickness * (1.0 - strain.reshape(middle.shape)))

    def _tip_fields(self, records: IntArray, angle: Array) -> dict[str, Array]:
        dataset = self._dataset
        rows = dataset["rotor_shape"].values[self._tips, :2]
        moved, rate = (
            kinematics.combine(history(dataset, f"rotor_{quantity}", records), rows)
            for quantity in ("displacement", "velocity")
        )
        spin = (0.0 if self._rotating else 1.0) * rotation.speeds(dataset)[records]
        rate += spin[:, None, None] * rotate(moved, np.pi / 2)
        return {
            "displacement": _in_space(rotate(moved, angle[:, None])),
            "velocity": _in_space(rotate(rate, angle[:, None])),
            "gap": history(dataset, "gap", records),
            "contact_force": _in_space(
                kinematics.contact_forces(dataset, records, rotating=self._rotating)
            ),
        }

    def _contact(
        self, nodes: Array, angle: float, fields: dict[str, Array], index: int, blade: IntArray
    ) -> meshio.Mesh:
        """Return the grid of the tips of some blades with contact forces. The points lie on the
        front of the blades, so that arrows are visible."""
        rest = self._tips_at_rest
        return meshio.Mesh(
            points=rotate(rest, angle),
            cells=[("vertex", blade[:, None])],
            point_data={
                "warp": _in_space(rotate(nodes[:, :2] - rest[:, :2], angle)),
                **{name: values[index] for name, values in fields.items()},
            },
            cell_data={"blade": [blade]},
        )

    def _supports(
        self,
        stage: EnlargedStage,
        index: int,
        wall: Array,
        nodes: Array,
        turns: tuple[Array, Array],
    ) -> meshio.Mesh | None:
        """Return springs, dampers, struts and links as lines; None if the stage has none of these.

        An end that is attached to a body has the `warp` of the body, and the `displacement` of the
        body except for terms of second order in the displacement.
        """
        angles = float(turns[1][index]), float(turns[0][index])
        moved = self._symbols.drawn(
            wall[:, 1],
            stage.wall_at_rest(),
            stage.factor * stage.centre[index],
            nodes,
            float(stage.turns[index]),
        )
        rest, enlarged, drawn = (
            [getattr(self._symbols.together(symbols, *angles), name) for name in HOLDERS]
            for symbols in (*self._still, moved)
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


def _in_space(vectors: Array) -> Array:
    """Return plane vectors (..., 2) with a zero third component, as required by VTK."""
    return np.concatenate([vectors, np.zeros_like(vectors[..., :1])], axis=-1)

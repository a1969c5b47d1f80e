"""Grids of a superelement at some records: points of the blades, contact nodes, wall and coating.

As in `parts`, points are at their positions at rest, and the array `warp` moves them to their
positions in a picture.
"""

from collections.abc import Iterator, Sequence

import meshio
import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, contact_vectors
from bladewhirl.postprocess.fields.points import contact_nodes
from bladewhirl.postprocess.pictures.solids import CORNERS, tube, tube_triangles

STATIONS = 256  #: smallest number of stations of the wall


class NodeParts:
    """Grids of the parts `blades`, `contact`, `casing` and, if there is one, `coating`.

    Args:
        dataset: a result.
        records: numbers of records.
        surface: must be false: the file of the superelement contains the surface.
        rotating: true for rotating axes, false for static axes.
        exaggeration: factor of clearance and displacement in `warp`; chosen when None.

    Raises:
        ViewError: the file has no points, the exaggeration is invalid, or `surface` is true.
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
        if surface:
            raise ViewError("surface: not for a superelement, whose file contains its surface")
        self._dataset, self._records, self._rotating = dataset, records, rotating
        per_element = -(-STATIONS // dataset.sizes.get("casing_node", 1))
        self._true, self._stage = (
            EnlargedStage(dataset, each, factor=factor, pieces=1, per_element=per_element)
            for each, factor in ((records[:1], 1.0), (records, exaggeration))
        )
        self.exaggeration = self._stage.factor
        self.largest_displacement = self._stage.largest_displacement  #: over all records [m]
        points = self._stage.rest
        self.size = float(np.ptp(points, axis=0).max()) / 2.0  #: half the size of the blades [m]
        self._strips = self._stage.strips() if self._stage.coating else []
        self.names = ["blades", "contact", "casing", *(["coating"] if self._strips else [])]
        self.grid_names = tuple(self.names)

    def grids(self) -> Iterator[dict[str, meshio.Mesh]]:
        """Yield the grids of the parts, by name, for each record."""
        stage = self._stage
        for index, record in enumerate(self._records):
            ahead = float(stage.turns[index])
            turn = 0.0 if self._rotating else ahead
            meshes = {
                "blades": self._blades(index, int(record), turn),
                "contact": self._contact(index, int(record), turn),
                "casing": self._casing(index, turn - ahead),
            }
            if self._strips:
                meshes["coating"] = self._coating(index, turn - ahead)
            yield meshes

    def _blades(self, index: int, record: int, turn: float) -> meshio.Mesh:
        """Return the points and triangles at a record, turned by an angle [rad]."""
        dataset, body = self._dataset, self._stage.body
        moved = body.moved(dataset["rotor_displacement"][record].values)
        spin = 0.0 if self._rotating else rotation.speeds(dataset)[record]
        velocity = body.moved(dataset["rotor_velocity"][record].values)
        velocity += spin * np.cross([0.0, 0.0, 1.0], moved)
        return meshio.Mesh(
            rotate(body.rest, turn),
            [("triangle" if body.cells.shape[1] == 3 else "vertex", body.cells)],
            {
                "displacement": rotate(moved, turn),
                "velocity": rotate(velocity, turn),
                "radial_displacement": np.sum(unit(body.rest * [1.0, 1.0, 0.0]) * moved, axis=1),
                "blade": body.blade,
                **{
                    field.name.lower().replace(" ", "_"): field.at(np.array([record]))[0, :, 0]
                    for field in body.recovered.values()
                },
                "warp": rotate(self._stage.points(index) - body.rest, turn),
            },
        )

    def _contact(self, index: int, record: int, turn: float) -> meshio.Mesh:
        """Return the contact nodes at a record, turned by an angle [rad]."""
        dataset, angle = self._dataset, self._dataset["tip_angle"].values + turn
        rest, records = contact_nodes(dataset), np.array([record])
        force = np.zeros((len(rest), 3))
        if "contact_force" in dataset:
            force = dataset["contact_force"][record].values
        return meshio.Mesh(
            rotate(rest, turn),
            [("vertex", np.arange(len(angle))[:, None])],
            {
                "displacement": rotate(contact_vectors(dataset, records)[0], angle),
                "contact_force": rotate(force, angle),
                "gap": dataset["gap"][record].values,
                "blade": dataset["blade"].values,
                "warp": rotate(self._stage.contact_nodes(index) - rest, turn),
            },
        )

    def _casing(self, index: int, turn: float) -> meshio.Mesh:
        """Return the wall without its coating, turned by an angle [rad]."""
        faces = [self._faces(index, self._stage.coating, outer) for outer in (False, True)]
        return self._ring(index, faces, self._stage.edges, turn)

    def _coating(self, index: int, turn: float) -> meshio.Mesh:
        """Return the strips of the coating, turned by an angle [rad], with the depth `wear` that is
        removed from each track and the number of the track, -1 beside the tracks."""
        stage, rings = self._stage, []
        for track, *edges in self._strips:
            depth = stage.wear[index, track] if track >= 0 else np.zeros(len(stage.angle))
            new, metal = self._faces(index, 0.0, False)[0], self._faces(index, stage.coating, False)
            worn = self._faces(index, depth, False)[1]
            ring = self._ring(index, [(new, worn), metal], edges, turn)
            ring.point_data["wear"] = np.repeat(depth, CORNERS)
            ring.point_data["remaining_thickness"] = stage.coating - ring.point_data["wear"]
            ring.cell_data["track"] = [np.full(len(ring.cells[0].data), track)]
            rings.append(ring)
        first = np.cumsum([0, *(len(ring.points) for ring in rings)])
        cells = [ring.cells[0].data + n for ring, n in zip(rings, first, strict=False)]
        return meshio.Mesh(
            np.concatenate([ring.points for ring in rings]),
            [("triangle", np.concatenate(cells))],
            {
                name: np.concatenate([ring.point_data[name] for ring in rings])
                for name in rings[0].point_data
            },
            {"track": [np.concatenate([ring.cell_data["track"][0] for ring in rings])]},
        )

    def _faces(self, index: int, depth: Array | float, outer: bool) -> tuple[Array, Array]:
        """Return a face of the wall at rest, in true size, and as it is drawn (station, 2) [m]: the
        inner face where a depth of the coating is removed, or the outer face."""
        true, drawn = self._true, self._stage
        rest = (true.inner_radius + depth)[:, None] * directions(true.angle)
        moved = drawn.inner(index, depth)
        if outer:
            thickness = drawn.wall_thickness[:, None]
            rest, moved = rest + thickness * unit(rest), moved + thickness * unit(moved)
        return rest, moved

    def _ring(
        self, index: int, faces: list[tuple[Array, Array]], edges: Sequence[float], turn: float
    ) -> meshio.Mesh:
        """Return the ring between two faces, each at rest and as it is drawn, and between two axial
        positions [m], turned by an angle [rad]."""
        places = []
        for stage, face in ((self._true, 0), (self._stage, 1)):
            (low, high), (first, last) = (each[face] for each in faces), edges
            corners = ((low, first), (low, last), (high, last), (high, first))
            places.append(tube(*(stage.wall_edge(*corner) for corner in corners)))
        moved = np.pad(self._stage.ring_displacement[index], ((0, 0), (0, 1)))
        radial = np.sum(moved[:, :2] * directions(self._true.angle), axis=1)
        return meshio.Mesh(
            rotate(places[0], turn),
            [("triangle", tube_triangles(len(moved), ring=True))],
            {
                "warp": rotate(places[1] - places[0], turn),
                "displacement": np.repeat(rotate(moved, turn), CORNERS, axis=0),
                "radial_displacement": np.repeat(radial, CORNERS),
            },
        )

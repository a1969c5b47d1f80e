"""Grids of a superelement at some records: points of the blades, contact nodes, wall and coating.

As in `parts`, points are at their positions at rest, and the array `warp` moves them to their
positions in a picture.
"""

from collections.abc import Iterator, Sequence

import meshio
import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import directions, rotate, unit
from bladewhirl.postprocess.fields.enlarged_surface import EnlargedSurface
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError
from bladewhirl.postprocess.fields.nodes import frame_meshes
from bladewhirl.postprocess.fields.point_stresses import PointStresses, has_stresses
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
        if "point_shape" not in dataset:
            raise ViewError("expected a superelement whose file has points and recovery")
        self._dataset, self._records, self._rotating = dataset, records, rotating
        per_element = -(-STATIONS // dataset.sizes.get("casing_node", 1))
        self._true, self._stage = (
            EnlargedSurface(dataset, each, factor=factor, per_element=per_element)
            for each, factor in ((records[:1], 1.0), (records, exaggeration))
        )
        self._stresses = PointStresses(dataset) if has_stresses(dataset) else None
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
            meshes = frame_meshes(self._dataset, int(record), self._rotating)
            if self._stresses is not None:
                (stress,) = self._stresses.at(np.array([record]))
                meshes["blades"].point_data["von_mises_stress"] = stress
            ahead = float(stage.turns[index])
            turn = 0.0 if self._rotating else ahead
            drawn = {
                "blades": rotate(stage.points(index), turn),
                "contact": rotate(stage.contact_nodes(index), turn),
            }
            for name, places in drawn.items():
                meshes[name].point_data["warp"] = places - meshes[name].points
            meshes["casing"] = self._casing(index, turn - ahead)
            if self._strips:
                meshes["coating"] = self._coating(index, turn - ahead)
            yield meshes

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

"""Grids of a superelement at some records: points of the blades, contact nodes, and the casing.

As in `parts`, points are at their positions at rest, and the array `warp` moves them to their
positions in a picture.
"""

from collections.abc import Iterator

import meshio
import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import rotate
from bladewhirl.postprocess.fields.enlarged_surface import EnlargedSurface
from bladewhirl.postprocess.fields.kinematics import IntArray, ViewError
from bladewhirl.postprocess.fields.nodes import frame_meshes, is_flexible
from bladewhirl.postprocess.fields.point_stresses import PointStresses, has_stresses


class NodeParts:
    """Grids of the parts `blades`, `contact` and, if it is flexible, `casing`.

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
        self._stage = EnlargedSurface(dataset, records, factor=exaggeration, per_element=1)
        self._stresses = PointStresses(dataset) if has_stresses(dataset) else None
        self.exaggeration = self._stage.factor
        self.largest_displacement = self._stage.largest_displacement  #: over all records [m]
        points = self._stage.rest
        self.size = float(np.ptp(points, axis=0).max()) / 2.0  #: half the size of the blades [m]
        self.names = ["blades", "contact", *(["casing"] if is_flexible(dataset) else [])]
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
            if "casing" in meshes:
                inner = rotate(stage.wall(index)[:, 0], turn - ahead)
                axial = meshes["casing"].points[:, 2].reshape(2, -1)
                edges = [stage.wall_edge(inner, position) for position in axial]
                drawn["casing"] = np.concatenate(edges)
            for name, places in drawn.items():
                meshes[name].point_data["warp"] = places - meshes[name].points
            yield meshes

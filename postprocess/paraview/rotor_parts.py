"""Grids of the parts of a rotor with one wheel or several, at some records."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import meshio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.enlarged_wheels import EnlargedDisk
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, turn
from bladewhirl.postprocess.fields.wheels import each_wheel, wheels_without_wall, with_surfaces
from bladewhirl.postprocess.paraview.parts import StageParts, surface_grid


class RotorParts:
    """Grids of the parts of all wheels, which have one `exaggeration`: a part such as `rotor` or
    `casing` is one grid of those of all wheels; wheels without a wall are the last of `rotor`.

    Args:
        dataset: a result with a casing, see `with_wall`.
        records: numbers of records.
        exaggeration: factor of clearance and displacement in `warp`; chosen when None.
        surface: see `StageParts`.
        rotating: likewise.

    Raises:
        ViewError, ResultError: see `StageParts`.
    """

    def __init__(
        self,
        dataset: xr.Dataset,
        records: IntArray,
        *,
        surface: bool,
        rotating: bool,
        exaggeration: float | None,
    ) -> None:
        look = {"surface": surface, "rotating": rotating}
        self._records, self._rotating = records, rotating
        wheels = each_wheel(with_surfaces(dataset))
        parts = [StageParts(one, records, exaggeration=exaggeration, **look) for one in wheels]
        self.exaggeration = least = min(each.exaggeration for each in parts)
        self._each = [
            own
            if own.exaggeration == least
            else StageParts(one, records, exaggeration=least, **look)
            for one, own in zip(wheels, parts, strict=True)
        ]
        self._angles = np.zeros(len(records)) if rotating else turn(dataset, records)
        self._bare = [
            (one, EnlargedDisk(one, records, factor=least)) for one in wheels_without_wall(dataset)
        ]
        first = self._each[0]
        self.names, self.body, self.shaft = first.names, first.body, first.shaft
        #: names of the grids
        self.grid_names = tuple(dict.fromkeys(n for each in self._each for n in each.grid_names))
        #: largest deformation of rotor and casing, and wear of the coating, over all records [m]
        self.largest = {
            name: max(each.largest[name] for each in self._each) for name in first.largest
        }

    @property
    def drawn(self) -> list[EnlargedStage]:
        """Drawn positions of each wheel at the first record."""
        return [each.drawn for each in self._each]

    @property
    def rests(self) -> list[Array]:
        """Drawn points of each disk at rest (point, 3) [m]."""
        return [*(one.rest for one in self.drawn), *(disk.rest for _, disk in self._bare)]

    def tips(self, record: int) -> Array:
        """Return the drawn contact nodes at a record in rotating axes (contact_node, 3) [m]."""
        return np.concatenate([each.tips(record) for each in self._each])

    def grids(self) -> Iterator[dict[str, meshio.Mesh]]:
        """Yield the grids of the parts, by name, for each record."""
        for index, each in enumerate(zip(*(one.grids() for one in self._each), strict=True)):
            found = {name: [one[name] for one in each if name in one] for name in self.grid_names}
            found["rotor"] += self._without_wall(index)
            yield {name: joined(meshes) for name, meshes in found.items()}

    def _without_wall(self, index: int) -> list[meshio.Mesh]:
        """Return the surfaces of wheels without a wall at the index-th record."""
        at = index, int(self._records[index]), float(self._angles[index])
        return [
            surface_grid(one, disk, *at, disk.points(index), rotating=self._rotating)
            for one, disk in self._bare
        ]


def joined(meshes: Sequence[meshio.Mesh]) -> meshio.Mesh:
    """Return meshes with cells of one kind as one mesh; an array on points that only the first one
    has is NaN on the others."""
    if len(meshes) == 1:
        return meshes[0]
    first, counts = meshes[0], [len(mesh.points) for mesh in meshes]
    starts = np.cumsum([0, *counts[:-1]])
    cells = [mesh.cells[0].data + start for mesh, start in zip(meshes, starts, strict=True)]

    def on_points(name: str, values: NDArray[Any]) -> NDArray[Any]:
        each = [
            mesh.point_data.get(name, np.full((count, *values.shape[1:]), np.nan))
            for mesh, count in zip(meshes, counts, strict=True)
        ]
        return np.concatenate(each)

    of_cells: Mapping[str, Any] = first.cell_data
    return meshio.Mesh(
        np.concatenate([mesh.points for mesh in meshes]),
        [(first.cells[0].type, np.concatenate(cells))],
        {name: on_points(name, values) for name, values in first.point_data.items()},
        {name: [np.concatenate([mesh.cell_data[name][0] for mesh in meshes])] for name in of_cells},
    )

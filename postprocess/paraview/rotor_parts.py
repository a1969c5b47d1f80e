"""Grids of the parts of a rotor with one wheel or several, at some records."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import meshio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.wheels import each_wheel, with_surfaces
from bladewhirl.postprocess.paraview.parts import StageParts


class RotorParts:
    """Grids of the parts of all wheels, which have one `exaggeration`: a part such as `rotor` or
    `casing` is one grid of those of all wheels.

    Args:
        dataset: a result with a casing, see `with_wall`.
        records: numbers of records.
        exaggeration: factor of clearance and displacement in `warp`; chosen when None.
        look: `surface` and `rotating`, see `StageParts`.

    Raises:
        ViewError, ResultError: see `StageParts`.
    """

    def __init__(
        self,
        dataset: xr.Dataset,
        records: IntArray,
        *,
        exaggeration: float | None,
        **look: bool,
    ) -> None:
        wheels = each_wheel(with_surfaces(dataset))
        parts = [StageParts(one, records, exaggeration=exaggeration, **look) for one in wheels]
        self.exaggeration = least = min(each.exaggeration for each in parts)
        self._each = [
            own
            if own.exaggeration == least
            else StageParts(one, records, exaggeration=least, **look)
            for one, own in zip(wheels, parts, strict=True)
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

    def tips(self, record: int) -> Array:
        """Return the drawn contact nodes at a record in rotating axes (contact_node, 3) [m]."""
        return np.concatenate([each.tips(record) for each in self._each])

    def grids(self) -> Iterator[dict[str, meshio.Mesh]]:
        """Yield the grids of the parts, by name, for each record."""
        for each in zip(*(parts.grids() for parts in self._each), strict=True):
            yield {
                name: joined([grids[name] for grids in each if name in grids])
                for name in self.grid_names
            }


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

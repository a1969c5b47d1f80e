"""Grids of a shaft line at some records: its surface, and rings at its bearings."""

import meshio
import numpy as np
import xarray as xr

from bladewhirl.meshes.plane import rotate
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, history
from bladewhirl.postprocess.fields.shaft_surface import AROUND, ShaftSurface
from bladewhirl.postprocess.pictures.solids import tube_triangles

LINE_PARTS = ("shaft", "bearings")
DRAWN = 0.05  #: largest displacement in a picture, as a fraction of the length of the shaft


def exaggeration_of(dataset: xr.Dataset, records: IntArray, given: float | None) -> float:
    """Return the factor of displacements in `warp`; chosen from the largest one if None.

    Raises:
        ViewError: it is not positive.
    """
    if given is not None:
        if not given > 0.0:
            raise ViewError(f"exaggeration {given:g}: expected a positive number")
        return given
    moved = history(dataset, "shaft_displacement", records)[..., :2]
    largest = float(np.linalg.norm(moved, axis=-1).max())
    length = float(np.ptp(dataset["shaft_position"].values))
    return DRAWN * length / largest if largest else 1.0


class LineGrids:
    """Grids of the parts `shaft` and `bearings`, of triangles with `displacement` and `warp` [m].

    Args:
        dataset: a result with a shaft line.
        rotating: true for rotating axes, false for static axes.
        exaggeration: factor of displacements in `warp`.
    """

    def __init__(self, dataset: xr.Dataset, *, rotating: bool, exaggeration: float) -> None:
        self.surface, self._factor = ShaftSurface(dataset), exaggeration
        self._angles, self._rotating = rotation.angles(dataset), rotating
        count, ring = len(self.surface.rings), tube_triangles(AROUND, ring=True)
        size = self.surface.rings[0].size // 3
        self._rings = np.vstack([ring + size * number for number in range(count)])
        self._shaft = tube_triangles(len(self.surface.position), corners=AROUND)

    def at(self, record: int) -> dict[str, meshio.Mesh]:
        """Return the grids at a record."""
        surface, turned = self.surface, float(self._angles[record])
        turn, back = (0.0, -turned) if self._rotating else (turned, 0.0)
        moved = np.broadcast_to(surface.ring_displacement(record), surface.rings.shape)
        rings, moved = surface.rings.reshape(-1, 3), moved.reshape(-1, 3)
        shaft = self._grid(surface.rest, surface.displacement(record), self._shaft, turn)
        of_rings = self._grid(rings, moved, self._rings, back)
        return dict(zip(LINE_PARTS, (shaft, of_rings), strict=True))

    def _grid(self, rest: Array, moved: Array, cells: IntArray, turn: float) -> meshio.Mesh:
        moved = rotate(moved, turn)
        arrays = {"displacement": moved, "warp": self._factor * moved}
        return meshio.Mesh(rotate(rest, turn), [("triangle", cells)], arrays)

"""Solids of a shaft line with a wheel: the shaft, and rings that stand for its bearings."""

import xarray as xr

from bladewhirl.meshes.plane import rotate
from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.shaft_surface import AROUND, ShaftSurface
from bladewhirl.postprocess.pictures.solids import Solid, tube_triangles

BEARING = "#7F9DB9"  #: colour of bearings


class ShaftSolids:
    """Solids of a shaft line, whose displacements are multiplied as those of its wheel.

    Args:
        dataset: result of a wheel on a shaft line.
        records: numbers of the records.
        stage: drawn positions of the wheel at these records.
    """

    def __init__(self, dataset: xr.Dataset, records: IntArray, stage: EnlargedStage) -> None:
        self._surface, self._records, self._stage = ShaftSurface(dataset), records, stage
        shaft = tube_triangles(len(self._surface.position), corners=AROUND)
        ring = Solid(triangles=tube_triangles(AROUND, ring=True), colour=BEARING)
        self.solids = [Solid(triangles=shaft), *[ring] * len(self._surface.rings)]

    def places(self, index: int, rotor: float, casing: float) -> list[Array]:
        """Return the points of each solid (point, 3) [m] at the index-th record, with rotor and
        casing turned by angles [rad]."""
        surface, record, factor = self._surface, int(self._records[index]), self._stage.factor
        shaft = surface.rest + factor * surface.displacement(record)
        rings = surface.rings + factor * surface.ring_displacement(record)
        return [rotate(shaft, rotor), *rotate(rings.reshape(len(rings), -1, 3), casing)]

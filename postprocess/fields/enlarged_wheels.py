"""Drawn positions of all wheels of a rotor: those with walls, by one factor, and those without."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.enlarged import EnlargedStage, magnify
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, history
from bladewhirl.postprocess.fields.points import points_of


class EnlargedDisk:
    """Drawn positions of the points of a wheel without a wall at chosen records, in rotating axes.

    Args:
        dataset: result of the wheel.
        records: numbers of records.
        factor: factor of displacements.
    """

    def __init__(self, dataset: xr.Dataset, records: IntArray, *, factor: float) -> None:
        self.body, self._factor = points_of(dataset, 1), factor
        self.rest = self.body.rest  #: drawn points at rest (point, 3) [m]
        self._motion = history(dataset, "rotor_displacement", records)
        self.centre = self._motion @ self.body.centre.T  #: see `EnlargedStage`
        self.gone = np.zeros(len(records), dtype=np.bool_)  #: likewise

    def points(self, index: int) -> Array:
        """Return the drawn points (point, 3) [m] at the index-th record."""
        moved = self.body.moved(self._motion[index])
        flat = magnify(self.rest[:, :2], moved[:, :2], self.centre[index], self._factor)
        return np.column_stack([flat, self.rest[:, 2] + self._factor * moved[:, 2]])


def enlarged_wheels(
    wheels: Sequence[xr.Dataset], records: IntArray, *, factor: float | None, **divided: int
) -> list[EnlargedStage]:
    """Return the drawn positions of the wheels of a rotor with one factor: the smallest of those
    chosen for each of them when None.

    Args:
        wheels: result of each wheel.
        records: numbers of records.
        factor: factor of displacements and clearance.
        divided: `pieces` and `per_element`, see `EnlargedStage`.

    Raises:
        ViewError: see `EnlargedStage`.
    """
    stages = [EnlargedStage(one, records, factor=factor, **divided) for one in wheels]
    least = min(stage.factor for stage in stages)
    return [
        stage if stage.factor == least else EnlargedStage(one, records, factor=least, **divided)
        for one, stage in zip(wheels, stages, strict=True)
    ]

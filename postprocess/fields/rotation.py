"""Speed and angle of the rotor at the records of a result and between them.

At constant speed they follow from the attribute `speed` of the result. If the speed varies, a
result, and a Dataset derived from it, contains them as `rotation_speed` and `rotation_angle`.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

ANGLE, SPEED = "rotation_angle", "rotation_speed"


def varies(dataset: xr.Dataset) -> bool:
    """Return whether the speed varies."""
    return ANGLE in dataset.variables


def angles(dataset: xr.Dataset) -> Array:
    """Return the angle of the rotor at every record [rad], (time,)."""
    if varies(dataset):
        return np.asarray(dataset.variables[ANGLE].values)
    return np.asarray(float(dataset.attrs["speed"]) * dataset.variables["time"].values)


def speeds(dataset: xr.Dataset) -> Array:
    """Return the speed of rotation at every record [rad/s], (time,)."""
    if varies(dataset):
        return np.asarray(dataset.variables[SPEED].values)
    return np.full(dataset.sizes["time"], float(dataset.attrs["speed"]))


def mean_speed(dataset: xr.Dataset) -> float:
    """Return the magnitude of the mean speed over all records, two or more [rad/s]."""
    if not varies(dataset):
        return abs(float(dataset.attrs["speed"]))
    time, angle = dataset.variables["time"].values, angles(dataset)
    return float(abs(angle[-1] - angle[0]) / (time[-1] - time[0]))


def angle_at(dataset: xr.Dataset, times: ArrayLike) -> Array:
    """Return the angle of the rotor at times within the run [rad], in the shape of the times;
    between records it is the cubic with the angles and speeds of the records."""
    times = np.asarray(times, dtype=np.float64)
    if not varies(dataset):
        return np.asarray(float(dataset.attrs["speed"]) * times)
    return _cubic(dataset, times, 0)


def speed_at(dataset: xr.Dataset, times: ArrayLike) -> Array:
    """Return the speed at times within the run [rad/s], in the shape of the times."""
    times = np.asarray(times, dtype=np.float64)
    if not varies(dataset):
        return np.full(times.shape, float(dataset.attrs["speed"]))
    return _cubic(dataset, times, 1)


def acceleration_at(dataset: xr.Dataset, times: ArrayLike) -> Array:
    """Return the rate of the speed at times within the run [rad/s2], in the shape of the times."""
    times = np.asarray(times, dtype=np.float64)
    if not varies(dataset) or dataset.sizes["time"] == 1:
        return np.zeros(times.shape)
    return _cubic(dataset, times, 2)


def _cubic(dataset: xr.Dataset, times: Array, derivative: int) -> Array:
    from scipy.interpolate import CubicHermiteSpline  # slow to import

    time = dataset.variables["time"].values
    if len(time) == 1:
        return np.full(times.shape, (angles(dataset), speeds(dataset))[derivative][0])
    curve = CubicHermiteSpline(time, angles(dataset), speeds(dataset))
    return np.asarray(curve(times, derivative))


def turns(dataset: xr.Dataset) -> Array:
    """Return the revolutions since the start of the run at every record, which never decrease,
    (time,)."""
    passed = np.abs(np.diff(angles(dataset)))
    first = abs(float(angles(dataset)[0]))
    return np.concatenate([[first], first + np.cumsum(passed)]) / (2.0 * np.pi)


def histories(dataset: xr.Dataset) -> Mapping[str, tuple[str, Array, str]]:
    """Return angle and speed for a Dataset derived from a result, for `labelled`; nothing at
    constant speed."""
    if not varies(dataset):
        return {}
    return {ANGLE: ("time", angles(dataset), "rad"), SPEED: ("time", speeds(dataset), "rad/s")}

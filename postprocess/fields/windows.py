"""Windows of time: a part of a run, its late part, and spans over which records are averaged."""

import numpy as np
import xarray as xr

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError

#: share of the time, at the end of a run, that is regarded as the late motion
LATE_SHARE = 1.0 / 3.0
EVEN = 1e-6  #: time steps count as equal if they differ from their median by at most this fraction


def select_window(
    dataset: xr.Dataset, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Return the records within [start, end] [s], by default all records.

    Raises:
        ViewError: the window ends before it starts, or contains fewer than two records.
    """
    time = dataset["time"].values
    first = time[0] if start is None else start
    last = time[-1] if end is None else end
    slack = 1e-9 * (time[-1] - time[0])  # records are at rounded multiples of their step
    chosen = slice(*np.searchsorted(time, [first - slack, last + slack]))
    if not first < last:
        raise ViewError(f"window [{first:g}, {last:g}] s: expected a start before the end")
    if len(time[chosen]) < 2:
        raise ViewError(
            f"window [{first:g}, {last:g}] s: expected at least two records in it; the run covers"
            f" [{time[0]:g}, {time[-1]:g}] s in {len(time)} records"
        )
    return dataset.isel(time=chosen)


def in_window(result: xr.Dataset, start: float | None, end: float | None) -> xr.Dataset:
    """Return the records within [start, end] [s]. When both limits are None, return the whole
    result, which may then have a single record.

    Raises:
        ViewError: the window is invalid, see `select_window`.
    """
    return result if start is None and end is None else select_window(result, start, end)


def late_part(dataset: xr.Dataset) -> xr.Dataset:
    """Return the records in the last third of the time; values are read when used."""
    time = dataset.variables["time"].values
    begin = time[-1] - LATE_SHARE * (time[-1] - time[0])
    return dataset.isel(time=slice(int(np.searchsorted(time, begin)), None))


def evenly_spaced(dataset: xr.Dataset, fewest: int) -> tuple[xr.Dataset, float]:
    """Return the equally spaced records and their step [s].

    The last record is dropped if the march ended early, between two regular records.

    Raises:
        ViewError: the records are not equally spaced, or there are fewer than `fewest`.
    """
    time = dataset.variables["time"].values
    steps = np.diff(time)
    step = float(np.median(steps)) if len(steps) else 0.0
    uneven = np.abs(steps - step) > EVEN * step
    if len(steps) and uneven[-1]:
        dataset, uneven = dataset.isel(time=slice(None, -1)), uneven[:-1]
    if uneven.any():
        at = float(time[int(np.argmax(uneven))])
        raise ViewError(f"a spectrum needs equally spaced records; their step changes at {at:g} s")
    if dataset.sizes["time"] < fewest:
        raise ViewError(
            f"a spectrum needs {fewest} equally spaced records or more, "
            f"the window contains {dataset.sizes['time']}"
        )
    return dataset, step


def span_starts(time: Array, spans: int) -> IntArray:
    """Return the number of the first record in each of `spans` equal spans of time; spans without
    records are left out. If there are no more records than spans, return all record numbers."""
    if len(time) <= spans:
        return np.arange(len(time))
    number = np.minimum((time - time[0]) * spans // np.ptp(time), spans - 1)
    return np.unique(number, return_index=True)[1]


def span_means(values: Array, starts: IntArray) -> Array:
    """Return means of `values` over the first axis, from each start to the next start."""
    count = np.diff(starts, append=len(values))
    sums = np.add.reduceat(values, starts, axis=0)
    return np.asarray(sums / count.reshape(-1, *[1] * (values.ndim - 1)))


def span_edges(time: Array, starts: IntArray, begin: float) -> Array:
    """Return the limits of the spans [s], (span + 1,): `begin`, and the time of the last record of
    each span."""
    ends = time[np.append(starts[1:], len(time)) - 1]
    return np.concatenate([[begin], ends])


def window_label(dataset: xr.Dataset) -> str:
    """Return the time interval of a Dataset as text, such as "10 to 20 ms"."""
    first, last = dataset.variables["time"].values[[0, -1]]
    unit, scale = handy_unit(float(last), "s")
    return f"{scale * first:.3g} to {scale * last:.3g} {unit}"

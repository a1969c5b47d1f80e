"""Values of a swept key at which an engine order meets a natural frequency of the nodal diameter
that it excites."""

from collections.abc import Iterable, Iterator
from itertools import product

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.by_blade import ANY, aliased
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.sweep.dataset import NATURAL_MODE

NATURAL_MODES = "natural_frequency", "natural_diameter"  #: variables of a sweep

RESONANCE = "resonance"  #: name of the dimension of resonances


def resonances(data: xr.Dataset, key: str, blades: int, orders: Iterable[int]) -> xr.Dataset:
    """Find where engine orders r = m N + d or m N - d meet natural frequencies with d nodal
    diameters of N blades, between two points along a key.

    Frequencies of a nodal diameter do not cross each other: those of one rank belong to one line.
    Frequencies and speed are interpolated linearly.

    Args:
        data: `NATURAL_MODES` and `rotation_speed` over the key and further dimensions.
        key: the swept key.
        blades: number of equal blades.
        orders: engine orders.

    Returns:
        Dataset over resonance: `resonance_at`, the value of the key, `resonance_order`,
        `resonance_frequency` [Hz], and for each further dimension the place along it, such as
        `resonance_line`.
    """
    rows = [str(each) for each in data["rotation_speed"].dims if each != key]
    order = (*rows, key, NATURAL_MODE)
    frequency, diameter = (data[name].transpose(*order).values for name in NATURAL_MODES)
    turns = np.abs(data["rotation_speed"].transpose(*rows, key).values) / (2.0 * np.pi)
    found = [
        (*row, engine_order, *met)
        for row, engine_order in product(np.ndindex(turns.shape[:-1]), orders)
        for met in _meetings(
            data[key].values,
            engine_order * turns[row],
            excited(frequency[row], diameter[row], blades, [engine_order]),
        )
    ]
    columns = np.array(found, dtype=np.float64).reshape(-1, len(rows) + 3).T
    numbers = dict(zip([*rows, "order"], columns.astype(np.int64), strict=False))
    return xr.Dataset(
        {
            **{f"resonance_{name}": (RESONANCE, values) for name, values in numbers.items()},
            "resonance_at": (RESONANCE, columns[-2]),
            "resonance_frequency": (RESONANCE, columns[-1], {"units": "Hz"}),
        }
    )


def excited(frequency: Array, diameter: Array, blades: int, orders: Iterable[int]) -> Array:
    """Return the frequencies (point, mode) of nodal diameters that engine orders excite, ascending
    at each point; NaN after the last one."""
    meant = np.isin(diameter, [ANY, *aliased(np.array([*orders]), blades)])
    return np.sort(np.where(meant, frequency, np.nan), axis=1)


def _meetings(key: Array, exciting: Array, lines: Array) -> Iterator[tuple[float, float]]:
    """Yield the value of the key and the frequency where a frequency (point,) meets lines (point,
    line); points without a result are left out."""
    finished = np.isfinite(exciting)
    key, lines = key[finished], lines[finished]
    apart = exciting[finished, None] - lines
    meets = (apart[:-1] <= 0.0) != (apart[1:] <= 0.0)
    for left, line in np.argwhere(meets & np.isfinite(apart[:-1]) & np.isfinite(apart[1:])):
        here, there = apart[left : left + 2, line]
        share = here / (here - there)
        at, frequency = (
            (1.0 - share) * each[left] + share * each[left + 1] for each in (key, lines[:, line])
        )
        yield float(at), float(frequency)

"""Regimes in reports: names, meaning, criterion, and where they occur in a sweep."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr

from bladewhirl.postprocess.energy.regimes import CRITERION
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.reports.page import Table
from bladewhirl.postprocess.sweep.quantities import other_keys

MOST_RANGES = 5
"""Largest number of ranges of a key that are listed."""


class Regime(NamedTuple):
    """Regime in the words of a report."""

    name: str
    tone: str  #: tone of the page, see `page.Page`
    meaning: str


REGIMES: Mapping[str, Regime] = {
    "divergent": Regime("Divergent", "bad", "The motion grows beyond the linear model."),
    "sustained": Regime("Sustained contact", "fair", "Contact persists without growth."),
    "damped": Regime("Damped", "good", "Blades touched the casing and came free again."),
    "no-contact": Regime("No contact", "good", "No blade touched the casing."),
}
"""Regimes, the worst first."""


def criterion_table(regime: str = "") -> Table:
    """Return the criterion of the regimes; the line of the given regime is marked."""
    rows = [(str(name), rule) for name, rule in CRITERION.items()]
    if regime:
        marked = [name for name, _ in rows].index(regime)
        return Table(name="criterion", title="Criterion", rows=rows, wide=False, marked=marked)
    return Table(
        name="criterion",
        title="Criterion of the regimes",
        caption="The first line that applies is the regime.",
        rows=rows,
        folded=True,
    )


def regime_table(points: xr.Dataset, counts: Mapping[str, int]) -> Table:
    """Return the number of points of each regime, and the ranges of the swept keys.

    Args:
        points: over (line, key): `regime`; attribute `along`.
        counts: number of points by regime.
    """
    key, others = points[str(points.attrs["along"])], other_keys(points)
    rows = []
    for name, count in counts.items():
        here = points["regime"].values == name
        ranges = [_ranges(key.values, here.any(axis=0))]
        ranges += [_ranges(other.values, here.any(axis=1)) for other in others]
        rows.append((REGIMES[name].name, str(count), *ranges))
    return Table(
        name="regime-ranges",
        title="Ranges of the regimes",
        head=("regime", "points", *map(key_heading, (key, *others))),
        rows=rows,
    )


def key_heading(key: xr.DataArray) -> str:
    """Return the name of a swept key with its unit."""
    name, units = str(key.attrs["long_name"]), str(key.attrs["units"])
    return name if units == "1" else f"{name} [{units}]"


def _ranges(values: Array, chosen: Array) -> str:
    """Ranges of neighbouring values at which something is true."""
    every = np.unique(values)
    inside = np.isin(every, values[chosen]).astype(int)
    edges = np.flatnonzero(np.diff(inside, prepend=0, append=0)).reshape(-1, 2)
    ranges = [(every[first], every[after - 1]) for first, after in edges]
    texts = [f"{low:.5g}" if low == high else f"{low:.5g} to {high:.5g}" for low, high in ranges]
    return ", ".join([*texts[:MOST_RANGES], *(["…"] if len(texts) > MOST_RANGES else [])])

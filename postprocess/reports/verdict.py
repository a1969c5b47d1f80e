"""Regimes in the words of a report: what each means, by which rule it is told, where it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr

from bladewhirl.postprocess.energy.regimes import CRITERION
from bladewhirl.postprocess.reports.page import Table
from bladewhirl.postprocess.sweep.quantities import other_keys

MOST_PARTS = 3
"""Parts of a second key that the headline tells apart: of more it gives the extent."""


class RegimeWords(NamedTuple):
    """A regime in words."""

    name: str
    tone: str  #: of the page, see `page.Page`
    meaning: str
    at_points: str  #: of a sweep: "diverges at ..."


REGIMES: Mapping[str, RegimeWords] = {
    "divergent": RegimeWords(
        name="Divergent",
        tone="bad",
        meaning="the motion grows until a linear model has nothing left to say",
        at_points="diverges",
    ),
    "sustained": RegimeWords(
        name="Sustained contact",
        tone="fair",
        meaning="blades and casing go on touching, without growth beyond its uncertainty",
        at_points="stays in contact",
    ),
    "damped": RegimeWords(
        name="Damped",
        tone="good",
        meaning="blades and casing touched, and the motion came free of the casing again",
        at_points="touches and comes free again",
    ),
    "no-contact": RegimeWords(
        name="No contact",
        tone="good",
        meaning="no blade ever touched the casing",
        at_points="never touches",
    ),
}
"""The worst first."""


def criterion_table(regime: str = "") -> Table:
    """The rule by which regimes are told apart: of a run, whose line is marked, or of a sweep."""
    rules = [rule.partition(": ") for rule in CRITERION.split("; ")]
    rows = [(name, words) for name, colon, words in rules if colon]
    if regime:
        marked = [name for name, _ in rows].index(regime)
        return Table(name="criterion", title="Criterion", rows=rows, wide=False, marked=marked)
    return Table(
        name="criterion",
        title="Criterion of the regimes",
        caption="Applied from above: the first line that fits is the regime.",
        rows=rows,
        folded=True,
    )


def headline(points: xr.Dataset | None, counts: Mapping[str, int], keys: str) -> str:
    """Which regime is where along the swept keys, in one sentence.

    Args:
        points: over (line, key): `regime`; attribute `along`; None where no point is done.
        counts: regimes to tell of, with how often each is.
        keys: names of all swept keys.
    """
    if points is None:
        return f"Swept: {keys}. No point is done."
    words = [f"{REGIMES[name].at_points} at {_places(points, name)}" for name in counts]
    return f"Swept: {keys}. The stage " + "; ".join(words) + "."


def _places(points: xr.Dataset, name: str) -> str:
    """Values of the key at which a regime is, and for which values of the others."""
    key = points[str(points.attrs["along"])]
    found_at = points["regime"].values == name
    own = f"{key.attrs['long_name']} {_ranges(key, found_at.any(axis=0))}"
    others = other_keys(points)
    if not others:
        return own
    if len(others) > 1:
        return f"{own} (with some values of the other keys)"
    (other,) = others
    parts: dict[str, np.ndarray] = {}
    for line in np.flatnonzero(found_at.any(axis=1)):
        values = _ranges(key, found_at[line])
        parts.setdefault(values, np.zeros(len(found_at), dtype=np.bool_))[line] = True
    if len(parts) > MOST_PARTS:
        extent = _ranges(other, found_at.any(axis=1))
        return f"{own} with {other.attrs['long_name']} {extent} (not at every pair of them)"
    if len(parts) == 1 and found_at.any(axis=1).all():
        return f"{own} whatever {other.attrs['long_name']}"
    places = [
        f"{values.replace(', ', ' and ')} with {_ranges(other, lines)}"
        for values, lines in parts.items()
    ]
    places[0] = places[0].replace("with ", f"with {other.attrs['long_name']} ")
    return f"{key.attrs['long_name']} " + ", at ".join(places)


def _ranges(key: xr.DataArray, chosen: np.ndarray, most: int = 5) -> str:
    """Runs of neighbouring values, in words, with their unit."""
    values, units = key.values, str(key.attrs["units"])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], chosen.astype(int), [0]])))
    runs = [(values[a], values[b - 1]) for a, b in edges.reshape(-1, 2)]
    said = [f"{a:.5g}" if a == b else f"{a:.5g} to {b:.5g}" for a, b in runs[:most]]
    more = f", {len(runs) - most} more ranges" if len(runs) > most else ""
    return ", ".join(said) + ("" if units == "1" else f" {units}") + more

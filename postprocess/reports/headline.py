"""Where along the keys of a sweep which regime is, in one sentence."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from bladewhirl.postprocess.sweep.quantities import other_keys

MOST_PARTS = 3
"""Parts of a second key that the headline tells apart: of more it gives the extent."""

WORDS = {
    "divergent": "diverges",
    "sustained": "stays in contact",
    "damped": "touches and comes free again",
    "no-contact": "never touches",
}


def headline(points: xr.Dataset | None, counts: Mapping[str, int], keys: str) -> str:
    """Where along the keys which regime is.

    Args:
        points: over (line, key): `regime`; attribute `along`; None where no point is done.
        counts: regimes to tell of, with how often each is.
        keys: names of all swept keys.
    """
    if points is None:
        return f"Swept: {keys}. No point is done."
    words = [f"{WORDS[name]} at {_places(points, name)}" for name in counts]
    return f"Swept: {keys}. The stage " + "; ".join(words) + "."


def _places(points: xr.Dataset, name: str) -> str:
    """Where a regime is: along the key, and for which values of the others."""
    key = points[str(points.attrs["along"])]
    is_so = points["regime"].values == name
    own = f"{key.attrs['long_name']} {_ranges(key, is_so.any(axis=0))}"
    others = other_keys(points)
    if not others:
        return own
    if len(others) > 1:
        return f"{own} (with some values of the other keys)"
    (other,) = others
    parts: dict[str, np.ndarray] = {}
    for line in np.flatnonzero(is_so.any(axis=1)):
        values = _ranges(key, is_so[line])
        parts.setdefault(values, np.zeros(len(is_so), dtype=np.bool_))[line] = True
    if len(parts) > MOST_PARTS:
        extent = _ranges(other, is_so.any(axis=1))
        return f"{own} with {key_name(other)} {extent} (not at every pair of them)"
    if len(parts) == 1 and is_so.any(axis=1).all():
        return f"{own} whatever {key_name(other)}"
    found = [
        f"{values.replace(', ', ' and ')} with {_ranges(other, lines)}"
        for values, lines in parts.items()
    ]
    found[0] = found[0].replace("with ", f"with {key_name(other)} ")
    return f"{key.attrs['long_name']} " + ", at ".join(found)


def key_name(key: xr.DataArray) -> str:
    """A swept key as in the case file."""
    return str(key.attrs["long_name"])


def _ranges(key: xr.DataArray, chosen: np.ndarray, most: int = 5) -> str:
    """Runs of neighbouring values, in words, with their unit."""
    values, units = key.values, str(key.attrs["units"])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], chosen.astype(int), [0]])))
    runs = [(values[a], values[b - 1]) for a, b in edges.reshape(-1, 2)]
    said = [f"{a:.5g}" if a == b else f"{a:.5g} to {b:.5g}" for a, b in runs[:most]]
    more = f", {len(runs) - most} more ranges" if len(runs) > most else ""
    return ", ".join(said) + ("" if units == "1" else f" {units}") + more

"""Speeds to avoid, from a sweep over the speed: where marches diverge or contact is strong."""

from collections.abc import Iterator
from typing import TypedDict

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import BoolArray
from bladewhirl.postprocess.sweep.dataset import swept

SPEED = "march_speed"  #: dimension of the speed

STRONG = 2.0
"""Contact is strong if the largest mean force on a contact node is this many times the median over
the speeds with contact."""

RPM = 30.0 / np.pi


class Range(TypedDict):
    """Neighbouring swept speeds, from the first to the last, and why to avoid them."""

    from_rpm: float
    to_rpm: float
    cause: str


def speeds_to_avoid(dataset: xr.Dataset) -> list[Range]:
    """Return ranges of the swept speeds to avoid, ascending; none without a swept speed.

    Of several values of other keys and of random draws the worst counts.

    Args:
        dataset: a sweep from `open_sweep`.
    """
    if SPEED not in swept(dataset):
        return []
    others = [name for name in swept(dataset) if name != SPEED]
    ordered = dataset[["regime", "contact_force_max", "state"]].sortby(SPEED)
    divergent = ((ordered["regime"] == "divergent") & (ordered["state"] == "done")).mean(others)
    force = ordered["contact_force_max"].where(ordered["state"] == "done").max(others).values
    touching = force[force > 0.0]
    median = float(np.median(touching)) if len(touching) else np.inf
    found = []
    for low, high in _ranges(divergent.values > 0.0):
        share = float(divergent.values[low:high].max())
        found.append((low, high, "divergent" + f" in up to {share:.0%}" * (share < 1.0)))
    for low, high in _ranges(force > STRONG * median):
        largest = float(np.nanmax(force[low:high]))
        times = f"{largest / median:.2g} times the median"
        found.append((low, high, f"contact force up to {largest:.4g} N, {times}"))
    rpm = RPM * ordered[SPEED].values
    return [
        Range(from_rpm=float(rpm[low]), to_rpm=float(rpm[high - 1]), cause=cause)
        for low, high, cause in sorted(found)
    ]


def _ranges(bad: BoolArray) -> Iterator[tuple[int, int]]:
    """Yield begin and end of each run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], bad, [False]]).astype(int)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)

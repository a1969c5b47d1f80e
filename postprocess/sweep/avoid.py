"""Speeds to avoid, from a sweep over the speed: where marches diverge or contact is strong."""

import tomllib
from collections.abc import Iterator
from typing import TypedDict

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import BoolArray
from bladewhirl.models.inputs.units import Speed
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
    margin: float | None
    """Distance of the range from the speed of the case, divided by this speed; None without it."""


def speeds_to_avoid(dataset: xr.Dataset) -> list[Range]:
    """Return ranges of the swept speeds to avoid, ascending; none without a swept speed.

    Of several values of other keys and of random draws the worst counts.

    Args:
        dataset: a sweep from `open_sweep`.
    """
    if SPEED not in swept(dataset):
        return []
    others = [name for name in swept(dataset) if name != SPEED]
    names = ["regime", "contact_force_max", "state", "rotation_speed", "reference_frequency"]
    ordered = dataset[names].sortby(SPEED)
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
    rpm = RPM * ordered["rotation_speed"].max(others).values
    speed = RPM * _speed_of_case(dataset.attrs["case"], float(dataset["reference_frequency"].max()))
    rows = []
    for low, high, cause in sorted(found):
        ends = float(rpm[low]), float(rpm[high - 1])
        apart = max(ends[0] - speed, speed - ends[1], 0.0)
        margin = apart / abs(speed) if speed else None
        rows.append(Range(from_rpm=ends[0], to_rpm=ends[1], cause=cause, margin=margin))
    return rows


def _speed_of_case(text: str, reference: float) -> float:
    """Return the speed of the case that is varied [rad/s]; 0 if it is not constant."""
    march = tomllib.loads(text).get("march", {})
    if march.keys() & {"speed_table", "run_up"}:
        return 0.0
    return Speed(march["speed"]).rad_per_s(reference)


def _ranges(bad: BoolArray) -> Iterator[tuple[int, int]]:
    """Yield begin and end of each run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], bad, [False]]).astype(int)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)

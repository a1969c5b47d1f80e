"""Speeds to avoid in and near an operating range: what a Campbell diagram says, in one list."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from bladewhirl.studies.modal.resonances import margin
from bladewhirl.studies.runs.columns import Column

NEAR = 0.2  #: largest margin of a speed that is listed

COLUMNS = (
    Column("from_rpm", "from [rpm]", ".1f"),
    Column("to_rpm", "to [rpm]", ".1f"),
    Column("cause", "cause"),
    Column("margin", "margin [%]", ".1f", 100.0),
)
"""Columns of the speeds to avoid."""


def speeds_to_avoid(
    document: Mapping[str, Any], operating: tuple[float, float]
) -> list[dict[str, Any]]:
    """Return the ranges of speed to avoid as rows, see `COLUMNS`, by margin and then by speed.

    The range of a resonance in a rub is that between free and held tips; other ranges have one
    speed, or no end (None). The margin is the distance from the operating range, divided by its
    nearer end.

    Args:
        document: document of `campbell`, without these rows.
        operating: ends of the operating range [rpm].
    """
    found = [(margin(low, high, operating), low, high, why) for low, high, why in _ranges(document)]
    return [
        {
            "from_rpm": low,
            "to_rpm": high if np.isfinite(high) else None,
            "cause": cause,
            "margin": share,
        }
        for share, low, high, cause in sorted(found)
        if share <= NEAR
    ]


def _ranges(document: Mapping[str, Any]) -> Iterator[tuple[float, float, str]]:
    """Yield the ends of each range [rpm] and its cause."""
    for row in document.get("resonances", ()):
        both = [each for each in (row["free_rpm"], row["held_rpm"]) if each is not None]
        excited = _mode(row["family"], row.get("k"))
        yield min(both), max(both), f"order {row['order']} ({row['source']}) excites {excited}"
    for row in document["coincidences"]:
        rotor, casing = _mode(row["rotor_family"], row["nodal_diameter"]), row["casing_family"]
        cause = f"waves of {rotor} and of the casing ({casing}) travel together"
        yield row["speed_rpm"], row["speed_rpm"], cause
    for row in document.get("critical_speeds", ()):
        yield row["rpm"], row["rpm"], f"critical speed of {_mode(row['family'], row['k'])}"
    if (merged := document.get("waves_meet")) is not None:
        yield merged["rpm"], np.inf, "two waves have merged and grow"


def _mode(family: str, k: int | None) -> str:
    return family if k is None else f"{family}, k = {k}"

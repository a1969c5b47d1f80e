"""Regimes in reports: names, meanings and criteria."""

from collections.abc import Mapping
from typing import NamedTuple

import xarray as xr

from bladewhirl.postprocess.energy.regimes import CRITERION
from bladewhirl.postprocess.reports.page import PageTable


class RegimeText(NamedTuple):
    """Description of a regime in a report."""

    name: str
    tone: str  #: class of the verdict, which selects its colour, see `page.Page`
    meaning: str  #: meaning in one sentence


REGIMES: Mapping[str, RegimeText] = {
    "divergent": RegimeText("Divergent", "bad", "The motion grows beyond the linear model."),
    "sustained": RegimeText("Sustained contact", "fair", "Contact persists without growth."),
    "damped": RegimeText("Damped", "good", "Blades touched the casing and came free again."),
    "no-contact": RegimeText("No contact", "good", "No blade touched the casing."),
}
"""Regimes, the worst first."""


def criterion_table(regime: str = "") -> PageTable:
    """Return a table of the criteria of the regimes; the row of `regime` is highlighted."""
    return PageTable(
        name="criterion",
        title="Criterion of the regimes",
        caption="The regime is the first line that applies.",
        rows=[(str(name), rule) for name, rule in CRITERION.items()],
        wide=not regime,
        folded=not regime,
        marked=[*map(str, CRITERION)].index(regime) if regime else None,
    )


def key_heading(key: xr.DataArray) -> str:
    """Return the name of a swept key with its unit."""
    name, units = str(key.attrs["long_name"]), str(key.attrs["units"])
    return name if units == "1" else f"{name} [{units}]"

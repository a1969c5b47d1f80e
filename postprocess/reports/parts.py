"""Parts that reports of runs and of sweeps have in common: regimes, resolved case, provenance."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import xarray as xr

from bladewhirl.postprocess.energy.regimes import CRITERION
from bladewhirl.postprocess.reports.page import PageSection, PageTable, Text

Provenance = Mapping[str, object]
"""Content of provenance.json; an empty mapping if the file does not exist."""


def subject(dataset: xr.Dataset, provenance: Provenance, name: str) -> str:
    """Return the line of a report with name, program version and date of a result."""
    date = str(provenance.get("date", ""))[:16].replace("T", " ")
    program = f"bladewhirl {dataset.attrs.get('version', '')}"
    return ", ".join(filter(None, [name, program, f"{date} UTC" if date else ""]))


def case_section(dataset: xr.Dataset, provenance: Provenance, caption: str) -> PageSection:
    """Return the section with the resolved case, under a caption, and the provenance of a result or
    a sweep."""
    text = str(dataset.attrs.get("case", "")).strip()
    case = Text(
        name="resolved-case", title="Resolved case", text=text, caption=caption, folded=True
    )
    blocks = [case, *_tables(dataset, provenance)]
    return PageSection(name="case", title="Case and provenance", blocks=blocks)


def _tables(dataset: xr.Dataset, provenance: Provenance) -> Iterator[PageTable]:
    """Yield a table of program and computer, and a table of the versions of the libraries."""
    facts = {name: value for name, value in provenance.items() if isinstance(value, str)}
    facts.setdefault("bladewhirl", str(dataset.attrs.get("version", "")))
    if dataset.attrs.get("symmetry"):
        facts["symmetry"] = str(dataset.attrs["symmetry"])
    yield PageTable(name="provenance", title="Provenance", rows=list(facts.items()))
    libraries = provenance.get("dependencies")
    if isinstance(libraries, Mapping):
        yield PageTable(
            name="dependencies",
            title="Versions of the libraries",
            rows=[(str(name), str(version)) for name, version in libraries.items()],
            folded=True,
        )


class RegimeText(NamedTuple):
    """Description of a regime in a report."""

    name: str
    tone: str  #: class of the verdict, which selects its colour, see `page.Page`
    meaning: str  #: meaning in one sentence


REGIMES: Mapping[str, RegimeText] = {
    "divergent": RegimeText("Divergent", "bad", "The motion grows beyond the linear model."),
    "sustained": RegimeText("Sustained contact", "fair", "Contact persists to the end."),
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

"""How a result was made, in a report: its resolved case, program, machine and libraries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import xarray as xr

from bladewhirl.postprocess.reports.page import Section, Table, Text

Provenance = Mapping[str, object]
"""Content of provenance.json; empty where that is not told."""


def subject(dataset: xr.Dataset, provenance: Provenance, name: str) -> str:
    """Name, program and date of a result, in words."""
    date = str(provenance.get("date", ""))[:16].replace("T", " ")
    made = f"bladewhirl {dataset.attrs.get('version', '')}"
    return ", ".join(filter(None, [name, made, f"{date} UTC" if date else ""]))


def case_section(
    dataset: xr.Dataset, provenance: Provenance, *, text: str, caption: str
) -> Section:
    """The resolved case of a result, and how it was made.

    Args:
        dataset: a result or a sweep.
        provenance: of it.
        text: the case.
        caption: words with the case.
    """
    case = Text(
        name="resolved-case", title="Resolved case", text=text, caption=caption, folded=True
    )
    blocks = [case, *_tables(dataset, provenance)]
    return Section(name="case", title="Case and provenance", blocks=blocks)


def _tables(dataset: xr.Dataset, provenance: Provenance) -> Iterator[Table]:
    """Program, machine, and versions of the libraries it uses."""
    made = {name: value for name, value in provenance.items() if isinstance(value, str)}
    made.setdefault("bladewhirl", str(dataset.attrs.get("version", "")))
    if dataset.attrs.get("symmetry"):
        made["symmetry"] = str(dataset.attrs["symmetry"])
    yield Table(name="provenance", title="Provenance", rows=list(made.items()))
    used = provenance.get("dependencies")
    if isinstance(used, Mapping):
        yield Table(
            name="dependencies",
            title="Versions of the libraries",
            rows=[(str(name), str(version)) for name, version in used.items()],
            folded=True,
        )

"""Provenance in a report: resolved case, program, computer and libraries."""

from collections.abc import Iterator, Mapping

import xarray as xr

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

"""Report of a run of a superelement: regime, figures, numbers and case."""

import xarray as xr

from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.plotting.registry import NODE_FIGURES
from bladewhirl.postprocess.plotting.titles import speed_label
from bladewhirl.postprocess.reports.page import Page, Section, report_figures
from bladewhirl.postprocess.reports.provenance import Provenance, case_section, subject
from bladewhirl.postprocess.reports.run import CASE_CAPTION, end_warnings, sentence, summary_table
from bladewhirl.postprocess.reports.verdict import REGIMES, criterion_table
from bladewhirl.postprocess.superelement.regime import node_regime
from bladewhirl.postprocess.superelement.run_figures import NodeFigures
from bladewhirl.postprocess.superelement.summary import summarise_nodes

TITLES = {
    "contact": "Contact of blades and casing",
    "casing": "Motion of the casing",
    "wear": "Wear of the coating",
}
"""Sections with figures."""


def node_report(dataset: xr.Dataset, provenance: Provenance, *, name: str = "") -> Page:
    """Return the report of a run of a superelement, for `page.write_page`.

    Args:
        dataset: result of a superelement.
        provenance: provenance of the run.
        name: name of the run, such as its folder.

    Raises:
        ViewError: the result has fewer than two records.
    """
    figures, regime = NodeFigures(dataset), node_regime(dataset)
    kinds = [NODE_FIGURES[name] for name in figures.names]
    meaning = REGIMES[regime.name].meaning
    reason = str(dataset.attrs.get("end_reason", "completed"))
    ended = reason in ("completed", "divergent", "damped")
    drawn = {
        part: report_figures(figures.draw, [kind for kind in kinds if kind.section == part])
        for part in TITLES
    }
    numbers = summary_table(dataset, lambda report: summarise_nodes(dataset, report).rows())
    sections = [
        Section(
            name="verdict",
            title="Regime, and why",
            words=f"{meaning} The regime is the first line of the criterion below that applies.",
            blocks=[criterion_table(regime.name)],
        ),
        *(
            Section(name=part, title=TITLES[part], blocks=blocks)
            for part, blocks in drawn.items()
            if blocks
        ),
        Section(name="numbers", title="Numbers", blocks=[numbers]),
        case_section(dataset, provenance, CASE_CAPTION),
    ]
    return Page(
        title=str(dataset.attrs.get("title", "")) or "Run",
        subject=subject(dataset, provenance, name),
        verdict=sentence(regime.name).rstrip(".") + ("" if ended else " so far"),
        tone=REGIMES[regime.name].tone if ended else "open",
        reason=f"{meaning} {sentence(regime.reason)}",
        warnings=end_warnings(dataset, reason),
        figures=_glance(dataset),
        sections=sections,
    )


def _glance(dataset: xr.Dataset) -> list[tuple[str, str, str]]:
    """Return the key figures: name, value, remark."""
    ratio, _, rpm = speed_label(dataset).partition(" (")
    touched = int((dataset["contact_steps"].sum("time").values > 0).sum())
    moved = abs(dataset["contact_displacement"]).max(("time", "contact_node")).values
    return [
        ("speed", ratio, rpm.rstrip(")")),
        ("end of the march", f"{float(dataset['time'].values[-1]):.6g} s", ""),
        ("contact nodes that touched", f"{touched} of {dataset.sizes['contact_node']}", ""),
        *(
            (f"largest {name} displacement", handy(float(value), "m", 4), "")
            for name, value in zip(dataset["direction"].values, moved, strict=True)
        ),
    ]

"""Report of a run of a superelement: regime, figures, numbers and case."""

import xarray as xr

from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.plotting.registry import NODE_FIGURES
from bladewhirl.postprocess.plotting.titles import speed_label
from bladewhirl.postprocess.reports.page import Page, Section, report_figures
from bladewhirl.postprocess.reports.provenance import Provenance
from bladewhirl.postprocess.reports.run import page_of_run, summary_table
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
    figures = NodeFigures(dataset)
    kinds = [NODE_FIGURES[each] for each in figures.names]
    drawn = {
        part: report_figures(figures.draw, [kind for kind in kinds if kind.section == part])
        for part in TITLES
    }
    return page_of_run(
        dataset,
        provenance,
        node_regime(dataset),
        name=name,
        parts=[
            Section(name=part, title=TITLES[part], blocks=blocks)
            for part, blocks in drawn.items()
            if blocks
        ],
        numbers=summary_table(dataset, lambda report: summarise_nodes(dataset, report).rows()),
        glance=_glance(dataset),
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

"""Report of a run: regime, figures, numbers and case."""

import math
from collections.abc import Callable, Mapping, Sequence

import xarray as xr

from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.energy.regimes import classify
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.plotting.titles import speed_label
from bladewhirl.postprocess.reports.figures import figures_of_run
from bladewhirl.postprocess.reports.instants import instants
from bladewhirl.postprocess.reports.page import Page, PageSection, PageTable, report_figures
from bladewhirl.postprocess.reports.parts import (
    REGIMES,
    Provenance,
    case_section,
    criterion_table,
    subject,
)
from bladewhirl.postprocess.run.blade_contact import CLASS_COLOURS, contact_classes
from bladewhirl.postprocess.run.contact_side import contact_phase
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.run.node_summary import node_regime, summarise_nodes
from bladewhirl.postprocess.run.summary import MARCH_REPORT, summarise
from bladewhirl.postprocess.run.summary_table import summary_rows
from bladewhirl.postprocess.shaft.orbits import MILLI
from bladewhirl.postprocess.shaft.whirl import FRAMES, whirl

LATE = "over the last third"  #: time window of whirl and contact scenario
CASE_CAPTION = (
    "All keys of the case with their values in SI units. Save these lines as a case file;"
    " bladewhirl run with this file repeats the run."
)
UNKNOWN = ("complementarity residual", "time step / critical", "wall time")
"""Rows of the summary that are known only after the march has ended."""

TITLES = {
    "shaft": "Motion of the shaft",
    "contact": "Contact of blades and casing",
    "casing": "Motion of the casing",
    "frequencies": "Frequencies",
    "energy": "Strain energy and stress",
    "wear": "Wear of the coating",
}
"""Names and titles of the sections with figures; a report leaves out sections without a figure."""


def run_report(dataset: xr.Dataset, provenance: Provenance, *, name: str = "") -> Page:
    """Return the report of a run, of beams or of a superelement, for `page.write_page`.

    The report of an interrupted march covers the time up to its last record and has a warning.

    Args:
        dataset: a result.
        provenance: provenance of the run.
        name: name of the run, such as its folder.

    Raises:
        ViewError: the result has fewer than two records.
    """
    figures = figures_of_run(dataset)
    first, glance = [], _glance(dataset)
    if isinstance(figures, RunFigures):
        energy, orbit = figures.energies, figures.orbit
        regime = classify(dataset, energy["total"].values)
        plots = instants(dataset, figures.contact, orbit, energy)
        first.append(PageSection(name="instant", title="At one instant", blocks=[plots]))
        glance += _beam_glance(dataset, orbit)
        stresses = figures.stresses
        rows = _summary(dataset, lambda report: summary_rows(summarise(dataset, report, stresses)))
    else:
        regime = node_regime(dataset)
        glance += _node_glance(dataset)
        rows = _summary(dataset, lambda report: summarise_nodes(dataset, report).rows())
    meaning = REGIMES[regime.name].meaning
    reason = str(dataset.attrs.get("end_reason", "completed"))
    ended = reason in ("completed", "divergent", "damped")
    verdict = PageSection(
        name="verdict",
        title="Regime, and why",
        words=f"{meaning} The regime is the first line of the criterion below that applies.",
        blocks=[*report_figures(figures, "verdict"), criterion_table(regime.name)],
    )
    parts = [
        PageSection(name=part, title=title, blocks=blocks)
        for part, title in TITLES.items()
        if (part != "wear" or "coating_strain" in dataset)
        and (blocks := report_figures(figures, part))
    ]
    numbers = PageSection(name="numbers", title="Numbers", blocks=[rows])
    case = case_section(dataset, provenance, CASE_CAPTION)
    return Page(
        title=str(dataset.attrs.get("title", "")) or "Run",
        subject=subject(dataset, provenance, name),
        verdict=_sentence(regime.name).rstrip(".") + ("" if ended else " so far"),
        tone=REGIMES[regime.name].tone if ended else "open",
        reason=f"{meaning} {_sentence(regime.reason)}",
        warnings=_warnings(dataset, reason),
        figures=glance,
        sections=[*first, verdict, *parts, numbers, case],
    )


def _late(dataset: xr.Dataset) -> xr.Dataset:
    """Return the records of the last third of the time, or of the complete run if the last third
    has fewer than two records."""
    late = late_part(dataset)
    return late if late.sizes["time"] > 1 else dataset


def _summary(
    dataset: xr.Dataset, rows_of: Callable[[Mapping[str, float]], Mapping[str, str]]
) -> PageTable:
    """Return the rows of a summary. If the march has not ended, rows that are known only at its end
    are left out. `rows_of` makes the rows from the quality measures of the march."""
    reported = {name: dataset.attrs.get(name, math.nan) for name in MARCH_REPORT}
    done = float(dataset["time"].values[-1]) / float(dataset.attrs["time_step"])
    missing = any(math.isnan(float(reported[name])) for name in MARCH_REPORT)
    if missing:
        reported |= {"steps": round(done), "unsolved_steps": 0}
    left_out = {"because", *(UNKNOWN if missing else ())}  # the reason is at the top of the page
    shown = [row for row in rows_of(reported).items() if row[0] not in left_out]
    return PageTable(name="summary", title="Summary", rows=shown)


def _warnings(dataset: xr.Dataset, reason: str) -> Sequence[str]:
    """Return warnings for a march that did not reach its planned end."""
    end = f"{float(dataset['time'].values[-1]):.6g} s"
    message = str(dataset.attrs.get("end_message", ""))
    texts = {
        "completed": "",
        "damped": message,
        "divergent": message.partition("; ")[2],  # the reason is shown with the regime
        "interrupted": f"The march was interrupted at {end}.",
    }
    unfinished = "The march is unfinished: it was killed, or is still running."
    text = texts.get(reason, f"{unfinished} The last record is at {end}.")
    return [_sentence(text)] if text else []


def _glance(dataset: xr.Dataset) -> list[tuple[str, str, str]]:
    """Return the key figures of every run: name, value, remark."""
    ratio, _, rpm = speed_label(dataset).partition(" (")
    end = f"{float(dataset['time'].values[-1]):.6g} s"
    return [("speed", ratio, rpm.rstrip(")")), ("end of the march", end, "")]


def _node_glance(dataset: xr.Dataset) -> list[tuple[str, str, str]]:
    """Return the key figures of contact nodes."""
    touched = int((dataset["contact_steps"].sum("time").values > 0).sum())
    moved = abs(dataset["contact_displacement"]).max(("time", "contact_node")).values
    return [
        ("contact nodes that touched", f"{touched} of {dataset.sizes['contact_node']}", ""),
        *(
            (f"largest recorded {name} displacement", handy(float(value), "m", 4), "")
            for name, value in zip(dataset["direction"].values, moved, strict=True)
        ),
    ]


def _beam_glance(dataset: xr.Dataset, orbit: xr.Dataset) -> list[tuple[str, str, str]]:
    """Return the key figures of shaft and blades."""
    late, late_orbit = _late(dataset), _late(orbit)
    classes = contact_classes(late)["contact_class"].values
    radius = MILLI * float(orbit["radius"].max())
    clearance = MILLI * float(orbit.attrs["smallest_clearance"])
    touched = int((dataset["contact_steps"].sum("time").values > 0).sum())
    counts = {name: int((classes == name).sum()) for name in CLASS_COLOURS}
    phases = contact_phase(late, late_orbit)
    in_contact, lead = bool(phases["impulse"].any()), float(phases.attrs["lead"])
    angle = (
        [f"shaft leads by {math.degrees(lead):.0f}°"] if in_contact and not math.isnan(lead) else []
    )
    whirls = {frame: whirl(late_orbit, frame).text.partition(", ") for frame in FRAMES}
    return [
        (
            "largest recorded shaft displacement",
            f"{radius:.4g} mm",
            f"{radius / clearance:.3g} times the clearance" if clearance else "",
        ),
        *(
            (f"whirl, {frame} frame", direction, ", ".join(filter(None, [rate, LATE])))
            for frame, (direction, _, rate) in whirls.items()
        ),
        (
            "blades that touched",
            f"{touched} of {dataset.sizes['blade']}",
            ", ".join(f"{count} {name}" for name, count in counts.items() if count),
        ),
        (
            "contact scenario",
            str(phases.attrs["scenario"]) if in_contact else "no contact",
            ", ".join([*angle, LATE]),
        ),
    ]


def _sentence(words: str) -> str:
    """Return words with a capital at the start and a full stop at the end."""
    return words[:1].upper() + words[1:].rstrip(".") + "."

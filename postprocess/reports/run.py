"""Report of a run: regime, figures, numbers and case."""

import math
from collections.abc import Callable, Mapping, Sequence

import xarray as xr

from bladewhirl.postprocess.energy.regimes import Regime, classify
from bladewhirl.postprocess.energy.strain import strain_energies
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.plotting.registry import RUN_FIGURES
from bladewhirl.postprocess.plotting.titles import speed_label
from bladewhirl.postprocess.reports.instants import instants
from bladewhirl.postprocess.reports.page import Page, ReportFigure, Section, Table, report_figures
from bladewhirl.postprocess.reports.provenance import Provenance, case_section, subject
from bladewhirl.postprocess.reports.verdict import REGIMES, criterion_table
from bladewhirl.postprocess.run.blade_contact import CLASS_COLOURS, contact_classes
from bladewhirl.postprocess.run.contact_side import contact_phase
from bladewhirl.postprocess.run.figures import RunFigures
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


def run_report(dataset: xr.Dataset, provenance: Provenance, *, name: str = "") -> Page:
    """Return the report of a run, for `page.write_page`.

    The report of an interrupted march covers the time up to its last record and has a warning.

    Args:
        dataset: a result.
        provenance: provenance of the run.
        name: name of the run, such as its folder.

    Raises:
        ViewError: the result has fewer than two records.
    """
    titles = {
        "shaft": "Motion of the shaft",
        "contact": "Contact of blades and casing",
        "frequencies": "Frequencies",
        "energy": "Strain energy and stress",
    }
    if "coating_strain" in dataset:
        titles["wear"] = "Wear of the coating"
    figures = RunFigures(dataset)
    energy = strain_energies(dataset)
    regime = classify(dataset, energy["total"].values)
    instant = Section(
        name="instant",
        title="At one instant",
        blocks=[instants(dataset, figures.contact, figures.orbit, energy)],
    )
    parts = [
        Section(name=part, title=title, blocks=_drawn(figures, part))
        for part, title in titles.items()
    ]
    return page_of_run(
        dataset,
        provenance,
        regime,
        name=name,
        first=[instant],
        reasons=_drawn(figures, "verdict"),
        parts=parts,
        numbers=_numbers(figures),
        glance=_glance(dataset, figures.orbit, contact_classes(_late(dataset))),
    )


def page_of_run(
    dataset: xr.Dataset,
    provenance: Provenance,
    regime: Regime,
    *,
    name: str,
    parts: Sequence[Section],
    numbers: Table,
    glance: Sequence[tuple[str, str, str]],
    first: Sequence[Section] = (),
    reasons: Sequence[ReportFigure] = (),
) -> Page:
    """Return the page of a run from its parts.

    Args:
        dataset: a result, of beams or of a superelement.
        provenance: provenance of the run.
        regime: regime of the run.
        name: name of the run, such as its folder.
        parts: sections with figures.
        numbers: table of the summary.
        glance: key figures: name, value, remark.
        first: sections above the regime.
        reasons: figures that show why the run has this regime.
    """
    meaning = REGIMES[regime.name].meaning
    reason = str(dataset.attrs.get("end_reason", "completed"))
    ended = reason in ("completed", "divergent", "damped")
    verdict = Section(
        name="verdict",
        title="Regime, and why",
        words=f"{meaning} The regime is the first line of the criterion below that applies.",
        blocks=[*reasons, criterion_table(regime.name)],
    )
    table = Section(name="numbers", title="Numbers", blocks=[numbers])
    return Page(
        title=str(dataset.attrs.get("title", "")) or "Run",
        subject=subject(dataset, provenance, name),
        verdict=_sentence(regime.name).rstrip(".") + ("" if ended else " so far"),
        tone=REGIMES[regime.name].tone if ended else "open",
        reason=f"{meaning} {_sentence(regime.reason)}",
        warnings=_warnings(dataset, reason),
        figures=glance,
        sections=[*first, verdict, *parts, table, case_section(dataset, provenance, CASE_CAPTION)],
    )


def _numbers(figures: RunFigures) -> Table:
    dataset, stresses = figures.result, figures.stresses
    return summary_table(dataset, lambda report: summary_rows(summarise(dataset, report, stresses)))


def _drawn(figures: RunFigures, section: str) -> list[ReportFigure]:
    kinds = [kind for kind in RUN_FIGURES.values() if kind.section == section]
    return report_figures(figures.draw, kinds)


def _late(dataset: xr.Dataset) -> xr.Dataset:
    """Return the records of the last third of the time, or of the complete run if the last third
    has fewer than two records."""
    late = late_part(dataset)
    return late if late.sizes["time"] > 1 else dataset


def summary_table(
    dataset: xr.Dataset, rows_of: Callable[[Mapping[str, float]], Mapping[str, str]]
) -> Table:
    """Return the rows of a summary, without those that are known only after the march has ended if
    it has not. `rows_of` makes the rows from the quality measures of the march."""
    reported = {name: dataset.attrs.get(name, math.nan) for name in MARCH_REPORT}
    done = float(dataset["time"].values[-1]) / float(dataset.attrs["time_step"])
    missing = any(math.isnan(float(reported[name])) for name in MARCH_REPORT)
    if missing:
        reported |= {"steps": round(done), "unsolved_steps": 0}
    left_out = {"because", *(UNKNOWN if missing else ())}  # the reason is at the top of the page
    shown = [row for row in rows_of(reported).items() if row[0] not in left_out]
    return Table(name="summary", title="Summary", rows=shown)


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


def _glance(
    dataset: xr.Dataset, orbit: xr.Dataset, classes: xr.Dataset
) -> list[tuple[str, str, str]]:
    """Return the key figures: name, value, remark."""
    late = _late(orbit)
    radius = MILLI * float(orbit["radius"].max())
    clearance = MILLI * float(orbit.attrs["smallest_clearance"])
    touched = int((dataset["contact_steps"].sum("time").values > 0).sum())
    counts = {name: int((classes["contact_class"].values == name).sum()) for name in CLASS_COLOURS}
    phases = contact_phase(_late(dataset), late)
    in_contact, lead = bool(phases["impulse"].any()), float(phases.attrs["lead"])
    angle = (
        [f"shaft leads by {math.degrees(lead):.0f}°"] if in_contact and not math.isnan(lead) else []
    )
    whirls = {frame: whirl(late, frame).text.partition(", ") for frame in FRAMES}
    ratio, _, rpm = speed_label(dataset).partition(" (")
    return [
        ("speed", ratio, rpm.rstrip(")")),
        ("end of the march", f"{float(dataset['time'].values[-1]):.6g} s", ""),
        (
            "largest shaft displacement",
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

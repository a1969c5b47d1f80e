"""Report of a run: regime, figures, numbers and case."""

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.postprocess.energy.regimes import classify, regime_title
from bladewhirl.postprocess.fields.by_blade import blade_count, largest_contact_motion, of_blades
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.labelled import LOSS
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.nodes import DIRECTIONS
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.pictures.choices import Field
from bladewhirl.postprocess.pictures.render import animation_records
from bladewhirl.postprocess.pictures.web_page import film_page
from bladewhirl.postprocess.plotting.titles import speed_label
from bladewhirl.postprocess.reports.page import (
    Block,
    Film,
    Page,
    PageSection,
    PageTable,
    ReportFigure,
    report_figures,
)
from bladewhirl.postprocess.reports.parts import (
    REGIMES,
    Provenance,
    case_section,
    criterion_table,
    subject,
)
from bladewhirl.postprocess.reports.player import player
from bladewhirl.postprocess.run.blade_contact import CLASS_COLOURS, contact_classes
from bladewhirl.postprocess.run.contact_side import contact_phase
from bladewhirl.postprocess.run.extremes import largest_force, stress_split
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.run.histories import contact_force
from bladewhirl.postprocess.run.measures import MARCH_REPORT, Motion
from bladewhirl.postprocess.run.summary import summarise
from bladewhirl.postprocess.run.summary_table import summary_rows
from bladewhirl.postprocess.run.unrolled import unrolled
from bladewhirl.postprocess.run.wear import coating_of
from bladewhirl.postprocess.shaft.orbits import MILLI, shaft_orbit
from bladewhirl.postprocess.shaft.whirl import FRAMES, whirl
from bladewhirl.postprocess.shaft_line.motion import line_bearing_forces

PICTURES = 60  #: number of pictures of the film
FILM = (
    "Wheel to zoom; click on the curve of the force or move the slider to see an instant."
    " Displacements and clearance are enlarged; arrows are contact forces."
)
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
    """Return the report of a run for `page.write_page`.

    The report of an interrupted march covers the time up to its last record and has a warning.

    Args:
        dataset: a result.
        provenance: provenance of the run.
        name: name of the run, such as its folder.

    Raises:
        ViewError: the result has fewer than two records.
    """
    figures = RunFigures(dataset)
    energies = figures.energies
    regime = classify(dataset, energies["total"].values)
    first = [
        PageSection(name="one-page", title="On one page", blocks=report_figures(figures, "card"))
    ]
    stresses = figures.known_stresses
    first.append(_film(dataset, "deformation" if stresses is None else "stress"))
    meaning = REGIMES[regime.name].meaning
    title = regime_title(regime.name, judged=regime.growth is not None)
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
        if (blocks := _blocks(figures, part))
    ]
    numbers = PageSection(name="numbers", title="Numbers", blocks=[_summary(dataset, stresses)])
    case = case_section(dataset, provenance, CASE_CAPTION)
    return Page(
        title=str(dataset.attrs.get("title", "")) or "Run",
        subject=subject(dataset, provenance, name),
        verdict=_sentence(title).rstrip(".") + ("" if ended else " so far"),
        tone=REGIMES[regime.name].tone if ended else "open",
        reason=f"{meaning} {_sentence(regime.reason)}",
        warnings=_warnings(dataset, reason),
        figures=_glance(dataset, stresses),
        sections=[*first, verdict, *parts, numbers, case],
    )


def _blocks(figures: RunFigures, part: str) -> list[Block]:
    """Return the figures of a section; that of contact has the casing over time as well."""
    alone = ["contact-classes"] * (blade_count(figures.result) == 1)  # which compares blades
    blocks: list[Block] = [*report_figures(figures, part, alone)]
    if part == "contact" and blocks:
        place = [block.name for block in blocks].index("unrolled")
        blocks.insert(place + 1, player(unrolled(figures.result)))
    return blocks


def _film(dataset: xr.Dataset, colour: Field) -> PageSection:
    """Return the section with the film around the strongest contact, or the reason why the stage
    cannot be drawn."""
    title, records = "Film of the stage", animation_records(dataset, frames=PICTURES)
    try:
        block: Block = Film(
            name="film",
            title=title,
            caption=FILM if has(dataset, "lines") else f"Drag to turn the stage. {FILM}",
            text=film_page(dataset, records, colour=colour),
        )
    except ViewError as error:
        block = ReportFigure(name="film", title=title, obstacle=str(error))
    return PageSection(name="stage", title="The stage in motion", blocks=[block])


def _late(dataset: xr.Dataset) -> xr.Dataset:
    """Return the records of the last third of the time, or of the complete run if the last third
    has fewer than two records."""
    late = late_part(dataset)
    return late if late.sizes["time"] > 1 else dataset


def _summary(dataset: xr.Dataset, stresses: xr.Dataset | None) -> PageTable:
    """Return the rows of a summary. If the march has not ended, rows that are known only at its end
    are left out. `stresses` are from `stress_history`, None for a stage without stresses."""
    reported = {name: dataset.attrs.get(name, math.nan) for name in MARCH_REPORT}
    done = float(dataset["time"].values[-1]) / float(dataset.attrs["time_step"])
    missing = any(math.isnan(float(reported[name])) for name in MARCH_REPORT)
    if missing:
        reported |= {"steps": round(done), "unsolved_steps": 0}
    left_out = {"because", *(UNKNOWN if missing else ())}  # the reason is at the top of the page
    rows = summary_rows(summarise(dataset, reported, stresses))
    shown = [row for row in rows.items() if row[0] not in left_out]
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


def _loads(dataset: xr.Dataset, stresses: xr.Dataset | None) -> list[tuple[str, str, str]]:
    """Return the largest force, stress and wear: name, value, remark."""
    rows, force = [], largest_force(dataset)
    if force["force"]:
        times = force["averaged_over"], float(dataset.attrs["record_step"])
        over, step = (handy(one, "s", 3) for one in times)
        largest = handy(float(contact_force(dataset)["normal"].max()), "N", 3)
        remark = f"mean over {over}; over {step} up to {largest}"
        rows.append(("largest force on a blade", handy(force["on_blade"], "N", 3), remark))
    split = None if stresses is None else stress_split(stresses)
    if stresses is not None and split is not None:
        unit, scale = handy_unit(max(split["alternating"], abs(split["mean"])), "Pa")
        remark = f"{split['member']}, about a mean of {scale * split['mean']:.3g} {unit}"
        remark += "" if stresses.attrs["steady"] else ", without steady rotation"
        if split["margin"] is not None:
            remark += f", margin {split['margin']:.3g}"
        size = f"{scale * split['alternating']:.3g} {unit}"
        rows.append(("alternating stress", size, remark))
    if has(dataset, "coating"):
        depth = coating_of(dataset).thickness * float(dataset["coating_strain"][-1].max())
        volume = f"{1e9 * float(dataset['wear_volume'][-1]):.3g} mm³ removed"
        rows.append(("deepest wear", handy(depth, "m", 3), volume))
    return rows


def _glance(dataset: xr.Dataset, stresses: xr.Dataset | None = None) -> list[tuple[str, str, str]]:
    """Return the key figures of a run: name, value, remark."""
    ratio, _, rpm = speed_label(dataset).partition(" (")
    turns = ("speed", rpm.rstrip(")"), f"{ratio}, ω₁: reference frequency")
    end = f"{float(dataset['time'].values[-1]):.6g} s"
    ran = [turns, ("end of the march", end, "")]
    if has(dataset, "line"):
        force = float(line_bearing_forces(dataset)["force"].max())
        ran += [
            ("largest displacement of the shaft", handy(Motion(dataset).radius.max(), "m", 4), ""),
            ("largest force of a bearing", handy(force, "N", 4), ""),
        ]
    if not dataset.sizes["contact_node"]:
        return ran
    late = _late(dataset)
    classes = contact_classes(late)["contact_class"].values
    counts = {name: int((classes == name).sum()) for name in CLASS_COLOURS}
    steps = of_blades(dataset, dataset["contact_steps"].sum("time").values)
    blades = (
        "blades that touched",
        f"{np.count_nonzero(steps)} of {len(steps)}",
        ", ".join([*(f"{count} {name}" for name, count in counts.items() if count), LATE]),
    )
    if LOSS in dataset.attrs:
        ran.append(("loss", str(dataset.attrs[LOSS]), ""))
    ran += _loads(dataset, stresses)
    ran += [
        (f"largest recorded {way} displacement of a tip", handy(float(far), "m", 4), "")
        for way, far in zip(DIRECTIONS, largest_contact_motion(dataset).max(0), strict=True)
        if far
    ]
    if not has(dataset, "centre"):
        return [*ran, blades]
    orbit = shaft_orbit(dataset)
    late_orbit = _late(orbit)
    radius = MILLI * float(orbit["radius"].max())
    clearance = MILLI * float(orbit.attrs["smallest_clearance"])
    phases = contact_phase(late, late_orbit)
    in_contact, lead = bool(phases["impulse"].any()), float(phases.attrs["lead"])
    angle = []
    if in_contact and not math.isnan(lead):
        ahead = round(math.degrees(lead))
        angle.append(f"shaft {'leads' if ahead >= 0 else 'lags'} by {abs(ahead)}°")
    whirls = {frame: whirl(late_orbit, frame).text.partition(", ") for frame in FRAMES}
    moved = [
        (
            "largest recorded displacement of the shaft",
            f"{radius:.4g} mm",
            f"{radius / clearance:.3g} times the clearance" if clearance else "",
        )
    ]
    return [
        *ran,
        *(moved if not has(dataset, "line") else []),  # which has that of all nodes
        *(
            (f"whirl, {frame} frame", direction, ", ".join(filter(None, [rate, LATE])))
            for frame, (direction, _, rate) in whirls.items()
        ),
        blades,
        (
            "contact scenario",
            str(phases.attrs["scenario"]) if in_contact else "no contact",
            ", ".join([*angle, LATE]),
        ),
    ]


def _sentence(words: str) -> str:
    """Return words with a capital at the start and a full stop at the end."""
    return words[:1].upper() + words[1:].rstrip(".") + "."

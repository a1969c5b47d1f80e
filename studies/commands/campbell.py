"""`bladewhirl campbell`: speeds at which waves on rotor and casing coincide."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.studies.commands.options import (
    AsJson,
    CaseFile,
    Changes,
    Replace,
    Span,
    output_option,
    span_option,
)
from bladewhirl.studies.commands.output import Column, emit, facts, table

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.table import Table

SPEEDS: Any = "0:3"
OPERATING: Any = "0.6:2"

COINCIDENCES = (
    Column("nodal_diameter", "k", "d"),
    Column("rotor_family", "bladed disk"),
    Column("casing_family", "casing"),
    Column("speed", "Ω / ω₁ [–]", ".4f"),
    Column("speed_rpm", "[rpm]", ".1f"),
    Column("in_operating_range", "operating"),
)
CRITICAL_SPEEDS = (
    Column("k", "k", "d"),
    Column("family", "family at rest"),
    Column("ratio", "Ω / ω₁ [–]", ".5f"),
    Column("rpm", "[rpm]", ".1f"),
    Column("spring_share", "strain energy in shaft springs [%]", ".3g", 100.0),
)


def campbell(
    case: CaseFile,
    speeds: Annotated[
        Span,
        span_option("--speeds", 'Speeds of the diagrams: times ω₁, or "2000 rpm:9000 rpm".'),
    ] = SPEEDS,
    operating: Annotated[
        Span,
        span_option("--operating", 'Operating range to shade: times ω₁, or "40 Hz:60 Hz".'),
    ] = OPERATING,
    families: Annotated[
        int, typer.Option(help="Families of the bladed disk, the suspension pair apart.", min=1)
    ] = 5,
    output: Annotated[
        Path | None,
        output_option("Folder to make; CASE-campbell by default."),
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option(help="Interactive page of both diagrams to write, FILE.html.", metavar="FILE"),
    ] = None,
    overwrite: Replace = False,
    json: AsJson = False,
    overrides: Changes = None,
) -> None:
    """Find coincidence speeds and draw Campbell diagrams, in the rotating and the static frame.

    Where k Ω = ω_casing + ω_rotor, Eq. (14), a wave that travels forward on the casing keeps pace
    with one that travels backward on the rotor, and contact feeds both. The table has the speeds
    inside --speeds; JSON has those of every nodal diameter and family. With --json or --html the
    folder is made only if -o names one.
    """
    from bladewhirl.postprocess.plotting.files import checked_target
    from bladewhirl.studies.modal import campbell as study
    from bladewhirl.studies.modal.modes import stage_of_file

    folder = output
    if output is None and html is None and not json:
        folder = Path(f"{case.stem}-campbell")
    if html is not None:
        checked_target(html, ".html")
    stage = stage_of_file(case, overrides, "a Campbell diagram", "centrifugal", "full")
    reference = stage.reference_frequency
    first, last = speeds.values(reference).tolist()
    diagram = study.campbell(
        stage,
        families=families,
        speeds=(first, last),
        operating=tuple(operating.values(reference).tolist()),
    )
    if folder is not None:
        study.draw_campbell(diagram, folder, overwrite=overwrite)
    if html is not None:
        study.write_campbell_page(diagram, html, overwrite=overwrite)
    document = study.coincidence_list(diagram)
    emit(document, *_tables(document, first, last), json=json, written=[folder, html])


def _tables(document: dict[str, Any], first: float, last: float) -> Iterator[Table]:
    """Yield the tables of a document; speeds from `first` to `last`, normalised."""
    rows = [row for row in document["coincidences"] if first <= row["speed"] <= last]
    yield table(rows, COINCIDENCES, f"Coincidence speeds from {first:g} to {last:g} ω₁")
    if "critical_speeds" not in document:
        return
    yield table(document["critical_speeds"], CRITICAL_SPEEDS, f"Critical speeds up to {last:g} ω₁")
    names = {
        "waves_meet": "two waves merge and grow without contact from",
        "clearance_gone": "the growth of the tips equals the cold clearance at",
    }
    yield facts(
        {
            name: f"{document[key]['ratio']:.4f} ω₁ = {document[key]['rpm']:.1f} rpm"
            for key, name in names.items()
            if document[key] is not None
        }
    )

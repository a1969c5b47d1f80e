"""`bladewhirl render`: a film or a still of a run."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.studies.commands.options import (
    End,
    Replace,
    RunFolder,
    Start,
    claim_output,
    options_of_window,
    parse_time,
    parse_window,
)
from bladewhirl.studies.commands.progress import progress_bar

if TYPE_CHECKING:
    import xarray as xr

    from bladewhirl.postprocess.fields.kinematics import IntArray


class FrameOfView(StrEnum):
    """Whose axes the picture is drawn in."""

    static = "static"
    rotating = "rotating"


class FieldOfColour(StrEnum):
    """What beams and wall are coloured by."""

    displacement = "displacement"
    deformation = "deformation"
    velocity = "velocity"
    axial_strain = "axial-strain"
    bending_strain = "bending-strain"
    stress = "stress"
    gap = "gap"
    part = "part"


def render(
    directory: RunFolder,
    gif: Annotated[bool, typer.Option("--gif", help="An animation that loops (default).")] = False,
    mp4: Annotated[bool, typer.Option("--mp4", help="A film.")] = False,
    png: Annotated[bool, typer.Option("--png", help="Stills, one for each --time.")] = False,
    sheet: Annotated[
        bool,
        typer.Option(
            "--sheet",
            help="Many stills in one PNG: each --time, or --frames, by default of the revolution"
            " with the strongest contact.",
        ),
    ] = False,
    page: Annotated[
        bool,
        typer.Option(
            "--html", help="An animation to zoom and to point at, for any browser, offline."
        ),
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="File to write; its suffix may stand for --gif, --mp4, --png or --html. "
            "Otherwise animation.gif, animation.mp4, still.png, sheet.png, page.html in DIR.",
        ),
    ] = None,
    frames: Annotated[
        int | None, typer.Option(min=2, help="Pictures of an animation (120) or a sheet (9).")
    ] = None,
    start: Start = None,
    end: End = None,
    time: Annotated[
        list[str] | None,
        typer.Option(
            help="Instant of a still, any number; by default that of the largest force, normal and"
            " friction, over a record step."
        ),
    ] = None,
    exaggeration: Annotated[
        float | None,
        typer.Option(help="Factor on displacements and clearance; 1 is true; chosen by default."),
    ] = None,
    frame: Annotated[
        FrameOfView, typer.Option(help="Whose axes the picture is drawn in.")
    ] = FrameOfView.static,
    colour: Annotated[
        FieldOfColour, typer.Option(help="What beams and wall are coloured by.")
    ] = FieldOfColour.displacement,
    orbit: Annotated[
        bool, typer.Option("--orbit", help="Show the shaft's orbit in an inset.")
    ] = False,
    overwrite: Replace = False,
) -> None:
    """Draw a run as GIF, MP4, PNG or HTML, without a display.

    Blades and casing have their true thickness; displacements and clearance are drawn larger by
    one factor, so contact looks like contact exactly when there is contact. Animations show 120
    pictures, close enough for a smooth turn, where contact was strongest, unless told otherwise.
    """
    from bladewhirl.meshes.files.manifest import check_file
    from bladewhirl.postprocess.fields.result import open_result
    from bladewhirl.postprocess.pictures.render import (
        animation_records,
        check_inside,
        sheet_records,
    )
    from bladewhirl.studies.runs.render import SHEET_PICTURES
    from bladewhirl.studies.runs.render import render as draw

    wanted = {"gif": gif, "mp4": mp4, "png": png, "sheet": sheet, "html": page}
    targets = _targets(directory, output, [kind for kind, given in wanted.items() if given])
    moving = not {"gif", "mp4", "html", "sheet"}.isdisjoint(targets)
    windowed = {"--frames": frames, "--from": start, "--to": end}
    _refuse(not moving, windowed, "a still has --time")
    still = "png" in targets or "sheet" in targets
    _refuse(not still, {"--time": time or None}, "an animation has --from and --to")
    first, last = parse_window(start, end)
    times = [parsed for text in time or [] if (parsed := parse_time("--time", text)) is not None]
    files = [
        path
        for kind, target in targets.items()
        for path, _ in (_stills(target, times) if kind == "png" else [(target, None)])
    ]
    with options_of_window(), open_result(directory) as result:
        for inside in times:
            check_inside(result, inside)
        for path in files:
            with writing(path):
                check_file(path, overwrite=overwrite)
        paint = partial(draw, result, exaggeration=exaggeration, frame=frame.value)
        paint = partial(paint, colour=colour.value)
        for kind, target in targets.items():
            if kind == "png":
                for path, instant in _stills(target, times):
                    typer.echo(f"Wrote {paint(path, time=instant, orbit=orbit)}.")
            elif kind == "sheet" and times:
                _refuse(True, windowed, "the sheet has its --time")
                paint(target, time=times)
                typer.echo(f"Wrote {target}: {len(times)} pictures.")
            elif kind == "sheet":
                count = frames or SHEET_PICTURES
                records = sheet_records(result, count, start=first, end=last)
                paint(target, frames=count, start=first, end=last)
                _tell_span(result, target, records)
            else:
                paint_film = partial(paint, target, frames=frames, start=first, end=last)
                with progress_bar(target.name) as update:
                    paint_film(orbit=orbit, progress=update)
                shown = animation_records(result, frames=frames, start=first, end=last)
                _tell_film(result, target, shown)
                if first is None and last is None:
                    typer.echo("Hint: --from and --to choose another window.", err=True)
    for path in files:
        claim_output(path, named=output is not None, overwrite=True)


def _tell_film(result: xr.Dataset, target: Path, records: IntArray) -> None:
    """Say what an animation shows, and whether it turns smoothly."""
    from bladewhirl.postprocess.fields.kinematics import sampling_hint

    _tell_span(result, target, records)
    hint = sampling_hint(result, records)
    if hint:
        typer.echo(f"Hint: {hint}.", err=True)


def _tell_span(result: xr.Dataset, target: Path, records: IntArray) -> None:
    """Say how many pictures there are, and of which time."""
    first, last = result["time"].values[records[[0, -1]]]
    typer.echo(f"Wrote {target}: {len(records)} pictures from {first:.6g} s to {last:.6g} s.")


def _targets(directory: Path, output: Path | None, kinds: list[str]) -> dict[str, Path]:
    """The files to write, by kind."""
    from bladewhirl.studies.runs.folder import PICTURES

    if output is None:
        folder = directory if directory.is_dir() else directory.parent
        return {kind: folder / PICTURES[kind] for kind in kinds or ["gif"]}
    suffix = output.suffix.lower().removeprefix(".")
    endings = dict.fromkeys(Path(name).suffix for name in PICTURES.values())
    if f".{suffix}" not in endings:
        raise UserError(f"--output {output}: expected a name that ends in {', '.join(endings)}")
    kinds = kinds or [suffix]
    if len(kinds) > 1 or Path(PICTURES[kinds[0]]).suffix != f".{suffix}":
        flags = " ".join(f"--{kind}" for kind in kinds)
        raise UserError(f"--output {output}: expected one file of the kind asked for by {flags}")
    return {kinds[0]: output}


def _refuse(foreign: bool, options: Mapping[str, object], reason: str) -> None:
    """An option that would be passed over in silence is an error."""
    given = [name for name, value in options.items() if value is not None]
    if foreign and given:
        raise UserError(f"{given[0]}: not for what is to be drawn; {reason}")


def _stills(target: Path, times: list[float]) -> list[tuple[Path, float | None]]:
    """Files of stills and their instants [s], numbered where there are more than one."""
    if len(times) < 2:
        return [(target, times[0] if times else None)]
    names = (f"{target.stem}_{number}{target.suffix}" for number in range(1, len(times) + 1))
    return [(target.with_name(name), time) for name, time in zip(names, times, strict=True)]

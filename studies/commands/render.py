"""`bladewhirl render`: a film or a still of a run."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray as xr

SHEET_PICTURES = 9
"""Pictures of a sheet where neither times nor a number are given."""


class FrameOfView(StrEnum):
    """Whose axes the picture is drawn in."""

    static = "static"
    rotating = "rotating"


class FieldOfColour(StrEnum):
    """What beams and wall are coloured by."""

    displacement = "displacement"
    velocity = "velocity"
    axial_strain = "axial-strain"
    bending_strain = "bending-strain"
    stress = "stress"
    gap = "gap"
    part = "part"


@dataclass(frozen=True, kw_only=True)
class Look:
    """How a picture is drawn, whatever its kind."""

    exaggeration: float | None
    frame: FrameOfView
    colour: FieldOfColour

    def options(self) -> dict[str, Any]:
        """As the drawing functions take it."""
        return {
            "exaggeration": self.exaggeration,
            "frame": self.frame.value,
            "colour": self.colour.value,
        }


def render(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a run, or its result.nc.")
    ],
    gif: Annotated[bool, typer.Option("--gif", help="An animation that loops (default).")] = False,
    mp4: Annotated[bool, typer.Option("--mp4", help="A film.")] = False,
    png: Annotated[bool, typer.Option("--png", help="Stills, one for each --time.")] = False,
    sheet: Annotated[
        bool, typer.Option("--sheet", help="Many stills in one PNG: each --time, or --frames.")
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
    start: Annotated[
        str | None, typer.Option("--from", help='Start of the window: seconds, or "0.8 ms".')
    ] = None,
    end: Annotated[str | None, typer.Option("--to", help="End of the window.")] = None,
    time: Annotated[
        list[str] | None,
        typer.Option(help="Instant of a still, any number; by default that of the largest force."),
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
) -> None:
    """Draw a run as GIF, MP4, PNG or HTML, without a display.

    Blades and casing have their true thickness; displacements and clearance are drawn larger by
    one factor, so contact looks like contact exactly when there is contact. Animations show 120
    pictures, close enough for a smooth turn, where contact was strongest, unless told otherwise.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.postprocess.fields.result import open_result
    from bladewhirl.studies.commands.times import options_of_window, parse_time

    wanted = {"gif": gif, "mp4": mp4, "png": png, "sheet": sheet, "html": page}
    targets = _targets(directory, output, [kind for kind, given in wanted.items() if given])
    moving = not {"gif", "mp4", "html", "sheet"}.isdisjoint(targets)
    _refuse(not moving, {"--frames": frames, "--from": start, "--to": end}, "a still has --time")
    still = "png" in targets or "sheet" in targets
    _refuse(not still, {"--time": time or None}, "an animation has --from and --to")
    window = (parse_time("--from", start), parse_time("--to", end))
    times = [parsed for text in time or [] if (parsed := parse_time("--time", text)) is not None]
    look = Look(exaggeration=exaggeration, frame=frame, colour=colour)
    with options_of_window(), open_result(directory) as result:
        for kind, target in targets.items():
            try:
                if kind == "png":
                    _stills(result, target, times, look, orbit)
                elif kind == "sheet":
                    _sheet(result, target, times, frames, window, look)
                else:
                    _film(result, target, frames, window, look, orbit)
            except OSError as error:
                raise UserError(f"{target}: cannot be written ({error.strerror})") from None


def _targets(directory: Path, output: Path | None, kinds: list[str]) -> dict[str, Path]:
    """The files to write, by kind."""
    from bladewhirl.models.inputs.errors import UserError
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
    from bladewhirl.models.inputs.errors import UserError

    given = [name for name, value in options.items() if value is not None]
    if foreign and given:
        raise UserError(f"{given[0]}: not for what is to be drawn; {reason}")


def _stills(result: xr.Dataset, target: Path, times: list[float], look: Look, orbit: bool) -> None:
    """Write a still for each time, numbered where there are more than one, and say so."""
    from bladewhirl.postprocess.pictures.render import check_inside, render_still

    for time in times:
        check_inside(result, time)
    wanted: list[float | None] = [*times] or [None]
    for number, instant in enumerate(wanted, start=1):
        name = f"{target.stem}_{number}{target.suffix}" if len(times) > 1 else target.name
        path = target.with_name(name)
        render_still(result, path, time=instant, orbit=orbit, **look.options())
        typer.echo(f"Wrote {path}.")


def _sheet(
    result: xr.Dataset,
    target: Path,
    times: list[float],
    frames: int | None,
    window: tuple[float | None, float | None],
    look: Look,
) -> None:
    """Write a sheet of the times, or of instants spread over the window, and say so."""
    import numpy as np

    from bladewhirl.postprocess.fields.fields import frame_records, nearest_records
    from bladewhirl.postprocess.pictures.render import check_inside
    from bladewhirl.postprocess.pictures.sheet import render_sheet

    others = {"--frames": frames, "--from": window[0], "--to": window[1]}
    _refuse(bool(times), others, "the sheet has its --time")
    for time in times:
        check_inside(result, time)
    records = (
        nearest_records(result, np.array(times))
        if times
        else frame_records(result, frames or SHEET_PICTURES, *window)
    )
    render_sheet(result, target, records, **look.options())
    typer.echo(f"Wrote {target}: {len(records)} pictures.")


def _film(
    result: xr.Dataset,
    target: Path,
    frames: int | None,
    window: tuple[float | None, float | None],
    look: Look,
    orbit: bool,
) -> None:
    """Write an animation with a progress bar; say what it shows and whether it turns smoothly."""
    from rich.console import Console
    from rich.progress import Progress

    from bladewhirl.postprocess.fields.fields import sampling_hint
    from bladewhirl.postprocess.pictures.render import animation_records, render_animation
    from bladewhirl.postprocess.pictures.web_page import render_page

    records = animation_records(result, frames=frames, start=window[0], end=window[1])
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(target.name, total=len(records))

        def told(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)

        if target.suffix.lower() == ".html":
            render_page(result, target, records, progress=told, **look.options())
        else:
            render_animation(result, target, records, orbit=orbit, progress=told, **look.options())
    first, last = result["time"].values[records[[0, -1]]]
    typer.echo(f"Wrote {target}: {len(records)} pictures from {first:.6g} s to {last:.6g} s.")
    if window == (None, None):
        typer.echo("Hint: --from and --to choose another window.", err=True)
    hint = sampling_hint(result, records)
    if hint:
        typer.echo(f"Hint: {hint}.", err=True)

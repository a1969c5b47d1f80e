"""`bladewhirl render`: a film or a still of a run."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    import xarray as xr

FILES = {".gif": "animation.gif", ".mp4": "animation.mp4", ".png": "still.png"}
"""What is written for each kind of picture where no file is named."""


class FrameOfView(StrEnum):
    """Whose axes the picture is drawn in."""

    static = "static"
    rotating = "rotating"


def render(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a run, or its result.nc.")
    ],
    gif: Annotated[bool, typer.Option("--gif", help="An animation that loops (default).")] = False,
    mp4: Annotated[bool, typer.Option("--mp4", help="A film.")] = False,
    png: Annotated[bool, typer.Option("--png", help="A still.")] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="File to write; its suffix may stand for --gif, --mp4 or --png. "
            "Otherwise animation.gif, animation.mp4, still.png in DIR.",
        ),
    ] = None,
    frames: Annotated[
        int | None, typer.Option(min=2, help="Pictures of an animation; 120 by default.")
    ] = None,
    start: Annotated[
        str | None, typer.Option("--from", help='Start of the window: seconds, or "0.8 ms".')
    ] = None,
    end: Annotated[str | None, typer.Option("--to", help="End of the window.")] = None,
    time: Annotated[
        str | None, typer.Option(help="Instant of a still; by default that of the largest force.")
    ] = None,
    exaggeration: Annotated[
        float | None,
        typer.Option(help="Factor on displacements and clearance; 1 is true; chosen by default."),
    ] = None,
    frame: Annotated[
        FrameOfView, typer.Option(help="Whose axes the picture is drawn in.")
    ] = FrameOfView.static,
) -> None:
    """Draw a run as GIF, MP4 or PNG, without a display.

    Blades and casing have their true thickness; displacements and clearance are drawn larger by
    one factor, so contact looks like contact exactly when there is contact. Animations show 120
    pictures, close enough for a smooth turn, where contact was strongest, unless told otherwise.
    """
    from bladewhirl.models.faults import UserError
    from bladewhirl.postprocess.result import open_result
    from bladewhirl.studies.times import parse_time

    targets = _targets(directory, output, {".gif": gif, ".mp4": mp4, ".png": png})
    moving = any(target.suffix.lower() != ".png" for target in targets)
    still = any(target.suffix.lower() == ".png" for target in targets)
    _refuse(not moving, {"--frames": frames, "--from": start, "--to": end}, "a still has --time")
    _refuse(not still, {"--time": time}, "an animation has --from and --to")
    window = (parse_time("--from", start), parse_time("--to", end))
    with open_result(directory) as result:
        for target in targets:
            try:
                if target.suffix.lower() == ".png":
                    _still(result, target, parse_time("--time", time), exaggeration, frame)
                else:
                    _film(result, target, frames, window, exaggeration, frame)
            except OSError as error:
                raise UserError(f"{target}: cannot be written ({error.strerror})") from None


def _targets(directory: Path, output: Path | None, wanted: dict[str, bool]) -> list[Path]:
    """The files to write."""
    from bladewhirl.models.faults import UserError

    kinds = [suffix for suffix, given in wanted.items() if given]
    if output is None:
        folder = directory if directory.is_dir() else directory.parent
        return [folder / FILES[suffix] for suffix in kinds or [".gif"]]
    if output.suffix.lower() not in FILES:
        raise UserError(f"--output {output}: expected a name that ends in {', '.join(FILES)}")
    if kinds not in ([], [output.suffix.lower()]):
        flags = " ".join(f"--{suffix[1:]}" for suffix in kinds)
        raise UserError(f"--output {output}: expected one file of the kind asked for by {flags}")
    return [output]


def _refuse(foreign: bool, options: dict[str, object], reason: str) -> None:
    """An option that would be passed over in silence is an error."""
    from bladewhirl.models.faults import UserError

    given = [name for name, value in options.items() if value is not None]
    if foreign and given:
        raise UserError(f"{given[0]}: not for what is to be drawn; {reason}")


def _still(
    result: xr.Dataset,
    target: Path,
    time: float | None,
    exaggeration: float | None,
    frame: FrameOfView,
) -> None:
    """Write a still and say so."""
    from bladewhirl.postprocess.render import render_still

    render_still(result, target, time=time, exaggeration=exaggeration, frame=frame.value)
    typer.echo(f"Wrote {target}.")


def _film(
    result: xr.Dataset,
    target: Path,
    frames: int | None,
    window: tuple[float | None, float | None],
    exaggeration: float | None,
    frame: FrameOfView,
) -> None:
    """Write an animation with a progress bar; say what it shows and whether it turns smoothly."""
    from rich.console import Console
    from rich.progress import Progress

    from bladewhirl.postprocess.fields import sampling_hint
    from bladewhirl.postprocess.render import animation_records, render_animation

    records = animation_records(result, frames=frames, start=window[0], end=window[1])
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(target.name, total=len(records))
        render_animation(
            result,
            target,
            records,
            exaggeration=exaggeration,
            frame=frame.value,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    first, last = result["time"].values[records[[0, -1]]]
    typer.echo(f"Wrote {target}: {len(records)} pictures from {first:.6g} s to {last:.6g} s.")
    if window == (None, None):
        typer.echo("Hint: --from and --to choose another window.", err=True)
    hint = sampling_hint(result, records)
    if hint:
        typer.echo(f"Hint: {hint}.", err=True)

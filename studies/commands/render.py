"""`bladewhirl render`: a film or a still of a run."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.postprocess.pictures.choices import Field, Frame, View
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.terminal import progress_bar


def render(
    directory: options.RunFolder,
    gif: Annotated[bool, typer.Option("--gif")] = False,
    mp4: Annotated[bool, typer.Option("--mp4")] = False,
    png: Annotated[bool, typer.Option("--png")] = False,
    sheet: Annotated[bool, typer.Option("--sheet")] = False,
    page: Annotated[bool, typer.Option("--html")] = False,
    output: options.Output = None,
    frames: Annotated[int | None, typer.Option(min=2)] = None,
    start: options.Start = None,
    end: options.End = None,
    time: Annotated[list[float] | None, options.time("--time")] = None,
    exaggeration: float | None = None,
    frame: Frame | None = None,
    colour: Field = "deformation",
    view: View | None = None,
    orbit: Annotated[bool, typer.Option("--orbit")] = False,
    width: Annotated[float | None, typer.Option(min=60.0, max=400.0)] = None,
    overwrite: options.Replace = False,
) -> None:
    """Draw a run as GIF, MP4, PNG or HTML, without a display.

    Blades and casing have their true thickness; displacements and clearance are multiplied by one
    factor, so bodies touch in the picture exactly when they touch in the run. By default an
    animation has 120 pictures around the strongest contact, close enough in time for a smooth
    rotation.

    Args:
        gif: An animation that loops (default).
        mp4: A film.
        png: Stills, one for each --time.
        sheet: Several stills in one PNG: one for each --time, or a number of --frames, by default
            over the revolution with the strongest contact.
        page: An interactive animation for any browser, which works offline.
        output: File to write; its suffix replaces --gif, --mp4, --png or --html. By default
            animation.gif, animation.mp4, still.png, sheet.png or page.html in DIR.
        frames: Number of pictures: by default 120, in a sheet 9.
        time: Instant of a still; may be given several times. By default the record with the largest
            mean contact force (normal and friction) since the previous record.
        exaggeration: Factor on displacements and clearance; 1: true to scale; automatic by default.
        frame: Frame of reference of the picture: by default static, rotating for a single blade.
        colour: Field that colours rotor and wall; strains are those of beams, the stress of a
            superelement is the von Mises stress; wear is the removed depth of a coating.
        view: Direction of the view of a superelement: by default oblique, with the wall cut open in
            front of the tips. "line" shows a shaft line with the orbits at its bearings, the only
            view without blades.
        orbit: Show the shaft's orbit in an inset.
        width: Width of a still in print [mm], such as 85 for a column and 170 for a page; text has
            7 points.
    """
    from bladewhirl.files import check_file
    from bladewhirl.postprocess.fields.kinematics import nearest_records, sampling_hint
    from bladewhirl.postprocess.fields.result import open_result
    from bladewhirl.studies.runs.render import render as draw
    from bladewhirl.studies.runs.render import window_records

    flags = {"gif": gif, "mp4": mp4, "png": png, "sheet": sheet, "html": page}
    targets = _targets(directory, output, [kind for kind, flag in flags.items() if flag])
    times: list[Any] = time or []
    window = {"frames": frames, "start": start, "end": end}
    _check_options(set(targets), times, {"--frames": frames, "--from": start, "--to": end})
    if width is not None and (set(targets) != {"png"} or orbit):
        raise UserError("--width: allowed for a still (--png) without --orbit only")
    pictures = list(_pictures(targets, times, window))
    look: dict[str, Any] = {"frame": frame, "colour": colour, "view": view, "orbit": orbit}
    look["width"] = None if width is None else 1e-3 * width
    with open_result(directory) as result:
        for path, _ in pictures:
            with writing(path):
                check_file(path, overwrite=overwrite)
        nearest_records(result, times)  # refuses times outside the run
        for path, chosen in pictures:
            with progress_bar(path.name) as update, writing(path):
                draw(result, path, **chosen, **look, exaggeration=exaggeration, progress=update)
            options.claim_output(path, named=output is not None, overwrite=True)
            if "time" in chosen:
                typer.echo(f"Wrote {path}.")
                continue
            records = window_records(result, path, **chosen)
            first, last = result["time"].values[records[[0, -1]]]
            typer.echo(f"Wrote {path}: {len(records)} pictures from {first:.6g} s to {last:.6g} s.")
            hint = "" if path.suffix.lower() == ".png" else sampling_hint(result, records)
            if hint:
                typer.echo(f"Hint: {hint}; --from and --to choose another window.", err=True)


def _targets(directory: Path, output: Path | None, kinds: list[str]) -> dict[str, Path]:
    """Return the files to write, by kind."""
    from bladewhirl.studies.runs.folder import PICTURES

    if output is None:
        folder = directory if directory.is_dir() else directory.parent
        return {kind: folder / PICTURES[kind] for kind in kinds or ["gif"]}
    suffix = output.suffix.lower()
    suffixes = {kind: Path(name).suffix for kind, name in PICTURES.items()}
    if suffix not in suffixes.values():
        listed = ", ".join(dict.fromkeys(suffixes.values()))
        raise UserError(f"--output {output}: expected a name that ends in {listed}")
    kinds = kinds or [suffix.removeprefix(".")]
    if len(kinds) > 1 or suffixes[kinds[0]] != suffix:
        flags = " ".join(f"--{kind}" for kind in kinds)
        raise UserError(f"--output {output}: names one file, whose suffix does not fit {flags}")
    return {kinds[0]: output}


def _pictures(
    targets: Mapping[str, Path], times: list[Any], window: dict[str, Any]
) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Yield the files of all pictures with their instants or their time window."""
    from bladewhirl.studies.runs.render import SHEET_PICTURES

    for kind, path in targets.items():
        if kind == "png":
            for number, instant in enumerate(times or [None], 1):
                name = f"{path.stem}_{number}{path.suffix}" if len(times) > 1 else path.name
                yield path.with_name(name), {"time": instant}
        elif kind == "sheet" and times:
            yield path, {"time": times}
        elif kind == "sheet":
            yield path, window | {"frames": window["frames"] or SHEET_PICTURES}
        else:
            yield path, window


def _check_options(kinds: set[str], times: list[float], window: Mapping[str, object]) -> None:
    """Refuse times or a time window that no requested file uses.

    Raises:
        UserError: an option is not used; the message names the option.
    """
    moving, still = kinds & {"gif", "mp4", "html"}, kinds & {"png", "sheet"}
    if times and not still:
        raise UserError(
            "--time: allowed for a still or a sheet only; an animation has --from and --to"
        )
    unused = not moving and ("sheet" not in kinds or bool(times))
    for name, value in window.items():
        if unused and value is not None:
            raise UserError(f"{name}: allowed for an animation or a sheet only; a still has --time")

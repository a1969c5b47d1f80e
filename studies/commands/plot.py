"""`bladewhirl plot`: figures of a run or a sweep, by name."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

NAMES = {
    "orbit": "the shaft in rotating and static frame",
    "whirl": "rate and direction of the whirl over time, in both frames",
    "spectrum": "of the shaft, forward and backward, with lines of modes, rotating frame",
    "spectrum-static": "the same in the static frame",
    "spectrogram": "of the shaft over time, rotating frame",
    "spectrogram-static": "the same in the static frame",
    "state-space": "velocity over place, and the Poincaré map once a revolution",
    "energy": "strain energy of suspension and first family",
    "energy-families": "strain energy by family and nodal diameter",
    "energy-cyclic": "the same from a transform of the field over the sectors",
    "gaps": "between blades and casing over time",
    "forces": "on the blades over time",
    "contact-classes": "blades in permanent or intermittent contact, and free ones",
    "contact-phase": "of shaft and smallest clearance, and the contact scenario",
    "stress": "of blades, disk and casing over time, and the extremes of every blade",
    "regime": "the amplitude over time, and its growth rate with its uncertainty",
}
"""The figures of a run, and what they show."""

SWEEP_NAMES = {
    "frequency-map": "spectrum of the shaft over the swept key, engine orders, lines of modes",
    "shaft-radius": "largest and final displacement of the shaft",
    "regimes": "regime of each point, and growth rate with its uncertainty",
    "whirl": "direction and frequency of the whirl with its scatter, in both frames",
    "contact-phase": "of the shaft against the contact: standard or inverted scenario",
    "contact-classes": "time in contact of each blade; permanent, intermittent and free blades",
    "energy-families": "strain energy by family and nodal diameter",
    "bifurcation": "Poincaré sections and local maxima of the late motion",
    "maps": "regime, displacement and growth over two swept keys",
}
"""The figures of a sweep, and what they show."""

ALL = "all"
PLOTS = "plots"
"""Folder in that of the run or the sweep where figures go."""


def plot(
    directory: Annotated[
        Path,
        typer.Argument(
            metavar="DIR", help="Folder of a run or a sweep, or its result.nc or sweep.nc."
        ),
    ],
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME",
            help="Figures, or all. Of a run:\n\n"
            + "\n\n".join(f"{name}: {about}." for name, about in NAMES.items())
            + "\n\nOf a sweep:\n\n"
            + "\n\n".join(f"{name}: {about}." for name, about in SWEEP_NAMES.items()),
            show_default=False,
        ),
    ] = None,
    start: Annotated[
        str | None,
        typer.Option(
            "--from", help='Start of the window of a run: seconds, or "0.8 ms"; its start if none.'
        ),
    ] = None,
    end: Annotated[str | None, typer.Option("--to", help="End of the window.")] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help=f"Folder for the figures; DIR/{PLOTS} if none."),
    ] = None,
) -> None:
    """Draw figures of a run or a sweep as PNG and PDF, with the data behind each as netCDF.

    Without a NAME it lists those that there are.
    Without a window, a run's spectrum and contact-classes are of the last third of the time.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.postprocess.fields.fields import ViewError
    from bladewhirl.postprocess.fields.result import open_result
    from bladewhirl.postprocess.plotting.style import save_figure
    from bladewhirl.postprocess.run.figures import RunFigures
    from bladewhirl.postprocess.sweep.dataset import open_sweep
    from bladewhirl.postprocess.sweep.figures import SweepFigures
    from bladewhirl.studies.commands.times import options_of_window, parse_time

    of_sweep = _is_sweep(directory)
    known = SWEEP_NAMES if of_sweep else NAMES
    if not names:
        for name, about in known.items():
            typer.echo(f"{name}: {about}")
        return
    unknown = [name for name in names if name not in (*known, ALL)]
    if unknown:
        kind = "a sweep has" if of_sweep else "a run has"
        raise UserError(f"{', '.join(unknown)}: {kind} {', '.join(known)}; or {ALL}")
    if of_sweep and (start is not None or end is not None):
        raise UserError(f"{directory}: expected no --from and --to with a sweep")
    folder = output or (directory if directory.is_dir() else directory.parent) / PLOTS
    window = (parse_time("--from", start), parse_time("--to", end))
    with options_of_window(), open_sweep(directory) if of_sweep else open_result(directory) as data:
        figures = SweepFigures(data) if of_sweep else RunFigures(data, *window)
        for name in known if ALL in names else dict.fromkeys(names):
            try:
                figure, drawn = figures.draw(name)
            except ViewError as error:
                if ALL not in names:
                    raise
                typer.echo(f"{name} left out: {error}", err=True)
                continue
            try:
                folder.mkdir(parents=True, exist_ok=True)
                save_figure(figure, folder / name, drawn)
            except OSError as error:
                raise UserError(f"{folder}: cannot be written ({error.strerror})") from None
            typer.echo(f"Wrote {folder / name}.png, .pdf and .nc.")


def _is_sweep(path: Path) -> bool:
    """Whether a folder is that of a sweep, or a file its dataset."""
    from bladewhirl.postprocess.sweep.dataset import SWEEP_NAME

    return (path / SWEEP_NAME).is_file() if path.is_dir() else path.name == SWEEP_NAME

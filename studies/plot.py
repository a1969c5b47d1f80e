"""`bladewhirl plot`: figures of a run, by name."""

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
}
"""The figures, and what they show."""

ALL = "all"
PLOTS = "plots"
"""Folder in that of the run where figures go."""


def plot(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a run, or its result.nc.")
    ],
    names: Annotated[
        list[str],
        typer.Argument(
            metavar="NAME",
            help="Figures, or all:\n\n"
            + "\n\n".join(f"{name}: {about}." for name, about in NAMES.items()),
        ),
    ],
    start: Annotated[
        str | None,
        typer.Option(
            "--from", help='Start of the window: seconds, or "0.8 ms"; of the run if none.'
        ),
    ] = None,
    end: Annotated[str | None, typer.Option("--to", help="End of the window.")] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help=f"Folder for the figures; DIR/{PLOTS} if none."),
    ] = None,
) -> None:
    """Draw figures of a run as PNG and PDF, with the data behind each as netCDF.

    Without a window, spectrum and contact-classes are of the last third of the time.
    """
    from bladewhirl.models.faults import UserError
    from bladewhirl.postprocess.fields import ViewError
    from bladewhirl.postprocess.result import open_result
    from bladewhirl.postprocess.run_figures import RunFigures
    from bladewhirl.postprocess.style import save_figure
    from bladewhirl.studies.times import parse_time

    unknown = [name for name in names if name not in (*NAMES, ALL)]
    if unknown:
        raise UserError(f"{', '.join(unknown)}: expected {', '.join(NAMES)} or {ALL}")
    folder = output or (directory if directory.is_dir() else directory.parent) / PLOTS
    window = (parse_time("--from", start), parse_time("--to", end))
    with open_result(directory) as result:
        figures = RunFigures(result, *window)
        for name in NAMES if ALL in names else dict.fromkeys(names):
            try:
                figure, data = figures.draw(name)
            except ViewError as error:
                if ALL not in names:
                    raise
                typer.echo(f"{name} left out: {error}", err=True)
                continue
            try:
                folder.mkdir(parents=True, exist_ok=True)
                save_figure(figure, folder / name, data)
            except OSError as error:
                raise UserError(f"{folder}: cannot be written ({error.strerror})") from None
            typer.echo(f"Wrote {folder / name}.png, .pdf and .nc.")

"""Outputs of a run in addition to its records: summary, figures and the ParaView series."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

from bladewhirl.files import write_atomically
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.progress import report as report_progress
from bladewhirl.studies.runs import folder

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure
    from rich.console import Group

    from bladewhirl.postprocess.run.summary import Summary


@dataclass(frozen=True, kw_only=True)
class Window:
    """Time window of the ParaView series of a run, and its number of instants."""

    frames: int  #: number of instants, equally spaced; 0 for no series
    start: float | None = None  #: start of the window [s]; None: start of the run
    end: float | None = None  #: end of the window [s]; None: end of the run
    rotating: bool = False  #: whether rotating axes are used

    def check(self, duration: float) -> None:
        """Check that the window is valid and overlaps a run of a duration [s].

        Raises:
            UserError: the window or the number of frames is invalid.
        """
        from bladewhirl.postprocess.fields.kinematics import MOST_FRAMES  # loads xarray

        if not 0 <= self.frames <= MOST_FRAMES:
            raise UserError(f"--frames {self.frames}: expected 0 to {MOST_FRAMES}")
        start, end = self.start or 0.0, duration if self.end is None else self.end
        if self.frames and not 0.0 <= start <= min(end, duration):
            raise UserError(
                f"--from {start:g} --to {end:g}: expected a start before the end, both within the"
                f" {duration:g} s of the run"
            )


@dataclass(frozen=True, kw_only=True)
class Run:
    """A finished run: its folder, end and summary."""

    directory: Path
    end_reason: str  #: "completed", "divergent" or "interrupted"
    end_message: str  #: cause and remedy of an early end, in one line
    summary: Summary
    symmetry: str  #: symmetry of both bodies, and the method of their march
    hints: tuple[str, ...]  #: hints on implausible values and on the sampling of the series

    def __rich__(self) -> Group:
        """Return the number of unsolved steps, if there are any, and a table of regime and reason,
        end, orbit, energies, contacts, quality of the march, symmetry, and files."""
        from rich.console import Group
        from rich.text import Text

        from bladewhirl.postprocess.run.summary_table import summary_rows, unsolved_share
        from bladewhirl.studies.runs.columns import facts
        from bladewhirl.studies.runs.march_texts import unsolved_text

        names = ", ".join(sorted(path.name for path in self.directory.iterdir()))
        texts = filter(None, [self.symmetry, f"{self.directory}: {names}"])
        of = self.summary
        unsolved = unsolved_text(of.unsolved_steps, of.steps, unsolved_share(of))
        first = [Text(unsolved[:1].upper() + unsolved[1:])] if unsolved else []
        return Group(*first, facts(summary_rows(self.summary)), *map(Text, texts))

    def __repr__(self) -> str:
        """Return the table as plain text, with the reason for an early end, and hints."""
        from rich.console import Console

        console = Console(file=StringIO(), width=100, color_system=None)
        with console.capture() as captured:
            console.print(self)
        lines = [line.rstrip() for line in captured.get().splitlines()]
        lines += [self.end_message, *(f"Hint: {hint}." for hint in self.hints)]
        return "\n".join(filter(None, lines))

    def __fspath__(self) -> str:
        """Return the folder of the run, so that a run can be used in place of a path."""
        return str(self.directory)

    def open(self) -> xr.Dataset:
        """Open the result, which is read when used; close it, or use ``with``."""
        from bladewhirl.postprocess.fields.result import open_result

        return open_result(self.directory)


def write_outputs(directory: Path, report: Mapping[str, float], window: Window) -> Run:
    """Write summary, figures, signals of sensors and ParaView series into a folder that contains
    the result of a run.

    The report contains the quality measures of the march, see `postprocess.run.summary`; the window
    defines the instants of the series.
    """
    from bladewhirl.postprocess.energy.strain import plot_energy, strain_energies
    from bladewhirl.postprocess.fields.netcdf import has
    from bladewhirl.postprocess.fields.result import open_result
    from bladewhirl.postprocess.plotting.style import save_figure
    from bladewhirl.postprocess.run.hints import run_hints
    from bladewhirl.postprocess.run.summary import summarise
    from bladewhirl.postprocess.run.wear import write_profile
    from bladewhirl.postprocess.shaft.orbits import plot_orbit, shaft_orbit
    from bladewhirl.postprocess.shaft_line.motion import line_orbits, plot_line_orbits
    from bladewhirl.studies.runs.sensor_files import write_sensors

    with open_result(directory) as result:
        energies = strain_energies(result)
        drawn = {folder.ENERGY_NAME: (plot_energy(energies), energies)}
        orbit = None
        if has(result, "centre"):
            orbit = shaft_orbit(result)
            drawn[folder.ORBIT_NAME] = plot_orbit(orbit), orbit
        elif has(result, "line"):
            orbits = line_orbits(result)
            drawn[folder.ORBIT_NAME] = plot_line_orbits(orbits), orbits
        drawn |= _contact_figures(result)
        summary = summarise(result, report, orbit=orbit, energies=energies)
        hints = [*run_hints(summary, result), *write_sensors(result, directory)]
        if has(result, "coating"):
            write_profile(result, directory / folder.WEAR_NAME)
        write_atomically(directory / folder.SUMMARY_NAME, summary.to_json())
        for name, (figure, data) in drawn.items():
            save_figure(figure, directory / name, data, ["png"])
        hints += _write_series(result, directory / folder.VTK_NAME, window)
        return Run(
            directory=directory,
            end_reason=result.attrs["end_reason"],
            end_message=result.attrs["end_message"],
            summary=summary,
            symmetry=result.attrs.get("symmetry", ""),
            hints=tuple(hints),
        )


def _contact_figures(result: xr.Dataset) -> dict[str, tuple[Figure, xr.Dataset]]:
    """Return `CONTACT_FIGURES` with their data, by file name, as far as the run has them."""
    if result.sizes["time"] < 2:
        return {}
    from bladewhirl.postprocess.run.figures import RunFigures

    figures = RunFigures(result)
    names = [name for name in folder.CONTACT_FIGURES if name in figures.kinds]
    return {f"{name}.png": figures.draw(name) for name in names if figures.moves}


def _write_series(result: xr.Dataset, directory: Path, window: Window) -> Iterator[str]:
    """Write the ParaView series; yield hints for the user, for instance about too coarse
    sampling."""
    from bladewhirl.postprocess.fields.kinematics import ViewError, frame_records, sampling_hint
    from bladewhirl.postprocess.fields.netcdf import has

    if window.frames == 0 or not any(has(result, part) for part in ("points", "lines", "line")):
        return
    from bladewhirl.postprocess.paraview.series import export_vtk

    try:
        records = frame_records(result, window.frames, window.start, window.end)
    except ViewError as error:  # the run ended before the window
        yield f"no ParaView series: {error}"
        return
    export_vtk(
        result,
        directory,
        records=records,
        rotating=window.rotating,
        progress=partial(report_progress, "writing the ParaView series"),
    )
    hint = sampling_hint(result, records)
    if hint:
        yield f"{directory.name}: {hint} (--from, --to, --frames)"

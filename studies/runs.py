"""One run: from a case to a folder with the march's result, its summary, figures and series."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bladewhirl.models.case import Case
from bladewhirl.models.case_file import dumps_case
from bladewhirl.models.contact_problem import ContactProblem
from bladewhirl.models.faults import UserError
from bladewhirl.models.march_problem import contact_problem
from bladewhirl.models.stage import Stage, build_stage
from bladewhirl.solvers.central_difference import CentralDifference
from bladewhirl.solvers.march import Chunk, EndReason, Timing, march
from bladewhirl.solvers.recorder import (
    INTERRUPTED,
    RESULT_NAME,
    Attribute,
    NonFiniteError,
    Recorder,
)
from bladewhirl.studies import run_directory as folder

if TYPE_CHECKING:
    import xarray as xr

    from bladewhirl.postprocess.summary import Summary

Report = Callable[[int, int], None]
"""Called with steps done and steps in all."""

REMEDY = (
    "small displacements no longer hold; if the stage is not meant to diverge, look at its speed, "
    "load, damping and friction, else raise march.displacement_limit to follow it further"
)


@dataclass(frozen=True, kw_only=True)
class Window:
    """Which instants of a run its ParaView series shows.

    Raises:
        UserError: fewer than no frames, or a window that is empty or begins before the run.
    """

    frames: int  #: spread evenly; 0 for no series
    start: float | None  #: [s]; that of the run when None
    end: float | None  #: [s]; that of the run when None
    rotating: bool  #: seen from the rotor

    def __post_init__(self) -> None:
        if self.frames < 0:
            raise UserError(f"--frames {self.frames}: expected 0 or more")
        start = 0.0 if self.start is None else self.start
        end = np.inf if self.end is None else self.end
        if not 0.0 <= start <= end:
            raise UserError(
                f"--from {start:g} --to {end:g}: expected a window in order that begins at 0 s or"
                " later"
            )

    def check_within(self, duration: float) -> None:
        """See that there is something to show.

        Raises:
            UserError: it begins when the run has ended.
        """
        if self.frames > 0 and self.start is not None and self.start > duration:
            raise UserError(
                f"--from {self.start:g}: expected a time before the end of the run, {duration:g} s"
            )


@dataclass(frozen=True, kw_only=True)
class Run:
    """What a run left."""

    directory: Path
    end_reason: str  #: "completed", "divergent" or "interrupted"
    end_message: str  #: where it did not complete, cause and remedy in one line
    summary: Summary
    hints: tuple[str, ...]  #: what may be done better

    def open(self) -> xr.Dataset:
        """The result, read when used; close it, or open it in a ``with``."""
        from bladewhirl.postprocess.result import open_result

        return open_result(self.directory)


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """A case ready to march; whatever can be wrong with it has been seen."""

    stage: Stage
    problem: ContactProblem
    timing: Timing
    scheme: CentralDifference


def prepare(case: Case) -> Prepared:
    """Build the stage of a case, factorise its march and compile the kernel.

    Raises:
        CaseError: all faults that only show here.
    """
    stage = build_stage(case)
    problem = contact_problem(stage)
    timing = Timing(
        time_step=case.march.time_step,
        duration=case.march.duration,
        record_step=case.march.record_step,
    )
    scheme = CentralDifference(problem, timing.time_step, timing.record_every)
    scheme.advance(scheme.init(), 0)  # compiles, so that the march's clock does not count it
    return Prepared(stage=stage, problem=problem, timing=timing, scheme=scheme)


def run_case(
    case: Case,
    directory: str | Path,
    *,
    overwrite: bool = False,
    frames: int = 300,
    start: float | None = None,
    end: float | None = None,
    rotating: bool = False,
    progress: Report | None = None,
) -> Run:
    """Run a case and leave everything about it in a folder.

    The folder gets case.toml, provenance.json, result.nc, summary.json, orbit and energy (.png,
    .pdf and the data behind them) and vtk/. Nothing is written before the case is known to be
    right. Ctrl-C ends the march in order: what was recorded is finished and summed up, and the
    run says "interrupted".

    Args:
        case: to run.
        directory: to make.
        overwrite: replace the run in an existing folder; files that are not the run's stay.
        frames: of the ParaView series in vtk/; 0 for no series.
        start: of the series [s]; of the run when None.
        end: of the series [s]; of the run when None.
        rotating: show the series as seen from the rotor.
        progress: called with steps done and steps in all, every few hundredths of a second.

    Raises:
        CaseError: all faults of the case.
        UserError: the folder may not be used, the window makes no sense, or something can't be
            written.
    """
    directory = Path(directory)
    window = Window(frames=frames, start=start, end=end, rotating=rotating)
    window.check_within(case.march.duration)
    folder.check_free(directory, overwrite=overwrite)
    prepared = prepare(case)
    try:
        folder.clear(directory)
        folder.write_provenance(directory)
        (directory / folder.CASE_NAME).write_text(dumps_case(case), encoding="utf-8")
        report = _march(prepared, directory / RESULT_NAME, progress)
        return _write_up(directory, report, window)
    except OSError as error:
        raise UserError(f"{directory}: cannot be written ({error})") from None


def _march(prepared: Prepared, path: Path, progress: Report | None) -> dict[str, float]:
    """March and record; returns what the march alone knows of its quality."""
    timing, residual = prepared.timing, 0.0
    reason, message = EndReason.COMPLETED.value, ""
    with Recorder(path, prepared.stage.arrays, _attributes(prepared)) as recorder:
        began = time.perf_counter()
        try:
            with _interrupt() as interrupted:
                for state, chunk, end in march(prepared.scheme, timing):
                    recorder.write(chunk)
                    residual = state.statistics.complementarity_residual
                    if progress is not None:
                        progress(min(state.step, timing.steps), timing.steps)
                    if end is EndReason.DIVERGENT:
                        reason, message = end.value, _divergence(prepared, chunk)
                    elif end is None and interrupted():
                        reason = INTERRUPTED
                        message = f"interrupted at {recorder.steps * timing.time_step:.6g} s"
                        break
        except NonFiniteError as error:
            reason, message = EndReason.DIVERGENT.value, f"{error}; {REMEDY}"
        wall_time = time.perf_counter() - began
        report = {
            "complementarity_residual": residual,
            "dt_over_critical": timing.time_step / prepared.problem.critical_time_step,
            "steps": recorder.steps,
            "wall_time": wall_time,
            "us_per_step": 1e6 * wall_time / max(recorder.steps, 1),
        }
        recorder.finish(reason, message, report)
    return report


def _attributes(prepared: Prepared) -> dict[str, Attribute]:
    stage = prepared.stage
    case = stage.case
    return {
        "title": case.title,
        "version": folder.version(),
        "speed": stage.speed,
        "reference_frequency": stage.reference_frequency,
        "casing_radius": stage.reduced_casing.radius,
        "tip_radius": stage.rotor.tip_radius,
        "friction": case.contact.friction,
        "time_step": prepared.timing.time_step,
        "record_step": prepared.timing.record_step,
        "clamped": int(case.shaft.clamped),
        "case": dumps_case(case),
    }


def _divergence(prepared: Prepared, chunk: Chunk) -> str:
    """Which tip went too far, when, and what to do."""
    rotor, last = prepared.problem.rotor, chunk.rotor_displacement[-1]
    outward = np.maximum(np.abs(rotor.tip_radial @ last), np.abs(rotor.tip_tangential @ last))
    limit = prepared.problem.displacement_limit
    return (
        f"blade {int(outward.argmax())} passed march.displacement_limit = {limit:g} m at "
        f"{chunk.time[-1]:.6g} s; {REMEDY}"
    )


def _write_up(directory: Path, report: dict[str, float], window: Window) -> Run:
    """Summary, figures and series of what was recorded."""
    from bladewhirl.postprocess.energies import plot_energy, strain_energies
    from bladewhirl.postprocess.orbits import plot_orbit, shaft_orbit
    from bladewhirl.postprocess.result import open_result
    from bladewhirl.postprocess.style import save_figure
    from bladewhirl.postprocess.summary import summarise, write_summary

    with open_result(directory) as result:
        summary = summarise(result, report)
        write_summary(summary, directory / folder.SUMMARY_NAME)
        orbit, energies = shaft_orbit(result), strain_energies(result)
        save_figure(plot_orbit(orbit), directory / folder.ORBIT_NAME, orbit)
        save_figure(plot_energy(energies), directory / folder.ENERGY_NAME, energies)
        return Run(
            directory=directory,
            end_reason=result.attrs["end_reason"],
            end_message=result.attrs["end_message"],
            summary=summary,
            hints=tuple(_write_series(result, directory / folder.VTK_NAME, window)),
        )


def _write_series(result: xr.Dataset, directory: Path, window: Window) -> Iterator[str]:
    """Write the ParaView series; yields hints."""
    from bladewhirl.postprocess.fields import ViewError, frame_records, sampling_hint
    from bladewhirl.postprocess.vtk_series import write_vtk

    if window.frames == 0:
        return
    try:
        records = frame_records(result, window.frames, window.start, window.end)
    except ViewError as error:  # the run ended before the window
        yield f"no ParaView series: {error}"
        return
    write_vtk(
        result,
        directory,
        frames=window.frames,
        start=window.start,
        end=window.end,
        rotating=window.rotating,
    )
    hint = sampling_hint(result, records)
    if hint:
        yield f"{directory.name}: {hint} (--from, --to, --frames)"


@contextmanager
def _interrupt() -> Iterator[Callable[[], bool]]:
    """Turn the first Ctrl-C into a question to ask; the second one is a KeyboardInterrupt again.

    Only the main thread gets signals; elsewhere the answer stays False.
    """
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked.is_set
        return
    before = signal.getsignal(signal.SIGINT)

    def ask(number: int, frame: object) -> None:
        asked.set()
        signal.signal(signal.SIGINT, before)

    signal.signal(signal.SIGINT, ask)
    try:
        yield asked.is_set
    finally:
        signal.signal(signal.SIGINT, before)

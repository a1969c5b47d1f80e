"""One run: from a case to a folder with the march's result, its summary, figures and series."""

from __future__ import annotations

import gc
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.build import numbers_within_reach
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.hints import stage_hints
from bladewhirl.models.stage.stage import Stage, build_stage
from bladewhirl.solvers.march.march import Chunk, EndReason, Scheme, march
from bladewhirl.solvers.march.recorder import (
    INTERRUPTED,
    RESULT_NAME,
    Attribute,
    NonFiniteError,
    Recorder,
    description_bytes,
    result_bytes,
)
from bladewhirl.solvers.march.scheme import make_scheme
from bladewhirl.studies.runs import folder
from bladewhirl.studies.runs.interrupts import asked_to_stop
from bladewhirl.studies.runs.outputs import Run, Window, write_outputs
from bladewhirl.studies.runs.properties import MARCHES

SPARE_BYTES = 4_000_000
"""Room on the disk that a march leaves: HDF5 can't close a file on a full disk in order."""

Activity = Literal["marching", "writing"]

Progress = Callable[[Activity, int, int], None]
"""Called with what is being done, steps done and steps in all."""

REMEDY = (
    "there is nothing left for a linear model to say; if the stage is not meant to diverge, look "
    "at its speed, load, damping and friction, else raise march.displacement_limit to follow it "
    "further"
)


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """A case ready to march; whatever can be wrong with it has been seen."""

    stage: Stage
    problem: ContactProblem
    timing: Timing
    scheme: Scheme[Any]


def prepare(case: Case) -> Prepared:
    """Build the stage of a case, factorise its march and compile the kernel.

    Raises:
        CaseError: all faults that only show here.
    """
    return prepare_stage(build_stage(case))


def prepare_stage(stage: Stage) -> Prepared:
    """Factorise the march of a stage and compile the kernel.

    Raises:
        CaseError: all faults that stand in the way of a march.
    """
    problem, case = contact_problem(stage), stage.case
    timing = case.march.timing
    with numbers_within_reach(case):
        scheme = make_scheme(problem, timing.time_step, timing.record_every)
        begin = scheme.init()
    with _no_collection():  # compiles, so that the march's clock does not count it
        scheme.advance(begin, 0)
    return Prepared(stage=stage, problem=problem, timing=timing, scheme=scheme)


def run(
    case: Case,
    directory: str | Path,
    *,
    overwrite: bool = False,
    frames: int = 300,
    start: float | None = None,
    end: float | None = None,
    rotating: bool = False,
    progress: Progress | None = None,
) -> Run:
    """Run a case and leave everything about it in a folder.

    The folder gets case.toml (and a copy of its mesh file), provenance.json, result.nc,
    summary.json, orbit and energy (.png, .pdf and the data behind them) and vtk/. Nothing is
    written before the case is known to be right. Ctrl-C ends the march in order: what was
    recorded is finished and summed up, and the run says "interrupted".

    Args:
        case: to run.
        directory: to make.
        overwrite: replace the run in an existing folder; files that are not the run's stay.
        frames: of the ParaView series in vtk/; 0 for no series.
        start: of the series [s]; of the run when None.
        end: of the series [s]; of the run when None.
        rotating: show the series as seen from the rotor.
        progress: called with what is being done, steps done and steps in all, many times a second
            while marching.

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
        _check_room(directory, _expected_bytes(prepared))
        files = folder.case_files(case)
        folder.clear(directory)
        for name, content in files.items():
            (directory / name).write_bytes(content)
        folder.write_provenance(directory, case)
        report = march_to_file(
            prepared, directory / RESULT_NAME, files[folder.CASE_NAME].decode(), progress
        )
        done = write_outputs(directory, report, window)
        return replace(done, hints=(*stage_hints(prepared.stage), *done.hints))
    except OSError as error:
        raise UserError(f"{directory}: cannot be written ({error})") from None


@contextmanager
def _no_collection() -> Iterator[None]:
    """Keep the garbage collector away: it costs a compilation a tenth of its time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def march_to_file(
    prepared: Prepared, path: Path, case_text: str, progress: Progress | None = None
) -> dict[str, float]:
    """March and record; returns what the march alone knows of its quality.

    Args:
        prepared: the case to march.
        path: of the result.
        case_text: of the result, see `folder.portable_case`.
        progress: called with what is being done, steps done and steps in all.
    """
    timing, residual, unsolved = prepared.timing, 0.0, 0
    reason, message = EndReason.COMPLETED.value, ""
    with Recorder(path, prepared.stage.arrays, _attributes(prepared, case_text)) as recorder:
        began = time.perf_counter()
        try:
            with asked_to_stop() as interrupted:
                for state, chunk, end in march(prepared.scheme, timing):
                    _check_room(path.parent, 0)
                    recorder.write(chunk)
                    residual = state.statistics.complementarity_residual
                    unsolved = state.statistics.lcp_failures
                    if progress is not None:
                        progress("marching", min(state.step, timing.steps), timing.steps)
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
            "unsolved_steps": unsolved,
            "dt_over_critical": timing.time_step / prepared.problem.critical_time_step,
            "steps": recorder.steps,
            "wall_time": wall_time,
            "us_per_step": 1e6 * wall_time / max(recorder.steps, 1),
        }
        recorder.finish(reason, message, report)
    if progress is not None:
        progress("writing", recorder.steps, timing.steps)
    return report


def _expected_bytes(prepared: Prepared) -> int:
    problem, timing = prepared.problem, prepared.timing
    return description_bytes(prepared.stage.arrays) + result_bytes(
        len(problem.rotor.frequency),
        len(problem.casing.frequency),
        len(problem.rotor.tip_angle),
        timing.records,
    )


def _check_room(directory: Path, needed: int) -> None:
    """See that there is room for so many bytes and a little more.

    Raises:
        UserError: there is not.
    """
    free = shutil.disk_usage(folder.nearest_existing(directory)).free
    if free < needed + SPARE_BYTES:
        raise UserError(
            f"{directory}: expected {(needed + SPARE_BYTES) / 1e6:.0f} MB of room on the disk, "
            f"found {free / 1e6:.0f} MB"
        )


def _attributes(prepared: Prepared, case_text: str) -> dict[str, Attribute]:
    stage = prepared.stage
    case = stage.case
    strength = case.material.lowest_yield_strength
    return {
        **({} if strength is None else {"yield_strength": strength}),
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
        "symmetry": "; ".join(
            f"{body.replace('_', ' ')}: {found}, march {MARCHES[cyclic]}"
            for (body, found), cyclic in zip(
                stage.symmetry.items(), prepared.scheme.cyclic, strict=True
            )
        ),
        "case": case_text,
    }


def _divergence(prepared: Prepared, chunk: Chunk) -> str:
    """Which body went too far, where, how far and when, and what to do.

    The last record is the last state within the limit, so what goes beyond it is sought a step on.
    """
    rotor, casing = prepared.problem.rotor, prepared.problem.casing
    limit, step = prepared.problem.displacement_limit, prepared.timing.time_step
    moved = chunk.rotor_displacement[-1], chunk.rotor_velocity[-1]
    wall = chunk.casing_displacement[-1], chunk.casing_velocity[-1]
    angles = 360.0 * np.arange(len(casing.nodal)) / len(casing.nodal)
    tips = [f"blade {blade}" for blade in range(len(rotor.tip_angle))]
    candidates = (
        (tips, "radially", [rotor.tip_radial @ part for part in moved]),
        (tips, "tangentially", [rotor.tip_tangential @ part for part in moved]),
        (
            [f"the casing at {angle:.4g}°" for angle in angles],
            "radially",
            [casing.nodal[:, 0] @ part for part in wall],
        ),
    )
    places = [
        (abs(at + step * rate), name, way, at)
        for names, way, (values, rates) in candidates
        for name, at, rate in zip(names, values, rates, strict=True)
    ]
    _, place, way, value = max(places)
    return (
        f"{place} passed march.displacement_limit = {limit:g} m at {chunk.time[-1]:.6g} s"
        f" ({value:.4g} m {way}); {REMEDY}"
    )

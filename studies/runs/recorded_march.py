"""Time integration of a run with records and checkpoints, from the start or from a checkpoint."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from bladewhirl.files import replacing
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.solvers.march.checkpoint import (
    CHECKPOINT_NAME,
    Checkpoint,
    state_arrays,
    state_from,
    write_checkpoint,
)
from bladewhirl.solvers.march.free_motion import RULE
from bladewhirl.solvers.march.march import (
    CHUNK_STEPS,
    Chunk,
    CoatingRecords,
    EndReason,
    MarchState,
    coating_steps,
    joined,
    march,
)
from bladewhirl.solvers.march.recorder import (
    INTERRUPTED,
    NonFiniteError,
    Recorder,
    Records,
    Values,
    result_bytes,
)
from bladewhirl.solvers.march.schema import HISTORY
from bladewhirl.studies.runs import folder, march_texts
from bladewhirl.studies.runs.interrupts import asked_to_stop
from bladewhirl.studies.runs.prepare import Prepared

if TYPE_CHECKING:
    import xarray as xr

SPARE_BYTES = 4_000_000
"""Space on the disk that a march leaves free [bytes], because HDF5 cannot close a file properly on
a full disk."""

FLUSH_TIME, FLUSH_RECORDS = 0.5, 4096
"""Largest time [s] and largest number of records between two writes; a killed run loses at most the
records since the last write."""

CACHED_RECORDS = 500
"""Largest number of records that a march in memory computes at a time, so that they are in the
cache when they are stored."""

Activity = Literal["marching", "writing"]

Progress = Callable[[Activity, int, int], None]
"""Called with the activity, the number of finished steps and the number of all steps."""

REMEDY = (
    "the linear model no longer applies; check speed, load, damping, friction, or raise"
    " march.displacement_limit"
)


def march_to_file(
    prepared: Prepared,
    path: Path,
    case_text: str,
    progress: Progress | None = None,
    *,
    checkpoints: Path | None = None,
    begin: Checkpoint | None = None,
) -> dict[str, float]:
    """March and write records to disk; return the quality measures that only the march can compute.

    Args:
        prepared: the case to march.
        path: path of the result.
        case_text: text of the case for the result, see `folder.portable_case`.
        progress: called with the activity, the number of finished steps and the number of all
            steps.
        checkpoints: file for the state after every write of records; no file if None.
        begin: checkpoint from which to continue the earlier march that wrote ``path``.

    Raises:
        UserError: the disk is full; the records written are kept. The contact problem of more steps
            than march.unsolved_share allows was not solved.
        OSError: the system refuses a write; the records written are kept.
    """
    digest = "" if checkpoints is None else folder.march_digest(prepared.stage.case)
    with _recorder(prepared, path, case_text, begin) as recorder:

        def flush(chunk: Chunk, state: MarchState, wall_time: float) -> None:
            check_room(path.parent, 0)
            recorder.write(chunk)
            # No checkpoint after an extra record at the end, which a longer march does not have.
            if checkpoints is not None and state.step <= prepared.timing.whole_steps + 1:
                checkpoint = Checkpoint(
                    case=digest,
                    records=recorder.records,
                    wall_time=wall_time,
                    state=state_arrays(state),
                )
                write_checkpoint(checkpoints, checkpoint)

        return _march_into(recorder, prepared, flush, FLUSH_TIME, progress, begin)


def march_in_memory(
    prepared: Prepared, room: dict[str, Values] | None = None, *, casing: bool = True
) -> tuple[xr.Dataset, dict[str, float]]:
    """March with records in memory; return the result and the quality measures of `march_to_file`.

    If memory is passed as `room`, the result uses it and is valid until `room` is used again (see
    `Records`). The result contains the motion of the casing unless `casing` is false.
    """
    from bladewhirl.postprocess.fields.result import result_of  # loads xarray

    attributes = march_texts.attributes(prepared, dumps_case(prepared.stage.case))
    records = Records(prepared.arrays, attributes, prepared.timing.records, room, casing)
    prepared.scheme.records_casing = casing
    chunk_steps = CHUNK_STEPS
    if prepared.stop is None:  # which is asked after every chunk
        chunk_steps = min(CHUNK_STEPS, CACHED_RECORDS * prepared.timing.record_every)
    report = _march_into(
        records, prepared, lambda chunk, *_: records.write(chunk), 0.0, chunk_steps=chunk_steps
    )
    return result_of(records.stage, records.histories, records.attributes), report


def _march_into(
    record: Recorder | Records,
    prepared: Prepared,
    flush: Callable[[Chunk, MarchState, float], None],
    pause: float,
    progress: Progress | None = None,
    begin: Checkpoint | None = None,
    *,
    chunk_steps: int = CHUNK_STEPS,
) -> dict[str, float]:
    """March; return the quality measures. At intervals of `pause` [s], `flush` is called with the
    new records, the state and the elapsed time [s]; between two such calls are `chunk_steps` steps
    or more."""
    timing, statistics = prepared.timing, None
    reason, message = EndReason.COMPLETED.value, ""
    first, before = None, 0.0
    is_over = prepared.stop.is_over if prepared.stop is not None else None
    if begin is not None:
        first, before = state_at(prepared, begin), begin.wall_time
        statistics = first.statistics
    if prepared.problem.coating is not None:
        # There is a profile of the coating at the end of each chunk.
        chunk_steps = coating_steps(timing)
    began, flushed, waiting = time.perf_counter() - before, -pause, list[Any]()
    try:
        with asked_to_stop() as interrupted:
            for state, chunk, end in march(prepared.scheme, timing, first, is_over, chunk_steps):
                stopping = end is None and interrupted()
                waiting.append(chunk)
                due = time.perf_counter() - flushed >= pause
                if due or end or stopping or sum(c.records for c in waiting) > FLUSH_RECORDS:
                    flush(joined(waiting), state, time.perf_counter() - began)
                    waiting, flushed = [], time.perf_counter()
                statistics = state.statistics
                march_texts.check_solved(prepared, statistics.lcp_failures, timing.steps)
                if progress is not None:
                    progress("marching", min(state.step, timing.steps), timing.steps)
                if end is EndReason.DIVERGENT:
                    reason = end.value
                    message = f"{march_texts.divergence(prepared, chunk)}; {REMEDY}"
                elif end is EndReason.DAMPED:
                    reason, message = end.value, f"ended at {chunk.time[-1]:.6g} s, {RULE}"
                elif stopping:
                    reason = INTERRUPTED
                    message = f"interrupted at {record.steps * timing.time_step:.6g} s"
                    break
    except NonFiniteError as error:
        reason, message = EndReason.DIVERGENT.value, f"{error}; {REMEDY}"
    wall_time = time.perf_counter() - began
    unsolved = statistics.lcp_failures if statistics else 0
    march_texts.check_solved(prepared, unsolved, record.steps)
    report = {
        "complementarity_residual": statistics.complementarity_residual if statistics else 0.0,
        "unsolved_steps": unsolved,
        "dt_over_critical": timing.time_step / prepared.problem.critical_time_step,
        "steps": record.steps,
        "wall_time": wall_time,
        "us_per_step": 1e6 * wall_time / max(record.steps, 1),
    }
    if statistics is not None and unsolved:
        report |= {
            "unsolved_time": statistics.first_unsolved * timing.time_step,
            "unsolved_impulse": statistics.unsolved_impulse,
            "unsolved_wear": statistics.unsolved_wear,
        }
    if statistics is not None and statistics.fused_step >= 0:
        report["fuse_time"] = statistics.fused_step * timing.time_step
    record.finish(reason, message, report)
    if progress is not None:
        progress("writing", record.steps, timing.steps)
    return report


@contextmanager
def _recorder(
    prepared: Prepared, path: Path, case_text: str, begin: Checkpoint | None
) -> Iterator[Recorder]:
    """Yield a recorder of the result that contains the records before a checkpoint."""
    attributes = march_texts.attributes(prepared, case_text)
    if begin is None:
        with Recorder(path, prepared.arrays, attributes) as recorder:
            yield recorder
        return
    from bladewhirl.postprocess.fields.result import open_result, portions  # loads xarray

    with ExitStack() as stack:
        with replacing(path) as draft, open_result(path) as earlier:
            if earlier.sizes["time"] < begin.records:
                raise UserError(f"{path}: expected the {begin.records} records of the checkpoint")
            recorder = stack.enter_context(Recorder(draft, prepared.arrays, attributes))
            if "rod" in earlier.dims:
                reached = int(begin.state["step"]) * prepared.timing.time_step
                kept = np.flatnonzero(earlier["wear_time"].values <= reached)
                earlier = earlier.isel(wear_time=kept)
            for records in portions(earlier.isel(time=slice(begin.records))):
                portion = earlier.isel(time=records)
                first = recorder.records == 0
                recorder.write(_chunk(portion, prepared.timing.time_step, profiles=first))
        yield recorder


def _chunk(records: xr.Dataset, time_step: float, *, profiles: bool) -> Chunk:
    """Return records of a result as a chunk, with or without the profiles of its coating."""
    still = np.zeros((records.sizes["time"], 0))  # of a rigid wall
    names = (field.name for field in fields(Chunk) if field.name in HISTORY)
    values: dict[str, Any] = {name: records[name].values for name in names if name in records}
    for name in ("casing_displacement", "casing_velocity"):
        values.setdefault(name, still)
    coating = None
    if "rod" in records.dims:
        kept = records.isel(wear_time=slice(None if profiles else 0))
        parts = (field.name for field in fields(CoatingRecords))
        coating = CoatingRecords(**{name: kept[name].values for name in parts if name in kept})
    step = np.rint(values["time"] / time_step).astype(np.int64)
    return Chunk(step=step, coating=coating, **values)


def state_at(prepared: Prepared, begin: Checkpoint) -> Any:
    """Return the state of the scheme at a checkpoint.

    Raises:
        UserError: the march ends before the checkpoint, or the checkpoint belongs to another scheme
            or stage.
    """
    steps = int(begin.state["step"])
    if steps > prepared.timing.steps + 1:
        reached = (steps - 1) * prepared.timing.time_step
        raise UserError(
            f"march.duration: expected at least {reached:.6g} s, the time already marched"
        )
    try:
        return state_from(prepared.scheme.init(), begin.state)
    except ValueError as error:
        raise UserError(
            f"{CHECKPOINT_NAME}: does not contain the state of this march ({error})"
        ) from None


def check_room(directory: Path, needed: int) -> None:
    """Check that the disk has space for `needed` bytes and `SPARE_BYTES`.

    Raises:
        UserError: the space is not sufficient.
    """
    existing = next(path for path in (directory, *directory.absolute().parents) if path.exists())
    free = shutil.disk_usage(existing).free
    if free < needed + SPARE_BYTES:
        raise UserError(
            f"{directory}: expected {(needed + SPARE_BYTES) / 1e6:.0f} MB of free space on the"
            f" disk, found {free / 1e6:.0f} MB"
        )


def expected_bytes(prepared: Prepared) -> int:
    """Return the size of the result on disk if the march completes [bytes]."""
    return result_bytes(prepared.arrays, prepared.timing, prepared.problem.coating)


def history_bytes(prepared: Prepared) -> int:
    """Return the size of the records if the march completes [bytes], without the arrays of the
    stage."""
    described = sum(array.nbytes for array in prepared.arrays.stored.values())
    return expected_bytes(prepared) - described

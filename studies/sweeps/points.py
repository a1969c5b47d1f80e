"""Points of a sweep, marched and reduced to the data of the sweep.

The data of a point depend only on its case, so that it does not matter which worker marches a
point, when, or how often.
"""

import os
import threading
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import xarray as xr

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import loads, with_values
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.sweep.dataset import Layout
from bladewhirl.postprocess.sweep.digest import Digest, digest
from bladewhirl.solvers.march.free_motion import FreeMotion, StopWhen
from bladewhirl.solvers.march.march import EndReason
from bladewhirl.solvers.march.schema import RESULT_NAME
from bladewhirl.studies.runs.folder import portable_case
from bladewhirl.studies.runs.prepare import Change, prepare, screened
from bladewhirl.studies.runs.recorded_march import history_bytes, march_in_memory, march_to_file
from bladewhirl.studies.sweeps.axes import Value
from bladewhirl.studies.sweeps.carried import continued, late_state, read_state, write_state
from bladewhirl.studies.sweeps.stages import stage_at
from bladewhirl.studies.sweeps.starts import StartName, begun, start_of

IN_MEMORY = 500_000_000
"""Largest size of a history in the memory of a worker [bytes], without the arrays of its stage,
which are there in any case; a larger history is kept in a file until the data of the sweep have
been computed from it."""

_THREAD = threading.local()
"""Data of a marching thread: memory of its records, reused from point to point."""


@dataclass(frozen=True, kw_only=True)
class Point:
    """A point for a worker to march."""

    number: int
    values: Mapping[str, Value]  #: values of the swept keys
    history: str | None = None  #: file name of the full history; None if no history is kept
    screen: bool = False  #: whether to march with scaled masses of the casing
    before: str | None = None  #: file name of the state from which the march starts
    after: str | None = None  #: file name for the state at the end; None if it is not kept
    branch: Path | None = None  #: folder in that of the sweep of the branch with the first motion
    value: Value | None = None  #: value of the key of this branch


@dataclass(frozen=True, kw_only=True)
class Failure:
    """Outcome of a point without a result."""

    reason: str  #: reason of the failure, in one line


Outcome = Digest | Failure


@dataclass(frozen=True, kw_only=True)
class Work:
    """Data common to all points of a sweep."""

    case: str  #: case that is varied, as TOML
    layout: Layout | None  #: layout of the data of a point; None if only histories are kept
    histories: str  #: folder of full histories
    stop_when: StopWhen | None = None  #: condition for ending a march early
    states: str = ""  #: folder of states
    start: StartName = "rest"  #: motion from which marches start
    directory: str = ""  #: folder of the sweep


def march_point(work: Work, point: Point) -> Outcome:
    """March a point and reduce it, or return the reason of its failure.

    This function runs in a worker. A full history, if requested, gets its final name when it is
    complete.
    """
    try:
        return _march_point(work, with_values(_varied(work.case), point.values), point)
    except UserError as error:
        return Failure(reason=error.lines[0])
    except Exception as error:  # any error is the failure of this point
        text = " ".join(str(error).split())
        return Failure(reason=f"{type(error).__name__}: {text}")


@lru_cache(maxsize=1)
def _varied(text: str) -> Case:
    return loads(text)


def _march_point(work: Work, case: Case, point: Point) -> Digest:
    name, stage = point.history, stage_at(case)
    change, record = _change(work, stage, point)
    prepared = prepare(stage, change)
    if work.stop_when is not None:
        with suppress(ValueError):  # a march that cannot end early runs to its end
            stop = FreeMotion.of(prepared.problem, prepared.timing.time_step)
            prepared = replace(prepared, stop=stop)
    if work.layout is not None and name is None and history_bytes(prepared) <= IN_MEMORY:
        room = _THREAD.__dict__.setdefault("room", {})
        casing = "casing_displacement_max" in work.layout.variables or point.after is not None
        result, report = march_in_memory(prepared, room, casing=casing)
        _keep_state(work, stage, result, point)
        return digest(result, report, work.layout) | record
    # A history to keep is written into its final folder, under another name until it is complete.
    folder = work.histories if name is not None else None
    with TemporaryDirectory(prefix=".point-", dir=folder) as scratch:
        path = Path(scratch) / RESULT_NAME
        report = march_to_file(prepared, path, portable_case(case, os.pardir))
        kept: Digest = {}
        if work.layout is not None:
            with open_result(path) as result:
                _keep_state(work, stage, result, point)
                kept = digest(result, report, work.layout) | record
        if name is not None:
            os.replace(path, Path(work.histories) / name)
    return kept


def _change(work: Work, stage: Stage, point: Point) -> tuple[Change | None, Digest]:
    """Return the function that changes the contact problem of a point, None for no change, and the
    data of the sweep on the start of the march."""
    if point.screen:
        return screened, {}
    if work.start == "periodic":
        branch = None if point.branch is None else Path(work.directory) / point.branch
        start, record = start_of(stage, branch, point.value)
        if start is None:
            return None, record
        return lambda problem, timing: (begun(problem, start), timing), record
    if point.before is None:
        return None, {}
    state = read_state(Path(work.states) / point.before)
    return lambda problem, timing: (continued(stage, problem, state), timing), {}


def _keep_state(work: Work, stage: Stage, result: xr.Dataset, point: Point) -> None:
    """Write the state that is carried to the next speed, unless the march ended early."""
    if point.after is not None and result.attrs["end_reason"] == EndReason.COMPLETED.value:
        write_state(Path(work.states) / point.after, late_state(stage, result))

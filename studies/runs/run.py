"""Runs: from a case to a folder with result, summary, figures and series."""

import os
import sys
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

from bladewhirl.files import claim, owned, remove_leftovers, write_atomically
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import read_case
from bladewhirl.models.inputs.errors import CaseError, Hint, UserError, writing
from bladewhirl.models.stage.hints import stage_hints
from bladewhirl.solvers.march.checkpoint import CHECKPOINT_NAME, Checkpoint, read_checkpoint
from bladewhirl.solvers.march.schema import RESULT_NAME
from bladewhirl.studies.runs import folder, recorded_march
from bladewhirl.studies.runs.outputs import Run, Window, write_outputs
from bladewhirl.studies.runs.prepare import Prepared, prepare
from bladewhirl.studies.runs.sensor_files import check_gauges

LOCK_NAME = ".lock"
"""Name of the file locked by the process that writes a folder; the system releases the lock when
the process ends, even if it is killed."""

NEW, OLD = ".new", ".old"
"""Suffixes of the temporary folders of a new run, and of the run that it replaces."""


def run(
    case: Case | str | Path,
    directory: str | Path,
    *,
    overwrite: bool = False,
    frames: int = 300,
    start: float | None = None,
    end: float | None = None,
    rotating: bool = False,
    progress: recorded_march.Progress | None = None,
) -> Run:
    """March a case, and write all its results into a folder.

    The folder then contains case.toml (and a copy of its mesh file), provenance.json, result.nc,
    summary.json, orbit and energy (.png and their data) and vtk/; with tables [[sensor]] also
    sensors.nc and a file NAME.csv for each sensor. Nothing is written before the case is validated.
    Ctrl-C ends the march properly: all outputs are written for the time marched, and the end reason
    of the run is "interrupted".

    Args:
        case: case to march, or the path of its file.
        directory: folder to make.
        overwrite: whether to replace the run in an existing folder when the new run is finished;
            files that do not belong to the old run are kept.
        frames: number of frames of the ParaView series in vtk/; 0 for no series.
        start: start of the series [s]; if None, the start of the run.
        end: end of the series [s]; if None, the end of the run.
        rotating: whether the series is in rotating axes.
        progress: called with the activity, the number of finished steps and the number of all
            steps, many times a second while marching.

    Warns:
        Hint: an implausible value of the case, such as a clearance of a metre.

    Raises:
        CaseError: all faults of the case.
        UserError: the folder must not be used, the time window is invalid, or a file cannot be
            written.
    """
    if not isinstance(case, Case):
        case = read_case(case)
    directory = Path(directory)
    window = Window(frames=frames, start=start, end=end, rotating=rotating)
    folder.check_free(directory, overwrite=overwrite)
    prepared = prepare(case)
    window.check(prepared.timing.duration)
    check_gauges(prepared)
    for hint in stage_hints(prepared.stage):
        warnings.warn(hint, Hint, stacklevel=2)
    with writing(directory):
        recorded_march.check_room(directory, recorded_march.expected_bytes(prepared))
        files = folder.case_files(case)
        with _nothing_left(directory), taking_place(directory) as place:
            claim(place, folder.files_of_run(case))
            for name, content in files.items():
                write_atomically(place / name, content)
            folder.write_provenance(place, case)
            return replace(
                _march_and_sum_up(prepared, place, window, progress), directory=directory
            )


def resume(
    directory: str | Path,
    overrides: Iterable[str] = (),
    *,
    frames: int = 300,
    rotating: bool = False,
    progress: recorded_march.Progress | None = None,
) -> Run:
    """Finish a killed run or extend a run; the result is bitwise that of an uninterrupted run.

    Args:
        directory: folder of the run.
        overrides: a longer duration, such as "march.duration=6".
        frames: number of frames of the ParaView series; 0 for no series.
        rotating: whether the series is in rotating axes.
        progress: callback, see `run`.

    Raises:
        UserError: the folder contains no run that can be continued, a key other than the duration
            is changed, or a file cannot be written.
    """
    directory = Path(directory)
    path = directory / folder.CASE_NAME
    case, state = read_case(path, overrides), directory / CHECKPOINT_NAME
    try:
        checkpoint = read_checkpoint(state)
    except (OSError, ValueError) as error:
        raise UserError(
            f"{state}: expected the state at the end of a run ({error}); to start the run again:"
            f" bladewhirl run {path} --overwrite"
        ) from None
    if checkpoint.case != folder.march_digest(case):
        raise UserError(
            f"{path}: expected the case and the version of bladewhirl with which the run was begun;"
            " only march.duration may change"
        )
    window = Window(frames=frames, rotating=rotating)
    prepared = prepare(folder.with_originals(case, directory))
    window.check(prepared.timing.duration)
    recorded_march.state_at(prepared, checkpoint)  # nothing is written if the run cannot continue
    with writing(directory), locked(directory):
        remove_leftovers(directory)
        write_atomically(path, folder.portable_case(case))
        return _march_and_sum_up(prepared, directory, window, progress, checkpoint)


def _march_and_sum_up(
    prepared: Prepared,
    place: Path,
    window: Window,
    progress: recorded_march.Progress | None,
    begin: Checkpoint | None = None,
) -> Run:
    """March into a folder that contains the case, and write all outputs there."""
    case = prepared.stage.case
    report = recorded_march.march_to_file(
        prepared,
        place / RESULT_NAME,
        folder.portable_case(case),
        progress,
        checkpoints=place / CHECKPOINT_NAME,
        begin=begin,
    )
    done = write_outputs(place, report, window)
    return replace(done, hints=(*stage_hints(prepared.stage), *done.hints))


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock a folder for this process; make the folder if it does not exist.

    Raises:
        UserError: another process has locked the folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / LOCK_NAME
    with path.open("ab") as file:
        try:
            _lock(file)
        except OSError:
            raise UserError(
                f"{folder}: is in use; another process is writing a run there"
            ) from None
        try:
            yield
        finally:
            # The path can be another folder now, if this folder was moved and another took its
            # place.
            with suppress(OSError):
                if os.path.samestat(path.stat(), os.fstat(file.fileno())):
                    path.unlink()


def _lock(file: BinaryIO) -> None:
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def taking_place(directory: Path) -> Iterator[Path]:
    """Yield the folder to write a run into; at the end this folder replaces ``directory``.

    If there is no earlier run, the folder is ``directory`` itself. Files listed in the manifests of
    the earlier run are removed, other files are moved into the new folder. If another file has the
    name of a file of the new run, it is kept in a folder with the suffix ``.old``.

    Raises:
        UserError: another process writes there, or the files of an interrupted earlier call are in
            the way.
    """
    if not directory.exists() or not any(directory.iterdir()):
        with locked(directory):
            yield directory
        return
    directory = directory.resolve()
    new, old = (directory.with_name(directory.name + suffix) for suffix in (NEW, OLD))
    if old.exists():
        raise UserError(f"{old}: this folder exists and has files of an earlier run; move it away")
    with locked(directory), locked(new):
        for path in [*owned(new)]:
            path.unlink()
        _drop_empty_folders(new)
        yield new
        directory.rename(old)
        new.rename(directory)
        (directory / LOCK_NAME).unlink(missing_ok=True)
        _bring_over(old, directory)


@contextmanager
def _nothing_left(directory: Path) -> Iterator[None]:
    """Remove what a run wrote if its case turns out to be faulty while marching."""
    earlier = directory.exists() and any(directory.iterdir())
    place = directory.resolve().with_name(directory.name + NEW) if earlier else directory
    try:
        yield
    except CaseError:
        for path in [*owned(place)]:
            path.unlink()
        _drop_empty_folders(place)
        with suppress(OSError):
            place.rmdir()
        raise


def _bring_over(old: Path, directory: Path) -> None:
    for path in [*owned(old), old / LOCK_NAME]:
        path.unlink(missing_ok=True)
    for place, folders, names in [*os.walk(old)]:
        links = [name for name in folders if (Path(place) / name).is_symlink()]
        for path in (Path(place) / name for name in (*names, *links)):
            target = directory / path.relative_to(old)
            with suppress(FileExistsError, NotADirectoryError):
                target.parent.mkdir(parents=True, exist_ok=True)
                if not os.path.lexists(target):
                    path.rename(target)
    _drop_empty_folders(old)
    with suppress(OSError):
        old.rmdir()


def _drop_empty_folders(folder: Path) -> None:
    for place, folders, _ in os.walk(folder, topdown=False):
        for name in folders:
            with suppress(OSError):
                (Path(place) / name).rmdir()

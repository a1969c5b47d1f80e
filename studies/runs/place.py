"""Folder in which a new run is written: the final folder, or, if the new run replaces an earlier
one, a temporary folder next to the earlier run."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from bladewhirl.files import owned
from bladewhirl.models.inputs.errors import UserError

LOCK_NAME = ".lock"
"""Name of the file locked by the process that writes a folder; the system releases the lock when
the process ends, even if it is killed."""

NEW, OLD = ".new", ".old"
"""Suffixes of the temporary folders of a new run, and of the run that it replaces."""


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

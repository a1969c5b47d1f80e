"""Folder for the files of a new run: its own, or a temporary one beside the run it replaces."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from bladewhirl.files import owned
from bladewhirl.models.inputs.errors import UserError

LOCK_NAME = ".lock"
"""Held by the process that writes a folder; the system frees it when that ends, however it does."""

NEW, OLD = ".new", ".old"
"""Suffixes of the folder of a new run, and of the run that it replaces."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock a folder for this process; it is made if it does not exist.

    Raises:
        UserError: another one has it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / LOCK_NAME
    with path.open("ab") as file:
        try:
            _lock(file)
        except OSError:
            raise UserError(f"{folder}: is in use; another process writes a run there") from None
        try:
            yield
        finally:
            # Not where the folder has moved on, and another took its place.
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
    """Yield the folder to write a run into; at the end it replaces the run in ``directory``.

    Where there is none it is ``directory`` itself. Files of the earlier run that its manifests
    list go, others move into the new folder; those with names of the new run stay in one with
    ``.old`` after its name.

    Raises:
        UserError: another process writes there, or what an earlier call left is in the way.
    """
    if not directory.exists() or not any(directory.iterdir()):
        with locked(directory):
            yield directory
        return
    directory = directory.resolve()
    new, old = (directory.with_name(directory.name + suffix) for suffix in (NEW, OLD))
    if old.exists():
        raise UserError(f"{old}: expected no such folder; it has files of an earlier run")
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

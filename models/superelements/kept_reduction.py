"""Reductions that are kept: in memory, and in a folder beside the file of the superelement.

A reduction is found by a digest of all that it depends on: the arrays of the superelement, the
numbers of sectors and modes, and the version of the method. The name of its file also has the size
and a checksum of the contents, so that other contents are found before an array is read.
"""

import hashlib
import io
import logging
import re
import stat
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import scipy.sparse as sp

from bladewhirl.files import write_atomically
from bladewhirl.models.superelements.superelement import Superelement

logger = logging.getLogger(__name__)

VERSION = 5
"""Version of the method; a higher one makes all reductions again."""

FOLDER = ".reduced"  #: what the name of the folder adds to that of the file

LARGE = 1000  #: least number of coordinates of a superelement whose reduction is kept in a folder

NAMES = re.compile("[0-9a-f]{32}(-[0-9]+-[0-9a-f]{64})?[.]npz")
"""Names of the files in a folder, also of earlier versions; no other file is removed."""

MOST = 8  #: largest number of reductions in a folder

REMEMBERED, IN_MEMORY = 4, 1e8
"""Number of the last reductions that are kept in memory, and their largest size [bytes]."""

Arrays = Mapping[str, np.ndarray[Any, Any]]

Kind = TypeVar("Kind", bound=Any)

_remembered: dict[str, Arrays] = {}
"""The last reductions by their digests."""


def kept_reduction(
    file: str, part: Superelement, settings: tuple[float, ...], compute: Callable[[], Arrays]
) -> Arrays:
    """Return the arrays of a reduction: those that were kept, else those that a function computes.

    A file that is damaged is made again, which is logged; a folder that cannot be written, or is a
    link, keeps nothing.

    Args:
        file: file of the superelement.
        part: superelement.
        settings: numbers on which the reduction depends.
        compute: function that returns the arrays by name.
    """
    digest = _digest(part, settings)
    if digest in _remembered:
        return _remembered[digest]
    folder = Path(file + FOLDER)
    large = part.size >= LARGE
    if large and folder.is_symlink():
        logger.warning("%s: expected a folder, found a link: no reduction is kept.", folder)
        large = False
    arrays = _read(folder, digest) if large else None
    if arrays is None:
        arrays = compute()
        if large:
            _write(folder, digest, arrays)
    if sum(one.nbytes for one in arrays.values()) <= IN_MEMORY:
        _remembered[digest] = arrays
        for old in list(_remembered)[:-REMEMBERED]:
            del _remembered[old]
    return arrays


def flattened(parts: Iterable[Any]) -> dict[str, np.ndarray[Any, Any]]:
    """Return the arrays and numbers of dataclasses, by name and place, for `kept_reduction`."""
    return {
        f"{name}_{place}": np.asarray(value.toarray() if sp.issparse(value) else value)
        for place, part in enumerate(parts)
        for name, value in vars(part).items()
        if value is not None
    }


def restored(kind: type[Kind], count: int, arrays: Arrays) -> list[Kind]:
    """Return dataclasses from what `flattened` made of them."""
    names = [field.name for field in fields(kind)]
    found = [{name: arrays.get(f"{name}_{place}") for name in names} for place in range(count)]
    return [
        kind(**{name: one if one is None or one.ndim else one.item() for name, one in part.items()})
        for part in found
    ]


def _digest(part: Superelement, settings: tuple[float, ...]) -> str:
    found = hashlib.sha256(repr((VERSION, settings)).encode())
    for name, value in vars(part).items():
        if isinstance(value, str):  # name and source change nothing
            continue
        arrays = [value]
        if sp.issparse(value):
            rows = sp.csr_array(value)
            arrays = [rows.data, rows.indices, rows.indptr]
        for array in arrays:
            shape = None if array is None else (np.shape(array), np.asarray(array).dtype.str)
            found.update(repr((name, shape)).encode())
            if array is not None:
                found.update(np.ascontiguousarray(array).data)
    return found.hexdigest()[:32]


def _own(folder: Path, digest: str = "") -> list[Path]:
    """Return the files of a folder whose names are those that the program gives, old ones first."""
    files = [one for one in folder.glob(f"{digest}*.npz") if NAMES.fullmatch(one.name)]
    return sorted(files, key=lambda one: one.lstat().st_mtime)


def _read(folder: Path, digest: str) -> Arrays | None:
    """Return the arrays of a file; None if there is none that is whole."""
    for path in _own(folder, f"{digest}-"):
        try:
            state, (_, size, checksum) = path.lstat(), path.stem.split("-")
            # Reading a pipe never ends; a large file of another origin is not read at all.
            if not stat.S_ISREG(state.st_mode) or str(state.st_size) != size:
                raise ValueError(f"expected a regular file of {size} bytes")
            with path.open("rb") as stream:
                if hashlib.file_digest(stream, "sha256").hexdigest() != checksum:
                    raise ValueError("its contents have another checksum")
                stream.seek(0)
                with np.load(stream, allow_pickle=False) as archive:
                    arrays = {name: archive[name] for name in archive.files}
            if str(arrays.pop("digest", "")) != digest:
                raise ValueError("it belongs to another reduction")
            return arrays
        except Exception as error:  # the reader raises exceptions of any type
            logger.warning("%s: damaged (%s): the reduction is computed again.", path, error)
            with suppress(OSError):
                path.unlink()
    return None


def _write(folder: Path, digest: str, arrays: Arrays) -> None:
    try:
        np.savez(stream := io.BytesIO(), allow_pickle=False, digest=np.array(digest), **arrays)
        content = stream.getvalue()
        checksum = hashlib.sha256(content).hexdigest()
        write_atomically(folder / f"{digest}-{len(content)}-{checksum}.npz", content)
        for old in _own(folder)[:-MOST]:
            old.unlink()
    except (OSError, MemoryError) as error:
        logger.info("the reduction is not kept: %s", error)

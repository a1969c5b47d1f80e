"""Reductions that are kept: in memory, and in a folder beside the file of the superelement.

A reduction is found by a digest of all that it depends on: the arrays of the superelement, the
numbers of sectors and modes, and the version of the method.
"""

import hashlib
import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import scipy.sparse as sp

from bladewhirl.files import replacing
from bladewhirl.models.superelements.superelement import Superelement

logger = logging.getLogger(__name__)

VERSION = 4
"""Version of the method; a higher one makes all reductions again."""

FOLDER = ".reduced"  #: what the name of the folder adds to that of the file

LARGE = 1000  #: least number of coordinates of a superelement whose reduction is kept in a folder

MOST = 8  #: largest number of reductions in a folder

REMEMBERED, IN_MEMORY = 4, 1e8
"""Number of the last reductions that are kept in memory, and their largest size [bytes]."""

Arrays = Mapping[str, np.ndarray[Any, Any]]

_remembered: dict[str, Arrays] = {}
"""The last reductions by their digests."""


def kept_reduction(
    file: str, part: Superelement, settings: tuple[float, ...], compute: Callable[[], Arrays]
) -> Arrays:
    """Return the arrays of a reduction: those that were kept, else those that a function computes.

    A file that is damaged is made again; a folder that cannot be written keeps nothing.

    Args:
        file: file of the superelement.
        part: superelement.
        settings: numbers on which the reduction depends.
        compute: function that returns the arrays by name.
    """
    digest = _digest(part, settings)
    if digest in _remembered:
        return _remembered[digest]
    path = Path(file + FOLDER) / f"{digest}.npz"
    arrays = _read(path, digest) if part.size >= LARGE else None
    if arrays is None:
        arrays = compute()
        if part.size >= LARGE:
            _write(path, digest, arrays)
    if sum(one.nbytes for one in arrays.values()) <= IN_MEMORY:
        _remembered[digest] = arrays
        for old in list(_remembered)[:-REMEMBERED]:
            del _remembered[old]
    return arrays


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


def _read(path: Path, digest: str) -> Arrays | None:
    """Return the arrays of a file; None if there is none that is whole."""
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except (OSError, ValueError, TypeError, EOFError, BadZipFile, NotImplementedError) as error:
        if path.exists():
            logger.info("%s is made again: %s", path, error)
        return None
    return arrays if str(arrays.pop("digest", "")) == digest else None


def _write(path: Path, digest: str, arrays: Arrays) -> None:
    try:
        with replacing(path) as draft, draft.open("wb") as stream:
            np.savez(stream, allow_pickle=False, digest=np.array(digest), **arrays)
        others = sorted(path.parent.glob("*.npz"), key=lambda one: one.stat().st_mtime)
        for old in others[:-MOST]:
            old.unlink()
    except OSError as error:
        logger.info("the reduction is not kept: %s", error)

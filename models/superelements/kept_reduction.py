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
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import scipy.sparse as sp

from bladewhirl.files import write_atomically
from bladewhirl.models.superelements.superelement import Superelement

logger = logging.getLogger(__name__)

VERSION = 6
"""Version of the method; a higher one makes all reductions again."""

FOLDER = ".reduced"  #: what the name of the folder adds to that of the file

LARGE = 1000
"""Least number of coordinates of a sector, or a tenth of those of all sectors, whose reduction is
kept in a folder."""

NAMES = re.compile("[0-9a-f]{32}(-[0-9]+-[0-9a-f]{64})?[.]npz")
"""Names of the files in a folder, also of earlier versions; no other file is removed."""

MOST = 8  #: largest number of reductions in a folder

REMEMBERED, IN_MEMORY = 4, 1e8
"""Number of the last reductions that are kept in memory, and their largest size [bytes]."""

Arrays = Mapping[str, np.ndarray[Any, Any]]  #: arrays and numbers of a part of a reduction, by name

Kind = TypeVar("Kind", bound=Any)

_remembered: dict[str, list[Arrays]] = {}
"""The last reductions by their digests."""


def kept_reduction(
    file: str, part: Superelement, settings: tuple[float, ...], compute: Callable[[], list[Arrays]]
) -> list[Arrays]:
    """Return the parts of a reduction: those that were kept, else those that a function computes.

    A file that is damaged is made again, which is logged; a folder that cannot be written, or is a
    link, keeps nothing.

    Args:
        file: file of the superelement.
        part: superelement.
        settings: numbers on which the reduction depends; the first is that of sectors.
        compute: function that returns the parts, none of them without arrays.
    """
    digest = _digest(part, settings)
    if digest in _remembered:
        return _remembered[digest]
    folder = Path(file + FOLDER)
    large = part.size * max(1.0, 0.1 * settings[0]) >= LARGE
    if large and folder.is_symlink():
        logger.warning("%s: expected a folder, found a link: no reduction is kept.", folder)
        large = False
    parts = _read(folder, digest) if large else None
    if parts is None:
        parts = compute()
        if large:
            _write(folder, digest, parts)
    if sum(one.nbytes for arrays in parts for one in arrays.values()) <= IN_MEMORY:
        _remembered[digest] = parts
        for old in list(_remembered)[:-REMEMBERED]:
            del _remembered[old]
    return parts


def arrays_of(part: Any) -> Arrays:
    """Return the arrays and numbers of a dataclass, for `kept_reduction`."""
    return {
        name: np.asarray(value.toarray() if sp.issparse(value) else value)
        for name, value in vars(part).items()
        if value is not None
    }


def restored(kind: type[Kind], arrays: Arrays) -> Kind:
    """Return a dataclass from what `arrays_of` made of it."""
    given = {name: one if one.ndim else one.item() for name, one in arrays.items()}
    found: Kind = kind(**dict.fromkeys(field.name for field in fields(kind)) | given)
    return found


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


def _read(folder: Path, digest: str) -> list[Arrays] | None:
    """Return the parts in a file, each of which is a folder of it; None if there is no file that is
    whole."""
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
                    if str(archive["digest"]) != digest:
                        raise ValueError("it belongs to another reduction")
                    parts: dict[str, dict[str, Any]] = {}
                    for place in archive.files[1:]:
                        number, name = place.split("/")
                        parts.setdefault(number, {})[name] = archive[place]
            return [*parts.values()]
        except Exception as error:  # the reader raises exceptions of any type
            logger.warning("%s: damaged (%s): the reduction is computed again.", path, error)
            with suppress(OSError):
                path.unlink()
    return None


def _write(folder: Path, digest: str, parts: list[Arrays]) -> None:
    content: dict[str, Any] = {"digest": np.array(digest)}
    for number, arrays in enumerate(parts):
        content |= {f"{number}/{name}": each for name, each in arrays.items()}
    try:
        np.savez(stream := io.BytesIO(), allow_pickle=False, **content)
        written = stream.getvalue()
        checksum = hashlib.sha256(written).hexdigest()
        write_atomically(folder / f"{digest}-{len(written)}-{checksum}.npz", written)
        for old in _own(folder)[:-MOST]:
            old.unlink()
    except (OSError, MemoryError) as error:
        logger.info("the reduction is not kept: %s", error)

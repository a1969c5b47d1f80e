"""Arrays and matrices from files of NumPy, MATLAB and other programs, checked before use.

Compiled routines trust the indices of sparse matrices and access any memory to which they point.
Every matrix from a file therefore passes `checked_matrix` first.
"""

import warnings
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io as sio
import scipy.sparse as sp

from bladewhirl.files import check_regular, reason_of
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.machine import memory
from bladewhirl.models.inputs.units import LARGEST
from bladewhirl.models.superelements.matlab_tags import check_tags
from bladewhirl.models.superelements.superelement import Matrix, SuperelementError

MOST = 10_000_000
"""Largest number of rows or columns of a matrix."""


def read_foreign(file: Path, kind: str, read: Callable[[], Any]) -> Any:
    """Return the result of a function that reads a file.

    Raises:
        SuperelementError: the function raised any error; `kind`, such as "a file of NumPy",
            completes "expected".
    """
    try:
        check_regular(file)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return read()
    except SuperelementError:
        raise
    except OSError as error:
        reason = f"a readable file ({error.strerror or error})"
    except Exception as error:  # the readers raise exceptions of any type
        reason = f"{kind} ({own[:200]})" if (own := reason_of(error)) else kind
    raise SuperelementError(f"{file}: expected {reason}")


def npz_arrays(file: Path, known: Collection[str]) -> dict[str, Any]:
    """Return the arrays of a .npz file by name; those with an unknown name are None and not read.

    Raises:
        SuperelementError: the file cannot be read, or the arrays do not fit into memory.
    """

    def read() -> dict[str, Any]:
        with file.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            names = [name for name in archive.files if name in known]
            members = {f"{name}.npy" for name in names}.union(names)
            _check_size([i.file_size for i in archive.zip.infolist() if i.filename in members])
            return dict.fromkeys(archive.files) | {name: archive[name] for name in names}

    return dict(read_foreign(file, "a file of NumPy or MATLAB", read))


def mat_variables(file: Path, known: Collection[str]) -> dict[str, Any]:
    """Return the variables of a .mat file by name; unless they are structures, those with an
    unknown name are None and not read.

    Raises:
        SuperelementError: the file cannot be read, or the variables do not fit into memory.
    """

    def read() -> dict[str, Any]:
        check_tags(file)
        found = sio.whosmat(file, appendmat=False)
        rows = [row for row in found if row[0] in known or row[2] == "struct"]
        _check_size([8.0 * np.prod(shape, dtype=float) for _, shape, k in rows if k != "sparse"])
        names, options = [row[0] for row in rows], {"struct_as_record": False, "appendmat": False}
        content = sio.loadmat(file, variable_names=[*names], **options)
        return dict.fromkeys(row[0] for row in found) | {name: content[name] for name in names}

    return dict(read_foreign(file, "a .mat file before version 7.3", read))


def _check_size(sizes: list[float]) -> None:
    if sum(sizes) > memory():
        raise ValueError(f"its arrays need {sum(sizes) / 1e9:.3g} GB of memory")


def checked_matrix(key: str, value: Any) -> Matrix:
    """Return a matrix from a file with 64-bit floats, sparse if it is given so.

    Raises:
        SuperelementError: the matrix has other values than finite real numbers, or indices out of
            range.
    """
    if not sp.issparse(value):
        return np.atleast_2d(real_numbers(key, value))
    if value.ndim != 2 or max(value.shape) > MOST:
        raise SuperelementError(f"{key}: expected at most {MOST} rows, got {value.shape}")
    try:
        if value.format in ("csr", "csc"):
            _check_indices(value)
        rows = sp.csr_array(value, copy=True)
    except (ValueError, TypeError, MemoryError, IndexError) as error:
        raise SuperelementError(f"{key}: expected a sparse matrix ({error})") from None
    rows.data = real_numbers(key, rows.data)
    return rows


def _check_indices(matrix: Any) -> None:
    """Check compressed rows or columns. SciPy's own check skips matrices that seem to be empty."""
    lines, length = matrix.shape if matrix.format == "csr" else matrix.shape[::-1]
    begin, within = matrix.indptr, matrix.indices
    if len(begin) != lines + 1 or begin[0] != 0 or np.any(begin[1:] < begin[:-1]):
        raise ValueError("indptr does not ascend from 0")
    if not begin[-1] <= len(within) == len(matrix.data):
        raise ValueError("indptr exceeds the number of entries")
    if len(within) and not (within.min() >= 0 and within.max() < length):
        raise ValueError(f"indices are not from 0 to {length - 1}")


def real_numbers(key: str, value: Any) -> FloatArray:
    """Return an array of 64-bit floats.

    Raises:
        SuperelementError: the values are not finite real numbers of a plausible size.
    """
    given = np.asarray(value)
    with np.errstate(over="ignore"):
        numbers = given.astype(np.float64) if given.dtype.kind in "biuf" else np.array(np.nan)
    if not np.all(abs(numbers) <= LARGEST):
        raise SuperelementError(f"{key}: expected finite real numbers")
    return numbers


def whole_numbers(key: str, value: Any) -> np.ndarray[Any, Any]:
    """Return an array of 64-bit integers.

    Raises:
        SuperelementError: the values are not whole numbers that floats represent exactly.
    """
    given = real_numbers(key, value)
    if not np.all((given == np.round(given)) & (abs(given) < 2.0**53)):
        raise SuperelementError(f"{key}: expected whole numbers")
    return given.astype(np.int64)

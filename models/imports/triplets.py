"""Text files of sparse matrices: Matrix Market, and lines of row, column and value."""

from pathlib import Path
from typing import Any

import numpy as np
import scipy.io as sio
import scipy.sparse as sp

from bladewhirl.models.superelements.superelement import SuperelementError

MATRIX_MARKET = b"%%MatrixMarket"


def read_matrix(path: Path) -> sp.csr_array:
    """Read a real matrix from a file of Matrix Market, or of lines of row, column and value.

    Raises:
        SuperelementError: the file is missing, or not a square matrix.
    """
    try:
        with path.open("rb") as stream:
            head = stream.read(len(MATRIX_MARKET))
        if head != MATRIX_MARKET:
            return read_triplets(path)
        matrix = sp.csr_array(sio.mmread(path))
    except OSError as error:
        reason = error.strerror or error
        raise SuperelementError(f"{path}: expected a readable file ({reason})") from None
    except (ValueError, TypeError, EOFError, OverflowError, MemoryError) as error:
        raise SuperelementError(f"{path}: expected a file of Matrix Market ({error})") from None
    if matrix.shape[0] != matrix.shape[1] or matrix.dtype.kind not in "iuf":
        raise SuperelementError(f"{path}: expected a square real matrix, got {matrix.shape}")
    return matrix.astype(np.float64)


def read_triplets(path: Path, size: int | None = None) -> sp.csr_array:
    """Read a matrix from lines of row, column and value, separated by blanks or commas.

    Rows and columns begin with 1. If only one triangle has entries, the matrix is symmetric.

    Args:
        path: path of the file.
        size: number of rows and columns; by default the largest number of a row.

    Raises:
        SuperelementError: the file is missing, or has lines of another form.
    """
    try:
        text = path.read_text(encoding="utf-8").replace(",", " ")
        values: Any = np.array(text.split(), dtype=np.float64).reshape(-1, 3)
    except (OSError, ValueError):
        raise SuperelementError(f"{path}: expected lines of row, column and value") from None
    row, column = (values[:, n].astype(np.int64) - 1 for n in range(2))
    most = int(max(row.max(), column.max())) + 1 if len(values) else 0
    size = most if size is None else size
    if not len(values) or most > size or min(row.min(), column.min()) < 0:
        raise SuperelementError(f"{path}: expected rows and columns from 1 to {size}, got {most}")
    matrix = sp.csr_array((values[:, 2], (row, column)), shape=(size, size))
    if np.all(row <= column) or np.all(row >= column):
        return sp.csr_array(matrix + matrix.T - sp.diags_array(matrix.diagonal()))
    return matrix

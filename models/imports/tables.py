"""Matrices in files of Matrix Market or MATLAB, with a table of their nodes."""

import csv
import re
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io as sio
import scipy.sparse as sp

from bladewhirl.files import csv_rows, open_text, plain
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.imports.parts import ForeignPart
from bladewhirl.models.superelements.containers import (
    checked_matrix,
    mat_variables,
    read_foreign,
    real_numbers,
    whole_numbers,
)
from bladewhirl.models.superelements.file import KEYS, superelement_of
from bladewhirl.models.superelements.superelement import (
    FIXED,
    Matrix,
    Superelement,
    SuperelementError,
    errors_of,
)

POSITION, ROWS, GROUP = ("x", "y", "z"), ("row_x", "row_y", "row_z"), "group"

MOST_ROWS = 7
"""Largest number of degrees of freedom of a node."""

MOST_IN_TABLE = 10**15
"""Largest number of a node, and largest coordinate."""

NAMES = {
    "mass": ("mass", "M", "MM", "Maa", "Mred"),
    "stiffness": ("stiffness", "K", "KK", "Kaa", "Kred"),
    "damping": ("damping", "D", "C"),
    "gyroscopic": ("gyroscopic", "G"),
    "blade_stiffness": ("blade_stiffness", "KB"),
}
"""Names of matrices in MATLAB files, of which the first that is present is taken."""


def read_matrix_market(stiffness: Path, mass: Path, nodes: Path) -> ForeignPart:
    """Read stiffness and mass from two files of Matrix Market, and the nodes from a table.

    Raises:
        SuperelementError: a file is missing or invalid, or the matrices differ in size.
    """
    matrices = {"stiffness": read_matrix(stiffness), "mass": read_matrix(mass)}
    return _with_nodes(matrices, nodes, f"{stiffness.name} and {mass.name}")


def read_matlab(path: Path, nodes: Path) -> ForeignPart:
    """Read the matrices M and K of a .mat file of NLvib or another program, and a table of nodes.

    The matrices may be fields of a structure. D or C is damping, G the matrix of the Coriolis
    forces at 1 rad/s, and KB the part of the stiffness that the blades have.

    Raises:
        SuperelementError: a file is missing or invalid, or there are no matrices M and K.
    """
    return _with_nodes(_variables(path)[1], nodes, path.name)


def read_matlab_superelement(path: Path) -> Superelement:
    """Read a superelement from a .mat file whose matrices may be named as in `read_matlab`.

    Raises:
        SuperelementError: the file is missing or invalid, or describes no structure.
    """
    variables, matrices = _variables(path)
    content = {key: value for key, value in variables.items() if key in KEYS}
    with errors_of(path):
        return superelement_of(content | matrices)


def _variables(path: Path) -> tuple[dict[str, Any], dict[str, Matrix]]:
    """Return the variables of a .mat file, and its matrices by key with mass and stiffness."""
    content = mat_variables(path, {*KEYS, *chain.from_iterable(NAMES.values())})
    with errors_of(path):
        matrices = dict(_matrices(content))
    missing = {"mass", "stiffness"} - matrices.keys()
    if missing:
        expected = " and ".join(sorted(NAMES[key][1] for key in missing))
        raise SuperelementError(
            f"{path}: expected matrices {expected}, as variables or in a structure"
        )
    return content, matrices


def _matrices(content: dict[str, Any]) -> Iterator[tuple[str, Matrix]]:
    """Yield each matrix with its key: first the fields of structures, so that variables of the same
    key replace them."""
    for value in content.values():
        for one in value.flat if getattr(value, "dtype", None) == np.object_ else ():
            if isinstance(one, sio.matlab.mat_struct):
                yield from _matrices(dict(vars(one)))
    for key, names in NAMES.items():
        given = next((content[name] for name in names if np.ndim(content.get(name, 0)) == 2), None)
        if given is not None:
            yield key, checked_matrix(key, given)


def _with_nodes(matrices: dict[str, Any], table: Path, source: str) -> ForeignPart:
    size = matrices["mass"].shape[0]
    for key, matrix in matrices.items():
        if matrix.shape != (size, size):
            shapes = f"{matrix.shape[0]} x {matrix.shape[1]}, and the mass {size} rows"
            raise SuperelementError(f"{source}: expected matrices of one size; {key} has {shapes}")
    rows = _read_table(table)
    numbers = _column(table, rows, "node", int)
    points = np.array([_column(table, rows, key, float) for key in POSITION]).T
    if len(set(numbers)) < len(numbers):
        twice = next(number for number in numbers if numbers.count(number) > 1)
        raise SuperelementError(
            f"{table}: expected each node at most once; node {twice} occurs again"
        )
    groups: dict[str, list[int]] = {}
    for place, row in enumerate(rows):
        for name in (row.get(GROUP) or "").split():
            groups.setdefault(name, []).append(place)
    return ForeignPart(
        source=source,
        numbers=np.array(numbers, dtype=np.int64),
        points=points,
        dofs=_dofs(table, rows, size),
        groups={name: np.array(places) for name, places in groups.items()},
        **matrices,
    )


def _dofs(table: Path, rows: list[dict[str, str]], size: int) -> IntArray:
    """Return the rows of the x, y and z displacements of each node, (nodes, 3): those in the table,
    or consecutive rows in the order of its nodes."""
    if any(key in rows[0] for key in ROWS):
        columns = [_column(table, rows, key, int, empty=0) for key in ROWS]
        dofs = np.array(columns, dtype=np.int64).T - 1
        if dofs.min() < FIXED or dofs.max() >= size:
            raise SuperelementError(
                f"{table}: expected rows from 1 to {size}, the size of the matrices, or 0 for fixed"
                f" displacements; they go from {dofs.min() + 1} to {dofs.max() + 1}"
            )
        return dofs
    each, rest = divmod(size, len(rows))
    if rest or not 3 <= each <= MOST_ROWS:
        raise SuperelementError(
            f"{table}: expected columns {', '.join(ROWS)}: {size} rows of the matrices are not the"
            f" displacements of {len(rows)} nodes in order"
        )
    return np.asarray(each * np.arange(len(rows))[:, None] + np.arange(3))


def _read_table(path: Path) -> list[dict[str, str]]:
    try:
        head, *lines = [cells for _, cells in csv_rows(path) if cells] or [[]]
        keys = [key.strip().lower() for key in head]
        rows = [dict(zip(keys, cells, strict=False)) for cells in lines]
    except (OSError, ValueError, csv.Error) as error:
        raise SuperelementError(f"{path}: expected a readable CSV file ({error})") from None
    if not rows or not {"node", *POSITION} <= set(rows[0]):
        raise SuperelementError(
            f"{path}: expected a first line node,x,y,z and a line for each node"
        )
    return rows


def _column(
    path: Path, rows: list[dict[str, str]], key: str, kind: type[Any], *, empty: Any = None
) -> list[Any]:
    values = []
    for line, row in enumerate(rows, 2):
        text = (row.get(key) or "").strip()
        try:
            value = empty if not text and empty is not None else kind(plain(text))
            if not abs(value) <= MOST_IN_TABLE:
                raise ValueError
        except (ValueError, OverflowError):
            noun = "a whole number" if kind is int else "a finite number"
            raise SuperelementError(
                f"{path}: line {line}: {key}: expected {noun}, got {text!r}"
            ) from None
        values.append(value)
    return values


MATRIX_MARKET, SYMMETRIES = b"%%MatrixMarket", ("general", "symmetric")


def read_matrix(path: Path) -> sp.csr_array:
    """Read a real matrix from a file of Matrix Market, or of lines of row, column and value.

    Raises:
        SuperelementError: the file is missing, or not a square matrix.
    """
    matrix = read_foreign(path, "a file of Matrix Market", lambda: _market(path))
    with errors_of(path):
        return sp.csr_array(checked_matrix("matrix", matrix))


def _market(path: Path) -> Any:
    """Read a file of Matrix Market, of which scipy reads the head only: its reader of the numbers
    ends the process if the file is shorter than its head says."""
    with path.open("rb") as stream:
        head = stream.read(len(MATRIX_MARKET))
    if head != MATRIX_MARKET:
        return read_triplets(path)
    rows, columns, entries, kind, field, symmetry = sio.mminfo(path)
    if rows != columns or field in ("complex", "pattern") or symmetry not in SYMMETRIES:
        raise SuperelementError(
            f"{path}: expected a square real matrix, general or symmetric, got {rows} x {columns},"
            f" {field}, {symmetry}"
        )
    if max(rows, entries) > path.stat().st_size:
        raise ValueError(f"{rows} rows and {entries} entries in {path.stat().st_size} bytes")
    numbers = _numbers_in(path)
    if kind == "coordinate":
        lines = numbers[3:].reshape(-1, 3)
        if len(lines) != entries:
            raise ValueError(f"{len(lines)} entries in place of {entries}")
        return _of_triplets(path, lines, rows)
    lower = np.triu_indices(rows) if symmetry == "symmetric" else np.indices((rows, rows))
    column, row = np.reshape(lower, (2, -1))  # column by column
    whole = sp.csr_array((numbers[2:], (row, column)), shape=(rows, rows))
    return _completed(whole)


def read_triplets(path: Path, size: int | None = None) -> sp.csr_array:
    """Read a matrix from lines of row, column and value, separated by blanks or commas.

    Rows and columns begin with 1. If only one triangle has entries, they stand for a symmetric
    matrix.

    Args:
        path: path of the file.
        size: number of rows and columns; by default the largest number of a row, which is at most
            the number of bytes of the file.

    Raises:
        SuperelementError: the file is missing, or has lines of another form.
    """
    kind = "lines of row, column and value"
    return _of_triplets(
        path, read_foreign(path, kind, lambda: _numbers_in(path).reshape(-1, 3)), size
    )


def _of_triplets(path: Path, numbers: FloatArray, size: int | None) -> sp.csr_array:
    """Return the matrix of lines of row, column and value, completed to a symmetric one."""
    with errors_of(path):
        row, column = (whole_numbers("rows and columns", numbers[:, n]) - 1 for n in range(2))
        values = real_numbers("values", numbers[:, 2])
    most = int(max(row.max(), column.max())) + 1 if len(values) else 0
    size = min(most, path.stat().st_size) if size is None else size
    if not len(values) or most > size or min(row.min(), column.min()) < 0:
        raise SuperelementError(f"{path}: expected rows and columns from 1 to {size}, got {most}")
    return _completed(sp.csr_array((values, (row, column)), shape=(size, size)))


def _completed(matrix: sp.csr_array) -> sp.csr_array:
    """Return a matrix; if only one triangle has entries, the symmetric matrix of the triangle."""
    row, column = matrix.nonzero()
    if np.all(row <= column) or np.all(row >= column):
        return sp.csr_array(matrix + matrix.T - sp.diags_array(matrix.diagonal()))
    return matrix


def _numbers_in(path: Path) -> FloatArray:
    """Return the numbers of a file without lines that begin with %."""
    with open_text(path) as stream:
        text = re.sub("^[ \t]*%.*$", "", stream.read(), flags=re.MULTILINE)
        return np.array(plain(text).replace(",", " ").split(), dtype=np.float64)

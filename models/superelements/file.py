"""Files of superelements: .npz of NumPy and .mat of MATLAB."""

from collections.abc import Mapping
from difflib import get_close_matches
from os import PathLike
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import scipy.io as sio
import scipy.sparse as sp

from bladewhirl.files import replacing
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.inputs.units import to_si
from bladewhirl.models.superelements.superelement import (
    Matrix,
    Superelement,
    SuperelementError,
    errors_of,
)

MATRICES = ("mass", "stiffness", "damping", "gyroscopic", "recovery")
NUMBERS = ("contact_position", "points")
INTEGERS = ("contact_dofs", "centre_dofs", "triangles", "left_dofs", "right_dofs")
TEXTS = ("name", "source")
UNITS = {"length_unit": "m", "mass_unit": "kg"}
REQUIRED = ("mass", "stiffness", "contact_position", "contact_dofs")


def read_superelement(path: str | PathLike[str]) -> Superelement:
    """Read a superelement from a file.

    The keys of the file are the attributes of `Superelement`. A sparse matrix is stored as
    `NAME_data`, `NAME_indices`, `NAME_indptr` and `NAME_shape` in compressed rows (or columns, if
    `NAME_indptr` has one entry more than there are columns), or as a sparse matrix of MATLAB. With
    `length_unit` and `mass_unit`, such as "mm" and "t" for matrices in N/mm and t, all numbers
    are converted to SI units; the unit of time is the second. Numbers of degrees of freedom begin
    with 0. Other keys are ignored, unless they resemble one of these.

    Args:
        path: path of a .npz or .mat file.

    Raises:
        SuperelementError: the file cannot be read, lacks a key, or does not describe a structure.
    """
    file = Path(path)
    with errors_of(file):
        content = _content(file)
        for key in sorted(set(content) - set(KEYS)):
            if meant := get_close_matches(key, KEYS, 1, 0.8):
                raise SuperelementError(f"{key}: unknown key; did you mean {meant[0]}?")
        return superelement_of(content)


def superelement_of(content: Mapping[str, Any]) -> Superelement:
    """Return a superelement from arrays and texts by name; texts state the units of the arrays.

    Raises:
        SuperelementError: a key is missing or unknown, or the arrays do not describe a structure.
    """
    missing = [key for key in REQUIRED if key not in content and f"{key}_data" not in content]
    if missing:
        raise SuperelementError(f"expected {', '.join(missing)}; a superelement needs them")
    length, mass = (_unit(content, key) for key in UNITS)
    values: dict[str, Any] = {key: _text(content[key]) for key in TEXTS if key in content}
    for key in MATRICES:
        matrix = _matrix(content, key)
        if matrix is not None:
            values[key] = matrix if key == "recovery" else matrix * mass
    for key in NUMBERS:
        if key in content:
            values[key] = length * _numbers(key, content[key])
    for key in INTEGERS:
        if key in content:
            values[key] = _whole(key, content[key])
    for key in ("left_dofs", "right_dofs"):
        if key in values and values[key].size % 3 == 0:
            values[key] = values[key].reshape(-1, 3)
    if "centre_dofs" in values:
        values["centre_dofs"] = values["centre_dofs"].ravel()
    return Superelement(**values)


def write_superelement(path: str | PathLike[str], part: Superelement) -> None:
    """Write a superelement to a .npz file, in SI units; sparse matrices remain sparse.

    Raises:
        SuperelementError: the file name does not end with .npz.
        OSError: the file cannot be written.
    """
    file = Path(path)
    if file.suffix.lower() != ".npz":
        raise SuperelementError(f"{file}: expected a name that ends with .npz")
    content: dict[str, Any] = {}
    for key in (*MATRICES, *NUMBERS, *INTEGERS, *TEXTS):
        value = getattr(part, key)
        if value is None:
            continue
        if sp.issparse(value):
            rows = sp.csr_array(value)
            content[f"{key}_data"], content[f"{key}_shape"] = rows.data, np.array(rows.shape)
            content[f"{key}_indices"], content[f"{key}_indptr"] = rows.indices, rows.indptr
        else:
            content[key] = value
    with replacing(file) as draft, draft.open("wb") as stream:
        np.savez_compressed(stream, **content)


_SPARSE = ("data", "indices", "indptr", "shape")
KEYS = (
    *(*MATRICES, *NUMBERS, *INTEGERS, *TEXTS, *UNITS),
    *(f"{key}_{part}" for key in MATRICES for part in _SPARSE),
)


def _content(file: Path) -> dict[str, Any]:
    """Return the variables of a file by name."""
    try:
        if file.suffix.lower() == ".npz":
            with np.load(file, allow_pickle=False) as archive:
                return {name: archive[name] for name in archive.files}
        if file.suffix.lower() == ".mat":
            read = sio.loadmat(file, appendmat=False)
            return {name: value for name, value in read.items() if not name.startswith("__")}
    except OSError as error:
        raise SuperelementError(f"expected a readable file ({error.strerror or error})") from None
    except (ValueError, BadZipFile, EOFError, KeyError, NotImplementedError, TypeError) as error:
        raise SuperelementError(f"expected a file of NumPy or MATLAB ({error})") from None
    raise SuperelementError("expected a .npz file of NumPy or a .mat file of MATLAB")


def _matrix(content: Mapping[str, Any], key: str) -> Matrix | None:
    """Return a dense or sparse matrix; None if it is not given."""
    if key in content:
        value = content[key]
        if sp.issparse(value):
            return sp.csr_array(value).astype(np.float64)
        return np.atleast_2d(_numbers(key, value))
    if f"{key}_data" not in content:
        return None
    try:
        data, indices, indptr, shape = (np.asarray(content[f"{key}_{part}"]) for part in _SPARSE)
        rows, columns = (int(length) for length in shape.ravel())
        kind = sp.csr_array if len(indptr.ravel()) == rows + 1 else sp.csc_array
        made = kind((data.ravel(), indices.ravel(), indptr.ravel()), shape=(rows, columns))
        made.check_format()
        return sp.csr_array(made).astype(np.float64)
    except KeyError as error:
        raise SuperelementError(f"{error.args[0]}: missing; {key}_data needs it") from None
    except (ValueError, TypeError) as error:
        raise SuperelementError(f"{key}: expected a sparse matrix ({error})") from None


def _numbers(key: str, value: Any) -> np.ndarray[Any, Any]:
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise SuperelementError(f"{key}: expected real numbers") from None


def _whole(key: str, value: Any) -> np.ndarray[Any, Any]:
    given = _numbers(key, value)
    if not np.array_equal(given, np.round(given)):
        raise SuperelementError(f"{key}: expected whole numbers")
    return given.astype(np.int64)


def _text(value: Any) -> str:
    return str(np.ravel(value)[0]) if np.size(value) else ""


def _unit(content: Mapping[str, Any], key: str) -> float:
    """Return a unit of the file in SI units; 1 if the file does not state one."""
    if key not in content:
        return 1.0
    value = np.ravel(content[key])[0] if np.size(content[key]) else ""
    try:
        if isinstance(value, str):
            return to_si(f"1 {value}", UNITS[key])
        factor = float(value)
    except (ValueError, TypeError, CaseError):
        factor = 0.0
    if not (np.isfinite(factor) and factor > 0.0):
        example = '"mm"' if key == "length_unit" else '"t"'
        raise SuperelementError(f"{key}: expected a unit such as {example}, got {str(value)!r}")
    return factor

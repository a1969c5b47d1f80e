"""Files of superelements: .npz of NumPy and .mat of MATLAB."""

from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from bladewhirl.files import replacing
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.inputs.units import to_si
from bladewhirl.models.superelements.containers import (
    checked_matrix,
    mat_variables,
    npz_arrays,
    real_numbers,
    whole_numbers,
)
from bladewhirl.models.superelements.superelement import (
    ARRAYS,
    HUB,
    Matrix,
    Superelement,
    SuperelementError,
    errors_of,
)

MATRICES = (*Superelement.FORMS, *Superelement.ROWS)
SPEED, SECTORS, MASS = "speed", "sectors", "whole_mass"
INTEGERS = (
    *("contact_dofs", "centre_dofs", "hub_dofs", "triangles", "left_dofs", "right_dofs"),
    *("joint_left", "joint_right"),
)
TEXTS = ("name", "source", "command", "mesh_axis", "group_places")
UNITS = {"length_unit": "m", "mass_unit": "kg"}
ROUNDING = 1e-9
"""Largest direction cosine that is a rounding error."""

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
    content = _content(file)
    with errors_of(file):
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
            values[key] = matrix * _scale(key, length, mass)
    for key in ARRAYS:
        if key in content:
            values[key] = _scale(key, length, mass) * real_numbers(key, content[key])
    for key in ("hub_position", "young_modulus", "poisson_ratio", *Superelement.LOADS):
        if key in values:
            values[key] = values[key].ravel()
    if SPEED in content:
        values[SPEED] = _number(content, SPEED)
    if MASS in content:
        values[MASS] = mass * _number(content, MASS)
    if SECTORS in content:
        values[SECTORS] = int(whole_numbers(SECTORS, _number(content, SECTORS)))
    for key in INTEGERS:
        if key in content:
            values[key] = whole_numbers(key, content[key])
    for key in ("left_dofs", "right_dofs"):
        if key in values and values[key].size % 3 == 0:
            values[key] = values[key].reshape(-1, 3)
    for key in ("centre_dofs", "hub_dofs", "joint_left", "joint_right"):
        if key in values:
            values[key] = values[key].ravel()
    part = _with_rotations(Superelement(**values), length)
    if part.speed and part.stiffness_speed is not None:
        raise SuperelementError(
            "speed: expected 0 with stiffness_speed, which needs the stiffness at rest"
        )
    still = np.flatnonzero(abs(part.contact_rows[::3]).sum(axis=1) < ROUNDING)
    if len(still):
        raise SuperelementError(
            f"contact_dofs: expected a radial displacement of each node; node {still[0]} has none"
        )
    return part


def _scale(key: str, length: float, mass: float) -> float:
    """Return the factor to SI units of the numbers under a key, from the units of length [m] and
    mass [kg] of a file."""
    factors = {
        **dict.fromkeys(("recovery", "poisson_ratio"), 1.0),
        **dict.fromkeys(("contact_position", "hub_position", "points"), length),
        "strain_recovery": 1.0 / length,
        "stress_recovery": mass / length**2,
        "young_modulus": mass / length,
        **dict.fromkeys(Superelement.LOADS, mass * length),
    }
    return factors.get(key, mass)


def _with_rotations(part: Superelement, length: float) -> Superelement:
    """Return a superelement with SI units of the rotations of its hub, which have no unit, from one
    in which they have that of length [m]."""
    if part.hub_dofs is None:
        return part
    unit = np.ones(part.size)
    unit[part.hub_dofs[HUB // 2 :]] = length
    turn = sp.diags_array(unit)
    changes: dict[str, Any] = {key: one @ turn for key, one in part.given(MATRICES).items()}
    changes |= {key: turn @ changes[key] for key in part.given(part.FORMS)}
    changes |= {key: unit * load for key, load in part.given(part.LOADS).items()}
    return replace(part, **changes)


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
    for key in (*MATRICES, *ARRAYS, SPEED, SECTORS, MASS, *INTEGERS, *TEXTS):
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
    *(*MATRICES, *ARRAYS, SPEED, SECTORS, MASS, *INTEGERS, *TEXTS, *UNITS),
    *(f"{key}_{part}" for key in MATRICES for part in _SPARSE),
)


def _content(file: Path) -> dict[str, Any]:
    """Return the variables of a file by name; unknown ones are None."""
    readers = {".npz": npz_arrays, ".mat": mat_variables}
    read = readers.get(file.suffix.lower())
    if read is None:
        raise SuperelementError(f"{file}: expected a .npz file of NumPy or a .mat file of MATLAB")
    return read(file, KEYS)


def _matrix(content: Mapping[str, Any], key: str) -> Matrix | None:
    """Return a dense or sparse matrix; None if it is not given."""
    if key in content:
        return checked_matrix(key, content[key])
    if f"{key}_data" not in content:
        return None
    missing = [f"{key}_{part}" for part in _SPARSE if f"{key}_{part}" not in content]
    if missing:
        raise SuperelementError(f"{missing[0]}: missing; {key}_data needs it")
    given, *structure = (np.ravel(content[f"{key}_{part}"]) for part in _SPARSE)
    data = real_numbers(key, given)
    indices, indptr, shape = (
        whole_numbers(f"{key}_{part}", values)
        for part, values in zip(_SPARSE[1:], structure, strict=True)
    )
    try:
        kind = sp.csr_array if len(indptr) == shape[0] + 1 else sp.csc_array
        return checked_matrix(key, kind((data, indices, indptr), shape=tuple(shape.tolist())))
    except (ValueError, TypeError, IndexError) as error:
        raise SuperelementError(f"{key}: expected a sparse matrix ({error})") from None


def _text(value: Any) -> str:
    return str(np.ravel(value)[0]) if np.size(value) else ""


def _number(content: Mapping[str, Any], key: str) -> float:
    values = real_numbers(key, content[key])
    if values.size != 1:
        raise SuperelementError(f"{key}: expected one number")
    return float(values.ravel()[0])


def _unit(content: Mapping[str, Any], key: str) -> float:
    """Return a unit of the file in SI units; 1 if the file does not state one."""
    if key not in content:
        return 1.0
    value = np.ravel(content[key])[0] if np.size(content[key]) else ""
    try:
        if isinstance(value, str):
            return to_si(f"1 {value}", UNITS[key])
        factor = float(real_numbers(key, value))
    except (ValueError, TypeError, CaseError):
        factor = 0.0
    if not (np.isfinite(factor) and factor > 0.0):
        example = '"mm"' if key == "length_unit" else '"t"'
        raise SuperelementError(f"{key}: expected a unit such as {example}, got {str(value)!r}")
    return factor

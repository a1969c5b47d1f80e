"""Calls of the compiled marches: structs of `kernel.h` filled from NumPy arrays."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from bladewhirl.models.inputs.errors import UserError

try:
    from bladewhirl.solvers.kernel._kernel import ffi, lib
except ImportError as error:
    raise UserError(
        f"the compiled march is not there ({error}); in a checkout `pip install -e .` builds it"
    ) from None

_ARRAYS = {
    "Vector": ("double *", np.dtype(np.float64), 1),
    "Matrix": ("double *", np.dtype(np.float64), 2),
    "IntVector": ("int64_t *", np.dtype(np.int64), 1),
    "IntMatrix": ("int64_t *", np.dtype(np.int64), 2),
    "Cube": ("double *", np.dtype(np.float64), 3),
}

_SIZES = {1: ("size",), 2: ("rows", "columns"), 3: ("layers", "rows", "columns")}


class Struct(NamedTuple):
    """A C struct and the arrays that it points to, which must live as long."""

    pointer: Any
    bundle: Any


def struct(bundle: Any, name: str | None = None) -> Struct:
    """C struct of a named tuple, by its class's name or another; ``None`` becomes NULL.

    Raises:
        TypeError: an array of another type or number of axes, or one that is not contiguous.
    """
    if bundle is None:
        return Struct(ffi.NULL, None)
    name = name or type(bundle).__name__
    pointer = ffi.new(f"{name} *")
    _fill(pointer, name, bundle)
    return Struct(pointer, bundle)


@cache
def _fields(name: str) -> list[tuple[str, str]]:
    """Name and type of each field of a struct."""
    return [(field, kind.type.cname) for field, kind in ffi.typeof(name).fields]


def _fill(target: Any, name: str, bundle: Any) -> None:
    for field, kind in _fields(name):
        value = getattr(bundle, field)
        if isinstance(value, np.ndarray):
            _point(getattr(target, field), f"{name}.{field}", *_ARRAYS[kind], value)
        elif isinstance(value, tuple):
            _fill(getattr(target, field), kind, value)
        else:
            setattr(target, field, value)


def _point(
    target: Any, name: str, pointer: str, dtype: np.dtype[Any], axes: int, array: np.ndarray
) -> None:
    """Let a vector or matrix of C point to an array."""
    if array.dtype != dtype or array.ndim != axes or not array.flags.c_contiguous:
        raise TypeError(
            f"{name}: expected {axes} contiguous axes of {dtype}, "
            f"got {array.ndim} of {array.dtype}, strides {array.strides}"
        )
    target.at = ffi.from_buffer(pointer, array)
    for size, length in zip(_SIZES[axes], array.shape, strict=True):
        setattr(target, size, length)


def march(
    stage: tuple[Struct, ...],
    state: Struct,
    records: Struct,
    scratch: Struct,
    step: int,
    steps: int,
    record_every: int,
) -> tuple[int, int, int]:
    """March from ``step`` to ``step + steps`` without Python's lock; see `kernel.h`.

    Args:
        stage: rotor, casing, springs, dampers, gyroscopic forces, wheel speed, numbers.
        state: advanced in place.
        records: get a row at multiples of ``record_every``.
        scratch: working arrays.
        step: n.
        steps: to do.
        record_every: steps between records.

    Returns:
        status (RUNNING or DIVERGED), the step reached, and the number of records written.
    """
    reached = ffi.new("int64_t[2]")
    pointers = [part.pointer for part in (*stage, state, records, scratch)]
    status = lib.march(*pointers, step, steps, record_every, reached)
    return status, reached[0], reached[1]


def number(value: float | None) -> Struct:
    """Pointer to a number; NULL for None."""
    return Struct(ffi.NULL if value is None else ffi.new("double *", value), value)


def dense_march(
    stage: Struct,
    law: Struct,
    state: Struct,
    scratch: Struct,
    time_step: float,
    first: int,
    steps: int,
) -> int:
    """Do steps of a dense scheme from the first on; see `kernel.h`. Return the number done."""
    pointers = [part.pointer for part in (stage, law, state, scratch)]
    return int(lib.dense_march(*pointers, time_step, first, steps))

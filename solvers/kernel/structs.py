"""Structs of `kernel.h` that refer to NumPy arrays, and calls of the compiled functions."""

import re
from functools import cache
from importlib import resources
from math import prod
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.errors import UserError

try:
    from bladewhirl.solvers.kernel._kernel import ffi
    from bladewhirl.solvers.kernel._kernel import lib as lib
except ImportError as error:
    raise UserError(
        f"the compiled march is missing ({error}); in a checkout `pip install -e .` builds it"
    ) from None

_ARRAYS = {
    "Vector": ("double *", np.dtype(np.float64), ("size",)),
    "Matrix": ("double *", np.dtype(np.float64), ("rows", "columns")),
    "Cube": ("double *", np.dtype(np.float64), ("layers", "rows", "columns")),
    "IntVector": ("int64_t *", np.dtype(np.int64), ("size",)),
    "IntMatrix": ("int64_t *", np.dtype(np.int64), ("rows", "columns")),
}

CACHE_LINE = 64
"""Size of a cache line [bytes]."""

Arrays = dict[str, Any]
"""Arrays of a struct by name; the arrays of a nested struct are a nested dictionary."""


@cache
def _fields(name: str) -> dict[str, tuple[str, list[str]]]:
    """Return the type of each field of a struct in `kernel.h`, and the shape of each array."""
    header = resources.files(__package__).joinpath("kernel.h").read_text(encoding="utf-8")
    content = header[: header.index(f"\n}} {name};")].rpartition("typedef struct {")[2]
    fields = re.findall(r"^ {4}(\w+) (\w+);(?: +/\* \(([\w, ]+)\))?", content, re.MULTILINE)
    return {field: (kind, shape.split(", ")) for kind, field, shape in fields}


def zeros(struct: str, sizes: dict[str, int]) -> Arrays:
    """Return arrays of zeros for all arrays of a struct.

    Args:
        struct: name of the struct.
        sizes: lengths by their names in `kernel.h`.
    """
    arrays: Arrays = {}
    for field, (kind, shape) in _fields(struct).items():
        if kind in _ARRAYS:
            lengths = tuple(int(name) if name.isdigit() else sizes[name] for name in shape)
            arrays[field] = aligned(lengths, _ARRAYS[kind][1])
        elif kind[0].isupper():
            arrays[field] = zeros(kind, sizes)
    return arrays


class Struct:
    """A C struct, with the arrays to which it points as attributes.

    Args:
        name: name of the struct.
        fields: all fields: arrays, numbers and nested structs.

    Raises:
        TypeError: a field is missing or unknown, or the type or shape of an array differs from
            `kernel.h`.
    """

    def __init__(self, name: str, /, **fields: Any) -> None:
        expected = _fields(name)
        if fields.keys() != expected.keys():
            raise TypeError(f"{name}: expected the fields {', '.join(expected)}")
        self.name, self.pointer = name, ffi.new(f"{name} *")
        sizes: dict[str, int] = {}
        for field, value in fields.items():
            kind, shape = expected[field]
            if kind in _ARRAYS:
                array = getattr(self.pointer, field)
                _point(array, f"{name}.{field}", _ARRAYS[kind], shape, value, sizes)
            elif isinstance(value, dict):
                fields[field] = value = Struct(kind, **value)
                setattr(self.pointer, field, value.pointer[0])
            else:
                setattr(self.pointer, field, value.pointer[0] if kind[0].isupper() else value)
            if isinstance(value, Struct):
                value.pointer = ffi.addressof(self.pointer, field)  # the copy that is read
        self.contents = fields  #: arrays, numbers and nested structs by name

    def __getattr__(self, name: str) -> Any:
        """Return a field: an array, a number or a nested struct."""
        return self.contents[name]

    def point_to(self, field: str, array: np.ndarray[Any, Any]) -> None:
        """Let a field point to another array of the same shape."""
        kind, shape = _fields(self.name)[field]
        target = getattr(self.pointer, field)
        _point(target, f"{self.name}.{field}", _ARRAYS[kind], shape, array, {})
        self.contents[field] = array


def _point(
    target: Any,
    name: str,
    kind: tuple[str, np.dtype[Any], tuple[str, ...]],
    shape: list[str],
    array: np.ndarray[Any, Any],
    sizes: dict[str, int],
) -> None:
    """Let a C vector or matrix point to an array; check lengths that other arrays share."""
    pointer, dtype, lengths = kind
    named = {
        axis: int(axis) if axis.isdigit() else sizes.setdefault(axis, length)
        for axis, length in zip(shape, array.shape, strict=False)
        if array.size
    }
    fits = array.ndim == len(shape) and (
        array.size == 0 or array.shape == tuple(named[axis] for axis in shape)
    )
    if array.dtype != dtype or not array.flags.c_contiguous or not fits:
        raise TypeError(
            f"{name}: expected contiguous {dtype} ({', '.join(shape)}) with {sizes}, "
            f"got {array.dtype} {array.shape}, strides {array.strides}"
        )
    target.at = ffi.from_buffer(pointer, array)
    for length, value in zip(lengths, array.shape, strict=True):
        setattr(target, length, value)


def padded(size: int, unit: int = lib.LANES) -> int:
    """Return the smallest multiple of a unit that is not below a size."""
    return -(-size // unit) * unit


def aligned(shape: int | tuple[int, ...], dtype: Any = np.float64) -> np.ndarray[Any, Any]:
    """Return an array of zeros that starts on a cache line."""
    count = prod(shape) if isinstance(shape, tuple) else shape
    raw = np.zeros(count + CACHE_LINE // 8 - 1, dtype)
    first = -(raw.ctypes.data // 8) % (CACHE_LINE // 8)
    return raw[first : first + count].reshape(shape)


def aligned_copy(values: np.ndarray[Any, Any]) -> FloatArray:
    """Return a copy that starts on a cache line."""
    out = aligned(values.shape, values.dtype)
    out[...] = values
    return out


def working_array(stage: dict[str, Struct | None], state: Struct) -> FloatArray:
    """Return the array for the working arrays of a march, which every call overwrites.

    Args:
        stage: fields of the struct `Stage`; None for options that the march does not have.
        state: state.
    """
    return aligned(lib.scratch_size(_stage(stage), state.pointer))


def _stage(parts: dict[str, Struct | None]) -> Any:
    return ffi.new("Stage *", {name: part.pointer for name, part in parts.items() if part})


def march(
    stage: dict[str, Struct | None],
    state: Struct,
    records: Struct,
    scratch: FloatArray,
    step: int,
    steps: int,
    record_every: int,
) -> tuple[int, int, int]:
    """Advance a march from ``step`` to ``step + steps``, without the interpreter lock of Python.

    Args:
        stage: fields of the struct `Stage`; None for options that the march does not have.
        state: state, which is advanced in place.
        records: arrays that get a row at multiples of ``record_every``.
        scratch: what `working_array` returns.
        step: number of the first step.
        steps: number of steps to do.
        record_every: number of steps between records.

    Returns:
        status (RUNNING or DIVERGED), the number of the last step, and the number of records.
    """
    reached = ffi.new("int64_t[2]")
    arena = {"at": ffi.from_buffer("double *", scratch), "size": scratch.size}
    status = lib.march(
        _stage(stage), state.pointer, records.pointer, arena, step, steps, record_every, reached
    )
    return status, reached[0], reached[1]

"""Types of arrays that xarray knows, asked of libraries that are loaded only.

xarray loads `dask.array` and `pint` at its first Dataset, to tell their arrays from NumPy's: half a
second and more for arrays that nobody can have before these libraries are loaded. It keeps the
types in a table; what is put there looks at what is loaded each time it is asked. An xarray
without that module or table costs time, not an error.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

PYCOMPAT = "xarray.namedarray.pycompat"
"""xarray's module with the table, not part of its public interface."""

ARRAYS = {"dask": ("dask.array", "Array"), "pint": ("pint", "Quantity")}
"""Module and class of the arrays of each library."""


class ArraysOnceLoaded:
    """Stands for a library in xarray's table.

    Args:
        library: key of `ARRAYS`.
    """

    def __init__(self, library: str) -> None:
        self._library = library

    @property
    def type(self) -> tuple[type, ...]:
        """The class of its arrays; none before it is loaded."""
        module, name = ARRAYS[self._library]
        found = getattr(sys.modules.get(module), name, None)
        return () if found is None else (found,)

    def __getattr__(self, name: str) -> Any:
        """The rest as xarray knows it, for which the library is loaded."""
        known: Any = import_module(PYCOMPAT)
        return getattr(known.DuckArrayModule(self._library), name)


def ask_loaded_only() -> None:
    """Have xarray ask libraries that are loaded."""
    try:
        table: dict[Any, Any] = getattr(import_module(PYCOMPAT), "_cached_duck_array_modules", {})
    except ImportError:
        return
    for library in ARRAYS:
        table.setdefault(library, ArraysOnceLoaded(library))

"""How the march is compiled, and what tells numba's cache that it has to be compiled anew."""

from __future__ import annotations

import hashlib
from pathlib import Path
from types import ModuleType
from typing import Any

from numpy.typing import NDArray

Array = NDArray[Any]

FAST = {"reassoc", "contract", "nsz", "arcp"}  # NaN and infinity keep their meaning
COMPILE = {
    "nogil": True, "fastmath": FAST, "error_model": "numpy", "no_cfunc_wrapper": True,
    "no_cpython_wrapper": True,
}  # fmt: skip
"""Options of what compiled code alone calls."""

ENTRY = COMPILE | {"cache": True, "no_cpython_wrapper": False}
"""Options of what Python calls: only that needs, and compiles, what unpacks arguments."""


def digest(*modules: ModuleType) -> int:
    """Number that changes with the source of any of the modules.

    numba's cache looks at the file of the function that it stores and at the variables which that
    function takes from an enclosing one, not at the files of what it calls. Such a variable that
    holds this number lets it notice a change in any of them.
    """
    sources = hashlib.sha256()
    for module in modules:
        sources.update(Path(str(module.__file__)).read_bytes())
    return int.from_bytes(sources.digest()[:7], "big")

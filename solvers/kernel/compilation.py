"""How the march is compiled, and what tells numba's cache that it has to be compiled anew."""

from __future__ import annotations

import hashlib
from pathlib import Path
from types import ModuleType
from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numpy.typing import NDArray

Array = NDArray[Any]


class _Part(JITCodeLibrary):
    """Code that runs only as part of what calls it.

    numba optimises each function and makes machine code of it, then links it into what calls it,
    optimises that and makes machine code again; the first takes a third of the time that the march
    needs to be compiled. A part stays as it was written until it is linked.
    """

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout  # as every module that is linked needs

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Null: there is no machine code."""
        return 0

    @property
    def codegen(self) -> _Part:
        """What numba tells about the environment, see `set_env`."""
        return self

    def set_env(self, name: str, environment: object) -> None:
        """Nothing: what a Python exception or object would need is never used here."""


class _PartCompiler(CompilerBase):
    """numba's own passes, into a `_Part`."""

    def define_pipelines(self) -> list[Any]:
        """Passes of the one attempt that is made."""
        state = self.state
        state.library = _Part(state.targetctx.codegen(), state.func_id.func_qualname)
        return [DefaultPassBuilder.define_nopython_pipeline(state)]


FAST = {"reassoc", "contract", "nsz", "arcp"}  # NaN and infinity keep their meaning
_COMMON = {"nogil": True, "fastmath": FAST, "error_model": "numpy", "no_cfunc_wrapper": True}

COMPILE = _COMMON | {"no_cpython_wrapper": True, "pipeline_class": _PartCompiler}
"""Options of what compiled code alone calls."""

ENTRY = _COMMON | {"cache": True}
"""Options of what Python calls."""


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

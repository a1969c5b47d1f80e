"""How the march is compiled: the one module that reaches into numba's compiler.

Tried with numba 0.68.1; pyproject.toml bounds it above, since what is used here is not
part of numba's interface: `JITCodeLibrary`, which collects the code of a function, and
`CompilerBase`, which lists the passes that make it. The reason is speed. By itself numba optimises
each function, makes machine code of it, links it into what calls it, optimises that and makes
machine code again, which takes a third of the time that the march needs to be compiled; and it
keeps each function callable from outside, so that bundles of arrays are handed on whole, array by
array. Here functions stay as they were written until the march is linked, and are private to it
then: the compiler drops arguments that are not used and has them inlined where they serve once.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from llvmlite.binding import Linkage
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numpy.typing import NDArray

Array = NDArray[Any]


class _Library(JITCodeLibrary):
    """Code without an optimisation of its functions one by one."""

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout  # as every module that is linked needs


class _Part(_Library):
    """Code that runs only as part of what calls it."""

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


class _Apart(_Part):
    """A part that is not inlined."""

    def _optimize_functions(self, ll_module: Any) -> None:
        super()._optimize_functions(ll_module)
        for function in ll_module.functions:
            if not function.is_declaration:
                function.add_function_attribute("noinline")


class _Whole(_Library):
    """Code that Python calls, with all its parts."""

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.linkonce_odr:
                function.linkage = Linkage.internal
        super()._optimize_final_module()


def _compiler(kind: type[_Library]) -> type[CompilerBase]:
    """numba's own passes, into a library of that kind."""

    class Compiler(CompilerBase):
        """numba's passes for compiled code without Python objects."""

        def define_pipelines(self) -> list[Any]:
            """Passes of the one attempt that is made."""
            state = self.state
            state.library = kind(state.targetctx.codegen(), state.func_id.func_qualname)
            if kind is _Whole:
                state.library.enable_object_caching()
            return [DefaultPassBuilder.define_nopython_pipeline(state)]

    return Compiler


FAST = {"reassoc", "contract", "nsz", "arcp"}  # NaN and infinity keep their meaning
_COMMON = {"nogil": True, "fastmath": FAST, "error_model": "numpy", "no_cfunc_wrapper": True}

COMPILE = _COMMON | {"no_cpython_wrapper": True, "pipeline_class": _compiler(_Part)}
"""Options of what compiled code alone calls."""

APART = COMPILE | {"pipeline_class": _compiler(_Apart)}
"""The same, not inlined: what is seldom or long, or must round alike wherever it is called.

With everything inlined, the march becomes one function that takes twice the time to compile.
"""

ENTRY = _COMMON | {"cache": True, "pipeline_class": _compiler(_Whole)}
"""Options of what Python calls."""


def digest(folder: Path) -> int:
    """Number that changes with any module of a folder.

    numba's cache looks at the file of the function that it stores and at the variables which that
    function takes from an enclosing one, not at the files of what it calls. Such a variable that
    holds this number lets it notice a change in any of them.
    """
    sources = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        sources.update(path.read_bytes())
    return int.from_bytes(sources.digest()[:7], "big")

"""The compiled march's cache: numba itself looks at one file of several."""

from importlib import import_module
from pathlib import Path
from types import ModuleType

from numba import njit

from bladewhirl.solvers.kernel import compilation as compiled
from bladewhirl.solvers.kernel import step as kernel
from bladewhirl.solvers.kernel.compilation import COMPILE, ENTRY, digest

SOLVERS = Path(kernel.__file__).parent


def module(path: Path, source: str) -> ModuleType:
    """A module of that source."""
    path.write_text(source)
    made = ModuleType(path.stem)
    made.__file__ = str(path)
    return made


def test_a_digest_changes_with_any_of_its_sources(tmp_path: Path) -> None:
    first, second = module(tmp_path / "a.py", "x = 1\n"), module(tmp_path / "b.py", "y = 1\n")
    before = digest(first, second)
    assert digest(first, second) == before
    Path(str(second.__file__)).write_text("y = 2\n")
    assert digest(first, second) != before


def test_the_cache_is_told_of_every_module_that_the_march_compiles() -> None:
    others = {path.stem for path in SOLVERS.glob("*.py")} - {"__init__", "step", "compilation"}
    names = ["compilation", *sorted(others)]
    sources = digest(*(import_module(f"bladewhirl.solvers.kernel.{name}") for name in names))
    (cell,) = kernel.advance.py_func.__closure__  # type: ignore[attr-defined]
    assert cell.cell_contents == sources
    assert compiled.ENTRY["cache"] is True


def test_a_part_is_made_into_machine_code_only_with_what_calls_it() -> None:
    @njit(**COMPILE)  # type: ignore[untyped-decorator]
    def part(x: float) -> float:
        return 3.0 * x

    @njit(**ENTRY | {"cache": False})  # type: ignore[untyped-decorator]
    def entry(x: float) -> float:
        return part(x) + part(2.0 * x)  # type: ignore[no-any-return]

    assert entry(1.5) == 13.5
    (made,) = part.overloads.values()
    assert made.library.get_pointer_to_function(made.fndesc.llvm_func_name) == 0
    (made,) = entry.overloads.values()
    assert made.library.get_pointer_to_function(made.fndesc.llvm_func_name) != 0

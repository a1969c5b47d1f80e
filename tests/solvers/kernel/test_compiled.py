"""The compiled march's cache: numba itself looks at one file of several."""

from pathlib import Path

from numba import njit

from bladewhirl.solvers.kernel import step
from bladewhirl.solvers.kernel.compilation import APART, COMPILE, ENTRY, digest

KERNEL = Path(step.__file__).parent


def test_a_digest_changes_with_any_module_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text("x = 1\n")
    (tmp_path / "b.py").write_text("y = 1\n")
    before = digest(tmp_path)
    assert digest(tmp_path) == before
    (tmp_path / "b.py").write_text("y = 2\n")
    changed = digest(tmp_path)
    assert changed != before
    (tmp_path / "c.py").write_text("z = 1\n")
    assert digest(tmp_path) not in (before, changed)


def test_the_cache_is_told_of_every_module_that_the_march_compiles() -> None:
    (cell,) = step.advance.py_func.__closure__  # type: ignore[attr-defined]
    assert cell.cell_contents == digest(KERNEL)
    assert ENTRY["cache"] is True


def test_a_part_is_made_into_machine_code_only_with_what_calls_it() -> None:
    @njit(**COMPILE)  # type: ignore[untyped-decorator]
    def part(x: float) -> float:
        return 3.0 * x

    @njit(**APART)  # type: ignore[untyped-decorator]
    def apart(x: float) -> float:
        return 2.0 * x

    @njit(**ENTRY | {"cache": False})  # type: ignore[untyped-decorator]
    def entry(x: float) -> float:
        return part(x) + apart(2.0 * x)  # type: ignore[no-any-return]

    assert entry(1.5) == 10.5
    for inner in (part, apart):
        (made,) = inner.overloads.values()
        assert made.library.get_pointer_to_function(made.fndesc.llvm_func_name) == 0
    (made,) = entry.overloads.values()
    assert made.library.get_pointer_to_function(made.fndesc.llvm_func_name) != 0
    whole = made.library.get_llvm_str()
    assert "apart" in whole.split("define", 1)[1]

"""Score of tests against small faults: `python tests/support/mutants.py MODULE... --count 30`.

Each mutant is a module with one comparison, sign, operator, number or condition changed, drawn
from all that there are by a seed. It is killed when one of the tests fails: those of the module's
folder, its own first, unless others are given. What is loaded beside the program is loaded once.
"""

import argparse
import ast
import contextlib
import copy
import importlib.machinery
import multiprocessing
import os
import random
import signal
import sys
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import h5py  # noqa: F401 - loaded before the fork, as are those below
import pytest
import scipy.linalg
import scipy.sparse.linalg  # noqa: F401
import skfem  # noqa: F401
import xarray  # noqa: F401

SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Lt: ast.GtE,
    ast.GtE: ast.Lt,
    ast.Gt: ast.LtE,
    ast.LtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.And: ast.Or,
    ast.Or: ast.And,
    ast.USub: ast.UAdd,
}
"""What an operator becomes."""

ASIDE = (ast.Raise, ast.Assert, ast.JoinedStr, ast.Import, ast.ImportFrom)
"""Words, and what is there for readers and types."""


def places(tree: ast.AST) -> Iterator[tuple[ast.AST, str, int | None]]:
    """Nodes that can be changed, with the field, and its position in a list."""
    for name, value in ast.iter_fields(tree):
        if name in {"annotation", "returns", "decorator_list"}:
            continue
        for at, node in enumerate(value) if isinstance(value, list) else [(None, value)]:
            if not isinstance(node, ast.AST) or isinstance(node, ASIDE):
                continue
            number = isinstance(node, ast.Constant) and isinstance(node.value, bool | int | float)
            if type(node) in SWAPS or number:
                yield tree, name, at
            yield from places(node)


def mutant(source: str, number: int) -> tuple[ast.Module, str]:
    """The module with its place of that number changed, and the change in words."""
    tree = ast.parse(source)
    parent, name, at = list(places(tree))[number]
    value: Any = getattr(parent, name)
    old = value if at is None else value[at]
    new: ast.AST = SWAPS[type(old)]() if type(old) in SWAPS else copy.copy(old)
    if isinstance(new, ast.Constant):
        given: Any = new.value
        new.value = not given if isinstance(given, bool) else given + 1
    where = parent if hasattr(parent, "lineno") else old
    before = ast.unparse(where)
    if at is None:
        setattr(parent, name, new)
    else:
        value[at] = new
    after = ast.unparse(where if where is parent else new)
    return ast.fix_missing_locations(tree), f"{getattr(where, 'lineno', 0)}: {before} -> {after}"


class FirstFault:
    """For pytest: hypothesis stops at the first example that fails, and seeks no smaller one."""

    def pytest_configure(self) -> None:
        """After the profile of the tests is loaded."""
        import hypothesis  # pytest has to load it first

        kinds = [hypothesis.Phase.explicit, hypothesis.Phase.generate]
        hypothesis.settings.register_profile("mutants", phases=kinds)
        hypothesis.settings.load_profile("mutants")


def outcome(module: Path, tree: ast.Module, tests: list[str], seconds: int) -> bool:
    """Whether the tests pass, in a process of their own, with the module replaced."""
    get_code = importlib.machinery.SourceFileLoader.get_code

    def replaced(self: Any, fullname: str) -> Any:
        path = Path(self.get_filename(fullname))
        return compile(tree, path, "exec") if path.samefile(module) else get_code(self, fullname)

    def run_tests() -> None:
        os.setsid()
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 1)
            os.dup2(nowhere.fileno(), 2)
        importlib.machinery.SourceFileLoader.get_code = replaced  # type: ignore[method-assign]
        options = ["-x", "-q", "-p", "no:cacheprovider"]
        sys.exit(int(pytest.main([*options, *tests], plugins=[FirstFault()])))

    child = multiprocessing.get_context("fork").Process(target=run_tests)
    child.start()
    child.join(seconds)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child.pid or 0, signal.SIGKILL)
    child.join()
    return child.exitcode == 0


def tests_of(module: Path) -> list[str]:
    """The test file of a module, if it has one, and the tests of its folder."""
    beside = "tests" / module.parent
    room = next(path for path in (beside, *beside.parents) if path.exists())
    own = beside / f"test_{module.name}"
    return [str(path) for path in (own, room) if path.exists()]


@cache
def seconds_unchanged(*tests: str) -> float:
    """How long the tests take without any change."""
    began, here = time.monotonic(), Path(__file__)  # they don't import this module
    if not outcome(here, ast.parse(here.read_text()), [*tests], 600):
        raise SystemExit(f"{' '.join(tests)}: tests fail without any change")
    return time.monotonic() - began


def score(modules: list[Path], tests: list[str], count: int, seed: int, minutes: float) -> None:
    """Try mutants; print those that survive, and the score of each module.

    Args:
        modules: paths of the modules.
        tests: paths of their tests; `tests_of` each module if empty.
        count: largest number of mutants of a module.
        seed: of the draws of modules and mutants.
        minutes: time after which no further mutant is begun; modules without any are not printed.
    """
    chance, end = random.Random(seed), time.monotonic() + 60.0 * minutes
    tried_all = killed_all = 0
    for at, module in enumerate(chance.sample(modules, len(modules))):
        source, given = module.read_text(), tests or tests_of(module)
        known = len(list(places(ast.parse(source))))
        latest = time.monotonic() + (end - time.monotonic()) / (len(modules) - at)
        tried = killed = 0
        for number in chance.sample(range(known), min(count, known)):
            if time.monotonic() > latest:
                break
            seconds = 10 + int(5 * seconds_unchanged(*(tests or given[-1:])))
            tree, words = mutant(source, number)
            survives = outcome(module, tree, given, seconds)
            tried, killed = tried + 1, killed + (not survives)
            if survives:
                print(f"{module}:{words}", flush=True)
        if tried:
            print(f"{module}: {killed} of {tried} killed, of {known} places", flush=True)
        tried_all, killed_all = tried_all + tried, killed_all + killed
    print(f"{killed_all} of {tried_all} killed in all")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Score of tests against small faults.")
    parser.add_argument("modules", nargs="*", type=Path, metavar="module")
    parser.add_argument("--tests", nargs="+", default=[], help="of the modules; else by folder")
    parser.add_argument("--count", type=int, default=30, help="largest number for each module")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=1e6, help="time for all modules")
    given = parser.parse_args()
    score(given.modules, given.tests, given.count, given.seed, given.minutes)

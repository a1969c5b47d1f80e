"""Score of tests against small faults: `python tests/support/mutants.py MODULE TEST... --count 30`.

Each mutant is the module with one comparison, sign, operator, number or condition changed, drawn
from all that there are by a seed. It is killed when one of the tests fails. What is
loaded beside the program is loaded once.
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


def score(module: Path, tests: list[str], count: int, seed: int) -> tuple[int, int]:
    """Mutants tried and killed; those that survive are printed."""
    source = module.read_text()
    began = time.monotonic()
    if not outcome(module, ast.parse(source), tests, 600):
        raise SystemExit(f"{module}: its tests fail without any change")
    seconds = 10 + int(5 * (time.monotonic() - began))
    known = len(list(places(ast.parse(source))))
    chosen = sorted(random.Random(seed).sample(range(known), min(count, known)))
    killed = 0
    for number in chosen:
        tree, words = mutant(source, number)
        survives = outcome(module, tree, tests, seconds)
        killed += not survives
        if survives:
            print(f"{module}:{words}", flush=True)
    print(f"{module}: {killed} of {len(chosen)} killed, of {known} places", flush=True)
    return len(chosen), killed


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Score of tests against small faults.")
    parser.add_argument("module", type=Path)
    parser.add_argument("tests", nargs="+")
    parser.add_argument("--count", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    tried, killed = score(given.module, given.tests, given.count, given.seed)
    sys.exit(killed < 0.85 * tried)

"""Whatever is typed or read ends in an answer or a sentence: see `support/fuzz.py`.

The slow test tries `FUZZ_INPUTS` of each of the five kinds, from number `FUZZ_FIRST` on.
"""

from __future__ import annotations

import os

import pytest
from small_run import run_script


def findings(kind: str, count: int, first: int = 0) -> str:
    """What went wrong with some inputs of a kind; empty if nothing did."""
    tried = run_script("fuzz.py", kind, "--first", str(first), "--count", str(count))
    return "" if tried.returncode == 0 else tried.stdout + tried.stderr


@pytest.mark.parametrize("kind", ["case", "mesh"])
def test_a_few_inputs_that_nobody_means(kind: str) -> None:
    assert not findings(kind, 2)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["case", "mesh", "result", "sweep", "options"])
def test_hundreds_of_inputs_that_nobody_means(kind: str) -> None:
    count, first = (int(os.environ.get(f"FUZZ_{n}", d)) for n, d in (("INPUTS", 100), ("FIRST", 0)))
    assert not findings(kind, count, first)

"""Whatever is typed or read ends in an answer or a sentence: see `support/fuzz.py`.

A night's work: `python tests/support/fuzz.py KIND --count 2000` for each of the five kinds.
"""

from __future__ import annotations

import pytest
from small_run import run_script


def findings(kind: str, count: int) -> str:
    """What went wrong with the first inputs of a kind; empty if nothing did."""
    tried = run_script("fuzz.py", kind, "--count", str(count))
    return "" if tried.returncode == 0 else tried.stdout + tried.stderr


@pytest.mark.parametrize("kind", ["case", "mesh"])
def test_a_few_inputs_that_nobody_means(kind: str) -> None:
    assert not findings(kind, 15)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["case", "mesh", "result", "sweep", "options"])
def test_hundreds_of_inputs_that_nobody_means(kind: str) -> None:
    assert not findings(kind, 100)

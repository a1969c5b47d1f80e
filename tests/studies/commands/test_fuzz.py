"""Inputs without meaning end in an answer or a message, see `support/fuzz.py`.

The test tries `FUZZ_INPUTS` of each of the five kinds, from number `FUZZ_FIRST` on.
"""

import os

import pytest
from small_run import run_script


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["case", "mesh", "result", "sweep", "options"])
def test_inputs_without_meaning(kind: str) -> None:
    count, first = (os.environ.get(f"FUZZ_{n}", d) for n, d in (("INPUTS", "100"), ("FIRST", "0")))
    done = run_script("fuzz.py", kind, "--first", first, "--count", count)
    assert done.returncode == 0, done.stdout + done.stderr

"""Inputs without meaning end in an answer or a message, see `support/fuzz.py`.

The tests try `FUZZ_INPUTS` of each kind, from number `FUZZ_FIRST` on; of decks of solids 500.
"""

import os

import pytest
from small_run import run_script


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "number"),
    [
        *((kind, "100") for kind in ("case", "mesh", "result", "sweep", "options")),
        *((kind, "500") for kind in ("inp", "msh", "vtu", "calculix", "matrices")),
    ],
)
def test_inputs_without_meaning(kind: str, number: str) -> None:
    count, first = (os.environ.get(f"FUZZ_{n}", d) for n, d in (("INPUTS", number), ("FIRST", "0")))
    done = run_script("fuzz.py", kind, "--first", first, "--count", count)
    assert done.returncode == 0, done.stdout + done.stderr

"""Linear algebra uses one thread after `import bladewhirl`, whatever was imported before."""

import os
import subprocess
import sys

import pytest

from bladewhirl.threads import VARIABLES

CODE = """
import {first}
import {second}
import scipy.linalg, threadpoolctl
import numpy
counts = {{pool["num_threads"] for pool in threadpoolctl.threadpool_info()}}
print(*counts)
"""


@pytest.mark.parametrize("given", [{}, {"OPENBLAS_NUM_THREADS": "2", "MKL_NUM_THREADS": "2"}])
@pytest.mark.parametrize(
    "modules",
    [
        pytest.param(("numpy", "bladewhirl"), marks=pytest.mark.slow),
        ("bladewhirl", "numpy"),
    ],
)
def test_linear_algebra_uses_one_thread(modules: tuple[str, str], given: dict[str, str]) -> None:
    unset = {*VARIABLES, "OMP_NUM_THREADS"}
    bare = {name: value for name, value in os.environ.items() if name not in unset}
    done = subprocess.run(
        [sys.executable, "-c", CODE.format(first=modules[0], second=modules[1])],
        env=bare | given,
        capture_output=True,
        text=True,
        check=True,
    )
    expected = str(min(2, os.cpu_count() or 1)) if given else "1"
    assert done.stdout.split() == [expected]

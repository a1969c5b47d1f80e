"""Number of threads of linear algebra.

The matrices are small, and sweeps march on all cores: more than one thread makes a response some
forty times slower.
"""

import os
import sys

VARIABLES = (
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
"""Environment variables from which libraries of linear algebra take their number of threads."""


def use_one_thread() -> None:
    """Let linear algebra use one thread, also in libraries that are already loaded and in processes
    started later, unless the environment sets a number."""
    if os.environ.keys() & {*VARIABLES, "OMP_NUM_THREADS"}:
        return
    os.environ.update(dict.fromkeys(VARIABLES, "1"))
    if "numpy" in sys.modules:
        import threadpoolctl  # type: ignore[import-untyped]  # ships no type information

        threadpoolctl.threadpool_limits(limits=1, user_api="blas")

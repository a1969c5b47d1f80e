"""Sparse factorisation for large superelements: choice of the solver, cost, and progress."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec

import scipy.sparse as sp
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.machine import memory
from bladewhirl.models.superelements.superelement import SuperelementError

logger = logging.getLogger(__name__)

LARGE = 20_000
"""Number of coordinates from which the cost of a reduction is reported."""

FILL, BYTES = 15.0, 24.0
"""Number of entries of the triangular factor of a solid with n coordinates, divided by n^(4/3)
(measured for blades of 6,000 to 87,000 coordinates); and bytes per entry, for both factors."""

FACTOR_SECONDS, SOLVE_SECONDS = 3e-9, 2.5e-9
"""Time of a factorisation divided by n^2, and time of a solution divided by the number of entries
of the factor [s]; accurate to a factor of three."""

Progress = Callable[[int, int], None]
"""Callback; its arguments are the number of finished solutions and the number of all solutions."""


@dataclass
class _Watch:
    update: Progress
    total: int = 1
    done: int = 0


_watch: ContextVar[_Watch | None] = ContextVar("watch", default=None)


@contextmanager
def reduction_progress(update: Progress) -> Iterator[None]:
    """Call `update` after each solution of a large reduction inside this context."""
    token = _watch.set(_Watch(update))
    try:
        yield
    finally:
        _watch.reset(token)


def announce(coordinates: int, modes: int, loads: int) -> None:
    """Log the cost of a large reduction before it starts.

    Args:
        coordinates: number of coordinates.
        modes: number of modes.
        loads: number of static solutions.

    Raises:
        SuperelementError: the reduction needs more memory than this computer has.
    """
    solves, entries = 3 * modes + 20 + loads, FILL * coordinates ** (4.0 / 3.0)
    if (watch := _watch.get()) is not None:
        watch.total, watch.done = solves, 0
    needed = BYTES * entries + 8.0 * coordinates * (3 * modes + 2 * loads)
    time = FACTOR_SECONDS * coordinates**2 + SOLVE_SECONDS * entries * solves
    cost = f"{needed / 1e9:.2g} GB of memory"
    if needed > (most := memory()):
        raise SuperelementError(
            f"expected a smaller superelement: {coordinates} coordinates take about {cost}, and"
            f" this computer has {most / 1e9:.3g} GB"
        )
    if coordinates >= LARGE:
        logger.warning(
            "Large superelement: %s coordinates take about %s and some %.2g s.",
            *(coordinates, cost, time),
        )


def factorised(matrix: sp.csc_array) -> Callable[[FloatArray], FloatArray]:
    """Return a function that solves linear systems with a sparse symmetric matrix.

    Pardiso is used if it is installed (`pip install pypardiso`), otherwise SuperLU of SciPy.
    """
    solve: Callable[[FloatArray], FloatArray]
    if find_spec("pypardiso") is None:
        symmetric = {"SymmetricMode": True}
        solve = spla.splu(matrix, permc_spec="MMD_AT_PLUS_A", options=symmetric).solve
    else:
        solver, rows = import_module("pypardiso").PyPardisoSolver(), sp.csr_matrix(matrix)
        solver.factorize(rows)
        solve = lambda right: solver.solve(rows, right)  # noqa: E731

    def counted(right: FloatArray) -> FloatArray:
        if (watch := _watch.get()) is not None:
            watch.done = min(watch.done + 1, watch.total)
            watch.update(watch.done, watch.total)
        return solve(right)

    return counted

"""Natural frequencies of structures with large sparse matrices."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from scipy.linalg import eigh

from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.hub import hub_freed
from bladewhirl.models.superelements.nodal_blocks import wheel_blocks
from bladewhirl.models.superelements.superelement import (
    Matrix,
    Superelement,
    SuperelementError,
    diagonal,
)

SMALL = 600
"""Largest number of unknowns for which all eigenvalues are computed."""

FURTHER = 10  #: number of modes of a wheel besides those of its blades

MASSLESS = 1e-14
"""An inverse eigenvalue up to this fraction of the largest one belongs to a motion without
mass."""

SHIFT = 1e-11
"""Eigenvalues are shifted by this fraction of the largest one, so that the stiffness of a structure
with rigid modes is positive definite."""


def lowest_frequencies(mass: Matrix, stiffness: Matrix, count: int) -> np.ndarray[Any, Any]:
    """Return the lowest natural frequencies [Hz], (count,) or fewer, in ascending order.

    Matrices may be complex and Hermitian. If a squared frequency is negative, the frequency is
    negative, minus the root of its magnitude.

    Args:
        mass: mass [kg], (n, n), positive semidefinite.
        stiffness: stiffness [N/m], (n, n), positive semidefinite.
        count: number of frequencies.
    """
    n = mass.shape[0]
    massive = diagonal(mass).real > 0.0
    largest = np.max(diagonal(stiffness).real[massive] / diagonal(mass).real[massive])
    shift = SHIFT * float(largest)
    if n <= SMALL or count >= n - 1:
        squares = _all_eigenvalues(_full(mass), _full(stiffness), shift)[:count]
    else:
        shifted = spl.splu(sp.csc_array(stiffness + shift * mass), **SYMMETRIC_ORDER)
        inverse = spl.LinearOperator((n, n), shifted.solve, dtype=stiffness.dtype)
        start = np.array(np.random.default_rng(0).standard_normal(n), dtype=stiffness.dtype)
        squares = np.sort(
            spl.eigsh(
                *(sp.csc_array(stiffness), count, sp.csc_array(mass)),
                sigma=-shift,
                OPinv=inverse,
                v0=start,
                return_eigenvectors=False,
            )
        )
    return np.asarray(np.sign(squares) * np.sqrt(abs(squares)) / (2.0 * np.pi))


def frequencies_by_diameter(
    part: Superelement, count: int, diameters: Iterable[int]
) -> Iterator[np.ndarray[Any, Any]]:
    """Yield the lowest natural frequencies at rest [Hz], (count,), of the wheel of a sector for
    each nodal diameter; once those of a part that is no sector. A hub is held.

    Raises:
        SuperelementError: the sector does not say how many of them a wheel has.
    """
    part = hub_freed(part)
    if part.left_dofs is None:
        yield lowest_frequencies(part.mass, part.stiffness, min(count, part.size))
        return
    if part.sectors is None:
        raise SuperelementError(
            f"{part.name}: expected sectors, the number of sectors of the wheel"
        )
    for k in diameters:
        if 2 * k <= part.sectors:
            tie = transformation(part, part.sectors, k)
            own = part.projected(tie, ("mass", "stiffness"))
            yield lowest_frequencies(**own, count=min(count, tie.shape[1]))


def frequencies_of_wheel(part: Superelement) -> list[np.ndarray[Any, Any]]:
    """Return the lowest natural frequencies at rest [Hz] of a wheel in one piece for each nodal
    diameter from 0, as many as about two modes of each blade contain; empty if its blades are not
    known or differ, and for a wheel on springs.
    """
    part, blades = hub_freed(part), part.sectors or 1
    if part.left_dofs is not None or part.centre_dofs is not None or blades == 1:
        return []
    blocks = wheel_blocks(part, (0.0, 0.0), blades, 2 * blades + FURTHER)
    if [*blocks] != [*range(blades // 2 + 1)]:
        return []
    squares = [np.linalg.eigvalsh(block.stiffness) for block in blocks.values()]
    return [np.sign(each) * np.sqrt(abs(each)) / (2.0 * np.pi) for each in squares]


def _all_eigenvalues(mass: Any, stiffness: Any, shift: float) -> Any:
    """Return the finite eigenvalues; for coordinates without mass there are none."""
    try:
        return eigh(stiffness, mass, eigvals_only=True)
    except np.linalg.LinAlgError:  # the mass is singular
        inverse = eigh(mass, stiffness + shift * mass, eigvals_only=True)[::-1]
        finite = inverse[inverse > MASSLESS * inverse[0]]
        return 1.0 / finite - shift


SYMMETRIC_ORDER: dict[str, Any] = {
    "permc_spec": "MMD_AT_PLUS_A",
    "diag_pivot_thresh": 0.0,
    "options": {"SymmetricMode": True},
}
"""Options of SuperLU for symmetric matrices."""


def _full(matrix: Any) -> Any:
    return matrix.toarray() if sp.issparse(matrix) else matrix

"""Checks of a superelement before it is used: signs of its matrices, rigid modes, frequencies."""

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.plausible import fault_of
from bladewhirl.models.superelements.frequencies import SYMMETRIC_ORDER, lowest_frequencies
from bladewhirl.models.superelements.hub import NEEDED, check_hub, rigid_motions
from bladewhirl.models.superelements.superelement import (
    Matrix,
    Superelement,
    SuperelementError,
    diagonal,
)

MODES = 10
"""Number of elastic frequencies."""

RIGID = 1e-6
"""A mode is rigid if its frequency is below this fraction of the largest frequency of a
coordinate."""

NEGATIVE = 1e-7
"""An eigenvalue of a matrix scaled to a diagonal of ones is negative if below minus this number."""

LIGHTEST = 10.0
"""Smallest plausible mass divided by the volume of the convex hull of a part [kg/m3]."""

LOWEST, USUAL, HIGHEST = 1.0, 500.0, 50e3
"""Lowest plausible, usual and highest plausible first elastic frequency [Hz]."""

SLIPS = (
    (1e6, "the density is in t/mm3 beside lengths in m"),
    (1e3, "Young's modulus is in Pa beside lengths in mm and a density in t/mm3"),
    (math.sqrt(1e3), "the mass is in t beside a stiffness in N/m, or the density in g/cm3"),
    (math.sqrt(1e-3), "the stiffness is in N/mm beside a mass in kg"),
    (math.sqrt(1e-9), "Young's modulus is in GPa beside lengths in m"),
    (1e-3, "lengths are in mm beside Young's modulus in Pa and a density in kg/m3"),
    (1e-6, "the density is in kg/m3 beside lengths in mm and Young's modulus in MPa"),
)
"""Factors on frequencies due to inconsistent units, and their causes."""


@dataclass(frozen=True)
class Inspection:
    """Properties of a superelement."""

    frequencies: FloatArray  #: lowest elastic frequencies [Hz], without rigid modes
    rigid_modes: int  #: number of rigid modes
    hints: tuple[str, ...] = ()  #: warnings


def inspect(part: Superelement) -> Inspection:
    """Return frequencies and rigid modes of a superelement, and check its matrices.

    A sector is inspected with free faces. The matrices of a wheel with a hub are compared with
    those of a rigid body, see `hub`.

    Raises:
        SuperelementError: mass or stiffness is indefinite, the first frequency is implausible, or a
            wheel does not move rigidly with its hub.
    """
    for key in ("mass", "stiffness", "damping"):
        matrix = getattr(part, key)
        negative = 0 if matrix is None else negative_eigenvalues(matrix)
        if negative:
            hint = "; is the sign of some entries wrong, or a triangle of the matrix missing?"
            values = f"has {negative} negative eigenvalue{'s' if negative > 1 else ''}"
            raise SuperelementError(
                f"{key}: expected no negative eigenvalues, but it {values}{hint}"
            )
    count = min(MODES + 6, part.size)
    frequencies = lowest_frequencies(part.mass, part.stiffness, count)
    positive = diagonal(part.mass) > 0.0
    squares = diagonal(part.stiffness)[positive] / diagonal(part.mass)[positive]
    rigid = abs(frequencies) < RIGID * math.sqrt(float(squares.max())) / (2.0 * math.pi)
    elastic = frequencies[~rigid]
    if len(elastic) and elastic[0] < 0.0:
        raise SuperelementError(
            "stiffness: expected a stable structure; a mode has the imaginary frequency"
            f" {-elastic[0]:.4g}i Hz, as at speeds at which spin softening exceeds the stiffness"
        )
    if len(elastic):
        _check_units(float(elastic[0]))
    hints: tuple[str, ...] = ()
    if part.hub_dofs is not None:
        check_hub(part, rigid_motions(part))
        missing = [key for key in NEEDED if getattr(part, key) is None]
        if missing:
            text = "a wheel that turns with a shaft line needs them"
            hints = (f"{' and '.join(missing)} missing: {text}",)
    return Inspection(elastic[:MODES], int(np.count_nonzero(rigid)), hints)


def mass_hints(part: Superelement, mass: float) -> Iterator[str]:
    """Yield a warning if a mass [kg] is too small for the convex hull of the points of a part."""
    from scipy.spatial import ConvexHull, QhullError  # long to load

    with suppress(QhullError, ValueError):
        density = mass / ConvexHull(part.points).volume
        if expected := fault_of(density, LIGHTEST, math.inf, "kg/m3"):
            yield f"unusual mass = {mass:.4g} kg in the hull of the nodes: expected {expected}"


def negative_eigenvalues(matrix: Matrix) -> int:
    """Return the number of significantly negative eigenvalues of a symmetric matrix.

    They are counted in the factors of the matrix, scaled to a diagonal of ones, by Sylvester's law
    of inertia. Rows of zeros do not count.
    """
    scale = diagonal(matrix)
    rows = np.flatnonzero(scale > 0.0)
    if not len(rows):
        return 0
    factor = sp.diags_array(1.0 / np.sqrt(scale[rows]))
    scaled = factor @ sp.csr_array(matrix)[rows][:, rows] @ factor
    shifted = sp.csc_array(scaled + NEGATIVE * sp.eye_array(len(rows)))
    try:
        factors: Any = spl.splu(shifted, **SYMMETRIC_ORDER)
    except RuntimeError:  # a pivot is zero, which no positive definite matrix has
        return 1
    swapped = bool(np.any(factors.perm_r != factors.perm_c))
    pivots = factors.U.diagonal()
    return max(int(np.count_nonzero(pivots < 0.0)), int(swapped))


def _check_units(first: float) -> None:
    if LOWEST <= first <= HIGHEST:
        return
    likely = [
        (abs(math.log(first / ratio / USUAL)), text)
        for ratio, text in SLIPS
        if LOWEST <= first / ratio <= HIGHEST and (ratio > 1.0) == (first > HIGHEST)
    ]
    reason = f"; perhaps {min(likely)[1]}" if likely else ""
    raise SuperelementError(
        f"expected a first frequency from {LOWEST:g} Hz to {HIGHEST / 1e3:g} kHz, got"
        f" {first:.4g} Hz{reason}"
    )

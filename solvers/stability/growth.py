"""Growth rates and spectra of the coupled rotor and casing (Section 3.3.1, Fig. 12).

If all modes of a nodal diameter are cosine/sine pairs, complex coordinates z = y_c + i y_s =
X exp(i mu t) give an eigenvalue problem of half the size of Eq. (21); see
`CoupledEquations.whirl_matrix`. The eigenvalues of the real system are then i mu and their
complex conjugates. Without damping the growth is exactly zero if all mu are real. Nodal diameters
with a single mode (k = 0, N/2), and modes with several nodal diameters, are solved in real
coordinates.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from bladewhirl.meshes.line_mesh import BoolArray, ComplexArray, FloatArray
from bladewhirl.models.coupling.equations import CoupledEquations, companion
from bladewhirl.models.coupling.springs import CouplingModes
from bladewhirl.models.inputs.machine import cores

UNSTABLE_GROWTH = 1e-6
"""A point is unstable if its growth rate exceeds this fraction of the speed of rotation."""

REAL = 1e-6
"""A speed counts as real if its imaginary part is at most this fraction of its modulus."""

CHUNK, CHUNK_NUMBERS = 4096, 1 << 20
"""Largest number of points in one batch, and of matrix entries in one batch."""

Progress = Callable[[int, int], None]  #: called with the numbers of completed and of all points


def is_unstable(growth: ArrayLike, speed: ArrayLike) -> BoolArray:
    """Return a mask of growth rates [1/s] above `UNSTABLE_GROWTH` times the speed [rad/s]."""
    limit = UNSTABLE_GROWTH * np.abs(np.asarray(speed))
    return np.asarray(np.asarray(growth) > limit, dtype=np.bool_)


def eigenvalues(
    modes: CouplingModes | CoupledEquations, *, speed: ArrayLike, kappa: ArrayLike
) -> ComplexArray:
    """Return the eigenvalues of the autonomous coupled system, one nodal diameter after another.

    Args:
        modes: the coupled modes.
        speed: Omega [rad/s].
        kappa: spring stiffness [N/m]; broadcasts with speed to the shape (...).

    Returns:
        eigenvalues [1/s], (..., 2 * modes.size). Motions are proportional to exp(eigenvalue t); Eq.
        (21) has the opposite sign.
    """
    parts = []
    for block in modes.blocks:
        spectrum = _spectrum(block, speed, kappa)
        parts += [spectrum, spectrum.conj()] if block.pairs else [spectrum]
    return np.concatenate(parts, axis=-1)


def growth_rate(
    modes: CouplingModes | CoupledEquations,
    *,
    speed: ArrayLike,
    kappa: ArrayLike,
    progress: Progress | None = None,
) -> FloatArray:
    """Return the largest real part of the spectrum [1/s] on any grid of speeds and stiffnesses.

    Args:
        modes: the coupled modes.
        speed: Omega [rad/s].
        kappa: spring stiffness [N/m]; broadcasts with speed to the shape (...).
        progress: called after each batch of points.

    Returns:
        growth rates, (...); negative if every motion decays.
    """
    speed, kappa = np.broadcast_arrays(np.asarray(speed, np.float64), np.asarray(kappa, np.float64))
    largest_size = max(2 * block.structure.size for block in modes.blocks)
    chunks = max(1, speed.size // max(1, min(CHUNK, CHUNK_NUMBERS // largest_size**2)))
    speeds, kappas = np.array_split(speed.ravel(), chunks), np.array_split(kappa.ravel(), chunks)
    growth: list[FloatArray] = []

    def largest(some_speeds: FloatArray, some_kappas: FloatArray) -> FloatArray:
        spectra = [_spectrum(block, some_speeds, some_kappas) for block in modes.blocks]
        return np.asarray(np.max([s.real.max(axis=-1) for s in spectra], axis=0))

    # Batched eigenvalues release the interpreter's lock, so threads use every core.
    with ThreadPoolExecutor(cores()) as pool:
        done = 0
        for values in pool.map(largest, speeds, kappas):
            growth.append(values)
            done += values.size
            if progress is not None:
                progress(done, speed.size)
    return np.concatenate(growth).reshape(speed.shape) + 0.0  # no negative zeros


def track(parameter: FloatArray, values: ComplexArray) -> ComplexArray:
    """Reorder spectra along a line of parameters so that each column is one continuous branch.

    The branches are extrapolated linearly to the next parameter, and the eigenvalues there are
    assigned to the branches with the least sum of squared distances. Branches that cross therefore
    keep their direction. Beyond a point at which two branches coincide, the order of the two is
    arbitrary.

    Args:
        parameter: position along the line, strictly monotonic, (m,).
        values: spectra in any order, (m, n).

    Returns:
        the reordered rows of `values`, (m, n); the first row keeps its order.
    """
    branches = np.array(values)
    for i in range(1, len(branches)):
        expected = branches[i - 1]
        if i > 1:
            share = (parameter[i] - parameter[i - 1]) / (parameter[i - 1] - parameter[i - 2])
            expected = expected + share * (branches[i - 1] - branches[i - 2])
        distance = np.abs(expected[:, None] - branches[i][None, :]) ** 2
        branches[i] = branches[i][linear_sum_assignment(distance)[1]]
    return branches


def coincidence_speeds(modes: CouplingModes) -> dict[tuple[int, int], float]:
    """Return the speeds of modal coincidence of counter-rotating waves, Eq. (14) [rad/s].

    With the frequency nu = omega_casing - k Omega, the waves of the rotor are the solutions of a
    quadratic eigenvalue problem in Omega. Without rotation effects its solution is
    Omega = (omega_casing + omega_rotor) / k.

    Returns:
        for each (casing entry, rotor entry) with the same k > 0, the lowest speed at which the
        backward wave of the rotor entry meets the wave of the casing entry. Pairs that never meet
        are left out.
    """
    lowest: dict[tuple[int, int], float] = {}
    for casing in np.flatnonzero(modes.on_casing & (modes.nodal_diameter > 0)).tolist():
        k, frequency = int(modes.nodal_diameter[casing]), float(modes.frequency[casing])
        rotor = np.flatnonzero(~modes.on_casing & (modes.nodal_diameter == k))
        part = replace(modes.take(rotor), damping_ratio=np.zeros(len(rotor)))
        turning, softening = map(part.over_entries, (part.gyroscopic, part.stiffness_speed))
        rank = np.argsort(np.argsort(part.frequency, kind="stable"), kind="stable")
        identity, unit = np.eye(len(rotor)), float(modes.frequency.max())
        second = softening - k**2 * identity - 1j * k * turning
        first = np.asarray(frequency * (2.0 * k * identity + 1j * turning))
        zeroth = np.diag(part.frequency**2 - frequency**2).astype(np.complex128)
        speeds = unit * la.eigvals(
            companion(-zeroth / unit**2, -first / unit), la.block_diag(identity, second)
        )
        real = np.abs(speeds.imag) <= REAL * np.abs(speeds)
        for speed in np.sort(speeds.real[real & (k * speeds.real > frequency)]).tolist():
            waves = np.sort(rotor_waves(part, speed).real)
            behind = len(rotor) - 1 - int(np.abs(waves - (frequency - k * speed)).argmin())
            if behind >= 0:  # the wave travels backward at rest
                met = rotor[np.flatnonzero(rank == behind)[0]]
                lowest.setdefault((casing, int(met)), speed)
    return dict(sorted(lowest.items()))


def rotor_waves(rotor: CouplingModes, speed: float) -> ComplexArray:
    """Return frequencies nu of the waves exp(i nu t) of the rotor alone, positive forward [rad/s].

    Args:
        rotor: coupled modes of the rotor with one nodal diameter, in rotating axes.
        speed: Omega [rad/s].

    Returns:
        the frequencies, (2 * entries,).
    """
    structure = rotor.equations.structure
    stiffness = rotor.over_entries(structure.stiffness_at(speed))
    drag = rotor.over_entries(structure.drag(speed))
    matrix = companion(stiffness, 1j * drag, float(rotor.frequency.max()))
    return np.asarray(np.linalg.eigvals(matrix), dtype=np.complex128)


def _spectrum(block: CoupledEquations, speed: ArrayLike, kappa: ArrayLike) -> ComplexArray:
    """Return the eigenvalues of coupled modes [1/s]; for pairs only i mu, without conjugates."""
    if block.pairs:
        return np.asarray(1j * np.linalg.eigvals(block.whirl_matrix(speed, kappa)))
    state = block.state_matrix(speed, kappa)
    return np.asarray(np.linalg.eigvals(state), dtype=np.complex128)

"""Growth of the coupled rotor and casing: spectra, growth rates, stability charts (Section 3.3.1).

In the frame of `bladewhirl.models.coupling.invariant_frame` a nodal diameter that holds pairs only
obeys, with z = q_c + i q_s and nu = mu + r Omega for motions z = X exp(i mu t),

    (diag(omega^2 - nu^2) + i D diag(nu) + f kappa a a^T) X = 0,

which is a linear eigenvalue problem of half the size of Eq. (21), real without damping:

    mu (X, nu X) = [[-r Omega, 1], [K, -r Omega + i D]] (X, nu X).

The spectrum of the real system is i mu and its conjugates. Nodal diameters that hold a single mode
(k = 0, N/2) are solved in real coordinates. Without damping the growth is exactly zero where all
mu are real.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import BoolArray, ComplexArray, FloatArray
from bladewhirl.models.coupling.invariant_frame import state_matrix
from bladewhirl.models.coupling.springs import CouplingModes, spring_factor

UNSTABLE_GROWTH = 1e-6
"""A point is unstable when its growth rate exceeds this share of the rotational speed."""

CHUNK = 4096
"""Points solved in one batch: some megabytes, and a step of the progress bar."""

Progress = Callable[[int, int], None]  #: called with the points done and the points in all


def is_unstable(growth: ArrayLike, speed: ArrayLike) -> BoolArray:
    """Whether growth [1/s] exceeds `UNSTABLE_GROWTH` times the speed [rad/s]."""
    limit = UNSTABLE_GROWTH * np.abs(np.asarray(speed))
    return np.asarray(np.asarray(growth) > limit, dtype=np.bool_)


def eigenvalues(
    modes: CouplingModes, *, speed: ArrayLike, kappa: ArrayLike, with_pi: bool = True
) -> ComplexArray:
    """Spectrum of the coupled system in the invariant frame, nodal diameter by nodal diameter.

    Args:
        modes: the coupled modes.
        speed: Omega [rad/s].
        kappa: spring stiffness [N/m]; broadcasts with speed to the shape (...).
        with_pi: keep the factor pi of Eq. (8).

    Returns:
        (..., 2 modes.size) [1/s]; motions go as exp(eigenvalue t), opposite to Eq. (21).
    """
    speed, kappa = np.broadcast_arrays(np.asarray(speed, np.float64), np.asarray(kappa, np.float64))
    parts = []
    for k in modes.harmonics:
        harmonic = modes.harmonic(k)
        spectrum = _spectrum(harmonic, speed, kappa, with_pi)
        parts.append(spectrum)
        if np.all(harmonic.paired):
            parts.append(spectrum.conj())
    return np.concatenate(parts, axis=-1)


def growth_rate(
    modes: CouplingModes,
    *,
    speed: ArrayLike,
    kappa: ArrayLike,
    with_pi: bool = True,
    progress: Progress | None = None,
) -> FloatArray:
    """Largest real part of the spectrum [1/s], over any grid of speeds and stiffnesses.

    Args:
        modes: the coupled modes.
        speed: Omega [rad/s].
        kappa: spring stiffness [N/m]; broadcasts with speed to the shape (...).
        with_pi: keep the factor pi of Eq. (8).
        progress: called as points are done.

    Returns:
        (...); negative where every motion decays.
    """
    speed, kappa = np.broadcast_arrays(np.asarray(speed, np.float64), np.asarray(kappa, np.float64))
    parts = [modes.harmonic(k) for k in modes.harmonics]
    speeds = np.array_split(speed.ravel(), max(1, speed.size // CHUNK))
    kappas = np.array_split(kappa.ravel(), max(1, kappa.size // CHUNK))
    growth: list[FloatArray] = []

    def largest(some_speeds: FloatArray, some_kappas: FloatArray) -> FloatArray:
        spectra = [_spectrum(part, some_speeds, some_kappas, with_pi) for part in parts]
        return np.asarray(np.max([s.real.max(axis=-1) for s in spectra], axis=0))

    # Batched eigenvalues release the interpreter's lock, so threads use every core.
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        done = 0
        for values in pool.map(largest, speeds, kappas):
            growth.append(values)
            done += values.size
            if progress is not None:
                progress(done, speed.size)
    return np.concatenate(growth).reshape(speed.shape) + 0.0  # no negative zeros


def coincidence_speeds(modes: CouplingModes) -> dict[tuple[int, int], float]:
    """Speeds of modal coincidence, Eq. (14), of counter-rotating waves, in rad/s.

    Returns:
        Omega = (omega_casing + omega_rotor) / k for each (casing entry, rotor entry) of one k > 0.
    """
    k = modes.nodal_diameter
    return {
        (int(c), int(r)): float((modes.frequency[c] + modes.frequency[r]) / k[c])
        for c in np.flatnonzero(modes.on_casing & (k > 0))
        for r in np.flatnonzero(~modes.on_casing & (k == k[c]))
    }


def whirl_matrix(
    modes: CouplingModes, speed: FloatArray, kappa: FloatArray, *, with_pi: bool
) -> FloatArray | ComplexArray:
    """Matrix of half size with eigenvalues mu, for pairs of one nodal diameter (see the module).

    Returns:
        (..., 2 entries, 2 entries) [rad/s after scaling], real without damping.
    """
    n, damping = modes.entries, modes.damping_rate
    # nu X is divided by a typical frequency, so that both halves have the same unit and size.
    unit = float(np.max(modes.frequency)) or 1.0
    matrix = np.zeros(
        (*speed.shape, 2 * n, 2 * n), dtype=np.complex128 if damping.any() else np.float64
    )
    first, second = np.arange(n), np.arange(n, 2 * n)
    turning = np.multiply.outer(speed, modes.frame_rate)
    springs = spring_factor(int(modes.nodal_diameter[0]), with_pi=with_pi) * kappa
    matrix[..., n:, :n] = springs[..., None, None] * np.outer(modes.amplitude, modes.amplitude)
    matrix[..., second, first] += modes.frequency**2
    matrix[..., n:, :n] /= unit
    matrix[..., first, second] = unit
    matrix[..., first, first] = -turning
    matrix[..., second, second] = -turning + (1j * damping if damping.any() else 0.0)
    return matrix


def _spectrum(
    modes: CouplingModes, speed: FloatArray, kappa: FloatArray, with_pi: bool
) -> ComplexArray:
    """Spectrum of one nodal diameter [1/s]: the half i mu where it holds pairs only, or all."""
    if np.all(modes.paired):
        return np.asarray(
            1j * np.linalg.eigvals(whirl_matrix(modes, speed, kappa, with_pi=with_pi))
        )
    state = state_matrix(modes, speed=speed, kappa=kappa, with_pi=with_pi)
    return np.asarray(np.linalg.eigvals(state), dtype=np.complex128)

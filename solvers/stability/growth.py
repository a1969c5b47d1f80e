"""Growth of the coupled rotor and casing: spectra, growth rates, stability charts (Section 3.3.1).

In the frame of `bladewhirl.models.coupling.invariant_frame` a nodal diameter that holds pairs only
obeys, with z = q_c + i q_s and nu = mu + r Omega for motions z = X exp(i mu t),

    (diag(omega^2 - nu^2) + i D diag(nu) + f kappa a a^T) X = 0,

which is a linear eigenvalue problem of half the size of Eq. (21), real without damping:

    mu (X, nu X) = [[-r Omega, 1], [K, -r Omega + i D]] (X, nu X).

With rotation effects Omega^2 S joins the stiffness and 2 i Omega G diag(nu) the damping, so

    mu (X, nu X) = [[-r Omega, 1], [K + Omega^2 S, -r Omega + i D + 2 i Omega G]] (X, nu X),

real without damping where the bladed disk is its own mirror image.

The spectrum of the real system is i mu and its conjugates. Nodal diameters that hold a single mode
(k = 0, N/2) are solved in real coordinates. Without damping the growth is exactly zero where all
mu are real.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import BoolArray, ComplexArray, FloatArray
from bladewhirl.models.coupling.invariant_frame import state_matrix
from bladewhirl.models.coupling.springs import CouplingModes, spring_factor
from bladewhirl.models.coupling.turning_rotor import TurningRotor

UNSTABLE_GROWTH = 1e-6
"""A point is unstable when its growth rate exceeds this share of the rotational speed."""

REAL = 1e-6
"""Share of a speed up to which an imaginary part is rounding."""

CHUNK = 4096
"""Points solved in one batch: some megabytes, and a step of the progress bar."""

Progress = Callable[[int, int], None]  #: called with the points done and the points in all


def is_unstable(growth: ArrayLike, speed: ArrayLike) -> BoolArray:
    """Return whether growth [1/s] exceeds `UNSTABLE_GROWTH` times the speed [rad/s]."""
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
        Omega = (omega_casing + omega_rotor) / k for each (casing entry, rotor entry) of one k > 0;
        with rotation effects those of `coincidence_speeds_at_speed`.
    """
    if modes.turning is not None:
        return coincidence_speeds_at_speed(modes, modes.turning)
    k = modes.nodal_diameter
    return {
        (int(c), int(r)): float((modes.frequency[c] + modes.frequency[r]) / k[c])
        for c in np.flatnonzero(modes.on_casing & (k > 0))
        for r in np.flatnonzero(~modes.on_casing & (k == k[c]))
    }


def coincidence_speeds_at_speed(
    modes: CouplingModes, turning: TurningRotor
) -> dict[tuple[int, int], float]:
    """Lowest speed at which each backward wave has k Omega - omega_casing [rad/s].

    With nu = omega_casing - k Omega put in, waves of a turning rotor are a quadratic eigenvalue
    problem in Omega. A wave that is left out never meets the casing's.
    """
    lowest: dict[tuple[int, int], float] = {}
    for casing in np.flatnonzero(modes.on_casing & (modes.nodal_diameter > 0)).tolist():
        k, frequency = int(modes.nodal_diameter[casing]), float(modes.frequency[casing])
        rotor = np.flatnonzero(~modes.on_casing & (modes.nodal_diameter == k))
        part = turning.take(rotor)
        rank = np.argsort(np.argsort(modes.frequency[rotor], kind="stable"), kind="stable")
        identity, square = np.eye(len(rotor)), modes.frequency[rotor] ** 2
        second = part.softening - k**2 * identity - 2j * k * part.coriolis
        first = 2.0 * frequency * (k * identity + 1j * part.coriolis)
        zeroth = np.diag(square) - frequency**2 * identity
        unit = float(modes.frequency.max())
        companion = np.block(
            [[np.zeros_like(second), identity], [-zeroth / unit**2, -first / unit]]
        )
        speeds = la.eigvals(companion, la.block_diag(identity, second)) * unit
        real = np.abs(speeds.imag) <= REAL * np.abs(speeds)
        for speed in np.sort(speeds.real[real & (k * speeds.real > frequency)]).tolist():
            waves = np.sort(rotor_waves(part, modes.frequency[rotor], speed).real)
            behind = len(rotor) - 1 - int(np.abs(waves - (frequency - k * speed)).argmin())
            if behind >= 0:  # it travels backward at rest
                met = rotor[np.flatnonzero(rank == behind)[0]]
                lowest.setdefault((casing, int(met)), speed)
    return dict(sorted(lowest.items()))


def rotor_waves(
    turning: TurningRotor,
    frequency: FloatArray,
    speed: float,
    damping: FloatArray | None = None,
) -> ComplexArray:
    """Return all nu of waves exp(i nu t) of the rotor without casing, positive forward [rad/s], (2
    entries,).

    Args:
        turning: matrices over its entries, of one nodal diameter.
        frequency: of the entries at rest [rad/s], (entries,).
        speed: Omega [rad/s].
        damping: 2 xi omega of the entries [1/s], (entries,); none when None.
    """
    unit, size = float(frequency.max()), len(frequency)
    stiffness = np.diag(frequency**2) + speed**2 * turning.softening
    drag = 2.0 * speed * turning.coriolis + np.diag(np.zeros(size) if damping is None else damping)
    below = np.hstack([stiffness / unit, 1j * drag])
    above = np.hstack([np.zeros((size, size)), unit * np.eye(size)])
    return np.asarray(np.linalg.eigvals(np.vstack([above, below])), dtype=np.complex128)


def whirl_matrix(
    modes: CouplingModes, speed: FloatArray, kappa: FloatArray, *, with_pi: bool
) -> FloatArray | ComplexArray:
    """Return a matrix of half size with eigenvalues mu, for pairs of one nodal diameter.

    Returns:
        (..., 2 entries, 2 entries) [rad/s after scaling], real without damping, but for a rotor
        that turns and is not its own mirror image.
    """
    n, damping, rotor = modes.entries, modes.damping_rate, modes.turning
    # nu X is divided by a typical frequency, so that both halves have the same unit and size.
    unit = float(np.max(modes.frequency)) or 1.0
    is_complex = damping.any() or (rotor is not None and not rotor.mirrored)
    matrix = np.zeros(
        (*speed.shape, 2 * n, 2 * n), dtype=np.complex128 if is_complex else np.float64
    )
    first, second = np.arange(n), np.arange(n, 2 * n)
    turning = np.multiply.outer(speed, modes.frame_rate)
    springs = spring_factor(int(modes.nodal_diameter[0]), with_pi=with_pi) * kappa
    matrix[..., n:, :n] = springs[..., None, None] * np.outer(modes.amplitude, modes.amplitude)
    matrix[..., second, first] += modes.frequency**2
    if rotor is not None:
        square = (speed**2)[..., None, None]
        matrix[..., n:, :n] += square * (rotor.softening if is_complex else rotor.softening.real)
        twice = 2j * speed[..., None, None] * rotor.coriolis
        matrix[..., n:, n:] = twice if is_complex else twice.real
    matrix[..., n:, :n] /= unit
    matrix[..., first, second] = unit
    matrix[..., first, first] = -turning
    matrix[..., second, second] += -turning + (1j * damping if damping.any() else 0.0)
    return matrix


def _spectrum(
    modes: CouplingModes, speed: FloatArray, kappa: FloatArray, with_pi: bool
) -> ComplexArray:
    """Return the spectrum of one nodal diameter [1/s]: one half, i mu, if it has pairs only."""
    if np.all(modes.paired):
        return np.asarray(
            1j * np.linalg.eigvals(whirl_matrix(modes, speed, kappa, with_pi=with_pi))
        )
    state = state_matrix(modes, speed=speed, kappa=kappa, with_pi=with_pi)
    return np.asarray(np.linalg.eigvals(state), dtype=np.complex128)

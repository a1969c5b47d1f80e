"""The frame in which the coupled rotor and casing are autonomous: Eqs (15)-(21).

The change of variable u = P(t) q of Eq. (16) turns the coordinates of entry i by r_i Omega t, with
r = k/2 on the casing and -k/2 on the rotor, and makes the system autonomous. A single mode (k = 0,
or k = N/2 on the rotor) cannot be turned; where there is one, its body keeps r = 0 and the other
body's pairs take the whole k.

We differ from the printed Eq. (18), whose gyroscopic block of q5, q6 has the opposite sign of the
others when derived from Eq. (16), and add modal damping. Coordinates q stand in the order of u,
where Eq. (16) numbers its pairs backwards.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.coupling.springs import CouplingModes, spring_factor


def frame_matrices(
    modes: CouplingModes, *, speed: float, time: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Matrix P(t) of the change of variable u = P q, Eq. (16), and its time derivative.

    A pair's z = u_c + i u_s is c exp(i r Omega t) (q_c + i q_s) with c = -i on the casing and +i
    on the rotor as in Eq. (16), or c = +1 and -1 in a nodal diameter that holds a single mode:
    the two signs make every coupling term positive.

    Args:
        modes: the coupled modes.
        speed: Omega [rad/s].
        time: t [s], any shape (...).

    Returns:
        P and dP/dt, each (..., size, size), P orthogonal.
    """
    rate = modes.frame_rate
    halved = modes.paired & (2.0 * np.abs(rate) == modes.nodal_diameter)
    constant = np.where(modes.on_casing, 1.0, -1.0) * np.where(halved, -1j, 1.0)
    phase = np.multiply.outer(np.asarray(time, dtype=np.float64), rate * speed)
    factor = constant * np.exp(1j * phase)
    return _real_blocks(modes, factor), _real_blocks(modes, 1j * rate * speed * factor)


def _real_blocks(modes: CouplingModes, factor: ComplexArray) -> FloatArray:
    """Block-diagonal matrix that multiplies each entry by a complex number."""
    matrix = np.zeros((*factor.shape[:-1], modes.size, modes.size))
    first = modes.cosine
    matrix[..., first, first] = factor.real
    cosine, pair = first[modes.paired], factor[..., modes.paired]
    matrix[..., cosine + 1, cosine + 1] = pair.real
    matrix[..., cosine, cosine + 1] = -pair.imag
    matrix[..., cosine + 1, cosine] = pair.imag
    return matrix


def coupled_blocks(modes: CouplingModes, factor: ComplexArray) -> FloatArray:
    """Matrix over the real coordinates of a complex one over the entries.

    Args:
        modes: the coupled modes.
        factor: (..., entries, entries), real between single modes.

    Returns:
        (..., size, size).
    """
    entry, sine = modes.entry, modes.is_sine
    both = factor[..., entry[:, None], entry[None, :]]
    crossed = np.where(sine[:, None], both.imag, -both.imag)
    return np.asarray(np.where(sine[:, None] == sine[None, :], both.real, crossed))


def invariant_matrices(
    modes: CouplingModes, *, speed: ArrayLike, kappa: ArrayLike, with_pi: bool = True
) -> tuple[FloatArray, FloatArray]:
    """Constant matrices G(Omega) and K(Omega) of Eqs (18)-(20), corrected and with damping.

    G = 2 P^T dP/dt + P^T D P and K = P^T (d2P/dt2 + D dP/dt + K(t) P), in closed form. A rotor
    that turns adds 2 Omega Coriolis forces to D and Omega^2 S to K(t), see `turning_rotor`; as
    complex matrices of one body they commute with P.

    Args:
        modes: the coupled modes.
        speed: Omega [rad/s].
        kappa: spring stiffness [N/m]; broadcasts with speed to the shape (...).
        with_pi: keep the factor pi of the integral.

    Returns:
        G [1/s] and K [1/s^2], each (..., size, size).
    """
    speed, kappa = np.broadcast_arrays(np.asarray(speed, np.float64), np.asarray(kappa, np.float64))
    damping, rate = modes.damping_rate, modes.frame_rate
    turning = np.multiply.outer(speed, rate)
    gyroscopic = _real_blocks(modes, damping + 2j * turning)
    uncoupled = modes.frequency**2 - turning**2 + 1j * damping * turning
    stiffness = _real_blocks(modes, uncoupled)
    if modes.turning is not None:
        twice = (2.0 * speed[..., None, None]) * modes.turning.coriolis
        gyroscopic = gyroscopic + coupled_blocks(modes, twice)
        added = (speed**2)[..., None, None] * modes.turning.softening
        stiffness += coupled_blocks(modes, added + 1j * twice * turning[..., None, :])
    for k in modes.harmonics:
        rows = np.zeros((2, modes.size))
        here = modes.nodal_diameter == k
        cosine, pair = modes.cosine[here], here & modes.paired
        rows[0, cosine] = modes.amplitude[here]
        rows[1, modes.cosine[pair] + 1] = modes.amplitude[pair]
        springs = spring_factor(k, with_pi=with_pi) * kappa
        stiffness += springs[..., None, None] * (rows.T @ rows)
    return gyroscopic, stiffness


def state_matrix(
    modes: CouplingModes, *, speed: ArrayLike, kappa: ArrayLike, with_pi: bool = True
) -> FloatArray:
    """State matrix S of dz/dt = S z with z = (q, dq/dt), (..., 2 size, 2 size).

    The negative of the A of Eq. (21), so that a positive real part always means growth.
    """
    gyroscopic, stiffness = invariant_matrices(modes, speed=speed, kappa=kappa, with_pi=with_pi)
    size = modes.size
    state = np.zeros((*gyroscopic.shape[:-2], 2 * size, 2 * size))
    state[..., :size, size:] = np.eye(size)
    state[..., size:, :size] = -stiffness
    state[..., size:, size:] = -gyroscopic
    return state

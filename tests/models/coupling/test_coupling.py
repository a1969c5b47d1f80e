"""The springs between rotor and casing, against Eq. (8) integrated and Eqs (9), (16), (18)."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la
from coupled_system import paper_modes

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.coupling.springs import CouplingModes

BACKWARDS = [4, 5, 2, 3, 0, 1]
"""Positions in (v, u, u_o) of the paper's q1..q6, which Eq. (16) numbers from the suspension."""


def random_modes(seed: int) -> CouplingModes:
    """Nodal diameters 0 to 4, several families; k = 4 is single on the rotor, as for 8 blades."""
    rng = np.random.default_rng(seed)
    k = np.array([0, 0, 1, 1, 1, 2, 2, 3, 4, 4, 4])
    on_casing = np.array([1, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0], dtype=bool)
    return CouplingModes(
        name=tuple(f"mode {i}" for i in range(len(k))),
        on_casing=on_casing,
        nodal_diameter=k,
        frequency=rng.uniform(0.1, 5.0, len(k)),
        amplitude=rng.uniform(-1.5, 1.5, len(k)),
        damping_ratio=rng.uniform(0.0, 0.05, len(k)),
        paired=(k > 0) & ((k < 4) | on_casing),
    )


def integrated_stiffness(modes: CouplingModes, kappa: float, angle: float) -> FloatArray:
    """Hessian of the energy of Eq. (8) by the trapezoidal rule, exact for few harmonics."""
    points = 64
    theta = 2.0 * np.pi * np.arange(points) / points
    columns = []
    for i in range(modes.entries):
        k, amplitude = modes.nodal_diameter[i], modes.amplitude[i]
        where = theta if modes.on_casing[i] else theta - angle
        sign = 1.0 if modes.on_casing[i] else -1.0
        columns.append(sign * amplitude * np.cos(k * where))
        if modes.paired[i]:
            columns.append(sign * amplitude * np.sin(k * where))
    stretch = np.array(columns)
    return np.asarray(kappa * 2.0 * np.pi / points * stretch @ stretch.T)


def equation_16(speed: float, time: float) -> tuple[FloatArray, FloatArray]:
    """P of Eq. (16), typed in as printed, and its derivative."""
    c, s = np.cos(speed * time / 2.0), np.sin(speed * time / 2.0)

    def matrix(c: float, s: float) -> FloatArray:
        return np.array(
            [
                [0, 0, 0, 0, s, c],
                [0, 0, 0, 0, -c, s],
                [0, 0, s, -c, 0, 0],
                [0, 0, c, s, 0, 0],
                [s, -c, 0, 0, 0, 0],
                [c, s, 0, 0, 0, 0],
            ]
        )

    return matrix(c, s), speed / 2.0 * matrix(-s, c)


@pytest.mark.parametrize("seed", range(5))
def test_springs_are_the_integral_of_the_energy(seed: int) -> None:
    modes = random_modes(seed)
    angle, kappa = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi), 3.7
    stiffness = modes.equations.springs(angle, kappa)
    expected = integrated_stiffness(modes, kappa, angle)
    assert stiffness == pytest.approx(expected, rel=1e-12, abs=1e-12 * np.abs(expected).max())
    without = replace(modes, with_pi=False).equations.springs(angle, kappa)
    assert without * np.pi == pytest.approx(stiffness, rel=1e-14)


def test_angles_are_batched() -> None:
    modes, angles = random_modes(1), np.linspace(0.0, 6.0, 12).reshape(3, 4)
    batch = modes.equations.stiffness(angles, 2.0)
    one = modes.equations.stiffness(float(angles[2, 1]), 2.0)
    assert batch.shape == (3, 4, modes.size, modes.size)
    assert batch[2, 1] == pytest.approx(one, rel=1e-14)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.03])
@pytest.mark.parametrize("seed", range(5))
def test_half_speed_frame_gives_the_corrected_equation_18(seed: int, damping_ratio: float) -> None:
    rng = np.random.default_rng(seed)
    v, u, o, speed, kappa, time = rng.uniform(0.1, 5.0, 6)
    modes = paper_modes(casing=v, first_flexural=u, suspension=o, damping_ratio=damping_ratio)

    # Eq. (18) with the sign of its gyroscopic block for q5, q6 reversed.
    turn = speed * np.array([[0.0, 1.0], [-1.0, 0.0]])
    none, one, eps = np.zeros((2, 2)), np.eye(2), np.pi * kappa
    gyroscopic = np.block([[turn, none, none], [none, turn, none], [none, none, -turn]])
    delta = np.array([o, u, v]) ** 2 + eps - speed**2 / 4.0
    stiffness = np.kron(np.diag(delta - eps), one) + np.kron(np.full((3, 3), eps), one)
    drag = 2.0 * damping_ratio * np.diag(np.repeat([o, u, v], 2))
    gyroscopic += drag
    stiffness += drag @ np.block([[turn, none, none], [none, turn, none], [none, none, -turn]]) / 2

    # P^T (...) P with P as printed in Eq. (16) and K(t) by integration of Eq. (8).
    p, p_dot = equation_16(speed, time)
    k_t = np.diag(np.repeat([v, u, o], 2) ** 2)
    k_t = k_t + integrated_stiffness(modes, kappa, speed * time)
    d = 2.0 * damping_ratio * np.diag(np.repeat([v, u, o], 2))
    projected_g = 2.0 * p.T @ p_dot + p.T @ d @ p
    projected_k = p.T @ (-(speed**2) / 4.0 * p + d @ p_dot + k_t @ p)

    at_start = equation_16(speed, 0.0)[0]  # constant, between the two frames
    ours = (at_start.T @ part @ at_start for part in modes.equations.autonomous(speed, kappa))
    for matrix, projected, computed in zip(
        (gyroscopic, stiffness), (projected_g, projected_k), ours, strict=True
    ):
        for other in (projected, computed):
            assert np.abs(other - matrix).max() <= 1e-12 * np.abs(matrix).max()


def test_frame_is_the_printed_equation_16() -> None:
    modes = paper_modes(casing=0.1, first_flexural=1.0, suspension=2.5)
    y, rate = np.random.default_rng(0).normal(size=(2, 6))
    computed = modes.equations.in_body_axes(y[None], rate[None], speed=1.3, time=np.array([0.77]))
    (p, p_dot), at_start = equation_16(1.3, 0.77), equation_16(1.3, 0.0)[0]
    q, q_dot = at_start.T @ y, at_start.T @ rate
    assert computed[0][0] == pytest.approx(p @ q, abs=1e-15)
    assert computed[1][0] == pytest.approx(p_dot @ q + p @ q_dot, abs=2e-15)


def with_rotation(modes: CouplingModes) -> CouplingModes:
    """A rotor with random G, skew, and S, symmetric, that commute with a turn of its pairs."""
    k, rotor, rng = modes.nodal_diameter, ~modes.on_casing, np.random.default_rng(3)
    coupled = (k[:, None] == k) & np.logical_and.outer(rotor, rotor)
    both = np.logical_and.outer(modes.paired, modes.paired)
    real, imaginary = coupled * rng.normal(size=(2, modes.entries, modes.entries))
    drawn = np.zeros((modes.size, modes.size))
    for i, j in np.ndindex(real.shape):
        a, b = real[i, j], both[i, j] * imaginary[i, j]
        first, second = modes.cosine[i], modes.cosine[j]
        height, width = 1 + modes.paired[i], 1 + modes.paired[j]
        block = np.array([[a, -b], [b, a]])[:height, :width]
        drawn[first : first + height, second : second + width] = block
    return replace(modes, gyroscopic=drawn - drawn.T, stiffness_speed=drawn + drawn.T)


@pytest.mark.parametrize("seed", range(5))
def test_frame_makes_any_set_of_modes_autonomous(seed: int) -> None:
    for modes in (random_modes(seed), with_rotation(random_modes(seed))):
        speed, kappa, equations = 1.37, 0.9, modes.equations
        drag, stiffness = equations.autonomous(speed, kappa)
        assert equations.turning is not None
        turn, damping = speed * equations.turning, equations.drag(speed)
        for time in (0.0, 0.9, 4.2):
            frame = la.expm(time * turn)
            k_t = equations.stiffness(speed * time, kappa, speed=speed)
            rate = frame @ turn
            assert frame.T @ (2.0 * rate + damping @ frame) == pytest.approx(drag, abs=1e-12)
            projected = frame.T @ (rate @ turn + damping @ rate + k_t @ frame)
            assert projected == pytest.approx(stiffness, abs=1e-12 * np.abs(stiffness).max())
        y, rate = np.random.default_rng(seed).normal(size=(2, modes.size))
        expected = np.concatenate([rate, -drag @ rate - stiffness @ y])
        state = equations.state_matrix(speed, kappa)
        np.testing.assert_allclose(state @ np.concatenate([y, rate]), expected, atol=1e-12)


def test_printed_equation_9_lacks_the_rotor_rotor_coupling_and_pi() -> None:
    """Eq. (9), typed in as printed, for modal masses of one."""
    v, u, o = 0.2, 1.0, 2.5
    modes = replace(paper_modes(casing=v, first_flexural=u, suspension=o), with_pi=False)
    kappa, angle = 0.8, 0.6
    ours = modes.equations.stiffness(angle, kappa)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    one, none = np.eye(2), np.zeros((2, 2))
    printed = np.block(
        [
            [(v**2 + kappa) * one, -kappa * turn, -kappa * turn],
            [-kappa * turn.T, (u**2 + kappa) * one, none],
            [-kappa * turn.T, none, (o**2 + kappa) * one],
        ]
    )
    missing = np.zeros((6, 6))
    missing[[2, 3, 4, 5], [4, 5, 2, 3]] = kappa
    assert ours - printed == pytest.approx(missing, abs=1e-14)


def test_entries_can_be_taken() -> None:
    modes = random_modes(0)
    assert modes.harmonics == (0, 1, 2, 3, 4)
    assert modes.harmonic(1).name == ("mode 2", "mode 3", "mode 4")
    assert modes.take([4, 0]).paired.tolist() == [True, False]
    assert modes.size == 2 + 6 + 4 + 2 + 2 + 1 + 1

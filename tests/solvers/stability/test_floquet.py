"""Monodromy by direct integration: closed forms, Mathieu, another integrator, the frame."""

import numpy as np
import pytest
from coupled_system import UNIT, six_modes

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.coupling.springs import CouplingModes
from bladewhirl.solvers.stability.floquet import Floquet, coupled_floquet, floquet
from bladewhirl.solvers.stability.growth import eigenvalues, growth_rate


def monodromy(modes: CouplingModes, speed: float, kappa: float) -> Floquet:
    """Of the periodic equations of coupled modes, over one turn."""
    (turn,) = coupled_floquet(modes.equations, speed=speed, kappa=kappa)
    return turn


def test_oscillator_of_constant_stiffness() -> None:
    """x'' + 2 xi w x' + w^2 x = 0 has exponents -xi w +- i w sqrt(1 - xi^2)."""
    result = floquet(
        lambda times: np.full((len(times), 1, 1), 9.0), period=1.0, damping=np.array([[0.6]])
    )
    exact = -0.3 + 1j * np.sqrt(9.0 - 0.09)
    assert np.sort_complex(result.exponents) == pytest.approx([exact.conjugate(), exact], rel=1e-12)
    cos, sin, w = np.cos(exact.imag), np.sin(exact.imag), exact.imag
    position = np.exp(-0.3) * np.array([cos + 0.3 * sin / w, sin / w])
    assert result.monodromy[0] == pytest.approx(position, rel=1e-12)


def test_mathieu_grows_between_its_borders_only() -> None:
    a = np.array([[[0.5]], [[2.5]]])  # between b1 and a1, between a1 and b2
    result = floquet(lambda times: a - 2.0 * np.cos(2.0 * times)[:, None, None, None], period=np.pi)
    assert result.monodromy.shape == (2, 2, 2)
    assert result.growth[0] > 0.1
    assert result.growth[1] == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.005])
@pytest.mark.parametrize(
    ("speed", "kappa"), [(0.6, 1000.0), (1.17, 500.0), (1.9, 500.0), (2.7, 500.0), (2.7, 900.0)]
)
def test_agrees_with_the_autonomous_form(speed: float, kappa: float, damping_ratio: float) -> None:
    modes = six_modes(damping_ratio)
    omega = speed * UNIT
    result = monodromy(modes, omega, kappa)
    growth = growth_rate(modes, speed=omega, kappa=kappa)
    assert result.growth == pytest.approx(growth, rel=1e-6, abs=1e-6 * UNIT)
    # Over one turn the half-speed frame changes sign.
    expected = -np.exp(eigenvalues(modes, speed=omega, kappa=kappa) * result.period)
    distance = np.abs(expected[:, None] - result.multipliers)
    assert distance.min(axis=0) == pytest.approx(0.0, abs=1e-9)
    assert distance.min(axis=1) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
def test_agrees_for_many_nodal_diameters_and_a_single_mode() -> None:
    # The last two are a casing pair and a single rotor mode, as for k = N/2.
    modes = CouplingModes(
        name=tuple("abcdefghi"),
        on_casing=np.array([1, 0, 1, 0, 0, 1, 0, 1, 0], dtype=bool),
        nodal_diameter=np.array([0, 0, 1, 1, 1, 2, 2, 3, 3]),
        frequency=np.array([1.1, 1.0, 0.3, 0.9, 2.4, 0.5, 1.2, 1.3, 1.4]),
        amplitude=np.array([0.4, 0.6, 0.5, 0.3, 0.2, 0.4, 0.7, 0.9, 0.8]),
        damping_ratio=np.linspace(0.001, 0.01, 9),
        paired=np.array([0, 0, 1, 1, 1, 1, 1, 1, 0], dtype=bool),
    )
    for speed in (0.7, 1.0, 1.25):
        growth = growth_rate(modes, speed=speed, kappa=0.5)
        assert monodromy(modes, speed, 0.5).growth == pytest.approx(growth, abs=1e-9)


@pytest.mark.parametrize("speed", [0.8, -1.3])
def test_a_rotor_that_turns_agrees_with_its_autonomous_form(speed: float) -> None:
    """Both ways round, with Coriolis forces and spin softening that couple its two pairs."""
    real, imaginary = [[0.0, 0.2], [0.1, 0.0]], [[0.1, -0.3], [0.1, -0.2]]
    drawn = np.zeros((6, 6))
    drawn[2:, 2:] = np.kron(real, np.eye(2)) + np.kron(imaginary, [[0.0, -1.0], [1.0, 0.0]])
    modes = CouplingModes(
        name=("casing", "one", "other"),
        on_casing=np.array([True, False, False]),
        nodal_diameter=np.full(3, 2),
        frequency=np.array([0.5, 1.1, 1.9]),
        amplitude=np.array([0.7, 0.5, -0.4]),
        damping_ratio=np.array([0.01, 0.0, 0.02]),
        paired=np.ones(3, dtype=np.bool_),
        gyroscopic=drawn - drawn.T,
        stiffness_speed=drawn + drawn.T,
    )
    (result,) = coupled_floquet(modes, speed=speed, kappa=0.3)
    assert result.period == pytest.approx(2.0 * np.pi / abs(speed))
    expected = np.exp(eigenvalues(modes, speed=speed, kappa=0.3) * result.period)
    distance = np.abs(expected[:, None] - result.multipliers)
    assert distance.min(axis=0) == pytest.approx(0.0, abs=1e-9)
    assert distance.min(axis=1) == pytest.approx(0.0, abs=1e-9)


def test_a_step_errs_with_the_seventh_power_of_its_length(monkeypatch: pytest.MonkeyPatch) -> None:
    """So that halved steps err by a 64th over a turn; an odd number of them, too."""

    def after(steps: int) -> FloatArray:
        monkeypatch.setattr("bladewhirl.solvers.stability.floquet.FEWEST_STEPS", steps)
        actual = floquet(
            lambda times: np.array([[4.0, 1.0], [1.0, 2.0]]) * np.cos(times)[:, None, None] ** 2,
            period=np.pi,
            damping=np.array([[0.1, 0.3], [-0.2, 0.2]]),
            tolerance=np.inf,
        )
        assert actual.steps == 2 * steps
        return actual.monodromy

    exact = after(200)
    errors = [np.abs(after(steps) - exact).max() for steps in (7, 14)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(6.0, abs=0.3)


def test_too_tight_a_tolerance_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bladewhirl.solvers.stability.floquet.MOST_STEPS", 256)
    with pytest.raises(ArithmeticError, match="monodromy matrix: expected a change below 0"):
        floquet(lambda times: np.cos(times)[:, None, None], period=2.0 * np.pi, tolerance=0.0)
    with pytest.raises(ArithmeticError, match="expected a period of at most 512 s, got 1e\\+09 s"):
        floquet(lambda times: np.cos(times)[:, None, None], period=1e9)

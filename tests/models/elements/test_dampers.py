"""Dampers of supports and shaft: a full damping matrix in the march."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la
from contact_cases import (
    ledger_residual,
    problem,
    random_problem,
    run,
    run_as_reference,
    small_rotor,
    wall,
)
from stages import CASING_REFERENCE, SMALL, observed_order, ring, ring_moved, stage, steel

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.elements.casing import spring, strut
from bladewhirl.models.modal.modes import structure_modes
from bladewhirl.models.stage.contact_problem import ContactProblem


def damped(seed: int, rotor: int, casing: int, *, friction: float = 0.05) -> ContactProblem:
    """Bodies thrown at each other, with so many dampers each."""
    given = random_problem(seed, speed=1.0, friction=friction)
    random = np.random.default_rng([seed, 2])

    def rows(count: int, modes: int) -> FloatArray:
        return random.normal(scale=12.0, size=(count, modes))

    return replace(
        given,
        rotor=replace(given.rotor, dampers=rows(rotor, len(given.rotor.frequency))),
        casing=replace(given.casing, dampers=rows(casing, len(given.casing.frequency))),
    )


@pytest.mark.parametrize(("rotor", "casing"), [(2, 0), (0, 3), (2, 5)])
@pytest.mark.parametrize("seed", [1, 5])
def test_every_step_is_the_one_plain_numpy_takes(seed: int, rotor: int, casing: int) -> None:
    """There the damping matrix is a full one, solved for at each step."""
    dt, steps = 1e-4, 120
    given = damped(seed, rotor, casing)
    state, _ = run_as_reference(given, dt, steps)
    undamped, _, _ = run(random_problem(seed, speed=1.0), dt, steps)
    assert not np.allclose(undamped.arrays["rotor"], state.arrays["rotor"])


@pytest.mark.parametrize("seed", [1, 5])
def test_the_ledger_closes_in_contact(seed: int) -> None:
    state, chunk, _ = run(damped(seed, 2, 5, friction=0.3), 1e-4, 4000)
    assert state.statistics.contact_steps > 20
    assert state.statistics.complementarity_residual < 1e-10
    assert ledger_residual(chunk) < 1e-10
    assert chunk.damping_work[-1] > 0.0


def test_free_motion_is_that_of_the_full_matrix_to_second_order() -> None:
    """Against the exponential of x'' + D x' + K x = 0 with D = 2 xi omega + G^T G."""
    frequency, rows = np.array([300.0, 420.0, 900.0]), np.array([[9.0, -7.0, 4.0], [2.0, 8.0, 5.0]])
    rotor = small_rotor(frequency, dampers=rows, damping_ratio=np.full(3, 0.01))
    start = {"rotor": np.array([1e-4, 0.0, -2e-4]), "rotor_velocity": np.array([0.1, -0.2, 0.05])}
    full = np.diag(0.02 * frequency) + rows.T @ rows
    state = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.diag(frequency**2), -full]])
    end = 0.02
    exact = la.expm(end * state) @ np.concatenate([*start.values()])
    errors = []
    for steps in (200, 400, 800):
        _, chunk, _ = run(problem(rotor, wall(1.0), start=start), end / steps, steps)
        errors.append(np.abs(chunk.rotor_displacement[-1] - exact[:3]).max())
    assert errors[0] < 0.05 * np.abs(exact[:3]).max()
    np.testing.assert_allclose(observed_order(np.array(errors)), 2.0, atol=0.05)


def test_dampers_of_a_ring_that_moves_as_a_whole() -> None:
    """Power of three dampers at 120 degrees: 3 (c_r + c_t) / 2 v^2; of a strut's, c (e v)^2."""
    angles = 0.3 + 2.0 * np.pi * np.arange(3) / 3
    casing = ring(
        *(
            spring(a, radial=0, tangential=0, radial_damping=70, tangential_damping=20)
            for a in angles
        )
    )
    along_x = ring_moved(casing, 1.0, 0.0, 0.0)
    power = np.sum((casing.dampers @ along_x) ** 2)
    assert power == pytest.approx(1.5 * 90.0, rel=1e-5)
    leaning = ring(
        strut(1.0, steel(0.01), length=0.3, inclination=0.4, ends="built-in", damping=50.0)
    )
    power = np.sum((leaning.dampers @ along_x) ** 2)
    assert power == pytest.approx(50.0 * np.cos(1.4) ** 2, rel=1e-4)


def test_soft_springs_and_dampers_let_the_ring_fade_as_an_oscillator() -> None:
    """Three radial springs and dampers: its translations have c_eff = 3 c / 2 on the whole mass."""
    angles = 2.0 * np.pi * np.arange(3) / 3
    casing = ring(
        *(
            spring(a, radial=200, tangential=100, radial_damping=10, tangential_damping=0)
            for a in angles
        )
    )
    modes = structure_modes(casing.structure, CASING_REFERENCE)
    rows = casing.dampers @ modes.shapes
    full = np.diag(modes.frequency**2)
    size = modes.count
    state = np.block([[np.zeros((size, size)), np.eye(size)], [-full, -rows.T @ rows]])
    values = la.eigvals(state)
    low = values[np.argsort(np.abs(values))][:8]
    expected = -1.5 * 10.0 / (2.0 * casing.mass)
    near = low[np.abs(np.abs(low) - np.sqrt(1.5 * 300.0 / casing.mass)) < 0.2]
    assert len(near) == 4
    np.testing.assert_allclose(near.real, expected, rtol=5e-3)


def test_dampers_of_the_shaft_act_on_the_centre() -> None:
    dampers = ("shaft.damping=400.0", "shaft.damping_y=100.0")
    rotor = stage(*SMALL, *dampers).rotor
    np.testing.assert_allclose(rotor.dampers, np.array([[20.0], [10.0]]) * rotor.centre)
    assert not stage(*SMALL, *dampers, "shaft.clamped=true").rotor.dampers.any()

"""Shafts whose springs differ: turning with the bladed disk, and standing still."""

import numpy as np
import pytest
from contact_cases import (
    ledger_residual,
    problem,
    run,
    small_rotor,
    wall,
)
from places import EXAMPLES
from scipy.integrate import solve_ivp
from stages import SMALL, observed_order, stage

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.file import read_case
from bladewhirl.models.modal.modes import suspension_pair
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.loads import imbalance_force
from bladewhirl.models.stage.stage import Stage, build_stage
from bladewhirl.studies.runs.properties import stage_properties


def on_shaft(x: float, y: float | None, *more: str) -> Stage:
    """A small stage with these shaft springs."""
    other = () if y is None else (f"shaft.stiffness_y={y}",)
    return stage(*SMALL, f"shaft.stiffness={x}", *other, *more)


def test_a_force_at_the_centre_bends_its_own_spring() -> None:
    """Nothing else stands on the ground: F / k along each axis, and none across."""
    rotor = on_shaft(3.4e7, 1.1e7).rotor
    flexible = rotor.centre / rotor.frequency**2 @ rotor.centre.T
    np.testing.assert_allclose(flexible, np.diag([1 / 3.4e7, 1 / 1.1e7]), rtol=1e-9, atol=1e-17)


def test_the_suspension_pair_parts_by_its_share_in_the_springs() -> None:
    """First order: omega^2 changes by the share of the energy in the springs, up and down."""
    e = 1e-4
    modes = on_shaft(3.4e7, None).reduction.modes
    split = on_shaft(3.4e7 * (1 + e), 3.4e7 * (1 - e)).reduction.modes
    pair = suspension_pair(modes)
    square, share = modes.frequency[pair] ** 2, modes.spring_share[pair]
    change = split.frequency[suspension_pair(split)] ** 2 / square - 1.0
    np.testing.assert_allclose(change, np.array([-e, e]) * share, rtol=1e-3)


def test_equal_springs_keep_the_cyclic_path() -> None:
    """Symmetry is found; blades alike on a shaft that is not round are no blades that differ."""
    same, unequal = on_shaft(2e7, 2e7), on_shaft(2e7, 2.0001e7)
    assert same.reduction.modes.is_cyclic
    assert not unequal.reduction.modes.is_cyclic
    messages = "6 equal sectors on springs that differ: dense path"
    assert unequal.symmetry["bladed_disk"] == messages
    np.testing.assert_array_equal(
        same.reduction.modes.frequency, on_shaft(2e7, None).reduction.modes.frequency
    )
    np.testing.assert_allclose(
        unequal.reduction.modes.frequency, same.reduction.modes.frequency, rtol=1e-4
    )


def test_modes_that_do_not_move_the_centre_stay() -> None:
    """All but those with one nodal diameter, by the dense path as by the cyclic one."""
    modes, split = on_shaft(3.4e7, None).reduction.modes, on_shaft(3.4e7, 1e7).reduction.modes
    for k in (0, 2, 3):
        np.testing.assert_allclose(
            split.frequency[split.nodal_diameter == k],
            modes.frequency[modes.nodal_diameter == k],
            rtol=1e-9,
        )


def test_the_example_pulls_along_the_softer_spring() -> None:
    case = read_case(EXAMPLES / "unequal_shaft.toml")
    actual = build_stage(case)
    assert stage_properties(actual)["cyclic"] == {"bladed_disk": False, "casing": True}
    x, y = case.shaft.stiffnesses
    assert x < y
    # The static answer at the clearance speed closes the clearance where the tips go with the hub.
    speed = 0.95 * actual.reference_frequency
    force = imbalance_force(actual) * (speed / actual.speed) ** 2
    assert force / x == pytest.approx(1e-3, rel=1e-3)


def rigid(x: float, y: float, mass: float, speed: float) -> ContactProblem:
    """A rigid rotor on springs that stand still, in its two translations."""
    mean = 0.5 * (x + y)
    rotor = small_rotor(
        np.full(2, np.sqrt(mean / mass)),
        tip_radial=np.array([[1.0, 0.0]]) / np.sqrt(mass),
        tip_tangential=np.array([[0.0, 1.0]]) / np.sqrt(mass),
        centre=np.eye(2) / np.sqrt(mass),
        anisotropy=0.5 * (x - y),
    )
    start = {
        "rotor": np.array([1e-3, 2e-4]) * np.sqrt(mass),
        "rotor_velocity": np.array([0.05, -0.1]) * np.sqrt(mass),
    }
    return problem(rotor, wall(1e6), start=start, speed=speed)


@pytest.mark.parametrize("speed", [0.0, 80.0])
def test_springs_that_stand_still_swing_in_rotating_axes(speed: float) -> None:
    """Against the motion by scipy: force of the ground's springs, turned forth and back."""
    x, y, mass, end = 3e4, 1e4, 2.0, 0.2
    given = rigid(x, y, mass, speed)
    root = np.sqrt(mass)

    def rates(time: float, state: FloatArray) -> FloatArray:
        cos, sin = np.cos(speed * time), np.sin(speed * time)
        turn = np.array([[cos, -sin], [sin, cos]])
        pull = -turn.T @ (np.array([x, y]) * (turn @ state[:2]))
        return np.concatenate([state[2:], pull / mass])

    begin = np.concatenate([given.start.rotor, given.start.rotor_velocity]) / root
    exact = solve_ivp(rates, (0.0, end), begin, rtol=1e-11, atol=1e-14).y[:2, -1]
    errors = []
    for steps in (1000, 2000, 4000):
        _, chunk, _ = run(given, end / steps, steps)
        errors.append(np.abs(chunk.rotor_displacement[-1] / root - exact).max())
        assert ledger_residual(chunk) < 1e-10
        assert chunk.coupling_work.any() == (speed != 0.0)
    assert errors[-1] < 1e-3 * np.abs(exact).max()
    np.testing.assert_allclose(observed_order(np.array(errors)), 2.0, atol=0.05)


def test_a_speed_at_the_suspension_frequency_is_excited_at_the_rate_of_the_swing() -> None:
    """Motions exp(i b t) of the static frame obey (w^2 - (b - W)^2) (w^2 - (b + W)^2) = (d/m)^2.

    With the speed W = w this is b^4 - 4 w^2 b^2 = (d/m)^2, and one b is imaginary.
    """
    x, y, mass = 2.2e4, 1.8e4, 2.0
    natural, swing = np.sqrt(2e4 / mass), 2e3 / mass
    growth = np.abs(np.roots([1.0, 0.0, -4.0 * natural**2, 0.0, -(swing**2)]).imag).max()
    _, chunk, _ = run(rigid(x, y, mass, natural), 1e-4, 20_000)
    size = np.linalg.norm(chunk.rotor_displacement, axis=1)
    actual = np.log(size[20_000] / size[10_000])
    assert actual == pytest.approx(growth, rel=0.01)


def test_bearings_keep_the_mean_in_the_modes() -> None:
    """And the cyclic path: what swings comes in the march alone."""
    actual = on_shaft(3e7, 1e7, "shaft.frame=static")
    assert actual.reduction.modes.is_cyclic
    assert actual.rotor.anisotropy == 1e7
    np.testing.assert_array_equal(actual.rotor.frequency, on_shaft(2e7, None).rotor.frequency)
    held = on_shaft(3e7, 1e7, "shaft.frame=static", "shaft.clamped=true")
    assert held.rotor.anisotropy == 0.0
    assert on_shaft(2e7, None).rotor.anisotropy == 0.0

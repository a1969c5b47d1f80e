"""Marches with a speed of rotation that varies, against closed forms and marches at one speed."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import reference_march
from contact_cases import assert_same, run
from places import EXAMPLES
from reference_march import Reference

from bladewhirl.models.case.file import read_case, with_values
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.varying_speed import SpeedChange
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.studies.verification.bodies import (
    ledger_residual,
    marched,
    point_mass,
    problem,
    wall,
)
from bladewhirl.studies.verification.speed import marched_peak, masses_on_springs

SMALL = ("bladed_disk.blades=9", "reduction.fixed_interface_modes=36", "march.duration=0.02")


@cache
def small_stage(*changes: str, table: tuple[tuple[str, float], ...] = ()) -> ContactProblem:
    case = read_case(EXAMPLES / "imbalance.toml", [*SMALL, *changes])
    if table:
        case = with_values(case, {"march.speed_table": [list(row) for row in table]})
    return contact_problem(build_beams(case))


@pytest.mark.parametrize(
    "changes",
    [
        ("rotation.effects=none",),
        ("rotation.effects=full",),
        ("rotation.effects=full", "contact.sliding=full"),
        ("rotation.effects=full", "shaft.damping=2e4", "shaft.damping_frame=static"),
        ("rotation.effects=full", "rotation.clearance=cold", "contact.foreshortening=true"),
        ("rotation.effects=none", "shaft.stiffness_y=3e7", "shaft.frame=static"),
    ],
)
def test_a_constant_speed_in_a_table_is_the_march_at_this_speed(changes: tuple[str, ...]) -> None:
    thrown = (*changes, "casing.clearance=0.2 mm", "initial.centre_velocity=[0.5, 0.0]")
    given = small_stage(*thrown)
    varying = small_stage(*thrown, table=(("0 s", 1.05), ("0.01 s", 1.05)))
    expected, found = (run(each, 1e-6, 4000, every=50)[1] for each in (given, varying))
    assert expected.contact_impulse.any()
    np.testing.assert_allclose(found.rotation_speed, given.speed, rtol=1e-15)
    np.testing.assert_allclose(found.rotation_angle, given.speed * found.time, rtol=1e-14)
    none = np.zeros(0)
    assert_same(replace(found, rotation_speed=none, rotation_angle=none), expected, 1e-12)


@pytest.mark.parametrize(
    ("frequency", "ratio", "rate"), [(40.0, 0.02, 50.0), (25.0, 0.005, 8.0), (60.0, 0.03, -100.0)]
)
def test_peak_of_one_mass_at_constant_acceleration(
    frequency: float, ratio: float, rate: float
) -> None:
    exact, found = map(np.asarray, marched_peak(frequency, ratio, abs(rate), 2e-5))
    np.testing.assert_allclose(found, exact, rtol=1e-6)


@pytest.mark.parametrize("effects", ["none", "full"])
def test_works_balance_the_energy_while_the_speed_changes(effects: str) -> None:
    given = small_stage(
        f"rotation.effects={effects}",
        "casing.clearance=0.2 mm",
        "initial.centre_velocity=[0.5, 0.0]",
        "shaft.damping=1e3",
        table=(("0 s", 1.05), ("0.01 s", 0.95), ("0.02 s", 1.1)),
    )
    _, chunk, _ = run(given, 1e-6, 20000, every=100)
    assert chunk.contact_impulse.any()
    assert ledger_residual(chunk) < 1e-8
    dense = run(given, 1e-6, 2000, every=100, cyclic=False)[1]
    cyclic = run(given, 1e-6, 2000, every=100)[1]
    assert_same(dense, cyclic, 1e-8)


@pytest.mark.slow
def test_a_rub_at_a_rising_speed_is_that_of_the_definitions(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nine blades that rub while the speed rises: every step in NumPy with the matrices
    at its speed."""
    given = small_stage(
        "bladed_disk.blades=9",
        "casing.elements=12",
        "reduction.fixed_interface_modes=9",
        "rotation.effects=full",
        "casing.clearance=0.03 mm",
        "initial.centre_velocity=[0.1, 0.05]",
        "contact.friction=0.05",
        table=(("0 s", 0.9), ("0.02 s", 1.1)),
    )
    monkeypatch.setattr(reference_march, "REFRESH", 1)
    scheme, reference = CentralDifference(given, 4e-6, 20), Reference(given, 4e-6, 20)
    found = scheme.advance(scheme.init(), 1001)[1]
    expected = reference.advance(reference.init(), 1001)[1]
    assert found.contact_impulse.any()
    for name, error in (
        ("rotor_displacement", 1e-6),
        ("casing_displacement", 1e-3),
        ("contact_impulse", 1e-3),
        ("gap", 1e-3),
    ):
        one, other = getattr(found, name), getattr(expected, name)
        np.testing.assert_allclose(one, other, atol=error * np.abs(other).max(), err_msg=name)


def test_a_march_that_is_resumed_is_the_same() -> None:
    given = small_stage("rotation.effects=full", table=(("0 s", 0.4), ("0.01 s", 1.05)))
    scheme = CentralDifference(given, 1e-6, 100)
    whole = scheme.advance(scheme.init(), 5001)[0]
    half = scheme.advance(scheme.init(), 2301)[0]
    other = CentralDifference(given, 1e-6, 100)
    rest = other.advance(half, 5001 - 2301)[0]
    np.testing.assert_array_equal(rest.arrays["rotor"][:2], whole.arrays["rotor"][:2])


def test_friction_changes_its_sign_with_the_speed() -> None:
    """A mass is pressed to the wall; friction drives it against the rotation, and the speed passes
    zero."""
    body = point_mass(2.0, 300.0)
    body = replace(
        body,
        frequency=np.array([300.0, 200.0]),
        damping_ratio=np.zeros(2),
        contact=2.0**-0.5 * np.eye(3)[:, :2],
        centre=np.zeros((2, 2)),
        column=np.full(2, -1),
        dampers=np.zeros((0, 2)),
    )
    course = SpeedCourse.through([0.0, 0.2], [50.0, -50.0], 0.0)
    start = {"rotor": np.array([0.0, 0.0]), "rotor_velocity": np.array([1.0, 0.0])}
    given = problem(body, wall(0.0), start=start, speed=50.0, friction=0.2)
    given = replace(given, change=SpeedChange(course=course))
    chunk = marched(given, 1e-5, 20000, every=1)
    touched = chunk.contact_impulse[:, 0] > 0.0
    assert touched[chunk.time < 0.09].any()
    assert touched[chunk.time > 0.11].any()
    expected = 0.2 * np.sign(course.speed(chunk.time)) * chunk.contact_impulse[:, 0]
    np.testing.assert_allclose(chunk.friction_impulse[:, 0], expected, atol=1e-12)
    assert ledger_residual(chunk) < 1e-9


def test_a_slow_ramp_to_zero_passes_steady_states() -> None:
    """The displacement under an unbalance follows S Omega^2 / (k - m Omega^2) down to zero."""
    one = np.ones(1)
    course = SpeedCourse.smooth_step(150.0, 0.0, 0.2, 60.0)
    given = masses_on_springs(one, 200.0**2 * np.eye(1), one, course, damping=20.0)
    chunk = marched(given, 2e-4, 300_000, every=1000)
    moved = chunk.rotor_displacement @ given.rotor.centre.T @ [1.0, 1j]
    speed = chunk.rotation_speed
    steady = speed**2 / (200.0**2 - speed**2 + 20.0j * speed)
    late = chunk.time > 1.0
    np.testing.assert_allclose(moved[late], steady[late], atol=3e-3 * np.abs(steady).max())
    assert abs(moved[-1]) < 1e-5


def test_the_start_is_the_static_state_at_the_first_speed() -> None:
    """Without an unbalance and at a constant first speed nothing moves, and the growth of the tips
    is that of a stage at this speed."""
    changes = ("excitation.type=none", "rotation.effects=full", "rotation.clearance=cold")
    given = small_stage(*changes, table=(("0.01 s", 0.5), ("0.02 s", 1.2)))
    slow = small_stage(*changes, "march.speed=0.5")
    np.testing.assert_allclose(given.initial_gap(), slow.initial_gap(), rtol=1e-4)
    _, chunk, _ = run(given, 1e-6, 8000, every=1000)
    moved = chunk.rotor_displacement @ given.rotor.tip_radial.T
    grown = np.abs(given.rotor.tip_recess - slow.rotor.tip_recess).max()
    assert grown > 1e-5
    np.testing.assert_allclose(moved, np.tile(moved[0], (len(moved), 1)), atol=1e-6 * grown)

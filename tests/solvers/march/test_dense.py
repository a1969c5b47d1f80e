"""Moreau and Jean's impacts, and a penalty: on whole stages, beside the march of every day."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contact_cases import ledger_residual, problem, small_rotor, thrown, wall
from places import EXAMPLES
from scipy.interpolate import CubicHermiteSpline

from bladewhirl.models.case.analysis import Contact, SchemeName
from bladewhirl.models.case.file import read_case
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem, Load
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.solvers.march.march import EndReason
from bladewhirl.solvers.march.scheme import make_scheme
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.verification.bodies import marched
from bladewhirl.studies.verification.contact import pad_on_a_wall

LAWS: tuple[SchemeName, SchemeName] = ("moreau-jean", "penalty")


def stage(name: str, **changes: Any) -> ContactProblem:
    case = read_case(EXAMPLES / f"{name}.toml")
    return replace(contact_problem(build_stage(case)), **changes)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", ["coupled_modes", "spinning_fan", "unequal_bearings"])
def test_free_motion_is_that_of_central_differences(law: SchemeName, name: str) -> None:
    """With springs that turn, Coriolis forces, dampers: what differs falls with the square."""
    base, rng = stage(name), np.random.default_rng(2)
    moving = {
        f"{body}_velocity": 1e-4 * rng.normal(size=len(getattr(base, body).frequency))
        for body in ("rotor", "casing")
    }
    given = replace(base, start=replace(base.start, **moving))
    differences = []
    for steps in (50, 100):
        dt = 5e-5 / steps
        expected, actual = (
            marched(given, dt, steps, every=steps, scheme=scheme)
            for scheme in ("central-difference", law)
        )
        assert ledger_residual(actual) < 1e-11
        differences.append(
            [
                np.abs(getattr(actual, part) - getattr(expected, part))[-1].max()
                / np.abs(getattr(expected, part))[-1].max()
                for part in ("rotor_displacement", "casing_displacement")
            ]
        )
    assert np.log2(np.divide(differences[0], differences[1])) == pytest.approx(2.0, abs=0.2)
    assert np.max(differences) < 2e-2


@pytest.mark.parametrize("law", LAWS)
def test_a_free_mass_goes_where_its_loads_push_it(law: SchemeName) -> None:
    """A ramp, a cosine with its phase, an end: x(T) is the integral of (T - t) f(t)."""
    load = Load(
        rotor=np.ones(1), casing=np.zeros(1), end=8e-3, ramp=3e-3, frequency=700.0, phase=0.9
    )
    given = problem(small_rotor(np.zeros(1), tip_radial=np.ones((1, 1))), wall(9.0))
    given = replace(given, loads=(load,), law=Contact(penalty_stiffness=1.0).law)
    chunk = marched(given, 1e-5, 1000, every=500, scheme=law)
    t = np.linspace(0.0, load.end, 20_001)
    rise = np.where(t < load.ramp, 0.5 - 0.5 * np.cos(np.pi * t / load.ramp), 1.0)
    force = rise * np.cos(load.frequency * t + load.phase)
    expected = np.trapezoid((1e-2 - t) * force, t)
    assert chunk.rotor_displacement[-1, 0] == pytest.approx(expected, rel=1e-2)


@pytest.mark.parametrize("changes", [{}, {"tip_rotation": True, "speed": -300.0}])
def test_impulses_where_friction_slips_are_those_of_central_differences(
    changes: dict[str, Any],
) -> None:
    given = thrown(stage("imbalance", sliding="signed", **changes), 20.0, spread=0.3)
    fast = marched(given, 5e-7, 1600, every=100)
    slow = marched(given, 5e-7, 1600, every=100, scheme="moreau-jean")
    for name in ("contact_impulse", "friction_impulse"):
        expected_values, actual = (getattr(chunk, name).sum() for chunk in (fast, slow))
        assert actual == pytest.approx(expected_values, rel=0.02)
    assert slow.friction_work[-1] == pytest.approx(fast.friction_work[-1], rel=0.05)
    assert ledger_residual(slow) < 1e-11
    assert slow.gap.min() > -2e-5  # half a step of an impact
    np.testing.assert_array_equal(slow.contact_steps > 0, slow.contact_impulse > 0.0)
    assert slow.contact_steps.max() <= 100


def test_a_tip_under_a_load_sticks_up_to_the_limit_of_friction() -> None:
    """Pulled with 0.9 and 1.1 of what friction holds: it stays, or slides."""
    base = pad_on_a_wall()
    rotor = replace(base.rotor, frequency=np.array([50.0, 0.0]))
    moved = []
    for pull in (0.9, 1.1):
        load = Load(rotor=np.array([0.0, pull]), casing=np.zeros(1))
        start = replace(base.start, rotor=np.array([1e-3, 0.0]))
        given = replace(base, rotor=rotor, start=start, loads=(*base.loads, load))
        chunk = marched(given, 1e-5, 1000, scheme="moreau-jean")
        moved.append(chunk.rotor_displacement[-1, 1])
    assert abs(moved[0]) < 1e-15
    assert moved[1] == pytest.approx(0.5 * 0.1 * 0.01**2, rel=1e-3)  # a t^2 / 2


def test_a_penalty_creeps_where_a_tip_should_stick() -> None:
    base = replace(pad_on_a_wall(), law={"penalty_stiffness": 1e6, "stick_speed": 0.01})
    rotor = replace(base.rotor, frequency=np.array([50.0, 0.0]))
    load = Load(rotor=np.array([0.0, 0.5]), casing=np.zeros(1))
    pressed = 10.0 / 1e6  # so deep that the penalty holds the weight
    start = replace(base.start, rotor=np.array([1e-3 + pressed, 0.0]))
    weight = replace(base.loads[0], rotor=base.loads[0].rotor + np.array([50.0**2 * pressed, 0.0]))
    given = replace(base, rotor=rotor, start=start, loads=(weight, load))
    chunk = marched(given, 1e-5, 20_000, every=100, scheme="penalty")
    assert chunk.rotor_velocity[-1, 1] == pytest.approx(0.5 * 0.01, rel=1e-6)


@pytest.mark.parametrize("speed", [37.0, -37.0])
def test_a_penalty_pushes_where_the_tip_is_at_half_the_step(speed: float) -> None:
    """On an uneven rigid wall, the same curve by SciPy over one turn."""
    random, dt, penalty = np.random.default_rng(4), 1e-4, 1e4
    clearance = np.column_stack([random.uniform(1e-3, 2e-3, 3), random.normal(scale=1e-3, size=3)])
    arc = np.linspace(0.0, 2.0 * np.pi, 4)  # radius 1: arc length is angle
    around = np.vstack([clearance, clearance[:1]])
    curve = CubicHermiteSpline(arc, around[:, 0], around[:, 1])
    rotor = small_rotor(np.array([40.0]), tip_radial=np.ones((1, 1)), tip_angle=np.array([2.1]))
    casing = replace(wall(0.0, 3), clearance=clearance)
    load = Load(rotor=np.array([4.0]), casing=np.zeros(len(casing.frequency)))
    given = problem(rotor, casing, loads=(load,), speed=speed)
    given = replace(given, law=Contact(penalty_stiffness=penalty).law)
    chunk = marched(given, dt, 4000, scheme="penalty")
    middle = (chunk.rotor_displacement + 0.5 * dt * chunk.rotor_velocity)[:-1, 0]
    at = np.mod(2.1 + speed * (chunk.time[:-1] + 0.5 * dt), 2.0 * np.pi)
    pushed = dt * penalty * np.maximum(middle - curve(at), 0.0)
    assert np.count_nonzero(pushed) > 500
    np.testing.assert_allclose(chunk.contact_impulse[1:, 0], pushed, atol=1e-9 * pushed.max())
    np.testing.assert_array_equal(chunk.contacts[1:], pushed > 0.0)


def test_steps_in_pieces_are_the_same_bits() -> None:
    given = thrown(stage("imbalance"), 40.0, spread=0.5)
    scheme = make_scheme(given, 1e-6, 7, "moreau-jean")
    begin = scheme.init()
    whole, chunk, _ = scheme.advance(begin, 150)
    assert 0.0 < whole.statistics.complementarity_residual < 1e-10
    part, first, _ = scheme.advance(begin, 63)
    again, second, _ = scheme.advance(part, 87)
    assert begin.step == 0
    assert chunk.contact_impulse.any()
    np.testing.assert_array_equal(whole.arrays["displacement"], again.arrays["displacement"])
    for name in ("contact_impulse", "gap", "energy", "normal_work", "step"):
        joined = np.concatenate([getattr(first, name), getattr(second, name)])
        np.testing.assert_array_equal(getattr(chunk, name), joined)


@pytest.mark.parametrize(
    ("way", "law", "last"), [("tip_radial", "penalty", 100), ("tip_tangential", "moreau-jean", 199)]
)
def test_displacements_beyond_the_limit_end_it(way: str, law: SchemeName, last: int) -> None:
    """Looked at every hundred steps where they are not radial."""
    moved: dict[str, Any] = {way: np.ones((1, 1))}
    rotor = small_rotor(np.zeros(1), **moved)
    start = {"rotor_velocity": np.array([1.0])}
    given = problem(rotor, wall(9.0), start=start, displacement_limit=0.01005)
    scheme = make_scheme(replace(given, law=Contact(penalty_stiffness=1.0).law), 1e-4, 10, law)
    state, chunk, end = scheme.advance(scheme.init(), 1000)
    assert end is EndReason.DIVERGENT
    assert state.step == chunk.step[-1] == last
    assert np.isfinite(chunk.gap).all()


def test_a_penalty_that_the_step_does_not_resolve_is_refused() -> None:
    case = read_case(
        EXAMPLES / "imbalance.toml", ["march.scheme=penalty", "contact.penalty_stiffness=1e13"]
    )
    with pytest.raises(CaseError, match=r"contact\.penalty_stiffness = 1e13: expected less"):
        prepare(case)


@pytest.mark.parametrize("tips", [1, 3])
def test_a_penalty_moves_a_tip_by_half_a_radian_a_step_at_most(tips: int) -> None:
    """Unit masses against a rigid wall: their frequency is the root of the penalty."""
    given = problem(small_rotor(np.zeros(tips), tips, tip_radial=np.eye(tips)), wall(1e-3))
    dt = 1e-4
    stiffest = (0.5 / dt) ** 2
    make_scheme(
        replace(given, law=Contact(penalty_stiffness=0.999 * stiffest).law), dt, 1, "penalty"
    )
    with pytest.raises(ValueError, match=r"is above 2\.5e\+07 N/m"):
        make_scheme(
            replace(given, law=Contact(penalty_stiffness=1.001 * stiffest).law), dt, 1, "penalty"
        )

"""Moreau and Jean's impacts, and a penalty: on whole stages, beside the march of every day."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contact_cases import ledger_residual, problem, small_rotor, thrown, wall
from places import EXAMPLES

from bladewhirl.models.case.file import read_case
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem, Load
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.solvers.march.march import EndReason
from bladewhirl.solvers.march.scheme import SchemeName, make_scheme
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
        expected, found = (
            marched(given, dt, steps, every=steps, scheme=scheme)
            for scheme in ("central-difference", law)
        )
        assert ledger_residual(found) < 1e-11
        differences.append(
            [
                np.abs(getattr(found, part) - getattr(expected, part))[-1].max()
                / np.abs(getattr(expected, part))[-1].max()
                for part in ("rotor_displacement", "casing_displacement")
            ]
        )
    assert np.log2(np.divide(differences[0], differences[1])) == pytest.approx(2.0, abs=0.2)
    assert np.max(differences) < 2e-2


@pytest.mark.parametrize("changes", [{}, {"tip_rotation": True, "speed": -300.0}])
def test_impulses_where_friction_slips_are_those_of_central_differences(
    changes: dict[str, Any],
) -> None:
    given = thrown(stage("imbalance", sliding="signed", **changes), 20.0, spread=0.3)
    fast = marched(given, 5e-7, 1600, every=100)
    slow = marched(given, 5e-7, 1600, every=100, scheme="moreau-jean")
    for name in ("contact_impulse", "friction_impulse"):
        wanted, found = (getattr(chunk, name).sum() for chunk in (fast, slow))
        assert found == pytest.approx(wanted, rel=0.02)
    assert slow.friction_work[-1] == pytest.approx(fast.friction_work[-1], rel=0.05)
    assert ledger_residual(slow) < 1e-11
    assert slow.gap.min() > -2e-5  # half a step of an impact


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
    base = replace(pad_on_a_wall(), penalty_stiffness=1e6, stick_speed=0.01)
    rotor = replace(base.rotor, frequency=np.array([50.0, 0.0]))
    load = Load(rotor=np.array([0.0, 0.5]), casing=np.zeros(1))
    pressed = 10.0 / 1e6  # so deep that the penalty holds the weight
    start = replace(base.start, rotor=np.array([1e-3 + pressed, 0.0]))
    weight = replace(base.loads[0], rotor=base.loads[0].rotor + np.array([50.0**2 * pressed, 0.0]))
    given = replace(base, rotor=rotor, start=start, loads=(weight, load))
    chunk = marched(given, 1e-5, 20_000, every=100, scheme="penalty")
    assert chunk.rotor_velocity[-1, 1] == pytest.approx(0.5 * 0.01, rel=1e-6)


def test_steps_in_pieces_are_the_same_bits() -> None:
    given = thrown(stage("imbalance"), 40.0, spread=0.5)
    scheme = make_scheme(given, 1e-6, 7, "moreau-jean")
    begin = scheme.init()
    whole, chunk, _ = scheme.advance(begin, 150)
    part, first, _ = scheme.advance(begin, 63)
    again, second, _ = scheme.advance(part, 87)
    assert begin.step == 0
    assert chunk.contact_impulse.any()
    np.testing.assert_array_equal(whole.displacement, again.displacement)
    for name in ("contact_impulse", "gap", "energy", "normal_work", "step"):
        joined = np.concatenate([getattr(first, name), getattr(second, name)])
        np.testing.assert_array_equal(getattr(chunk, name), joined)


def test_displacements_beyond_the_limit_end_it() -> None:
    rotor = small_rotor(np.zeros(1), tip_radial=np.ones((1, 1)))
    start = {"rotor_velocity": np.array([1.0])}
    given = problem(rotor, wall(9.0), start=start, displacement_limit=0.01005)
    scheme = make_scheme(replace(given, penalty_stiffness=1.0), 1e-4, 10, "penalty")
    state, chunk, end = scheme.advance(scheme.init(), 1000)
    assert end is EndReason.DIVERGENT
    assert state.step == chunk.step[-1] == 100
    assert np.isfinite(chunk.gap).all()


def test_a_penalty_that_the_step_does_not_resolve_is_refused() -> None:
    case = read_case(
        EXAMPLES / "imbalance.toml",
        ["march.scheme=penalty", "contact.penalty_stiffness=1e13"],
    )
    with pytest.raises(CaseError, match=r"contact\.penalty_stiffness = 1e13: expected less"):
        prepare(case)

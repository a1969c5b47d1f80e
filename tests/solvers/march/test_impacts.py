"""The march beside one with another time rule and another contact law, on whole stages."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contact_cases import thrown
from impact_march import ImpactMarch
from places import EXAMPLES

from bladewhirl.models.case.file import read_case
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.studies.verification.bodies import marched


def stage(name: str, **changes: Any) -> ContactProblem:
    case = read_case(EXAMPLES / f"{name}.toml")
    return replace(contact_problem(build_beams(case)), **changes)


@pytest.mark.parametrize("name", ["coupled_modes", "spinning_fan", "unequal_bearings"])
def test_free_motion_is_that_of_the_midpoint_rule(name: str) -> None:
    """With springs that turn, Coriolis forces, dampers: what differs falls with the square."""
    base, rng = stage(name), np.random.default_rng(2)
    moving = {
        f"{body}_velocity": 1e-4 * rng.normal(size=len(getattr(base, body).frequency))
        for body in ("rotor", "casing")
    }
    given = replace(base, start=replace(base.start, **moving))
    modes, differences = len(base.rotor.frequency), []
    for steps in (50, 100):
        dt = 5e-5 / steps
        chunk, other = marched(given, dt, steps, every=steps), ImpactMarch(given, dt)
        other.march(steps)
        actual = chunk.rotor_displacement[-1], chunk.casing_displacement[-1]
        expected = np.split(other.displacement, [modes])
        pairs = zip(actual, expected, strict=True)
        differences.append([np.abs(one - two).max() / np.abs(two).max() for one, two in pairs])
    assert np.log2(np.divide(differences[0], differences[1])) == pytest.approx(2.0, abs=0.2)
    assert np.max(differences) < 2e-2


@pytest.mark.parametrize("changes", [{}, {"tip_rotation": True, "speed": -300.0}])
def test_impulses_where_friction_slips_are_those_of_impacts(changes: dict[str, Any]) -> None:
    given = thrown(stage("imbalance", sliding="signed", **changes), 20.0, spread=0.3)
    chunk, other = marched(given, 5e-7, 1600, every=100), ImpactMarch(given, 5e-7)
    other.march(1600)
    assert other.stuck == 0
    assert chunk.contact_impulse.sum() == pytest.approx(other.normal.sum(), rel=0.02)
    assert chunk.friction_impulse.sum() == pytest.approx(other.friction.sum(), rel=0.02)

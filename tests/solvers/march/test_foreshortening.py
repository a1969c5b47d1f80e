"""Gaps that open as blades bend: the compiled march against the reference, and its balances."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contact_cases import assert_same, thrown

from bladewhirl.models.case.case import Case
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import joined
from bladewhirl.solvers.march.reference import Reference

STEP = 2e-6
SMALL: dict[str, Any] = {
    "bladed_disk": {"blades": 5},
    "casing": {"elements": 12},
    "reduction": {"fixed_interface_modes": 10},
    "contact": {"foreshortening": True},
    "initial": {"tip_displacement": [[0.0, 0.03 - 0.01 * blade] for blade in range(5)]},
}
COATING = {"thickness": 5e-3, "young_modulus": 1e9, "yield_stress": 1e6, "hardening": 5e7}
KINDS: dict[str, dict[str, Any]] = {
    "permanent sliding": {},
    "Coriolis forces": {"rotation": {"effects": "full"}},
    "around the axis": {"contact": {"foreshortening": True, "tip_rotation": True}},
    "coating": {"casing": {"elements": 12, "coating": COATING}},
}


def problem(**tables: Any) -> ContactProblem:
    """Return a small stage with bent blades, whose tips start towards the casing."""
    return thrown(contact_problem(build_stage(Case(**SMALL | tables))), 40.0, spread=0.5)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("cyclic", [True, False])
def test_bent_blades_march_as_in_the_reference(kind: str, cyclic: bool) -> None:
    given = problem(**KINDS[kind])
    assert given.foreshortening is not None
    fast, plain = CentralDifference(given, STEP, 1, cyclic=cyclic), Reference(given, STEP, 1)
    _, chunk, _ = fast.advance(fast.init(), 150)
    _, expected, _ = plain.advance(plain.init(), 150)
    assert expected.contact_impulse.any()
    assert_same(chunk, expected, 1e-10)
    straight = replace(given, foreshortening=None)
    scheme = CentralDifference(straight, STEP, 1)
    _, without, _ = scheme.advance(scheme.init(), 150)
    assert np.abs(chunk.gap - without.gap).max() > 1e-4


def test_a_march_in_parts_is_the_same_to_the_last_bit() -> None:
    given = problem()
    scheme = CentralDifference(given, STEP, 7)
    _, whole, _ = scheme.advance(scheme.init(), 150)
    middle, first, _ = scheme.advance(scheme.init(), 61)
    _, rest, _ = CentralDifference(given, STEP, 7).advance(middle, 89)
    assert_same(joined([first, rest]), whole, 0.0)


def test_gaps_far_from_the_wall_open_by_the_form() -> None:
    given = contact_problem(build_stage(Case(**SMALL)))
    straight = replace(given, foreshortening=None)
    chunk, without = (
        scheme.advance(scheme.init(), 1500)[1]
        for scheme in (CentralDifference(given, STEP, 1), CentralDifference(straight, STEP, 1))
    )
    assert given.foreshortening is not None
    exact = given.foreshortening.opening(chunk.rotor_displacement)
    assert exact.max() > 1e-3
    error = np.abs(chunk.gap - without.gap - exact).max(axis=1) / exact.max()
    assert error[0] < 1e-12  # at the start
    assert error[700:].max() < 0.05  # extrapolated between checks

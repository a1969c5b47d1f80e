"""Gaps that open as blades bend."""

from dataclasses import replace

import numpy as np
from contact_cases import assert_same, small_problem, thrown

from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import joined

STEP = 2e-6


def problem() -> ContactProblem:
    """Return a small stage with bent blades."""
    bent = {"tip_displacement": [[0.0, 0.03 - 0.01 * blade] for blade in range(5)]}
    return small_problem(contact={"foreshortening": True}, initial=bent)


def test_a_march_in_parts_is_the_same_to_the_last_bit() -> None:
    given = thrown(problem(), 40.0, spread=0.5)
    scheme = CentralDifference(given, STEP, 7)
    _, whole, _ = scheme.advance(scheme.init(), 150)
    middle, first, _ = scheme.advance(scheme.init(), 61)
    _, rest, _ = CentralDifference(given, STEP, 7).advance(middle, 89)
    assert_same(joined([first, rest]), whole, 0.0)


def test_gaps_far_from_the_wall_open_by_the_form() -> None:
    given = problem()
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

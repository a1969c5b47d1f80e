"""A casing that closes on the tips: against the reference, against a constant clearance, and the
energy ledger of a wall that moves."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contact_cases import assert_same, small_problem

from bladewhirl.models.case.closure import Closure
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.free_motion import FreeMotion
from bladewhirl.solvers.march.march import Chunk

STEP = 2e-6


def problem(closure: dict[str, Any] | None, **casing: Any) -> ContactProblem:
    return small_problem(casing=casing | ({} if closure is None else {"closure": closure}))


def test_a_closure_that_does_not_change_is_a_smaller_clearance() -> None:
    """The gap at t = 0 is 1 mm in both cases, with the same shape around the casing."""
    lobes = [{"lobes": 2, "amplitude": 2e-4, "phase": 0.3}]
    moved = [{"lobes": 2, "amplitude": 2e-4, "phase": 0.3 + np.pi / 2}]
    closed = problem({"table": [[0.0, 1e-3]], "lobes": lobes}, clearance=2e-3)
    constant = problem(None, clearance=2e-3, clearance_lobes=moved)
    casing = replace(constant.casing, clearance=constant.casing.clearance - [1e-3, 0.0])
    velocity = 30.0 * np.linalg.pinv(closed.rotor.tip_radial) @ np.ones(5)
    chunks: list[Chunk] = []
    for given in (closed, replace(constant, casing=casing)):
        thrown = replace(given, start=replace(given.start, rotor_velocity=velocity))
        scheme = CentralDifference(thrown, STEP, 10)
        chunks.append(scheme.advance(scheme.init(), 400)[1])
    assert chunks[0].contact_impulse.any()
    assert_same(chunks[0], chunks[1])


def test_the_work_of_a_closing_wall_closes_the_ledger() -> None:
    """A wall that pushes tips from rest is the only source of energy."""
    lobes = [{"lobes": 2, "amplitude": 0.02, "phase": 0.3}]
    closing = {"amount": 0.1, "time_constant": 1e-2, "lobes": lobes}
    scheme = CentralDifference(problem(closing), STEP, 1)
    _, chunk, _ = scheme.advance(scheme.init(), 1000)
    put_in = chunk.normal_work + chunk.friction_work
    wall = chunk.normal_work - chunk.closing_work
    assert wall[-1] > 0.1 * chunk.energy.max() > 0.0
    assert chunk.closing_work[-1] < 0.0
    residual = np.abs(chunk.energy - put_in + chunk.damping_work).max()
    assert residual < 1e-8 * chunk.energy.max()


def test_the_work_of_the_wall_is_force_times_its_motion() -> None:
    given = problem({"table": [[0.0, 0.0], [1e-3, 2e-3]]})
    scheme = CentralDifference(replace(given, speed=0.0), STEP, 1)
    _, chunk, _ = scheme.advance(scheme.init(), 1000)
    wall = chunk.normal_work - chunk.closing_work
    assert wall[-1] == pytest.approx(chunk.contact_impulse.sum() * 2e-3 / 1e-3, rel=1e-9)


def test_free_motion_counts_the_clearance_that_will_be_left() -> None:
    load = {"type": "casing-distortion", "duration": 1e-3}
    enough = []
    for casing in (
        {"clearance": 1e-3},
        {"clearance": 2e-3, "closure": {"amount": 1e-3, "time_constant": 9.0}},
    ):
        enough.append(FreeMotion.of(small_problem(casing=casing, excitation=load), STEP).enough)
    assert enough[0] == pytest.approx(enough[1], rel=0.01)  # of rings of other radii


def test_the_closure_is_linear_between_rows_and_exponential_without() -> None:
    table = Closure(table=((1.0, 0.0), (3.0, 4e-3)))
    np.testing.assert_allclose(table.value([0.0, 2.0, 9.0]), [0.0, 2e-3, 4e-3])
    course = Closure(amount=1e-3, time_constant=2.0)
    np.testing.assert_allclose(course.value(2.0), 1e-3 * (1.0 - np.exp(-1.0)), rtol=1e-15)


def test_a_wall_that_is_closed_at_the_start_is_refused() -> None:
    with pytest.raises(CaseError, match=r"table = .*: expected a closure at t = 0 that is smaller"):
        problem({"table": [[0, 1e-3]]})

"""Branches of periodic motions against time integration of the same oscillator."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
import scipy.integrate as si
from periodic_cases import twisted_blade

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.solvers.periodic import bifurcation
from bladewhirl.solvers.periodic.blade import Blade, Grid, alike, between, comparable
from bladewhirl.solvers.periodic.contact import Motion, active
from bladewhirl.solvers.periodic.continuation import Continuation, Point
from bladewhirl.solvers.periodic.stability import Monodromy, monodromy
from bladewhirl.studies.verification.periodic import oscillator

DRAG, FORCE, STOP = 0.06, 0.1, 1.0
"""Damping, force and stiffness of the stop of an oscillator of unit mass and frequency."""


@lru_cache(maxsize=64)
def grid(speed: float, instants: int) -> Grid:
    blade = oscillator(speed, FORCE)
    return Grid(replace(blade, damping=np.array([[DRAG]]), compliance=np.eye(3) / STOP), instants)


def branch_from(speed: float, sign: float) -> tuple[Continuation, Point]:
    branch = Continuation(lambda speed, instants: (grid(speed, instants), 0.0), 0.16)
    return branch, branch.begin(Motion.free(grid(speed, 64)), speed, sign)


def settled(speed: float, state: FloatArray, periods: int) -> tuple[FloatArray, float]:
    """State after a number of periods, and the largest displacement in the last ones."""
    period = 2.0 * np.pi / speed

    def rate(time: float, y: FloatArray) -> list[float]:
        pushed = FORCE * np.cos(speed * time) - STOP * max(0.0, y[0] - 1.0)
        return [y[1], pushed - DRAG * y[1] - y[0]]

    last = np.linspace((periods - 2) * period, periods * period, 101)
    motion = si.solve_ivp(rate, (0.0, last[-1]), state, rtol=1e-8, atol=1e-10, t_eval=last)
    return motion.y[:, -1], float(motion.y[0].max())


@lru_cache
def traced() -> tuple[list[Point], list[bifurcation.Bifurcation]]:
    """A branch over the resonance, which leans to higher speeds, and its bifurcations."""
    branch, before = branch_from(0.95, 1.0)
    values, special, points = bifurcation.multipliers(before), [], [before]
    for point in branch.follow(before, 0.1, 0.1):
        after = bifurcation.multipliers(point)
        kinds = bifurcation.changed(before, point, values, after)
        special += bifurcation.found(branch, before, point, kinds)
        before, values = point, after
        points.append(point)
        if point.parameter > 1.06:
            break
    return points, special


@pytest.mark.slow
def test_a_multiplier_leaves_the_unit_circle_at_each_of_two_folds() -> None:
    points, folds = traced()
    assert [each.kind for each in folds] == ["fold", "fold"]
    high, low = (each.point.parameter for each in folds)
    assert low < high
    for each in folds:
        assert np.abs(bifurcation.multipliers(each.point) - 1.0).min() < 0.04
        assert each.shift < 2e-3 * high
    back = [point for point in points if point.heading < 0.0][1:-1]
    assert back
    assert not any(monodromy(point.motion).stable for point in back)


@pytest.mark.slow
def test_a_march_loses_the_large_motion_beyond_the_upper_fold() -> None:
    high = traced()[1][0].point.parameter
    state, _ = settled(1.04, np.array([2.0, 0.0]), 30)
    state, large = settled(high * 0.998, settled(1.05, state, 30)[0], 60)
    assert large > 1.2
    assert settled(high * 1.002, state, 100)[1] < 1.0


@pytest.mark.slow
def test_a_march_loses_the_small_motion_below_the_lower_fold() -> None:
    low = traced()[1][1].point.parameter
    speed = low * 1.002
    linear = FORCE / (1.0 - speed**2 + 1j * DRAG * speed)
    state, small = settled(speed, np.array([linear.real, (1j * speed * linear).real]), 50)
    assert small < 1.05
    assert settled(low * 0.998, state, 80)[1] > 1.2


def test_a_period_doubling_needs_a_multiplier_at_minus_one() -> None:
    """On a branch, a pair that meets at -1.5 changes the number of real multipliers too."""
    branch, start = branch_from(0.95, 1.0)
    ahead = branch.corrected(start, 0.1)
    pair, real = np.array([-1.5 + 0.1j, -1.5 - 0.1j]), np.array([-1.6 + 0j, -1.4 + 0j])
    assert bifurcation.changed(start, ahead, pair, real) == {"period doubling", "Neimark-Sacker"}
    assert bifurcation.found(branch, start, ahead, {"period doubling", "Neimark-Sacker"}) == []


def test_multipliers_without_contact_are_those_of_the_modes() -> None:
    motion = Motion.free(grid(1.3, 64))
    decay = np.exp(-0.5 * DRAG * motion.grid.blade.period)
    assert np.abs(monodromy(motion).multipliers) == pytest.approx(decay, rel=1e-9)


@pytest.mark.parametrize(("largest", "stable"), [(0.99, True), (1.01, False), (-1.1, False)])
def test_deviations_decay_if_all_multipliers_are_below_one(largest: float, stable: bool) -> None:
    assert Monodromy(np.diag([0.5, largest]), 1).stable == stable


def test_corners_are_passed_with_the_active_set_that_follows() -> None:
    """A branch over the place of the wall, which turns back at corners: each point is a periodic
    motion, and neighbours differ little."""
    blade = Blade.of_problem(twisted_blade("7000 rpm", "full", 0.05, "0.1 mm"))
    coarse = Grid(blade, 64)
    outward = -float(coarse.free_gap.min())
    branch = Continuation(lambda offset, _: (coarse, offset), outward)
    before = branch.begin(Motion.free(coarse, outward), outward, -1.0)
    turns, points = 0, [before]
    for point, _ in zip(branch.follow(before, 0.2, 0.2), range(40), strict=False):
        assert point.motion.residual < 1e-6
        assert (active(point.motion) == (point.motion.normal > 0.0)).all()
        turns += point.heading * points[-1].heading < 0.0
        points.append(point)
    assert turns >= 2
    assert points[-1].motion.impulse > 3.0


def test_blades_between_two_are_those_that_are_built() -> None:
    low, middle, high = (
        Blade.of_problem(twisted_blade(speed, "full", 0.05, "0.1 mm"))
        for speed in ("6000 rpm", "6500 rpm", "7000 rpm")
    )
    assert comparable(low, high)
    assert alike(middle, between(low, high, 0.5), 1e-9)
    assert not alike(middle, between(low, high, 0.51), 1e-9)
    assert between(low, high, 0.5).stiffness is low.stiffness
    assert not comparable(low, replace(high, lobes=1))

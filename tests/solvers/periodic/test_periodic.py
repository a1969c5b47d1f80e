"""Periodic motions against closed forms and against marches with small steps."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scipy.optimize as so
from boundary_cases import bladed
from periodic_cases import decay, marched, rub, states, twisted_blade

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.solvers.periodic.blade import Blade, Grid
from bladewhirl.solvers.periodic.contact import (
    Motion,
    NotConverged,
    active,
    equations,
    moved,
    solve,
)
from bladewhirl.solvers.periodic.search import periodic_motion
from bladewhirl.solvers.periodic.stability import _Answers, monodromy
from bladewhirl.studies.verification.periodic import STOP, oscillator


@pytest.mark.parametrize(("ratio", "expected"), [(1.2, 1.118965), (2.0, 1.319807), (5.0, 1.515945)])
def test_the_backbone_of_an_oscillator_with_an_elastic_stop(ratio: float, expected: float) -> None:
    """Frequency of free vibration at the amplitude a, from the closed form of its two parts; a
    small force moves it to both sides by the same amount, to first order."""
    stiff, instants, force = 1.0 + STOP, 1024, 1e-3
    rest = STOP / stiff  # of the mass in contact
    farthest = rest + np.sqrt((ratio**2 - 1.0) / stiff + (1.0 - rest) ** 2)

    def beyond(speed: float, push: float) -> float:
        grid = Grid(oscillator(speed, push), instants)
        time = (grid.time + 0.5 * grid.blade.period) % grid.blade.period - 0.5 * grid.blade.period
        phase = np.clip(np.sqrt(stiff) * time, -np.pi, np.pi)
        normal = np.maximum(0.0, STOP * (rest + (farthest - rest) * np.cos(phase) - 1.0))
        motion = solve(Motion(grid, normal[:, None], np.zeros((instants, 1))))
        return float(-grid.modes(motion.force)[0].min()) - ratio

    near = expected * (1.0 - 4e-3), expected * (1.0 + 4e-3)
    found = [so.brentq(beyond, *near, args=(push,), xtol=1e-12) for push in (force, -force)]
    assert np.mean(found) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(
    ("speed", "sliding", "friction", "closure"),
    [
        pytest.param("4500 rpm", "full", 0.1, "0.09 mm", marks=pytest.mark.slow),
        pytest.param("6000 rpm", "full", 0.05, "0.1 mm", marks=pytest.mark.slow),
        ("7000 rpm", "full", 0.05, "0.1 mm"),
        ("5000 rpm", "permanent", 0.1, "0.085 mm"),
    ],
)
def test_a_blade_in_an_oval_wall_moves_as_in_a_march(
    speed: str, sliding: str, friction: float, closure: str
) -> None:
    problem = twisted_blade(speed, sliding, friction, closure)
    motion = rub(problem)
    assert motion.grid.blade.lobes == 2
    assert motion.residual < 1e-9
    chunk = marched(problem, motion, 5e-7, 80)
    impulse = 2.0 * chunk.contact_impulse[-1].sum()
    assert motion.impulse == pytest.approx(impulse, rel=2e-3)
    leading = monodromy(motion)
    assert leading.stable
    state = states(problem, chunk)
    assert np.abs(leading.multipliers[0]) == pytest.approx(decay(state), abs=5e-3)


@pytest.mark.slow
def test_a_large_rub_that_only_a_branch_finds_is_that_of_a_march() -> None:
    """Newton's method from the motion without contact finds nothing here."""
    problem = twisted_blade("7000 rpm", "full", 0.1, "0.1 mm")
    blade = Blade.of_problem(problem)
    with pytest.raises(NotConverged):
        solve(Motion.free(Grid(blade, 64)))
    motion = periodic_motion(blade)
    chunk = marched(problem, motion, 1e-6, 30)
    impulse = 2.0 * chunk.contact_impulse[-1].sum()
    assert motion.impulse == pytest.approx(impulse, rel=1e-3)
    assert monodromy(motion).stable


def test_newton_has_the_derivatives_of_its_equations() -> None:
    problem = twisted_blade("7000 rpm", "full", 0.1, "0.1 mm")
    random = np.random.default_rng(1)
    motion = Motion.free(Grid(Blade.of_problem(problem), 16))
    chosen = random.random(motion.normal.shape) < 0.4
    motion = replace(
        motion,
        normal=np.where(chosen, 50.0 * random.random(chosen.shape), 0.0),
        angle=0.3 * random.standard_normal(chosen.shape),
    )
    change = 1e-4 * random.standard_normal(2 * np.count_nonzero(chosen))
    change[len(change) // 2 :] *= 0.01
    up, down = (equations(moved(motion, chosen, sign * change), chosen).value for sign in (1, -1))
    expected = equations(motion, chosen).matrix @ change
    half = len(change) // 2
    for part in (slice(half), slice(half, None)):
        largest = np.abs(expected[part]).max()
        assert 0.5 * (up - down)[part] == pytest.approx(expected[part], abs=1e-6 * largest)


def test_deviations_of_forces_keep_gaps_closed_and_oppose_the_slip() -> None:
    """Two nodes that slide in any direction: the linear deviations of their forces against the
    forces for states a little apart."""
    random, nodes = np.random.default_rng(4), np.arange(2)
    friction, step, normal, angle = 0.3, 0.2, np.array([2.0, 3.0]), np.array([0.7, -2.1])
    half, place, velocity = random.normal(size=(3, 6, 6))
    compliance = 4.0 * np.eye(6) + 0.3 * random.normal(size=(6, 6))
    flexible, rate = place @ half + compliance, velocity @ half + compliance / step
    slip = 5.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def force(values: FloatArray) -> FloatArray:
        pressed, way = values.reshape(2, 2)
        ways = np.stack([np.ones(2), friction * np.cos(way), friction * np.sin(way)], axis=1)
        return np.asarray((-pressed[:, None] * ways).ravel())

    def miss(values: FloatArray, state: FloatArray, before: FloatArray) -> FloatArray:
        change, way = force(values) - force(base), values[2:]
        gap = (place @ state + flexible @ change)[::3]
        moved = velocity @ state + rate @ change - compliance @ before / step
        across, axial = (slip + moved.reshape(2, 3)[:, 1:]).T
        return np.concatenate([gap, np.cos(way) * axial - np.sin(way) * across])

    base = np.concatenate([normal, angle])
    whole: Any = SimpleNamespace(
        turns=True, friction=friction, step=step, compliance=compliance, slip=slip[None]
    )
    whole.ways = -force(np.concatenate([np.ones(2), angle])).reshape(1, 2, 3)
    whole.normal, whole.angle = normal[None], angle[None]
    answers = _Answers(whole, place, velocity, flexible, rate)
    found = answers.forces(0, nodes, np.eye(6, 12), np.eye(6, 12, 6))
    for expected, change in zip(found.T, 1e-5 * np.eye(12), strict=True):
        up, down = (
            force(so.fsolve(miss, base, (sign * change[:6], sign * change[6:]), xtol=1e-13))
            for sign in (1.0, -1.0)
        )
        assert (up - down) / 2e-5 == pytest.approx(expected, rel=1e-6)


def test_responses_are_those_of_the_frequency_response() -> None:
    """Of a smooth force on a blade with Coriolis forces; and of a load without contact."""
    skew = np.zeros((8, 8))
    skew[0, 1], skew[1, 0] = 30.0, -30.0
    problem = bladed(1, 2, by_velocity=skew)
    push = np.arange(1.0, 9.0)
    load = Load(rotor=push, frequency=4.0 * problem.speed, phase=0.3, ramp=1.0)
    blade = Blade.of_problem(replace(problem, loads=(load,)))
    assert blade.lobes == 2
    grid, w = Grid(blade, 4096), 4.0 * problem.speed
    pattern = np.cos(np.arange(6.0))
    force = np.cos(w * grid.time)[:, None] * pattern
    unloaded = Grid(replace(blade, loads={}), 4096)
    answer = blade.compliance @ pattern + blade.contact @ blade.admittance(w) @ (
        blade.contact.T @ pattern
    )
    expected = (np.exp(1j * w * grid.time)[:, None] * answer).real
    largest = np.abs(expected).max()
    assert unloaded.displacement(force, unloaded.modes(force)) == pytest.approx(
        expected, abs=1e-5 * largest
    )
    drive = np.exp(0.3j) * blade.contact[::3] @ blade.admittance(w) @ push
    moving = (np.exp(1j * w * grid.time)[:, None] * drive).real
    assert grid.wall - grid.free_gap == pytest.approx(moving, abs=1e-12)


def test_motions_without_contact_and_what_is_refused() -> None:
    problem = bladed(1, 2)
    free = periodic_motion(Blade.of_problem(problem))
    assert not free.touches
    assert not active(free).any()
    round_wall = replace(
        problem.casing, clearance=np.tile([2e-4, 0.0], (len(problem.casing.clearance), 1))
    )
    for changes, reason in (
        ({"tip_rotation": True}, "tip_rotation"),
        ({"casing": round_wall}, "no period"),
        ({"speed": 0.0}, "no period"),
        ({"loads": (Load(rotor=np.ones(8), frequency=101.0),)}, "whole number"),
    ):
        with pytest.raises(ValueError, match=reason):
            Blade.of_problem(replace(problem, **changes))
    with pytest.raises(ValueError, match="massless"):
        Blade.of_problem(bladed(1, 2, massless=False))


def test_deviations_do_not_grow_in_a_long_contact_with_few_instants() -> None:
    """A mass that a force holds in contact with a stiff stop, with a step of five radians of its
    vibration: with forces that are linear in each step, the largest multiplier is 1e24."""
    blade = oscillator(1.0, 0.01, 0.05)
    pressed = replace(
        blade, compliance=np.eye(3) / 2500.0, loads={0: np.array([5.0 + 0j]), **blade.loads}
    )
    motion = solve(Motion.free(Grid(pressed, 64)))
    assert (motion.normal > 0.0).all()
    largest = np.abs(monodromy(motion).multipliers[0])
    assert np.exp(-0.5 * 0.05 * pressed.period) - 1e-9 < largest < 0.95


@pytest.mark.slow
def test_a_blade_that_jams_has_no_periodic_motion() -> None:
    """Friction that moves the nodes outward by more than the normal force moves them inward."""
    blade = oscillator(0.5, 2.0)
    outward = np.array([[1.0], [-30.0], [0.0]])
    stuck = replace(blade, contact=outward, friction=1.0, stiffness=np.array([1e-4]))
    with pytest.raises(NotConverged):
        periodic_motion(stuck)

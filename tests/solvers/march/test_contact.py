"""The contact step: against plain NumPy, on both paths, and in its conventions."""

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from contact_cases import (
    ledger_residual,
    problem,
    run,
    small_casing,
    small_rotor,
    stage_problem,
    thrown,
    wall,
)
from scipy.interpolate import CubicHermiteSpline

from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.solvers.march.march import Chunk

Sliding = Literal["permanent", "signed"]


def test_columns_that_the_displacements_do_not_follow_are_refused() -> None:
    given = stage_problem(5, 8)
    by_tip = given.rotor.contact.reshape(5, 3, -1)
    changed = by_tip[[1, 0, 2, 3, 4]].reshape(given.rotor.contact.shape)
    turned = replace(given.rotor, contact=changed)
    with pytest.raises(ValueError, match="do not match"):
        run(replace(given, rotor=turned), 1e-7, 1)
    mixed = replace(given.casing, column=np.roll(given.casing.column, 1))
    with pytest.raises(ValueError, match="do not match their displacements; give column -1"):
        run(replace(given, casing=mixed), 1e-7, 1)


def test_all_tips_at_once() -> None:
    """Every blade hits at the same step, and the casing is shared by all of them."""
    given = thrown(stage_problem(), 3.0)
    tight = replace(given.casing, clearance=0.02 * given.casing.clearance)
    given = replace(given, casing=tight, loads=())
    for cyclic in (True, False):
        state, chunk, _ = run(given, 1e-6, 3000, cyclic=cyclic)
        assert chunk.contacts.max() == 22
        assert state.statistics.complementarity_residual < 1e-10
        assert state.statistics.lcp_failures == 0
        assert ledger_residual(chunk) < 1e-8


@pytest.mark.parametrize("friction", [0.0, 0.1])
@pytest.mark.parametrize(("modes", "tips"), [(1, 6), (2, 6), (2, 22), (6, 22)])
def test_singular_delassus_matrices(modes: int, tips: int, friction: float) -> None:
    """More tips in contact than modes to move them, in a rigid wall: W has the modes' rank."""
    random = np.random.default_rng(modes + tips)
    radial = 0.1 + np.abs(random.normal(size=(tips, modes)))
    rotor = small_rotor(
        random.uniform(100.0, 300.0, modes),
        tips,
        damping_ratio=np.full(modes, 0.01),
        tip_radial=radial,
        tip_tangential=0.5 * random.normal(size=(tips, modes)),
        tip_angle=2.0 * np.pi * np.arange(tips) / tips,
    )
    start = {"rotor_velocity": np.full(modes, 1e3)}  # all tips are inside within a step
    loads = (Load(rotor=np.full(modes, 500.0), casing=np.zeros(1)),)
    given = problem(rotor, wall(1e-3), start=start, loads=loads, speed=200.0, friction=friction)
    state, chunk, _ = run(given, 1e-4, 800)
    assert state.statistics.contact_steps > 500
    assert state.statistics.complementarity_residual < 1e-10
    assert state.statistics.lcp_failures == 0
    assert chunk.gap.min() > -1e-13
    assert ledger_residual(chunk) < 1e-10


def test_tips_that_move_as_one_share_their_load() -> None:
    """Six equal rows: W is six times the same number, any sharing is right, the sum is known."""
    rotor = small_rotor(
        np.array([100.0]),
        tips=6,
        damping_ratio=np.array([0.5]),
        tip_radial=np.ones((6, 1)),
        tip_angle=np.arange(6.0),
    )
    load = Load(rotor=np.array([50.0]), casing=np.zeros(1))
    dt = 1e-4
    state, chunk, _ = run(problem(rotor, wall(1e-3), loads=(load,)), dt, 2000)
    assert chunk.contact_impulse[-1].sum() / dt == pytest.approx(50.0 - 100.0**2 * 1e-3, rel=1e-6)
    assert state.statistics.complementarity_residual < 1e-10


def rubbing(speed: float, sliding: Sliding, *, every: int = 1) -> Chunk:
    """A tip pressed on the casing at its node 0, both well damped, marched to rest.

    Rotor: radial mode of 100 rad/s, tangential one of 200. Casing: w of 300, u of 400 rad/s.
    """
    rotor = small_rotor(
        np.array([100.0, 200.0]),
        damping_ratio=np.full(2, 0.7),
        tip_radial=np.array([[1.0, 0.0]]),
        tip_tangential=np.array([[0.0, 1.0]]),
    )
    nodal = np.zeros((4, 4, 2))
    nodal[:, 0, 0] = nodal[:, 2, 1] = 1.0
    casing = small_casing(
        np.array([300.0, 400.0]), 1e-3, damping_ratio=np.full(2, 0.7), nodal=nodal
    )
    load = Load(rotor=np.array([50.0, 0.0]), casing=np.zeros(2))
    given = problem(rotor, casing, loads=(load,), speed=speed, friction=0.2, sliding=sliding)
    return run(given, 1e-4, 3000, every=every)[1]


@pytest.mark.parametrize("sliding", ["permanent", "signed"])
@pytest.mark.parametrize("speed", [3.0, -3.0])
def test_friction_drags_the_blade_back_and_the_casing_on(speed: float, sliding: Sliding) -> None:
    chunk = rubbing(speed, sliding)
    # Radial balance: 50 - 1e4 x = lambda = 9e4 w, x - w = 1 mm.
    w = 40.0 / 1e5
    force = 9e4 * w
    direction = np.sign(speed)
    np.testing.assert_allclose(chunk.rotor_displacement[-1, 0], 1e-3 + w, rtol=1e-6)
    np.testing.assert_allclose(chunk.casing_displacement[-1, 0], w, rtol=1e-6)
    np.testing.assert_allclose(
        chunk.rotor_displacement[-1, 1], -direction * 0.2 * force / 200.0**2, rtol=1e-6
    )
    np.testing.assert_allclose(
        chunk.casing_displacement[-1, 1], direction * 0.2 * force / 400.0**2, rtol=1e-6
    )
    assert chunk.contact_impulse[-1, 0] == pytest.approx(force * 1e-4, rel=1e-6)
    assert chunk.friction_impulse[-1, 0] == pytest.approx(direction * 0.2 * force * 1e-4, rel=1e-6)
    # The drive pays: what friction does to the two bodies is stored and damped in them.
    assert chunk.friction_work[-1] > 0.0
    assert ledger_residual(chunk) < 1e-10


@pytest.mark.parametrize("forward", [1.0, -1.0])
def test_signed_friction_at_standstill_takes_energy(forward: float) -> None:
    """A blade that swings on the wall is braked, whichever way it goes."""
    rotor = small_rotor(
        np.array([100.0, 200.0]),
        tip_radial=np.array([[1.0, 0.0]]),
        tip_tangential=np.array([[0.0, 1.0]]),
    )
    start = {"rotor": np.array([1e-3, 0.0]), "rotor_velocity": np.array([0.0, 0.5 * forward])}
    load = Load(rotor=np.array([20.0, 0.0]), casing=np.zeros(1))
    given = problem(rotor, wall(1e-3), start=start, loads=(load,), friction=0.2, sliding="signed")
    dt = 1e-5
    _, chunk, _ = run(given, dt, 500)
    assert chunk.friction_impulse[5, 0] == pytest.approx(forward * 0.2 * 10.0 * dt, rel=1e-6)
    assert (np.diff(chunk.friction_work[1:]) < 0.0).all()
    # Before it turns, the force 2 N against it is constant: closed form of the swing.
    offset, amplitude = forward * 2.0 / 200.0**2, 0.5 * forward / 200.0
    phase = 200.0 * chunk.time
    exact = -offset * (1.0 - np.cos(phase)) + amplitude * np.sin(phase)
    np.testing.assert_allclose(chunk.rotor_displacement[:, 1], exact, atol=1e-5 * abs(amplitude))


def uneven_wall(nodes: int, seed: int) -> tuple[ReducedCasing, CubicHermiteSpline]:
    """A rigid casing with a clearance that varies, and the same curve by SciPy over one turn."""
    random = np.random.default_rng(seed)
    clearance = np.column_stack(
        [random.uniform(1e-3, 2e-3, nodes), random.normal(scale=1e-3, size=nodes)]
    )
    casing = replace(wall(0.0, nodes), clearance=clearance)
    around = np.vstack([clearance, clearance[:1]])
    arc = np.linspace(0.0, 2.0 * np.pi, nodes + 1)  # radius 1: arc length is angle
    return casing, CubicHermiteSpline(arc, around[:, 0], around[:, 1])


@pytest.mark.parametrize("speed", [37.0, -37.0, 2.0 * np.pi * 100.0])
@pytest.mark.parametrize("nodes", [1, 3, 40])
def test_a_tip_passes_from_element_to_element(nodes: int, speed: float) -> None:
    """More than one turn, over node 0 in both senses; at 100 turns a second it lands on nodes."""
    casing, curve = uneven_wall(nodes, nodes)
    angle = np.array([0.0, 2.1, 5.9])
    rotor = small_rotor(np.ones(1), tips=3, tip_angle=angle)
    _, chunk, _ = run(problem(rotor, casing, speed=speed), 1e-3, 250)
    at = np.mod(angle + speed * chunk.time[:, None], 2.0 * np.pi)
    np.testing.assert_allclose(chunk.gap, curve(at), rtol=1e-10)


@pytest.mark.parametrize("tip_rotation", [False, True])
def test_the_place_of_a_tip_may_follow_its_tangential_displacement(tip_rotation: bool) -> None:
    casing, curve = uneven_wall(5, 9)
    rotor = small_rotor(np.array([40.0]), tip_tangential=np.ones((1, 1)), tip_angle=np.array([6.0]))
    start = {"rotor": np.array([0.6])}
    given = problem(rotor, casing, start=start, speed=5.0, tip_rotation=tip_rotation)
    _, chunk, _ = run(given, 1e-3, 400)
    swing = chunk.rotor_displacement[:, 0]
    assert swing.min() < -0.59
    at = np.mod(6.0 + 5.0 * chunk.time + swing * tip_rotation, 2.0 * np.pi)
    np.testing.assert_allclose(chunk.gap[:, 0], curve(at), rtol=1e-9)


def test_a_travelling_tip_feels_the_casing_under_it() -> None:
    """The gap closes by u_r and opens by the casing's w, interpolated with its slopes."""
    given = stage_problem()
    casing = given.casing
    moved = np.random.default_rng(3).normal(scale=1e-5, size=len(casing.frequency))
    given = replace(given, start=replace(given.start, casing=moved), loads=())
    _, chunk, _ = run(given, 1e-6, 200, every=20)
    fields = np.einsum("nkm,tm->tnk", casing.nodal[:, :2], chunk.casing_displacement)
    around = np.concatenate([fields, fields[:, :1]], axis=1)
    arc = casing.element_length * np.arange(len(casing.nodal) + 1)
    gap = np.empty((chunk.records, 22))
    for i, time in enumerate(chunk.time):
        wall_curve = CubicHermiteSpline(arc, around[i, :, 0], around[i, :, 1])
        at = np.mod(given.rotor.tip_angle + given.speed * time, 2.0 * np.pi) * casing.radius
        outward = given.rotor.tip_radial @ chunk.rotor_displacement[i]
        gap[i] = 1e-3 + wall_curve(at) - outward
    # A record holds the smallest gap since the one before.
    assert (chunk.gap[1:] <= gap[1:] + 1e-12).all()
    np.testing.assert_allclose(chunk.gap[0], gap[0], rtol=1e-10)
    steps = run(given, 1e-6, 200)[1]
    np.testing.assert_allclose(steps.gap[::20], gap, rtol=1e-9)
    np.testing.assert_array_equal(chunk.gap[1:], steps.gap[1:].reshape(10, 20, 22).min(axis=1))


def test_a_rigid_casing_needs_no_mode() -> None:
    rotor = small_rotor(np.array([100.0]), tip_radial=np.ones((1, 1)))
    chunks = []
    for casing in (wall(1e-3), small_casing(np.zeros(0), 1e-3)):
        load = Load(rotor=np.array([50.0]), casing=np.zeros(len(casing.frequency)))
        chunks.append(run(problem(rotor, casing, loads=(load,)), 1e-4, 500)[1])
    assert chunks[0].contact_impulse.sum() > 0.0
    assert chunks[1].casing_displacement.shape == (501, 0)
    np.testing.assert_array_equal(chunks[0].contact_impulse, chunks[1].contact_impulse)


@pytest.mark.parametrize("recess", [3e-4, -2e-4])
def test_a_short_blade_touches_later_and_a_long_one_sooner(recess: float) -> None:
    """A tip at constant speed meets a rigid wall after clearance + recess."""
    clearance, velocity, dt = 1e-3, 2.0, 1e-6
    rotor = small_rotor(np.zeros(1), tip_radial=np.ones((1, 1)), tip_recess=np.array([recess]))
    start = {"rotor_velocity": np.full(1, velocity)}
    touching = problem(rotor, wall(clearance), start=start)
    assert touching.initial_gap() == pytest.approx(clearance + recess)
    _, chunk, _ = run(touching, dt, 800)
    first = chunk.time[np.flatnonzero(chunk.contact_impulse[:, 0])[0]]
    assert first == pytest.approx((clearance + recess) / velocity, abs=2.0 * dt)
    assert chunk.rotor_displacement.max() == pytest.approx(clearance + recess, abs=1e-9)


def test_a_wall_that_stands_still_works_at_closing_only() -> None:
    """A mass that is thrown at a wall loses its energy there."""
    rotor = small_rotor(np.array([50.0]), tip_radial=np.ones((1, 1)))
    start = {"rotor_velocity": np.array([1.0])}
    _, chunk, _ = run(problem(rotor, wall(1e-3), start=start), 1e-5, 2000)
    assert chunk.contact_impulse.any()
    np.testing.assert_allclose(chunk.closing_work, chunk.normal_work, atol=1e-12)
    assert chunk.energy[-1] == pytest.approx(0.5 * (50.0 * 1e-3) ** 2, rel=0.02)


def test_a_wall_that_passes_a_pressed_tip_works_without_closing() -> None:
    """The tip follows a curved wall; only its first touch stops it."""
    casing, _ = uneven_wall(12, 3)
    flat = replace(casing, clearance=1e-3 + 0.01 * (casing.clearance - 1e-3))
    rotor = small_rotor(np.array([100.0]), damping_ratio=np.ones(1), tip_radial=np.ones((1, 1)))
    load = Load(rotor=np.array([50.0]), casing=np.zeros(1))
    given = problem(rotor, flat, loads=(load,), speed=5.0)
    _, chunk, _ = run(given, 1e-4, 4000)
    late = slice(2000, None)
    assert (chunk.contact_impulse[late, 0] > 0.0).all()
    passing = np.ptp((chunk.normal_work - chunk.closing_work)[late])
    assert passing > 1e-4
    assert np.ptp(chunk.closing_work[late]) < 0.01 * passing

"""Blades that follow one another in a flexible ring against marches of the whole stage."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from periodic_cases import case, decay, rub

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.periodic.blade import Blade, Grid
from bladewhirl.solvers.periodic.contact import Motion
from bladewhirl.solvers.periodic.ring import Ring
from bladewhirl.solvers.periodic.stability import _Structure, monodromy

RING = {
    "casing.type": "ring",
    "casing.elements": 64,
    "casing.support": "20 N/mm2",
    "casing.wall": {"width": "60 mm", "thickness": "8 mm"},
    "contact.friction": 0.1,
}
ORDERS = {"type": "engine-order", "order": 4, "phase": 2.0, "amplitude": "10 N"}


def bladed_ring(copies: int, damping: float, **changes: Any) -> ContactProblem:
    stage = {"bladed_disk.superelement.copies": copies, "damping.ratio": damping}
    return contact_problem(build_stage(case(**{**RING, **stage, **changes})))


def marched(problem: ContactProblem, blade: Blade, step: float, periods: int, records: int) -> Any:
    """A march from rest with a number of records in each period."""
    wall = replace(problem.casing, clearance=problem.clearance(np.inf))
    every = round(blade.period / records / step)
    closed = replace(problem, closure=None, casing=wall)
    scheme = CentralDifference(closed, blade.period / (every * records), every)
    _, chunk, end = scheme.advance(scheme.init(), every * records * periods + 1)
    assert end is None
    return chunk


def impulse_of_last_turn(chunk: Any, records: int) -> FloatArray:
    """Impulse on each of 16 blades in the last turn of two periods."""
    last = chunk.contact_impulse[-2 * records :].sum(axis=0)
    return np.asarray(last.reshape(16, -1).sum(axis=1), dtype=np.float64)


@pytest.mark.parametrize(
    "changes", [{"excitation": ORDERS}, pytest.param({}, marks=pytest.mark.slow)]
)
def test_sixteen_blades_move_as_in_a_march(changes: Any) -> None:
    problem, records = bladed_ring(16, 0.05, **changes), 16
    motion = rub(problem)
    blade = motion.grid.blade
    assert motion.impulse > 0.1
    chunk = marched(problem, blade, 1e-6, 16, records)
    each = impulse_of_last_turn(chunk, records)
    assert each == pytest.approx(motion.impulse, rel=1e-2)
    modes = len(blade.stiffness)
    rows = blade.contact.T
    expected = motion.modes[0][:: motion.grid.instants // records] @ rows
    last = chunk.rotor_displacement[-records - 1 : -1, :modes] @ rows
    assert last == pytest.approx(expected, abs=1e-2 * np.abs(expected).max())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speed", "stable"),
    [("5000 rpm", True), ("6000 rpm", False), ("8000 rpm", True), ("9000 rpm", True)],
)
def test_a_march_of_sixteen_blades_leaves_unstable_motions_only(speed: str, stable: bool) -> None:
    problem = bladed_ring(16, 0.05, **{"march.speed": speed})
    motion = rub(problem)
    blade = motion.grid.blade
    assert monodromy(motion).stable == stable
    each = impulse_of_last_turn(marched(problem, blade, 5e-7, 80, 1), 1) / motion.impulse
    assert (np.abs(each - 1.0).max() < 1e-2) == stable
    assert stable or np.ptp(each) > 0.1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("copies", "speed", "damping"),
    [(1, "10000 rpm", 0.03), (4, "7000 rpm", 0.04)],
)
def test_deviations_of_blades_and_ring_decay_as_in_a_march(
    copies: int, speed: str, damping: float
) -> None:
    changes = {
        "march.speed": speed,
        "casing.closure.amount": "0.12 mm",
        "casing.elements": 80,
    }
    problem = bladed_ring(copies, damping, **changes)
    motion = rub(problem)
    blade = motion.grid.blade
    chunk = marched(problem, blade, 5e-7, 160, 1)
    impulse = 2.0 * chunk.contact_impulse[-1].sum() / copies
    assert impulse == pytest.approx(motion.impulse, rel=5e-3)
    state = np.hstack([chunk.rotor_displacement * problem.rotor.frequency, chunk.rotor_velocity])
    largest = np.abs(monodromy(motion).multipliers[0])
    assert largest == pytest.approx(decay(state[50:], 0.93), abs=5e-3)


def test_passages_of_blades_lead_to_the_matrix_of_a_period() -> None:
    """A motion of two periods is another one with a period of a turn. The multipliers alone would
    not tell in which direction blades follow one another."""
    problem = bladed_ring(4, 0.05)
    motion = rub(problem)
    blade = motion.grid.blade
    by_passage = monodromy(motion).matrix
    fine = Grid(replace(blade, lobes=1), 2 * motion.grid.instants)
    twice = Motion(fine, np.tile(motion.normal, (2, 1)), np.tile(motion.angle, (2, 1)))
    exact = monodromy(twice).matrix
    assert np.abs(by_passage @ by_passage - exact).max() < 1e-9 * np.abs(exact).max()


@pytest.mark.parametrize("speed", ["7000 rpm", "-7000 rpm"])
def test_a_blade_is_where_the_one_ahead_was(speed: str) -> None:
    """Blade 1 is an eighth of a turn ahead of blade 0, which does the same an eighth of a turn
    later if the rotor turns forward, and earlier if it turns backward."""
    changes = {"march.speed": speed, "casing.elements": 16}
    blade = Blade.of_problem(bladed_ring(8, 0.05, **changes))
    motion = Motion.free(Grid(blade, 32))
    assert blade.lobes == 2
    eighth = 8  # instants, of 64 in a turn
    normal = np.random.default_rng(3).random(motion.normal.shape)
    whole = _Structure.of_motion(replace(motion, normal=normal))
    nodes = normal.shape[1]
    ahead = eighth if blade.speed > 0.0 else -eighth
    assert whole.normal[:, nodes : 2 * nodes] == pytest.approx(np.roll(normal, -ahead, axis=0))
    forces = np.repeat(whole.normal, 3, axis=1)
    assert np.roll(forces, -eighth, axis=0) @ whole.passed.T == pytest.approx(forces)


def test_a_constant_load_on_the_ring_moves_the_wall() -> None:
    problem = bladed_ring(2, 0.05)
    push = np.zeros(len(problem.casing.frequency))
    push[4] = 300.0
    still = np.zeros(len(problem.rotor.frequency))
    bent = replace(problem, loads=(Load(rotor=still, casing=push),))
    moved = Blade.of_problem(bent).clearance - Blade.of_problem(problem).clearance
    expected = problem.casing.nodal[:, 0, 4] * 300.0 / problem.casing.frequency[4] ** 2
    assert moved[:, 0] == pytest.approx(expected, abs=1e-12)


def test_harmonics_of_the_ring_are_its_modes() -> None:
    casing = bladed_ring(1, 0.05).casing
    ring = Ring.of_casing(casing)
    angle, force = casing.angle[:5], np.array([1.0, 0.3])
    by_modes = np.einsum(
        "nam,bm,b->na",
        casing.nodal[:5, ::2],
        casing.nodal[0, ::2] / casing.frequency**2,
        force,
    )
    assert ring.between(0.0, angle) @ force == pytest.approx(by_modes, abs=1e-3 * by_modes.max())


@pytest.mark.parametrize("speed", [700.0, -300.0])
def test_responses_to_harmonics_are_those_of_constant_forces_in_steps(speed: float) -> None:
    """The forces are the mean of those at both ends of each step; steps of the ring itself are
    exact, and repeat after a period. The harmonics converge slowly in velocities."""
    both = Ring.of_casing(bladed_ring(1, 0.05).casing)
    order, shape, mode = both.both_ways
    ring = Ring(order, both.frequency[mode], both.damping_ratio[mode], shape)
    instants, unit, harmonic = 16, 1000.0, 5
    step = 2.0 * np.pi / abs(speed) / instants
    carried, held = ring.transition(speed, unit, step)
    ahead = np.exp(2j * np.pi * harmonic / instants)
    matrix = ahead * np.eye(2) - carried
    state = np.linalg.solve(matrix, 0.5 * (1.0 + ahead) * held[..., None])[..., 0]
    expected = np.einsum("ks,ka,kb->sab", state, shape, shape.conj())
    expected[0] /= unit
    found = both.answers(1, speed, 1, np.zeros(1), instants)[:, harmonic]
    for one, other in zip(found, expected, strict=True):
        assert one == pytest.approx(other, abs=1e-2 * np.abs(other).max())


def test_loads_of_one_order_are_judged_together() -> None:
    """The cosine and the sine part alone are not the same on all blades; a standing wave on the
    blades is no engine order."""
    problem = bladed_ring(4, 0.05, excitation={**ORDERS, "order": 3})
    cosine, sine = problem.loads
    assert cosine.rotor.any()
    assert sine.rotor.any()
    Blade.of_problem(problem)
    for loads in ((cosine,), (sine,), (cosine, replace(sine, rotor=-sine.rotor))):
        with pytest.raises(ValueError, match="not fixed in space"):
            Blade.of_problem(replace(problem, loads=loads))
    opposite = replace(cosine, rotor=-(1.0 + 1e-15) * cosine.rotor)
    assert not Blade.of_problem(replace(problem, loads=(cosine, opposite))).loads


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"bladed_disk.mistuning": {"stiffness_spread": 0.01}}, "mistuning"),
        (
            {
                "casing.struts": [
                    {"angle": "90 deg", "length": "50 mm", "width": "9 mm", "thickness": "5 mm"}
                ]
            },
            "not uniform",
        ),
        ({"casing.support": 0.0}, "no stiffness"),
        ({"march.speed": 0.0, "excitation": ORDERS}, "no period"),
    ],
)
def test_what_does_not_follow_one_another(changes: Any, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        Blade.of_problem(bladed_ring(4, 0.05, **changes))

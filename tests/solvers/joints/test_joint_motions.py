"""Periodic motions with joints against linear limits, closed forms and an independent march."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from joint_cases import blade, tables
from joint_march import Wheel
from long_cases import slow_except
from march_grid import MarchGrid

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.joints.wheel import DIRECTIONS, JointedWheel
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.solvers.periodic import joint_law
from bladewhirl.solvers.periodic.joint_law import OPEN, SLIPPING, STUCK
from bladewhirl.solvers.periodic.joint_search import (
    _by_share,
    _errors,
    _matrix,
    joint_motion,
    solve,
)
from bladewhirl.solvers.periodic.joint_stability import (
    Deviations,
    largest_multiplier,
    multipliers,
)
from bladewhirl.solvers.periodic.joints import JointGrid, JointMotion

MODES, ORDER = 8, 2


def wheel(folder: Path, speed: float = 3000.0, **joint: object) -> JointedWheel:
    own = tables(folder, **joint)
    own |= {"reduction": {"free_interface_modes": MODES}, "march": {"speed": f"{speed} rpm"}}
    stage = build_stage(bw.case_from(own))
    assert isinstance(stage, Matrices)
    return jointed_wheel(stage)


def linear(given: JointedWheel, held: list[int]) -> ComplexArray:
    """Amplitudes of the loaded point if some values of the joints do not move."""
    flexible = given.flexibility(ORDER, ORDER * given.speed)
    force = np.zeros(given.values, dtype=np.complex128)
    if held:
        force[held] = np.linalg.solve(flexible[np.ix_(held, held)], -given.unloaded(ORDER)[held])
    return np.asarray(given.at_points(ORDER, force)[0])


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("joint", "held"),
    [
        ({"friction": 1e4, "preload": "1 kN"}, [0, 1, 2]),
        ({"friction": 0.0, "preload": "1 kN"}, [0]),
        ({"gap": "20 mm"}, []),
    ],
    ids=["stuck", "frictionless", "free"],
)
def test_limits_are_linear(
    tmp_path: Path, joint: dict[str, object], held: list[int], sign: float
) -> None:
    given = wheel(tmp_path, sign * 3000.0, **joint)
    found = joint_motion(given)
    amplitude = given.at_points(ORDER, found.of_order(ORDER))[0]
    assert amplitude == pytest.approx(linear(given, held), rel=1e-9)


def three_blades(folder: Path, overclosure: float, blades: int = 3, order: int = 1) -> JointedWheel:
    file = folder / "three.npz"
    bw.write_superelement(file, blade(blades))
    own = tables(folder, overclosure=overclosure, friction=0.3) | {
        "bladed_disk": {"superelement": {"file": str(file), "copies": blades}},
        "reduction": {"free_interface_modes": MODES},
        "damping": {"ratio": 0.1},
    }
    own["excitation"] |= {"order": order, "amplitude": 20.0}
    stage = build_stage(bw.case_from(own))
    assert isinstance(stage, Matrices)
    return jointed_wheel(stage)


@pytest.mark.parametrize("overclosure", slow_except([1.2e-3, 8e-4, 5e-4, 3e-4], 1.2e-3, 3e-4))
def test_a_motion_is_that_of_a_march_of_all_blades(tmp_path: Path, overclosure: float) -> None:
    given = three_blades(tmp_path, overclosure)
    found = joint_motion(given)
    amplitude = np.abs(given.at_points(1, found.of_order(1)))[0]
    marched = Wheel(3, MODES, 0.1, given.speed, 1, 20.0, -overclosure, 0.3, np.pi / 6.0)
    coarse, fine = (marched.march(steps, 8)[0][0] for steps in (64, 128))
    assert amplitude[1:] == pytest.approx(fine[1:], rel=3e-3)
    assert coarse[1:] == pytest.approx(fine[1:], rel=3e-3)
    assert (found.states == SLIPPING).any()
    assert (found.states == OPEN).any() == (overclosure < 4e-4)


@pytest.mark.slow
@pytest.mark.parametrize("overclosure", [8e-4, 3e-4])
def test_a_wave_is_a_march_of_all_blades_at_equal_instants(
    tmp_path: Path, overclosure: float
) -> None:
    given = three_blades(tmp_path, overclosure)
    marched = Wheel(
        3, MODES, 0.1, given.speed, 1, 20.0, -overclosure, 0.3, np.pi / 6.0, close=1e-12
    )
    grid = MarchGrid(given, 31)
    normal = marched.march(grid.instants, 48)[1][:, 0]
    found = solve(joint_motion(given).on(grid))
    assert found.force[:, 0, 0] == pytest.approx(normal, rel=1e-6, abs=1e-6 * normal.max())


def test_the_work_of_engine_orders_is_that_of_damping_and_friction(tmp_path: Path) -> None:
    given = wheel(tmp_path, 7000.0, preload="3 N")
    found = joint_motion(given)
    assert (found.states == SLIPPING).any()
    assert (found.states == STUCK).any()
    lost = brought = 0.0
    for h, amplitude in enumerate(found.harmonics):
        order = h * found.grid.order
        wave, w = given.wave(order), order * given.speed
        pushed = wave.rows.conj().T @ given.spread(order, amplitude)
        pushed = pushed + given.loads.get(order, 0.0)
        modal = wave.admittance(w) * pushed
        lost += 0.5 * w**2 * float((np.diag(wave.damping) * np.abs(modal) ** 2).sum())
        if order in given.loads:
            brought = 0.5 * w * float(np.imag(np.vdot(modal, given.loads[order])))
            static = given.joined(order, given.static[order])
            brought += 0.5 * w * float(np.imag(np.vdot(amplitude, static)))
    period = found.grid.period
    assert period * brought == pytest.approx(period * lost + found.work.sum(), rel=1e-9)


def test_forces_satisfy_the_contact_law(tmp_path: Path) -> None:
    found = joint_motion(wheel(tmp_path, 7000.0, preload="3 N"))
    force, moved, states = found.at(4 * found.grid.instants)
    normal, size = force[..., 0], np.linalg.norm(force[..., 1:], axis=-1)
    assert normal.min() >= 0.0
    assert (size <= 0.3 * normal * (1.0 + 1e-9)).all()
    gap = moved[..., 0] + found.grid.wheel.gap
    assert np.abs(gap).max() < 1e-12
    slip = np.roll(moved[..., 1:], -1, axis=0) - np.roll(moved[..., 1:], 1, axis=0)
    speed = np.linalg.norm(slip, axis=-1)
    fast = (states == SLIPPING) & (speed > 0.1 * speed.max())
    along = (force[..., 1:] * slip).sum(axis=-1)[fast]
    assert along == pytest.approx(-(size * speed)[fast], rel=1e-2)


@pytest.mark.parametrize("smooth", [0.0, 0.1])
def test_derivatives_are_those_of_the_equations(tmp_path: Path, smooth: float) -> None:
    grid = JointGrid(wheel(tmp_path, 7000.0, preload="3 N"), 8)
    noise = np.random.default_rng(1).normal(size=(2, *grid.load.shape)) * grid.size
    motion = JointMotion(grid, JointMotion.at_rest(grid).parts + 0.3 * noise[0])
    smooth *= grid.size

    def error(length: float, share: float) -> FloatArray:
        moved = replace(motion, parts=motion.parts + length * noise[1])
        return _errors(moved, smooth, share)[0].ravel()

    slope = _errors(motion, smooth, 0.7)[1]
    by_force, by_share = _matrix(grid, slope), _by_share(grid, slope)
    change = (error(1e-6, 0.7) - error(-1e-6, 0.7)) / 2e-6
    assert by_force @ noise[1].ravel() == pytest.approx(change, rel=1e-5, abs=1e-5 * grid.size)
    change = (error(0.0, 0.7 + 1e-6) - error(0.0, 0.7 - 1e-6)) / 2e-6
    assert by_share == pytest.approx(change, rel=1e-5, abs=1e-5 * grid.size)


def test_a_smooth_law_comes_near_the_true_one() -> None:
    trial = np.random.default_rng(2).normal(size=(50, 2, 3))
    friction = np.array([0.3, 0.6])
    true, near = (joint_law.projected(trial, friction, e).force for e in (0.0, 1e-6))
    assert near == pytest.approx(true, abs=1e-5)


def test_stuck_joints_have_no_mean_tangential_force(tmp_path: Path) -> None:
    found = joint_motion(wheel(tmp_path, preload="1 kN"))
    assert (found.states == STUCK).all()
    assert np.abs(found.parts[0, 1:]).max() < 1e-9 * np.abs(found.parts).max()


def test_a_motion_at_rest_has_the_static_forces(tmp_path: Path) -> None:
    rest = JointMotion.at_rest(JointGrid(wheel(tmp_path, preload="200 N"), 8))
    assert rest.parts[0] == pytest.approx([200.0, 0.0, 0.0])
    assert rest.parts.shape == (17, DIRECTIONS)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_multipliers_of_free_blades_are_those_of_their_modes(tmp_path: Path, sign: float) -> None:
    given = wheel(tmp_path, sign * 3000.0, gap="20 mm")
    motion = joint_motion(given)
    found = np.abs(multipliers(motion))
    rates = np.diag(given.damping[0]) / 2.0
    slow = np.exp(-rates * motion.grid.period)[:4]
    assert found[: 14 * len(slow)] == pytest.approx(np.repeat(slow, 14), rel=1e-9)


@pytest.mark.slow
def test_deviations_decay_as_in_a_march(tmp_path: Path) -> None:
    overclosure = 8e-4
    given = three_blades(tmp_path, overclosure)
    largest = abs(multipliers(joint_motion(given))[0])
    marched = Wheel(3, MODES, 0.1, given.speed, 1, 20.0, -overclosure, 0.3, np.pi / 6.0, close=1e-9)
    early, late, end = (marched.march(96, periods)[1][:, 0] for periods in (8, 16, 32))
    decay = (np.linalg.norm(late - end) / np.linalg.norm(early - end)) ** (1.0 / 8.0)
    assert largest == pytest.approx(decay, rel=0.03)


@pytest.mark.parametrize("order", [2, 3])
def test_multipliers_of_groups_are_those_of_all_blades(tmp_path: Path, order: int) -> None:
    motion = joint_motion(three_blades(tmp_path, 1.5e-3, 6, order))
    assert 0.0 < (motion.states == SLIPPING).mean() < 1.0
    every = Deviations(motion)
    assert every.groups == order
    every.groups = 1
    whole = np.abs(np.linalg.eigvals(every.passage(0))) ** every.passages
    assert np.abs(multipliers(motion)) == pytest.approx(np.sort(whole)[::-1], rel=1e-6, abs=1e-7)
    assert largest_multiplier(motion) == pytest.approx(whole.max(), rel=1e-9)


def test_a_wheel_in_one_piece_has_the_motion_of_its_blades(tmp_path: Path) -> None:
    blades = three_blades(tmp_path, 8e-4)
    count, modes = blades.blades, blades.stiffness.shape[1]
    every = np.eye(count)
    values = blades.contact.shape[1]
    shapes = blades.contact[0]
    wheel = replace(
        blades,
        stiffness=blades.stiffness.reshape(1, -1),
        damping=np.kron(every, blades.damping[0])[None],
        contact=np.einsum("ab,im->aibm", every, shapes).reshape(count, values, -1),
        compliance=np.einsum("ab,ij->aibj", every, blades.compliance[0, :, 0]),
        loads={
            order: np.kron(np.exp(2j * np.pi * order * np.arange(count) / count), load)
            for order, load in blades.loads.items()
        },
        points=np.pad(blades.points, ((0, 0), (0, (count - 1) * modes))),
        points_by_force=np.einsum("b,pi->pbi", every[0], blades.points_by_force[:, 0]),
    )
    one, other = joint_motion(blades), joint_motion(wheel)
    assert other.parts == pytest.approx(one.parts, rel=1e-6, abs=1e-6 * np.abs(one.parts).max())
    assert other.of_points == pytest.approx(one.of_points, rel=1e-6, abs=1e-9)
    largest = [np.abs(multipliers(each)[:6]) for each in (one, other)]
    assert largest[1] == pytest.approx(largest[0], rel=1e-6)

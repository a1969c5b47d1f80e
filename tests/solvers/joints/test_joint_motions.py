"""Periodic motions with joints against linear limits, closed forms and an independent march."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from joint_cases import blade, tables
from joint_march import Wheel

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.joints.wheel import DIRECTIONS, JointedWheel
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.solvers.periodic.joint_paths import joint_motion
from bladewhirl.solvers.periodic.joints import (
    OPEN,
    SLIPPING,
    STUCK,
    JointGrid,
    JointMotion,
    _stepped,
    stuck,
)

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


@pytest.mark.parametrize("overclosure", [1.2e-3, 8e-4, 5e-4, 3e-4])
def test_a_motion_is_that_of_a_march_of_all_blades(tmp_path: Path, overclosure: float) -> None:
    file = tmp_path / "three.npz"
    bw.write_superelement(file, blade(3))
    own = tables(tmp_path, overclosure=overclosure, friction=0.3) | {
        "bladed_disk": {"superelement": {"file": str(file), "copies": 3}},
        "reduction": {"free_interface_modes": MODES},
        "damping": {"ratio": 0.1},
    }
    own["excitation"] |= {"order": 1, "amplitude": 20.0}
    stage = build_stage(bw.case_from(own))
    assert isinstance(stage, Matrices)
    given = jointed_wheel(stage)
    found = joint_motion(given)
    amplitude = np.abs(given.at_points(1, found.of_order(1)))[0]
    marched = Wheel(3, MODES, 0.1, given.speed, 1, 20.0, -overclosure, 0.3, np.pi / 6.0)
    coarse, fine = (marched.march(steps, 8)[0][0] for steps in (64, 128))
    assert amplitude[1:] == pytest.approx(fine[1:], rel=3e-3)
    assert coarse[1:] == pytest.approx(fine[1:], rel=3e-3)
    assert (found.states == SLIPPING).any()
    assert (found.states == OPEN).any() == (overclosure < 4e-4)


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
    period = found.grid.period  # fast modes have added damping, which is not counted
    assert period * brought == pytest.approx(period * lost + found.work.sum(), rel=2e-3)


def test_forces_satisfy_the_contact_law(tmp_path: Path) -> None:
    found = joint_motion(wheel(tmp_path, 7000.0, preload="3 N"))
    normal, size = found.normal, np.linalg.norm(found.tangential, axis=-1)
    assert normal.min() >= 0.0
    assert np.abs(found.gap).max() < 1e-12
    assert (size <= 0.3 * normal * (1.0 + 1e-6)).all()
    slips = found.states == SLIPPING
    along = (found.tangential * found.slip).sum(axis=-1)[slips]
    opposed = -size[slips] * np.linalg.norm(found.slip, axis=-1)[slips]
    assert along == pytest.approx(opposed, rel=1e-5, abs=1e-12)


def test_a_derivative_is_that_of_the_equations(tmp_path: Path) -> None:
    """Near a solution, the error falls with the square of the distance."""
    found = joint_motion(wheel(tmp_path, 7000.0, preload="3 N"))
    noise = np.random.default_rng(1).normal(size=found.force.shape)

    def left(size: float) -> float:
        near = replace(found, force=found.force + size * noise)
        return float(np.abs(_stepped(near, found.states).force - found.force).max())

    assert left(1e-5) < 0.05 * left(1e-4)


def test_all_blades_have_the_same_instants(tmp_path: Path) -> None:
    given = wheel(tmp_path)
    grid = JointGrid.near(given, 64)
    assert grid.instants % 14 == 0
    assert grid.instants >= 64
    assert grid.shift * given.blades == grid.instants * ORDER


def test_stuck_joints_have_no_mean_tangential_force(tmp_path: Path) -> None:
    found = stuck(JointGrid.near(wheel(tmp_path, preload="1 kN"), 64))
    means: FloatArray = np.abs(found.tangential.mean(axis=0))
    assert means.max() < 1e-9 * np.abs(found.force).max()


def test_a_motion_at_rest_has_the_static_forces(tmp_path: Path) -> None:
    rest = JointMotion.at_rest(JointGrid.near(wheel(tmp_path, preload="200 N"), 64))
    assert rest.normal == pytest.approx(200.0)
    assert rest.force.shape[1] == DIRECTIONS

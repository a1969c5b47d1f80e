"""Rubs of all blades, with joints and without, against marches, one blade, and balances."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from joint_cases import blade, tables
from joint_march import Wheel
from march_grid import MarchGrid

import bladewhirl as bw
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.joints.wheel import JointedWheel
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.solvers.periodic.joint_law import OPEN
from bladewhirl.solvers.periodic.joint_rub import rub
from bladewhirl.solvers.periodic.joint_search import SMOOTH, joint_motion, loaded, solve
from bladewhirl.solvers.periodic.joints import JointGrid

MODES, OVERCLOSURE = 8, 8e-4
CLOSED = {"amount": "2 mm", "time_constant": "1 ms"}
"""The wall is that of `wheel` at the end; at the start no tip is beyond it."""

OVAL = ((2, 2e-6),)


def case(
    folder: Path, lobes: tuple[tuple[int, float], ...], clearance: float, **own: Any
) -> bw.Case:
    """Three damped blades with a joint in a wall."""
    file = folder / "three.npz"
    bw.write_superelement(file, blade(3))
    given = tables(folder, overclosure=OVERCLOSURE, friction=0.3) | {
        "bladed_disk": {"superelement": {"file": str(file), "copies": 3}},
        "reduction": {"free_interface_modes": MODES},
        "damping": {"ratio": 0.1},
        "casing": {
            "type": "rigid",
            "clearance": clearance + 2e-3,
            "clearance_lobes": [{"lobes": n, "amplitude": high} for n, high in lobes],
            "closure": CLOSED,
        },
        "contact": {"friction": 0.2, "sliding": "full"},
    }
    given["excitation"] |= {"order": 1, "amplitude": 20.0}
    return bw.case_from(given | own)


def wheel(given: bw.Case) -> JointedWheel:
    stage = build_stage(given)
    assert isinstance(stage, Matrices)
    return jointed_wheel(stage, contact_problem(stage, steps=False))


@pytest.mark.slow
def test_a_rub_is_a_march_of_all_blades_at_equal_instants(tmp_path: Path) -> None:
    clearance = 2e-6
    given = wheel(case(tmp_path, clearance=clearance, lobes=OVAL))
    marched = Wheel(
        *(3, MODES, 0.1, given.speed, 1, 20.0, -OVERCLOSURE, 0.3, np.pi / 6.0),
        close=1e-12,
        wall=(clearance, OVAL[0][1], OVAL[0][0], 0.2),
    )
    grid = MarchGrid(given, 31)
    normal = marched.march(grid.instants, 24)[1]
    found = solve(joint_motion(given).on(grid))
    shift = grid.instants // 3 * np.arange(3)
    every = np.stack([np.roll(found.force[..., 0], -turned, axis=0) for turned in shift], axis=2)
    every = every.reshape(grid.instants, -1)
    assert (normal[:, 3:] > 0.0).any(axis=0).all()
    assert every == pytest.approx(normal, rel=1e-6, abs=1e-6 * normal.max())


def test_a_wall_that_is_far_leaves_the_motion_of_the_joints(tmp_path: Path) -> None:
    given = case(tmp_path, clearance=5e-3, lobes=OVAL)
    stage = build_stage(given)
    assert isinstance(stage, Matrices)
    alone, together = (
        loaded(JointGrid(each, 16), SMOOTH[0]) for each in (jointed_wheel(stage), wheel(given))
    )
    amplitude = [each.grid.wheel.at_points(1, each.of_order(1)) for each in (alone, together)]
    assert amplitude[1] == pytest.approx(amplitude[0], rel=1e-6)


@pytest.mark.parametrize("sliding", ["permanent", "full"])
def test_the_work_of_loads_and_drive_is_that_of_damping_joints_and_friction(
    tmp_path: Path, sliding: str
) -> None:
    contact = {"friction": 0.2, "sliding": sliding}
    given = wheel(case(tmp_path, clearance=2e-6, lobes=OVAL, contact=contact))
    found = loaded(JointGrid(given, 16), SMOOTH[0])
    for harmonics in (32, 64):
        found = solve(found.on(JointGrid(given, harmonics)))
    lost = brought = 0.0
    for h, force in enumerate(found.harmonics):
        wave, w = given.wave(h), h * given.speed
        pushed = wave.rows.conj().T @ given.spread(h, force) + given.loads.get(h, 0.0)
        modal = wave.admittance(w) * pushed
        each = np.diag(wave.damping) * np.abs(modal) ** 2
        lost += np.pi * h * w * float(each.sum())
        if h in given.loads:
            brought = np.pi * h * float(np.imag(np.vdot(modal, given.loads[h])))
            brought += np.pi * h * float(np.imag(np.vdot(force, given.joined(h, given.static[h]))))
    at_wall = rub(found)
    assert (found.states[:, 1] == OPEN).any()
    assert at_wall.heat > 0.0
    spent = lost + found.work[0] + at_wall.heat
    assert brought + at_wall.drive - at_wall.heat == pytest.approx(lost + found.work[0], rel=1e-5)
    assert brought + at_wall.drive == pytest.approx(spent, rel=1e-6)

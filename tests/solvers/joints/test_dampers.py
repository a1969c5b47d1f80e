"""Periodic motions with dampers between blades: linear limits, balance, and marches."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from joint_cases import BLADES, blade, tables
from scipy.spatial.transform import Rotation

import bladewhirl as bw
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.joints.wheel import JointedWheel
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.superelements.superelement import Superelement
from bladewhirl.solvers.periodic.joint_law import OPEN, SLIPPING
from bladewhirl.solvers.periodic.joint_search import _errors, _matrix, joint_motion, rough_motion
from bladewhirl.solvers.periodic.joint_stability import largest_multiplier
from bladewhirl.solvers.periodic.joints import JointGrid, JointMotion
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

ORDER, RECORDS = 2, 64
FORCE, MASS = 3.0, 0.05


def damped(folder: Path, friction: float = 0.3, **wedge: Any) -> bw.Case:
    radius = FORCE / MASS / (100.0 * np.pi) ** 2
    wedge = {"angle": "30 deg", "mass": MASS, "radius": radius} | wedge
    joint = {"name": "damper", "kind": "wedge", "friction": friction, "wedge": wedge}
    own = tables(folder) | {
        "joint": [joint],
        "reduction": {"free_interface_modes": 8},
        "damping": {"ratio": 0.1},
        "march": {
            "speed": "3000 rpm",
            "revolutions": 30,
            "steps_per_revolution": 2048,
            "record_step": 0.02 / RECORDS,
        },
    }
    return bw.case_from(own)


def wheel(given: bw.Case) -> JointedWheel:
    stage = build_stage(given)
    assert isinstance(stage, Matrices)
    return jointed_wheel(stage)


@pytest.mark.parametrize(("friction", "held"), [(0.0, [0]), (1e4, [0, 1, 2])])
@pytest.mark.parametrize("axial", ["held", "free"])
def test_limits_are_linear(tmp_path: Path, axial: str, friction: float, held: list[int]) -> None:
    given = wheel(damped(tmp_path, friction=friction, axial=axial))
    found = joint_motion(given)
    moved = given.at_points(ORDER, found.of_order(ORDER))
    assert moved == pytest.approx(given.limit(ORDER, held), rel=1e-9, abs=1e-16)
    assert not (found.states == OPEN).any()
    assert largest_multiplier(found) < 1.0 + 1e-6


@pytest.mark.parametrize("axial", ["held", "free"])
def test_mean_forces_balance_the_centrifugal_force(tmp_path: Path, axial: str) -> None:
    given = wheel(damped(tmp_path, axial=axial))
    found = joint_motion(given)
    assert 0.3 < (found.states == SLIPPING).mean() < 1.0
    mean = found.harmonics[0].real
    assert given.pull.tolist() == pytest.approx([FORCE, *np.zeros(len(given.pull) - 1)])
    assert given.dampers.T @ mean == pytest.approx(-given.pull, abs=1e-9 * FORCE)
    assert bool(found.walks) == (axial == "free")


def test_derivatives_are_those_of_the_equations(tmp_path: Path) -> None:
    grid = JointGrid(wheel(damped(tmp_path, axial="free")), 8)
    noise = np.random.default_rng(1).normal(size=(2, *grid.load.shape)) * grid.size
    motion = JointMotion(grid, JointMotion.at_rest(grid).parts + 0.1 * noise[0])
    smooth = 0.1 * grid.size
    after, before = (
        _errors(replace(motion, parts=motion.parts + length * noise[1]), smooth, 0.7)[0]
        for length in (1e-6, -1e-6)
    )
    change = (after - before).ravel() / 2e-6
    by_force = _matrix(grid, _errors(motion, smooth, 0.7)[1])
    assert by_force @ noise[1].ravel() == pytest.approx(change, rel=1e-5, abs=1e-5 * grid.size)


def in_one_piece(blades: int) -> Superelement:
    """All blades of `joint_cases` as one body."""
    part = blade(blades)
    nodes = len(np.asarray(part.mass)) // 3
    angle = 2.0 * np.pi / blades * np.arange(blades)
    turns = [Rotation.from_rotvec([0.0, 0.0, each]).as_matrix() for each in angle]
    global_axes = la.block_diag(*(np.kron(np.eye(nodes), each) for each in turns))
    mass, stiffness = (
        global_axes @ np.kron(np.eye(blades), np.asarray(each)) @ global_axes.T
        for each in (part.mass, part.stiffness)
    )
    assert part.recovery is not None
    ahead = 3 * nodes * np.arange(blades)[:, None, None]
    return replace(
        part,
        mass=mass,
        stiffness=stiffness,
        contact_position=np.vstack([part.contact_position @ each.T for each in turns]),
        contact_dofs=(part.contact_dofs + ahead).reshape(-1, 3),
        points=np.vstack([part.points @ each.T for each in turns]),
        recovery=np.kron(np.eye(blades), np.asarray(part.recovery)),
    )


def test_dampers_of_a_wheel_in_one_piece_are_those_of_its_blades(tmp_path: Path) -> None:
    found = []
    for kind, part in (("blade", blade(3)), ("wheel", in_one_piece(3))):
        file = tmp_path / f"own_{kind}.npz"
        bw.write_superelement(file, part)
        own = kind == "blade"
        changes = {
            "bladed_disk.superelement": {"file": str(file), "kind": kind, "copies": 3},
            "reduction.free_interface_modes": 8 if own else 24,
            "excitation.order": 1,
            "excitation.points": [0] if own else [0, 2, 4],
        }
        found.append(rough_motion(wheel(bw.with_values(damped(tmp_path, axial="free"), changes))))
    one, other = found
    assert (one.states == SLIPPING).any()
    assert other.forces == pytest.approx(one.forces, abs=1e-6 * FORCE)
    assert other.walks == pytest.approx(one.walks, rel=1e-6)
    assert largest_multiplier(other) == pytest.approx(largest_multiplier(one), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("axial", ["held", "free"])
def test_a_motion_is_that_of_a_march_of_all_blades(tmp_path: Path, axial: str) -> None:
    given = damped(tmp_path, axial=axial)
    motion = joint_motion(wheel(given))
    one = np.abs(motion.grid.wheel.at_points(ORDER, motion.of_order(ORDER)))[-1]
    assert largest_multiplier(motion) < 1.0
    data, _ = march_in_memory(prepare(given))
    moved = data["contact_displacement"].values[-RECORDS:, 2::3]
    tips = np.abs(np.fft.fft(moved, axis=0)[ORDER]) * 2.0 / RECORDS
    assert tips[:, 1:] == pytest.approx(np.tile(one[1:], (BLADES, 1)), rel=1e-3)
    work = np.diff(data["joint_work"].values[[-1 - RECORDS, -1]].sum(axis=1))[0] / ORDER
    assert work / BLADES == pytest.approx(motion.work.sum(), rel=0.01)
    place = data["damper_displacement"].values[[-1 - RECORDS, -1], :, 2]
    walked = np.diff(place, axis=0)[0] / ORDER
    if axial == "free":
        assert walked == pytest.approx(np.full(BLADES, motion.walks["damper"]), rel=2e-3)

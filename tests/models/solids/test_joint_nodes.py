"""Nodes of joints from surfaces of solids."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from solid_meshes import SECTORS, STEEL, bladed_sector

import bladewhirl as bw
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.superelements.superelement import Superelement
from bladewhirl.postprocess.run.measures import energy_residual
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

FACES = {"joint_left": "clockwise", "joint_right": "ahead"}


def sector(**given: Any) -> Superelement:
    mesh = bladed_sector("hexahedron20", shroud=True)
    sides: dict[str, Any] = {"left": "left", "right": "right", "copies": SECTORS}
    return bw.mesh3d(mesh, **STEEL, **sides, contacts=2, stress=False, **given)


@pytest.mark.parametrize("count", [1, 4, None])
def test_pairs_are_opposite_to_each_other(count: int | None) -> None:
    part = sector(**FACES, joint_nodes=count)
    assert part.joint_left is not None
    assert part.joint_right is not None
    left = rotate(part.contact_position[part.joint_left], 2.0 * np.pi / SECTORS)
    right = part.contact_position[part.joint_right]
    assert len(left) == (count or 8)
    assert np.hypot(*left[:, :2].T) == pytest.approx(np.hypot(*right[:, :2].T))
    assert len(np.unique(np.r_[part.joint_left, part.joint_right])) == 2 * len(left)
    assert 1 <= part.contacts - 2 * len(left) <= 2  # those of tips that are in no pair
    if count == 4:
        assert np.ptp(left, axis=0).max() == pytest.approx(np.ptp(right, axis=0).max())


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"joint_left": "clockwise"}, "joint_left"),
        ({"joint_left": "clockwise", "joint_right": "clockwise"}, "joint_right"),
        ({"joint_left": "ahead", "joint_right": "clockwise"}, "joint_right"),
        ({**FACES, "joint_nodes": 99}, "joint_nodes"),
    ],
)
def test_pairs_that_cannot_be_are_refused(given: dict[str, Any], key: str) -> None:
    with pytest.raises(CaseError) as refused:
        sector(**given)
    assert refused.value.faults[0].key == key


def test_a_wheel_of_sectors_marches_with_them(tmp_path: Path) -> None:
    file = tmp_path / "sector.npz"
    bw.write_superelement(file, sector(**FACES, joint_nodes=1))
    case = bw.case_from(
        {
            "bladed_disk": {"superelement": {"file": str(file)}},
            "reduction": {"free_interface_modes": 4},
            "damping": {"ratio": 0.05},
            "casing": {"type": "rigid", "clearance": "10 mm"},
            "excitation": {"type": "engine-order", "order": 3, "amplitude": 2e3},
            "joint": [{"overclosure": "10 um", "friction": 0.2}],
            "march": {"speed": "9000 rpm", "revolutions": 2},
        }
    )
    prepared = prepare(case)
    assert prepared.scheme.cyclic[0]
    data, report = march_in_memory(prepared)
    assert report["unsolved_steps"] == 0
    assert energy_residual(data) < 1e-8
    assert data["joint_steps"].values[..., 2].any()
    timing = prepared.timing
    scheme = CentralDifference(
        prepared.problem, timing.time_step, timing.record_every, cyclic=False
    )
    dense, _ = march_in_memory(replace(prepared, scheme=scheme))
    force = data["joint_force"].values
    assert dense["joint_force"].values == pytest.approx(force, abs=1e-6 * np.abs(force).max())

"""A stage of beams as a superelement."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from rod_blade import blade, tables

import bladewhirl as bw
from bladewhirl.models.stage.build import steady_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory


@pytest.mark.parametrize("clamped", [True, False])
def test_a_stage_as_a_wheel_has_its_frequencies_and_motions(
    tmp_path: Path, *, clamped: bool
) -> None:
    small = {"blades": 5, "elements_per_blade": 3}
    shaft = {"clamped": clamped, "stiffness": 2e7, **({} if clamped else {"stiffness_y": 1e7})}
    stage = build_beams(bw.case_from({"bladed_disk": small, "shaft": shaft}))
    bw.write_superelement(tmp_path / "wheel.npz", stage.to_superelement())
    case = bw.case_from(
        {
            "bladed_disk": {"superelement": {"file": str(tmp_path / "wheel.npz"), "kind": "wheel"}},
            "casing": {"type": "rigid"},
            "shaft": shaft | {"clamped": False},
            "reduction": {"free_interface_modes": 12},
        }
    )
    wheel = build_matrices(case)
    structure = stage.disk.structure
    squares, shapes = la.eigh(structure.stiffness.toarray(), structure.mass.toarray())
    assert wheel.reduced.frequency == pytest.approx(np.sqrt(squares[:12]), rel=1e-9)
    assert wheel.copies == 1
    # Static flexibility of the tips: modes and residual together.
    static = shapes[stage.disk.tip_radial] / np.sqrt(squares)
    kept = wheel.reduced.contact[::3] / wheel.reduced.frequency
    flexibility = kept @ kept.T + wheel.reduced.compliance[::3, ::3]
    assert flexibility == pytest.approx(static @ static.T, rel=1e-8)
    tips = wheel.reduced.points.reshape(-1, 3, 12)[stage.disk.model.tips]
    angle = stage.disk.tip_angles[:, None]
    radial = np.cos(angle) * tips[:, 0] + np.sin(angle) * tips[:, 1]
    assert radial == pytest.approx(wheel.reduced.contact[::3], abs=1e-9)


@pytest.mark.parametrize("effects", ["none", "centrifugal", "full"])
def test_initial_motion_and_blade_forces_of_a_wheel_are_those_of_beams(
    tmp_path: Path, effects: str
) -> None:
    """With all fixed-interface modes both models have the same coordinates, so that the marches are
    equal to rounding."""
    tables = {
        "bladed_disk": {"blades": 4, "elements_per_blade": 2},
        "shaft": {"stiffness": 2e7},
        "casing": {"support": 7.975e6},
        "initial": {
            "centre_velocity": [0.2, -0.1],
            "centre_displacement": [1e-5, 2e-5],
            "tip_displacement": [[1e-6, 2e-4], [0.0, 1e-4], [-1e-6, 0.0], [0.0, -1e-4]],
        },
        "excitation": {"type": "engine-order", "order": [3], "amplitude": 20.0, "ramp": 0.0},
        "reduction": {"fixed_interface_modes": 24},
        "rotation": {"effects": effects},
        "march": {"speed": "1500 rpm", "time_step": 5e-7, "duration": 3e-3, "record_step": 1e-4},
    }
    beams = bw.case_from(tables)
    part = build_beams(beams).to_superelement()
    bw.write_superelement(tmp_path / "wheel.npz", part)
    given = {"file": str(tmp_path / "wheel.npz"), "kind": "wheel", "copies": 4}
    nodes = {
        "bladed_disk": {"superelement": given},
        "reduction": {"boundary": "consistent", "fixed_interface_modes": 24},
        "damping": {"boundary_ratio": beams.damping.ratio},
    }
    wheel = bw.case_from(tables | nodes)
    first, _ = march_in_memory(prepare(beams))
    second, _ = march_in_memory(prepare(wheel))
    expected = bw.tip_displacement(first)["displacement"]
    actual = second["contact_displacement"].values
    scale = float(np.abs(expected).max())
    for number, name in enumerate(("radial", "tangential")):
        assert actual[:, :, number] == pytest.approx(
            expected.sel(component=name).values, abs=1e-6 * scale
        )
    assert scale > 1e-4
    assert second["blade"].values.tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("copies", "changes", "expected"),
    [
        (1, {"excitation": {"type": "engine-order"}}, 'for excitation.type = "engine-order"'),
        (1, {"initial": {"centre_velocity": [1.0, 0.0]}}, "for initial.centre_velocity"),
        (3, {}, "copies = 3: expected a divisor of the 4 contact nodes"),
    ],
)
def test_blades_of_a_wheel_have_to_be_known(
    tmp_path: Path, copies: int, changes: dict[str, Any], expected: str
) -> None:
    small = {"bladed_disk": {"blades": 4, "elements_per_blade": 1}}
    part = build_beams(bw.case_from(small)).to_superelement()
    bw.write_superelement(tmp_path / "wheel.npz", part)
    given = {"file": str(tmp_path / "wheel.npz"), "kind": "wheel", "copies": copies}
    with pytest.raises(bw.CaseError, match=expected):
        bw.case_from({"bladed_disk": {"superelement": given}} | changes)


SHAFT = {"stiffness": 2e7, "stiffness_y": 1e7}


def test_the_centre_of_a_turned_wheel_moves_as_its_points(tmp_path: Path) -> None:
    stage = build_beams(
        bw.case_from({"bladed_disk": {"blades": 5, "elements_per_blade": 2}, "shaft": SHAFT})
    )
    bw.write_superelement(tmp_path / "wheel.npz", stage.to_superelement())
    given = {"file": str(tmp_path / "wheel.npz"), "kind": "wheel", "angle": 0.7}
    wheel = build_matrices(
        bw.case_from(
            {
                "bladed_disk": {"superelement": given},
                "casing": {"type": "rigid"},
                "shaft": SHAFT,
                "reduction": {"free_interface_modes": 12},
            }
        )
    )
    rows = wheel.centre_rows
    assert np.abs(rows).max() > 0.1
    assert rows == pytest.approx(wheel.arrays.point_shape[stage.disk.model.centre, :2], abs=1e-9)


@pytest.mark.parametrize("boundary", ["massless", "consistent"])
def test_mistuned_blades_have_the_flexibility_and_damping_of_their_stiffness(
    tmp_path: Path, boundary: str
) -> None:
    bw.write_superelement(tmp_path / "rods.npz", blade())
    stiffness = [1.0, 1.2, 0.9]
    key, kept, modes = {
        "massless": ("free_interface_modes", 15, 15),
        "consistent": ("fixed_interface_modes", 7, 7 + 9),
    }[boundary]
    table = tables(tmp_path / "rods.npz") | {
        "reduction": {"boundary": boundary, key: kept},
        "damping": {"ratio": 0.01, "boundary_ratio": 0.3},
    }
    table["bladed_disk"]["mistuning"] = {"stiffness": stiffness}
    stage = build_matrices(bw.case_from(table))
    assert stage.factor == pytest.approx(stiffness)
    rotor = steady_problem(stage).rotor
    residual = rotor.compliance
    rows = blade().contact_rows
    static = rows @ np.linalg.solve(np.asarray(blade().stiffness), rows.toarray().T)
    for copy, factor in enumerate(stiffness):
        modal = rotor.contact / rotor.by_copy(rotor.frequency)[copy]
        flexibility = modal @ modal.T + (0.0 if residual is None else residual[copy])
        assert flexibility == pytest.approx(static / factor, abs=1e-9 * abs(static).max())
    ratio = rotor.by_copy(rotor.damping_ratio)
    assert ratio.shape == (3, modes)
    assert ratio[:, :kept] == pytest.approx(0.01)
    assert ratio[:, kept:] == pytest.approx(0.3)

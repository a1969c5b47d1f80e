"""A stage of beams as a superelement."""

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as la

import bladewhirl as bw
from bladewhirl.models.stage.superelement_stage import superelement_stage


@pytest.mark.parametrize("clamped", [True, False])
def test_a_stage_as_a_wheel_has_its_frequencies_and_motions(
    tmp_path: Path, *, clamped: bool
) -> None:
    small = {"blades": 5, "elements_per_blade": 3}
    shaft = {"clamped": clamped, "stiffness": 2e7, **({} if clamped else {"stiffness_y": 1e7})}
    stage = bw.build_stage(bw.case_from({"bladed_disk": small, "shaft": shaft}))
    bw.write_superelement(tmp_path / "wheel.npz", stage.to_superelement())
    case = bw.case_from(
        {
            "bladed_disk": {"superelement": {"file": str(tmp_path / "wheel.npz"), "kind": "wheel"}},
            "casing": {"type": "rigid"},
            "shaft": shaft | {"clamped": False},
            "reduction": {"free_interface_modes": 12},
        }
    )
    wheel = superelement_stage(case)
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

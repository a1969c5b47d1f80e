"""Forces on the bearings, against circles in closed form and a march through a loss of a blade."""

from typing import Any

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

import bladewhirl as bw
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.result import completed
from bladewhirl.postprocess.run.summary import summarise
from bladewhirl.postprocess.shaft.bearing_forces import bearing_forces
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

RADIUS, RATE = 0.8e-3, 70.0  # m; rad/s, backward in rotating axes: what the synthetic shaft does
SPRINGS, DAMPERS = (2e6, 5e6), (3e3, 7e3)


def circling(**shaft: Any) -> xr.Dataset:
    """A result whose case has this table [shaft]."""
    keys = "\n".join(f"{key} = {value}" for key, value in shaft.items())
    result = synthetic.synthetic_result().drop_vars("shaft_stiffness")
    return completed(result.assign_attrs(case=f"[shaft]\n{keys}\n"))


@pytest.mark.parametrize("frame", ["rotating", "static"])
def test_springs_act_in_the_axes_in_which_they_are_fixed(frame: str) -> None:
    result = circling(stiffness=SPRINGS[0], stiffness_y=SPRINGS[1], frame=f'"{frame}"')
    force = bearing_forces(result)
    angle = (synthetic.SPEED if frame == "static" else 0.0) * result["time"].values
    angle = angle - RATE * result["time"].values  # of the shaft's centre in these axes
    own = RADIUS * np.array(SPRINGS) * np.column_stack([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(force["force"], np.hypot(*own.T), rtol=1e-12)
    if frame == "static":
        np.testing.assert_allclose(force["static"], own, atol=1e-9 * own.max())


def test_dampers_act_on_the_velocity_in_their_axes() -> None:
    at_rest = {"stiffness": 1e-9, "damping": DAMPERS[0]}
    for frame, rate in (("rotating", -RATE), ("static", synthetic.SPEED - RATE)):
        force = bearing_forces(circling(**at_rest, damping_frame=f'"{frame}"'))
        expected = DAMPERS[0] * abs(rate) * RADIUS
        np.testing.assert_allclose(force["force"], expected, rtol=1e-7)
    force = bearing_forces(circling(**at_rest, damping_y=DAMPERS[1]))
    angle = -RATE * force["time"].values
    own = RATE * RADIUS * np.column_stack([np.sin(angle), np.cos(angle)]) * DAMPERS
    np.testing.assert_allclose(force["force"], np.hypot(*own.T), rtol=1e-7)


def test_a_clamped_shaft_has_none() -> None:
    with pytest.raises(ViewError, match="springs"):
        bearing_forces(circling(clamped="true"))


def test_the_support_fuses_at_its_force() -> None:
    """Before it fuses the force is at most that of the fuse, afterwards that of softer springs."""
    fuse, soft = 2e4, 4e6
    case = bw.case_from(
        {
            "casing": {"type": "rigid", "clearance": 0.05},
            "shaft": {"fuse_force": fuse, "fused_stiffness": soft},
            "excitation": {"type": "none"},
            "blade_loss": {"blade": [3], "time": 1e-3},
            "march": {"speed": "3000 rpm", "duration": 0.02, "record_step": 1e-5},
        }
    )
    result, report = march_in_memory(prepare(case))
    force, after = bearing_forces(result), result["time"].values > result.attrs["fuse_time"]
    assert 0.97 * fuse < force["force"].values[~after].max() <= fuse * (1.0 + 1e-9)
    radius = bw.shaft_orbit(result)["radius"].values
    np.testing.assert_allclose(force["force"].values[after], soft * radius[after], rtol=1e-12)
    summary = summarise(result, report)
    assert summary.bearing_force_max == pytest.approx(force["force"].max())
    assert summary.bearing_force_time == float(force["time"][int(force["force"].values.argmax())])

"""Tip timing against arrivals of a motion in closed form."""

import numpy as np
import pytest
import xarray as xr
from synthetic_result import TIP_RADIUS, resting

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.run.tip_timing import tip_timing

PROBE, BLADE = np.deg2rad(50.0), 4
AMPLITUDE, RATE = 2e-3, 300.0  # of a bending mode [m], [rad/s]


def bending(records: int, speed: float = 80.0) -> xr.Dataset:
    """A result of 0.4 s in which only the first bending with one nodal diameter moves."""
    time = np.linspace(0.0, 0.4, records)
    q, rate = np.zeros((2, records, 5))
    q[:, 3], rate[:, 3] = AMPLITUDE * np.cos(RATE * time), -AMPLITUDE * RATE * np.sin(RATE * time)
    result = resting(records, speed, rotor_displacement=q, rotor_velocity=rate)
    return result.assign_coords(time=time)


@pytest.mark.parametrize("speed", [80.0, -80.0])
def test_a_blade_is_at_the_probe_when_it_arrives(speed: float) -> None:
    """`verify sensors` measures the order in the record step."""
    result = bending(401, speed)
    timing = tip_timing(result, ["10 deg", "50 deg"]).isel(probe=1).sel(blade=BLADE)
    arrival = timing["arrival"].dropna("revolution").values
    assert timing.sizes["revolution"] >= len(arrival) >= 5
    angle = float(result["tip_angle"][BLADE])
    moved = AMPLITUDE * np.cos(angle) * np.cos(RATE * arrival)
    np.testing.assert_allclose(timing["deflection"][: len(arrival)], moved, atol=1e-6)
    apart = angle + speed * arrival + moved / TIP_RADIUS - PROBE
    np.testing.assert_allclose(np.angle(np.exp(1j * apart)), 0.0, atol=80.0 * 1e-7)


def test_what_cannot_be_timed_is_refused() -> None:
    with pytest.raises(ViewError, match="at least four records a revolution"):
        tip_timing(bending(11))
    with pytest.raises(ViewError, match="at least four records a revolution"):
        tip_timing(bending(401).assign_attrs(speed=0.0))

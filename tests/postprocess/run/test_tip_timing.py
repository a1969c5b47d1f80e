"""Tip timing against arrivals of a motion in closed form."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from scipy.optimize import brentq
from stages import observed_order

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.run.tip_timing import tip_timing

PROBE, BLADE = np.deg2rad(50.0), 4
AMPLITUDE, RATE = 2e-3, 300.0  # of a bending mode [m], [rad/s]


def bending(records: int, speed: float = synthetic.SPEED) -> xr.Dataset:
    """A result of 0.4 s in which only the first bending with one nodal diameter moves."""
    result = synthetic.synthetic_result(records=records, speed=speed)
    time = np.linspace(0.0, 0.4, records)
    q, rate = np.zeros((2, records, 5))
    q[:, 3], rate[:, 3] = AMPLITUDE * np.cos(RATE * time), -AMPLITUDE * RATE * np.sin(RATE * time)
    result["rotor_displacement"].values[:] = q
    result["rotor_velocity"].values[:] = rate
    return result.assign_coords(time=time)


def exact(result: xr.Dataset) -> np.ndarray:
    """Arrivals of the blade at the probe [s]."""
    speed, angle = result.attrs["speed"], float(result["tip_angle"][BLADE])
    shape = AMPLITUDE * np.cos(angle)  # of the tip of the blade

    def behind(time: float, turn: int) -> float:
        moved = shape * np.cos(RATE * time) / synthetic.TIP_RADIUS
        return float(angle + speed * time + moved - PROBE - 2.0 * np.pi * turn)

    first, last = sorted((behind(0.0, 0), behind(0.4, 0)))
    turns = range(int(np.ceil(first / (2.0 * np.pi))), int(np.floor(last / (2.0 * np.pi))) + 1)
    return np.sort([brentq(behind, 0.0, 0.4, args=(m,), xtol=1e-16, rtol=1e-15) for m in turns])


@pytest.mark.parametrize("speed", [80.0, -80.0])
def test_arrivals_are_of_fourth_order_in_the_record_step(speed: float) -> None:
    errors = []
    for records in (201, 401):
        result = bending(records, speed)
        timing = tip_timing(result, ["10 deg", "50 deg"]).isel(probe=1).sel(blade=BLADE)
        arrival = timing["arrival"].dropna("revolution").values
        errors.append(np.abs(arrival - exact(result)).max())
        angle = float(result["tip_angle"][BLADE])
        assert timing.sizes["revolution"] >= len(arrival) >= 5
        moved = AMPLITUDE * np.cos(angle) * np.cos(RATE * arrival)
        np.testing.assert_allclose(timing["deflection"][: len(arrival)], moved, atol=1e-6)
    assert errors[1] < 1e-7
    assert observed_order(np.array(errors)) == pytest.approx(4.0, abs=0.8)


def test_what_cannot_be_timed_is_refused() -> None:
    with pytest.raises(ViewError, match="at least four records a revolution"):
        tip_timing(bending(11))
    with pytest.raises(ViewError, match="at least four records a revolution"):
        tip_timing(bending(401).assign_attrs(speed=0.0))

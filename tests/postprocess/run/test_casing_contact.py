"""Contact over the angle of the casing and the revolutions of the rotor."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.run.casing_contact import (
    casing_contact,
    plot_casing_contact,
    with_last_turns,
)


def rubbing_blade(speed: float) -> xr.Dataset:
    """A result whose first blade touches half of the time."""
    result = synthetic.synthetic_result(speed=speed)
    steps = np.zeros(result["gap"].shape, dtype=np.int64)
    steps[:, 0] = round(0.5 * result.attrs["record_step"] / result.attrs["time_step"])
    result["contact_steps"] = ("time", "blade"), steps
    return result


@pytest.mark.parametrize("speed", [200.0, -200.0])
def test_the_mark_of_one_blade_goes_round_with_the_rotor(speed: float) -> None:
    contact = casing_contact(rubbing_blade(speed))
    at = np.array([np.nanargmax(line) for line in contact.share.values])
    angle = (at + 0.5) * 2 * np.pi / contact.sizes["sector"]
    middle = (contact.time_edge.values[1:] + contact.time_edge.values[:-1]) / 2
    apart = np.angle(np.exp(1j * (angle - speed * middle)))
    assert np.abs(apart).max() < 2 * np.pi / 22
    assert np.nanmax(contact.share) == pytest.approx(0.5)


def test_at_rest_a_blade_rubs_its_own_sector() -> None:
    contact = casing_contact(rubbing_blade(0.0))
    share = contact.share.mean("time")
    assert share.sizes["sector"] == 22
    np.testing.assert_allclose(share, [0.5, *[0.0] * 21], rtol=1e-9, atol=1e-12)


def test_the_last_revolutions_of_a_long_run_are_drawn_apart() -> None:
    long = synthetic.synthetic_result(speed=200.0, records=601)  # 19 revolutions
    contact = with_last_turns(casing_contact(long), long)
    turned = 200.0 * np.ptp(contact["last_time_edge"].values) / (2 * np.pi)
    assert turned == pytest.approx(8.0, abs=0.05)
    assert len(plot_casing_contact(contact).axes) == 3

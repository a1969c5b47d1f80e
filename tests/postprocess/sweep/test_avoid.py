"""Speeds to avoid of a sweep: divergent ones, and those with strong contact."""

import numpy as np
import pytest
import xarray as xr

from bladewhirl.postprocess.sweep.avoid import speeds_to_avoid


def swept(regime: list[list[str]], force: list[float], *, failed: bool = False) -> xr.Dataset:
    """Return a sweep over 1000, 2000, ... rpm, in falling order, and over two clearances."""
    count = len(force)
    rpm = 1000.0 * np.arange(count, 0, -1)
    state = np.full((count, 2), "done", dtype=object)
    if failed:
        state[-1] = "failed"
    dims = ("march_speed", "casing_clearance")
    both = np.array([force, 0.5 * np.array(force)]).T
    return xr.Dataset(
        {
            "regime": (dims, np.array(regime).T[::-1]),
            "contact_force_max": (dims, both[::-1]),
            "state": (dims, state),
            "rotation_speed": (dims, np.tile(rpm[:, None] * np.pi / 30.0, 2)),
            "reference_frequency": (dims, np.full((count, 2), 100.0)),
        },
        {"march_speed": rpm * np.pi / 3000.0, "casing_clearance": [1e-4, 2e-4]},
        {"case": '[march]\nspeed = "4000 rpm"'},
    )


QUIET = ["damped"] * 6


def test_neighbouring_divergent_speeds_are_one_range() -> None:
    regime = ["damped", "divergent", "divergent", "damped", "damped", "divergent"]
    found = speeds_to_avoid(swept([regime, QUIET], [1.0] * 6))
    assert [(one["from_rpm"], one["to_rpm"]) for one in found] == [
        pytest.approx((2000.0, 3000.0)),
        pytest.approx((6000.0, 6000.0)),
    ]
    assert {one["cause"] for one in found} == {"divergent in up to 50%"}
    assert [one["margin"] for one in found] == pytest.approx([0.25, 0.5])
    both = speeds_to_avoid(swept([regime, regime], [1.0] * 6))
    assert {one["cause"] for one in both} == {"divergent"}


def test_strong_contact_is_told_from_the_usual_one() -> None:
    data = swept([QUIET, QUIET], [0.0, 100.0, 110.0, 90.0, 450.0, 105.0])
    [one] = speeds_to_avoid(data)
    assert (one["from_rpm"], one["to_rpm"]) == pytest.approx((5000.0, 5000.0))
    assert one["cause"] == "contact force up to 450 N, 4.3 times the median"
    assert speeds_to_avoid(swept([QUIET, QUIET], [0.0] * 6)) == []


def test_failed_points_and_sweeps_without_speeds_have_none() -> None:
    regime = ["divergent", *QUIET[1:]]
    data = swept([regime, regime], [1.0] * 6, failed=True)
    assert speeds_to_avoid(data) == []  # the lowest speed has no result
    assert speeds_to_avoid(data.rename(march_speed="contact_friction")) == []

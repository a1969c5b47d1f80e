"""Time steps and records of a march, counted in whole numbers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bladewhirl.models.inputs.timing import Timing


@given(every=st.integers(1, 10_000), steps=st.integers(1, 10**7), exponent=st.integers(-9, -1))
def test_timing_counts_steps(every: int, steps: int, exponent: int) -> None:
    dt = 1.1 * 10.0**exponent
    timing = Timing(time_step=dt, duration=steps * dt, record_step=every * dt)
    assert timing.record_every == every
    assert timing.steps == steps


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time_step": 0.0}, "must be positive"),
        ({"duration": -1.0}, "duration not negative"),
        ({"duration": np.inf}, "both finite"),
        ({"record_step": 1.5e-6}, r"whole number of time steps \(1e-06 s\); got 1.5e-06 s"),
        ({"record_step": 1e-7}, "whole number of time steps"),
        ({"record_step": np.nan}, "whole number of time steps"),
        ({"record_step": np.inf}, "whole number of time steps"),
    ],
)
def test_faulty_timings_are_refused(change: dict[str, float], message: str) -> None:
    sound = {"time_step": 1e-6, "duration": 3.0, "record_step": 1e-4}
    with pytest.raises(ValueError, match=message):
        Timing(**(sound | change))

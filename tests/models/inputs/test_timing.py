"""Time steps and records of a march, counted in whole numbers."""

from hypothesis import given
from hypothesis import strategies as st

from bladewhirl.models.inputs.timing import Timing


@given(every=st.integers(1, 10_000), steps=st.integers(1, 10**7), exponent=st.integers(-9, -1))
def test_timing_counts_steps(every: int, steps: int, exponent: int) -> None:
    dt = 1.1 * 10.0**exponent
    timing = Timing(time_step=dt, duration=steps * dt, record_step=every * dt)
    assert timing.record_every == every
    assert timing.steps == steps

"""What a sweep keeps of a run: spectra against closed forms."""

import numpy as np

from bladewhirl.postprocess.sweep.digest import magnitudes

STEP = 1e-3
FREQUENCY = np.arange(-100, 101) / 0.5  # of a window of half a second


def test_circles_have_their_radius_at_their_frequency() -> None:
    time = STEP * np.arange(500)
    motion = 3.0 + 2.0 * np.exp(2j * np.pi * 40.0 * time) + 0.5 * np.exp(-2j * np.pi * 60.0 * time)
    magnitude = magnitudes(motion, STEP, FREQUENCY)
    expected = np.zeros(len(FREQUENCY))
    for frequency, radius in ((0.0, 3.0), (40.0, 2.0), (-60.0, 0.5)):
        place = int(np.argmin(np.abs(FREQUENCY - frequency)))
        expected[place - 1 : place + 2] += radius * np.array([0.5, 1.0, 0.5])  # a Hann window
    np.testing.assert_allclose(magnitude, expected, atol=1e-12)


def test_it_is_the_sum_that_defines_it_at_any_frequency_and_length() -> None:
    random = np.random.default_rng(1)
    motion = random.normal(size=137) + 1j * random.normal(size=137)
    window = np.sin(np.pi * (np.arange(137) + 0.5) / 137) ** 2
    turns = np.exp(-2j * np.pi * np.outer(FREQUENCY, STEP * np.arange(137)))
    np.testing.assert_allclose(
        magnitudes(motion, STEP, FREQUENCY),
        np.abs(turns @ (window * motion)) / window.sum(),
        rtol=1e-9,
    )


def test_too_few_records_have_no_spectrum() -> None:
    assert np.isnan(magnitudes(np.ones(3, dtype=complex), STEP, FREQUENCY)).all()

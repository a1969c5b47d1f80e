"""The one measure of the whirl, against motions of known circles in both frames."""

import numpy as np
import pytest
import xarray as xr
from synthetic_result import resting

from bladewhirl.meshes.plane import rotate
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.shaft.transforms import Frame, strongest_lines
from bladewhirl.postprocess.shaft.whirl import FRAMES, ripple, whirl

SPEEDS = [10.0, 30.0, -10.0]  # turns a second
RADIUS = 0.8e-3


def orbit_of(parts: dict[float, float], speed: float, records: int = 4001) -> xr.Dataset:
    """A sum of circles in rotating axes: amplitude [m] by turns a second, forward positive."""
    time = 2.5e-4 * np.arange(records, dtype=np.float64)
    turning = np.exp(2j * np.pi * np.outer(time, list(parts)))
    place = turning @ np.array(list(parts.values()))
    sense = np.sign(speed)
    rotating = np.column_stack([place.real, sense * place.imag])
    plane, turn = ("time", "axis"), float(2 * np.pi * speed)
    return xr.Dataset(
        {
            "rotating": (plane, rotating),
            "static": (plane, rotate(rotating, turn * time)),
            "radius": ("time", np.abs(place)),
        },
        coords={"time": time},
        attrs={"speed": turn, "reference_frequency": 2 * np.pi * 10.0},
    )


def seen(frequency: float, speed: float, frame: Frame) -> float:
    """A frequency in rotating axes as a frame has it."""
    return frequency if frame == "rotating" else frequency + abs(speed)


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("frequency", [3.573, -40.5, 12.0])
@pytest.mark.parametrize("frame", FRAMES)
def test_a_circle_turns_at_its_frequency(speed: float, frequency: float, frame: Frame) -> None:
    actual = whirl(orbit_of({frequency: RADIUS}, speed), frame)
    expected = seen(frequency, speed, frame)
    assert actual.frequency == pytest.approx(expected, rel=1e-9)
    assert actual.error == pytest.approx(0.0, abs=1e-6)
    direction = "forward" if expected > 0 else "backward"
    assert actual.text == f"{direction}, {abs(expected):.3g} Hz"


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("frame", FRAMES)
def test_a_small_fast_component_does_not_count(speed: float, frame: Frame) -> None:
    """The mean of x cross v over r^2 would be -28.9 Hz in rotating axes."""
    orbit = orbit_of({-40.5: RADIUS, 100.0: 0.3 * RADIUS}, speed)
    actual = whirl(orbit, frame)
    assert actual.frequency == pytest.approx(seen(-40.5, speed, frame), abs=0.05)
    lines = strongest_lines(orbit, frame)
    expected = [seen(value, speed, frame) for value in (-40.5, 100.0)]
    np.testing.assert_allclose([line.frequency for line in lines], expected, atol=0.02)
    np.testing.assert_allclose([line.share for line in lines], [1 / 1.09, 0.09 / 1.09], rtol=5e-3)


@pytest.mark.parametrize("speed", SPEEDS)
def test_an_orbit_beside_the_centre_has_no_rate_but_its_ripple_has(speed: float) -> None:
    """As under imbalance: fixed in the rotor but for a ripple, so it turns with the rotor."""
    orbit = orbit_of({0.0: RADIUS, 27.0: 0.1 * RADIUS}, speed)
    assert whirl(orbit, "rotating").frequency is None
    assert whirl(orbit, "rotating").text == "no single frequency"
    assert whirl(orbit, "static").frequency == pytest.approx(abs(speed), rel=1e-3)
    size, about = ripple(orbit, "rotating")
    assert size == pytest.approx(0.1 * RADIUS, rel=1e-3)
    assert whirl(about, "rotating").frequency == pytest.approx(27.0, rel=1e-6)
    assert whirl(orbit_of({0.0: RADIUS, 27.0: 0.03 * RADIUS}, speed), "rotating").rests


def test_no_rate_of_equal_circles_or_of_a_line_through_the_centre() -> None:
    for parts in ({30.0: RADIUS, -30.0: RADIUS}, {30.0: RADIUS, -10.0: RADIUS}):
        orbit = orbit_of(parts, 3.0)
        assert whirl(orbit, "rotating").frequency is None
        lines = strongest_lines(orbit, "rotating")
        assert sorted(round(line.frequency) for line in lines) == sorted(parts)
        np.testing.assert_allclose([line.share for line in lines], 0.5, rtol=0.01)


@pytest.mark.parametrize("speed", SPEEDS)
def test_net_turns_that_no_line_has_are_no_rate(speed: float) -> None:
    """Three circles, none larger than the others together: -59.9 Hz on average, steadily."""
    orbit = orbit_of({-100.0: RADIUS, -30.0: 0.85 * RADIUS, 20.0: 0.6 * RADIUS}, speed)
    for frame in FRAMES:
        actual = whirl(orbit, frame)
        assert actual.rate / (2 * np.pi) == pytest.approx(seen(-59.9, speed, frame), abs=0.1)
        assert actual.error / (2 * np.pi) < 0.01
        assert actual.frequency is None
    mostly = orbit_of({-100.0: RADIUS, -30.0: 0.5 * RADIUS, 20.0: 0.4 * RADIUS}, speed)
    assert whirl(mostly, "rotating").frequency == pytest.approx(-100.0, abs=0.1)


def test_the_error_gives_how_the_rate_wanders() -> None:
    """Spans of a tenth that turn at 10 and 14 Hz in turn: 2.11 Hz apart, over the root of ten."""
    orbit = orbit_of({1.0: RADIUS}, 10.0, records=4000)
    rate = np.where(np.arange(4000) // 400 % 2, 14.0, 10.0)
    angle = 2 * np.pi * np.cumsum(rate) * 2.5e-4
    orbit["rotating"][:] = RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])
    actual = whirl(orbit, "rotating")
    assert actual.frequency == pytest.approx(12.0, rel=0.02)
    assert actual.error / (2 * np.pi) == pytest.approx(2 * np.sqrt(10 / 9) / np.sqrt(10), rel=1e-3)


@pytest.mark.parametrize("records", [1, 2, 15])
def test_a_shaft_at_rest_or_a_single_record_has_no_whirl(records: int) -> None:
    still = orbit_of({5.0: 0.0}, 10.0, records=records)
    for frame in FRAMES:
        assert whirl(still, frame).frequency is None
        assert np.isnan(whirl(still, frame).rate)
        assert strongest_lines(still, frame) == ()
    assert whirl(orbit_of({5.0: RADIUS}, 10.0, records=1), "static").frequency is None


def test_a_shaft_at_rest_in_a_frame_is_said_to_rest() -> None:
    """A constant displacement in rotating axes turns with the rotor in static axes."""
    moved = np.array([3e-4, 1e-4, 0.0, 0.0, 0.0])
    orbit = shaft_orbit(resting(records=401, rotor_displacement=moved))
    assert whirl(orbit, "rotating").text == "at rest"
    assert whirl(orbit, "static").direction == "forward"
    assert whirl(shaft_orbit(resting(records=11)), "static").text == "at rest"
    pulsing = moved * np.cos(0.1 * np.arange(401))[:, None]
    orbit = shaft_orbit(resting(records=401, rotor_displacement=pulsing))
    assert whirl(orbit, "rotating").text == "no single frequency"
    rounding = shaft_orbit(resting(records=401, rotor_displacement=1e-9 * pulsing))
    assert {whirl(rounding, frame).text for frame in FRAMES} == {"at rest"}

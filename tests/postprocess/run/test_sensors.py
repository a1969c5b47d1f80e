"""Signals of sensors, and tip timing, against motions in closed form."""

import warnings
from typing import Any

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from faults import fault
from synthetic_result import TIP_RADIUS, resting

import bladewhirl as bw
from bladewhirl.models.inputs.errors import Hint
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.run import sensor_figures
from bladewhirl.postprocess.run.tip_timing import tip_timing

GAUGE = {"type": "strain", "span": 0.4}
TIMING = {"type": "tip-timing", "probes": [0.0, "90 deg"], "name": "btt"}
WALL = {"type": "wall", "angle": "90 deg", "name": "wall"}


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return synthetic.synthetic_result()


def test_a_gauge_in_an_element_is_in_its_middle(result: xr.Dataset) -> None:
    """`verify sensors` compares the strains on both sides of a blade with beam theory."""
    gauges: list[dict[str, Any]] = [
        {"type": "strain", "element": 1, "blade": 3, "name": "a"},
        {"type": "strain", "span": 0.375, "name": "b"},  # of the second of four elements
    ]
    signals = bw.sensors(result, gauges)
    np.testing.assert_allclose(signals["a"], signals["b"].sel(blade=3), atol=1e-15)
    assert signals["b"].attrs["units"] == "m/m"


def test_beams_that_run_inward_have_the_same_sides(result: xr.Dataset) -> None:
    turned = result.copy(deep=True)
    blades = turned["rotor_part"].values == "blades"
    turned["rotor_line"].values[blades] = turned["rotor_line"].values[blades][:, ::-1]
    xr.testing.assert_allclose(bw.sensors(turned, [GAUGE]), bw.sensors(result, [GAUGE]))


def test_a_tapered_blade_is_strained_at_its_own_surface(result: xr.Dataset) -> None:
    tapered = result.copy(deep=True)
    tapered["rotor_thickness_change"].values[:] = -0.004
    gauge = [{"type": "strain", "element": 0, "name": "a"}, GAUGE | {"span": 0.2, "name": "b"}]
    plain, thin = bw.sensors(result, gauge), bw.sensors(tapered, gauge)
    np.testing.assert_allclose(thin["a"], plain["a"], atol=1e-15)  # in the middle of an element
    np.testing.assert_allclose(thin["b"], plain["b"] * (0.010 - 0.004 * 0.3) / 0.010, atol=1e-15)


def test_wall_sensors_move_as_the_waves_of_the_ring(result: xr.Dataset) -> None:
    """At 90 degrees the radial motion is that of the second mode less that of the third."""
    rate, time = 3000.0, np.arange(1201) / 3000.0
    exact = 1e-4 * np.sin(5.0 * time) - 0.2e-3 * np.cos(60.0 * time)
    second = -25e-4 * np.sin(5.0 * time) + 0.2e-3 * 3600.0 * np.cos(60.0 * time)
    first = 5e-4 * np.cos(5.0 * time) + 0.2e-3 * 60.0 * np.sin(60.0 * time)
    step = 60.0 * synthetic.RECORD_STEP
    for quantity, values, error in (
        ("displacement", exact, 0.2e-3 * step**4 / 384),
        ("velocity", first, 0.2e-3 * 60.0 * step**3 / 72 / np.sqrt(3.0)),
        ("acceleration", second, 0.2e-3 * 3600.0 * step**2 / 12),
    ):
        with pytest.warns(Hint, match="wall samples 3000 times a second, but the run has only"):
            actual = bw.sensors(result, [WALL | {"quantity": quantity, "sampling_rate": rate}])
        np.testing.assert_allclose(actual["time_3000_Hz"], time, atol=1e-12)
        np.testing.assert_allclose(actual["wall"], values, rtol=0, atol=1.01 * error + 1e-15)
        assert abs(actual["wall"] - values).max() > 0.5 * error  # the error that the text states
    along = bw.sensors(result, [WALL | {"direction": "tangential"}])["wall"]
    expected = bw.casing_displacement(result, "90 deg")["displacement"].sel(component="tangential")
    np.testing.assert_allclose(along, expected[:, 0], atol=1e-18)


def test_fewer_samples_than_records_are_taken_without_a_hint(result: xr.Dataset) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", Hint)
        few = bw.sensors(result, [WALL | {"sampling_rate": 500}])["wall"]
        bw.sensors(result, [TIMING | {"sampling_rate": "80 MHz"}])
    every = bw.sensors(result, [WALL])["wall"]
    np.testing.assert_allclose(few, every[::2], rtol=0, atol=1e-15)


def test_the_centre_is_seen_in_the_static_frame(result: xr.Dataset) -> None:
    """A whirl at -70 rad/s in axes that turn at 80 rad/s is one at 10 rad/s."""
    for order, quantity in enumerate(("displacement", "velocity", "acceleration")):
        sensor = {"type": "centre", "angle": 0.5, "quantity": quantity, "name": "probe"}
        actual = bw.sensors(result, [sensor], start=0.1)["probe"]
        phase = 10.0 * actual["time"].values - 0.5 + 0.5 * np.pi * order
        accuracy = (1e-12, 1e-12, 0.8e-3 * 70.0**4 * 1e-6 / 12)[order]
        expected = 0.8e-3 * 10.0**order * np.cos(phase)
        np.testing.assert_allclose(actual, expected, rtol=0, atol=accuracy)


def test_tip_timing_is_that_of_the_function(result: xr.Dataset) -> None:
    actual = bw.sensors(result, [TIMING])
    exact = bw.tip_timing(result, ["0 deg", "90 deg"])
    np.testing.assert_array_equal(actual["btt_arrival"], exact["arrival"])
    np.testing.assert_allclose(actual["btt"], exact["deflection"], atol=1e-12)


def test_noise_of_arrivals_is_noise_of_deflections(result: xr.Dataset) -> None:
    exact = bw.sensors(result, [TIMING])
    noisy = bw.sensors(result, [TIMING | {"noise": "2 us"}])
    late = (noisy["btt_arrival"] - exact["btt_arrival"]).values
    assert np.nanstd(late) == pytest.approx(2e-6, rel=0.15)
    assert len(np.unique(late[np.isfinite(late)])) == np.isfinite(late).sum()  # each its own
    moved = (noisy["btt"] - exact["btt"]).values
    np.testing.assert_allclose(moved, -synthetic.TIP_RADIUS * synthetic.SPEED * late, atol=1e-15)
    part = bw.sensors(result, [TIMING | {"noise": "2 us"}], start=0.1, end=0.3)
    assert np.isin(part["btt_arrival"].values, noisy["btt_arrival"].values).sum() >= 2 * 22 * 2
    clock = bw.sensors(result, [TIMING | {"sampling_rate": "10 kHz"}])["btt_arrival"].values
    ticks = clock[np.isfinite(clock)] * 1e4
    np.testing.assert_allclose(ticks, np.round(ticks), atol=1e-9)
    assert np.nanmax(abs(clock - exact["btt_arrival"].values)) <= 0.5e-4 + 1e-15


@pytest.mark.slow
def test_noise_follows_from_seed_and_number(result: xr.Dataset) -> None:
    gauges: list[dict[str, Any]] = [
        GAUGE | {"noise": 1e-6, "name": name, "seed": seed}
        for name, seed in (("a", 7), ("b", 7), ("c", 8))
    ]
    exact = bw.sensors(result, [GAUGE])["strain-0.4"]
    signals = bw.sensors(result, gauges)
    noise = {name: (signals[name] - exact).values for name in "abc"}
    for one in noise.values():
        assert one.std() == pytest.approx(1e-6, rel=0.03)
    for first, second in ("ab", "ac", "bc"):
        assert abs(np.corrcoef(noise[first].ravel(), noise[second].ravel())[0, 1]) < 0.05
    xr.testing.assert_identical(bw.sensors(result, gauges), signals)
    assert signals["c"].attrs["seed"] == 8
    window = bw.sensors(result, gauges, start=0.2)
    np.testing.assert_array_equal(window["a"], signals["a"].sel(time=window["time"]))


def test_sensors_are_those_of_the_case(result: xr.Dataset) -> None:
    text = bw.dumps_case(bw.Case(sensor=[WALL]))
    assert list(bw.sensors(result.assign_attrs(case=text))) == ["wall"]
    with pytest.raises(bw.ViewError, match=r"expected tables \[\[sensor\]\]"):
        bw.sensors(result)


def test_sensors_that_are_not_there_are_refused(result: xr.Dataset) -> None:
    line = fault(bw.sensors, result, [WALL, GAUGE | {"blade": 22}])
    assert line == 'sensor[1].blade = 22: expected "all" or a blade from 0 to 21'
    line = fault(bw.sensors, result, [{"type": "strain", "element": 4}])
    assert line == "sensor[0].element = 4: expected an element from 0 to 3 of blade 0"
    line = fault(bw.sensors, result.assign_attrs(speed=0.0), [TIMING])
    assert line.startswith('sensor[0].type = "tip-timing": expected at least four records')
    for sensor in (WALL, GAUGE, {"type": "centre"}):
        line = fault(bw.sensors, result, [sensor | {"sampling_rate": 1e12}])
        assert line.startswith("sensor[0].sampling_rate = 1e12: expected at most ")
    branched = result.copy(deep=True)
    branched["rotor_part"].values[:44] = "blades"
    assert "one chain from root to tip" in fault(bw.sensors, branched, [GAUGE])


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


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_tips_may_swing_faster_than_the_rotor_turns_but_not_backward(sense: float) -> None:
    result = bending(401)
    rate = sense * 1.2 * 80.0  # of mode 2, the rotation about the centre
    for name, values in (("displacement", rate * result["time"].values), ("velocity", rate)):
        result[f"rotor_{name}"][:, 2], result[f"rotor_{name}"][:, 3] = values, 0.0
    if sense < 0.0:
        with pytest.raises(ViewError, match="tips that turn forward"):
            tip_timing(result, ["0 deg"])
        return
    arrival = tip_timing(result, ["0 deg"])["arrival"].sel(blade=0)[0].dropna("revolution")
    np.testing.assert_allclose(np.diff(arrival), 2.0 * np.pi / (2.2 * 80.0), rtol=1e-9)


def test_what_cannot_be_timed_is_refused() -> None:
    with pytest.raises(ViewError, match="at least four records a revolution"):
        tip_timing(bending(11))
    with pytest.raises(ViewError, match="at least four records a revolution"):
        tip_timing(bending(401).assign_attrs(speed=0.0))
    with pytest.raises(bw.UserError, match=r"probes .*: expected at least one angle"):
        tip_timing(bending(401), [])
    with pytest.raises(bw.UserError, match='angle = "None": expected an angle'):
        tip_timing(bending(401), [None])  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_run_too_short_for_an_arrival_has_none(result: xr.Dataset) -> None:
    short = result.isel(time=slice(0, 3))
    signals = bw.sensors(short, [TIMING | {"probes": [1e-3] * 100, "noise": "1 us"}])
    assert signals["btt"].size == 0
    with pytest.raises(ViewError, match="expected a run in which a blade passes btt"):
        sensor_figures.all_blades(signals)

"""Figures of sensors: what they show of motions in closed form."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from legible import assert_legible

import bladewhirl as bw
from bladewhirl.models.inputs.units import to_si
from bladewhirl.postprocess.run import sensor_figures
from bladewhirl.postprocess.run.figures import RunFigures

pytestmark = pytest.mark.pictures

SENSORS = [
    {"type": "strain", "span": 0.4, "name": "gauge"},
    {"type": "tip-timing", "probes": [0.0, "90 deg"], "name": "btt"},
    {"type": "wall", "angle": 0.0, "name": "wall"},
    {"type": "centre", "angle": 0.0, "quantity": "velocity", "name": "probe"},
]


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    plain = synthetic.synthetic_result(records=2001)
    return plain.assign_attrs(case=bw.dumps_case(bw.Case(sensor=SENSORS)))


@pytest.mark.parametrize("name", ["sensors", "sensor-spectrum", "order-tracking", "all-blades"])
@pytest.mark.slow
def test_each_is_drawn_and_legible(result: xr.Dataset, name: str) -> None:
    figure, data = RunFigures(result).draw(name)
    assert figure.get_figwidth() == pytest.approx(to_si("170 mm", "m") / 0.0254)
    assert {"gauge"} <= set(data)
    titles = {axes.get_title(loc="left").partition(",")[0] for axes in figure.axes}
    drawn = {"gauge", "btt"} if name == "all-blades" else {"gauge", "wall", "probe"}
    assert drawn <= titles
    assert_legible(figure)


def test_a_spectrum_has_the_amplitude_and_the_frequency_of_a_vibration(result: xr.Dataset) -> None:
    spectra = RunFigures(result, 0.5, 2.0).sensor_spectra
    wall = spectra["wall"]
    peak = wall.isel(wall_frequency=int(np.argmax(wall.values)))
    assert float(peak) == pytest.approx(0.2e-3, rel=0.02)
    assert float(peak["wall_frequency"]) == pytest.approx(60.0 / 2.0 / np.pi, abs=0.3)
    lines = dict(zip(spectra["wall_line"].values, spectra["wall_mode"].values[:, 1], strict=True))
    assert lines["k = 2"] == pytest.approx(60.0 / 2.0 / np.pi)
    assert "btt" not in spectra


def test_order_tracking_is_over_the_speed(result: xr.Dataset) -> None:
    orders = RunFigures(result).draw("order-tracking")[1]["gauge"]
    strongest = orders["gauge_order"].values[orders.values.argmax(axis=0)]
    np.testing.assert_allclose(strongest, 75.0 / synthetic.SPEED, atol=0.1)
    with pytest.raises(bw.ViewError, match="a rotor that turns"):
        sensor_figures.sensor_orders(orders.to_dataset().assign_attrs(speed=0.0), result)


def test_all_blades_vibrate_as_their_wave(result: xr.Dataset) -> None:
    """The wave has the same amplitude on every blade; it is nearly a whole turn in a revolution."""
    _, blades = RunFigures(result).draw("all-blades")
    length = synthetic.TIP_RADIUS - synthetic.DISK_RADIUS
    amplitude = 0.005 * 3.0 * 0.6 / length**2 * 0.3e-3
    assert blades["gauge"].shape == (22, 25)
    assert float(blades["gauge"].max()) == pytest.approx(amplitude, rel=0.01)
    assert float(blades["gauge"].min()) > 0.9 * amplitude
    np.testing.assert_allclose(blades["gauge_high"], amplitude, rtol=0.01)
    exact = bw.tip_timing(result, [0.0, 0.5 * np.pi])["deflection"]
    np.testing.assert_allclose(blades["btt"], exact[0], atol=1e-12)


def test_long_curves_keep_their_extremes() -> None:
    time = np.arange(10_000.0)
    values = np.zeros(10_000)
    values[1234], values[4321] = 3.0, -2.0
    at, drawn = sensor_figures._thinned(time, values)
    assert len(at) == 2 * sensor_figures.COLUMNS
    assert (drawn.max(), drawn.min()) == (3.0, -2.0)
    assert abs(at[drawn.argmax()] - 1234.0) <= 10.0


def test_figures_need_sensors(result: xr.Dataset) -> None:
    without = result.assign_attrs(case="")
    with pytest.raises(bw.ViewError, match=r"expected tables \[\[sensor\]\]"):
        RunFigures(without).draw("sensors")
    timing = result.assign_attrs(case=bw.dumps_case(bw.Case(sensor=SENSORS[1:2])))
    with pytest.raises(bw.ViewError, match="tip timing has none"):
        RunFigures(timing).draw("order-tracking")
    with pytest.raises(bw.ViewError, match='a gauge with blade = "all"'):
        sensor_figures.all_blades(bw.sensors(result, SENSORS[2:]))


def test_orders_stay_orders_while_the_speed_changes(result: xr.Dataset) -> None:
    time = result["time"].values
    first, last = 60.0, 100.0
    speed = np.linspace(first, last, len(time))
    angle = first * time + 0.5 * (last - first) * time**2 / time[-1]
    varied = result.assign(rotation_speed=("time", speed), rotation_angle=("time", angle))
    signals = RunFigures(varied).sensors[["gauge"]].copy(deep=True)
    sampled = signals["gauge"]
    at = np.interp(sampled[sampled.dims[0]].values, time, angle)
    shape = np.cos(3.0 * at).reshape(-1, *(1,) * (sampled.ndim - 1))
    signals["gauge"] = sampled * 0.0 + shape
    orders = sensor_figures.sensor_orders(signals, varied)["gauge"]
    strongest = orders["gauge_order"].values[orders.values.argmax(axis=0)]
    resolution = np.diff(orders["gauge_order"].values)[0]
    np.testing.assert_allclose(strongest, 3.0, atol=resolution)
    np.testing.assert_allclose(orders.values.max(axis=0), 1.0, atol=0.05)
    stopping = varied.assign(rotation_angle=("time", np.sin(angle)))
    with pytest.raises(bw.ViewError, match="turns in one sense"):
        sensor_figures.sensor_orders(signals, stopping)

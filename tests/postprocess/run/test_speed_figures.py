"""Figures of a speed that varies: torques, orbits at critical speeds, waterfall."""

import numpy as np
import pytest
import xarray as xr
from legible import assert_legible

import bladewhirl as bw
from bladewhirl.models.case.file import loads
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.run import torques as torques_of_runs
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.run.summary import summarise
from bladewhirl.postprocess.run.summary_table import summary_rows
from bladewhirl.postprocess.run.waterfall import sensor_waterfall
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

pytestmark = pytest.mark.pictures

CASE = """
[bladed_disk]
blades = 5
[reduction]
fixed_interface_modes = 15
[excitation]
type = "imbalance"
unbalance = 0.002
ramp = 0.0
[[sensor]]
type = "centre"
angle = 0.0
name = "probe"
[march]
time_step = "2 us"
duration = "0.1 s"
record_step = "0.05 ms"
"""

FREE = 'speed = "3000 rpm"\ndrive = { inertia = "2 kg m2", torque = "90 N m", loss = "0.1 N m s" }'
TABLE = 'speed_table = [["0 s", "2400 rpm"], ["0.05 s", "9500 rpm"], ["0.1 s", "2400 rpm"]]'
FULL = """
[rotation]
effects = "full"
[shaft]
damping = "20 kN s/m"
damping_frame = "static"
"""


def result_of(march: str, further: str = "") -> xr.Dataset:
    return march_in_memory(prepare(loads(f"{further}{CASE}{march}")))[0]


@pytest.fixture(scope="module")
def through() -> xr.Dataset:
    return result_of(TABLE, FULL)


@pytest.mark.slow
def test_torques_of_a_free_speed_change_the_angular_momentum() -> None:
    rub = (
        '[casing]\ntype = "rigid"\nclearance = "0.2 mm"\n[initial]\ncentre_velocity = [0.3, 0.0]\n'
    )
    result = result_of(FREE, rub)
    figure, data = RunFigures(result).draw("torques")
    assert len(figure.axes) == 3
    assert_legible(figure)
    assert float(data["torque_friction"].min()) < -1.0
    np.testing.assert_array_equal(data["torque_drive"], 90.0)
    np.testing.assert_allclose(data["torque_loss"], -0.1 * data["speed"], rtol=1e-12)
    inertia, kinds = float(result["rotor_inertia"]), ("drive", "loss", "friction", "other")
    gained = np.sum([data[f"torque_{name}"].values for name in kinds])
    span = float(np.diff(data["time"]).mean())
    change = inertia * np.ptp(rotation.speeds(result)[[0, -1]])
    assert float(gained) * span == pytest.approx(
        inertia * (rotation.speeds(result)[-1] - rotation.speeds(result)[0]), abs=1e-3 * change
    )
    # A round wall and no static dampers: friction is all that brakes besides losses.
    other, friction = np.abs(data["torque_other"]), np.abs(data["torque_friction"])
    assert float(other.mean()) < 0.02 * float(friction.mean())
    power = np.sum([data[f"power_{name}"].values for name in kinds])
    stored = result["rotor_energy"].values
    assert float(power) * span == pytest.approx(stored[-1] - stored[0], rel=1e-3)


def test_the_other_torque_is_what_the_momentum_gains_besides(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A gain of 7 N m with a drive of 5 N m, losses of 0.5 x 4 N m and friction of 1 N at 0.3 m."""
    monkeypatch.setattr(torques_of_runs, "friction_supply", lambda _: np.zeros(41))
    time = np.linspace(0.0, 4.0, 41)
    rates = {"drive_work": 20.0, "loss_work": 8.0, "braking_work": 3.0, "angular_momentum": 7.0}
    rates |= {"rotation_angle": 4.0}
    values = {name: ("time", rate * time) for name, rate in rates.items()}
    constant = {"drive_torque": 5.0, "drive_loss": 0.5}
    pulled = {"friction_impulse": (("time", "blade"), np.full((41, 2), 0.05))}
    speed = {"rotation_speed": ("time", np.full(41, 4.0))}
    attrs = {"tip_radius": 0.3, "speed": 4.0, "case": "", "reference_frequency": 10.0}
    run = xr.Dataset(values | constant | pulled | speed, {"time": time}, attrs)
    data = torques_of_runs.torques(run)
    for name, torque in {"drive": 5.0, "loss": -2.0, "friction": -0.3, "other": 4.3}.items():
        np.testing.assert_allclose(data[f"torque_{name}"], torque, rtol=1e-9)
    np.testing.assert_allclose(data["power_other"], 3.0, rtol=1e-9)


def test_a_prescribed_speed_needs_the_torque_of_its_inertia(through: xr.Dataset) -> None:
    figure, data = RunFigures(through).draw("torques")
    drawn = np.asarray(figure.axes[0].lines[0].get_ydata())
    assert drawn.max() == pytest.approx(9500.0, rel=1e-2)
    model = build_beams(loads(f"{FULL}{CASE}{TABLE}")).disk.model
    mesh, places = model.mesh, np.asarray((np.arange(200) + 0.5) / 200.0)
    ends = mesh.points[mesh.lines]
    at = ends[:, :1] + places[:, None] * (ends[:, 1:] - ends[:, :1])
    weight = model.properties.at(places).line_mass * mesh.lengths[:, None] / len(places)
    inertia = float((weight * (at**2).sum(axis=-1)).sum())
    inertia += float((model.masses.mass * (mesh.points[model.masses.node] ** 2).sum(axis=1)).sum())
    speed = data["speed"].values
    rate = np.gradient(speed, data["time"].values)
    calm = np.abs(np.gradient(rate)) < 1e-3 * np.abs(rate).max()
    assert calm.sum() > 100
    torque = data["torque_drive"] + data["torque_friction"]
    # The static growth at the fastest speed adds some per mille to the moment of inertia.
    np.testing.assert_allclose(torque[calm], inertia * rate[calm], rtol=1e-2)
    np.testing.assert_allclose(data["power_drive"][calm], torque[calm] * speed[calm], rtol=1e-6)


@pytest.mark.slow
def test_orbits_at_the_crossings_of_critical_speeds(through: xr.Dataset) -> None:
    case = loads(f"{FULL}{CASE}{TABLE}")
    speeds = bw.critical_speeds(case, branches=4)
    known = speeds["critical_speed"].sel(stiffness=case.shaft.stiffness, method="nearest")
    expected = np.sort(known.values[np.isfinite(known.values)]) * np.pi / 30.0
    np.testing.assert_allclose(through["critical_speed"], expected[:8], rtol=1e-9)
    figure, data = RunFigures(through).draw("critical-orbits")
    assert_legible(figure)
    course = case.march.course(through.attrs["reference_frequency"])
    assert course is not None
    at = course.speed(data["time_of_crossing"].values)
    np.testing.assert_allclose(at, data["critical_speed"], rtol=1e-6)
    assert data["rising"].values.tolist() == sorted(data["rising"].values, reverse=True)
    assert set(data["whirl"].values) <= {"forward", "backward"}
    forward = data.isel(crossing=np.flatnonzero(data["whirl"] == "forward"))
    assert forward.sizes["crossing"] == 2
    angle = np.unwrap(np.angle(forward["path"].values @ [1.0, 1j]), axis=1)
    turns = np.nanmax(angle, axis=1) - np.nanmin(angle, axis=1)
    np.testing.assert_allclose(turns, 6.0 * np.pi, rtol=0.1)
    report = dict.fromkeys(
        ("complementarity_residual", "unsolved_steps", "dt_over_critical", "steps"), 0.0
    )
    summary = summarise(through, report | {"wall_time": 1.0, "us_per_step": 1.0})
    passed = summary.critical_crossings
    assert [each["time"] for each in passed] == data["time_of_crossing"].values.tolist()
    assert "rpm (forward, rising) at" in summary_rows(summary)["critical speeds passed"]


def test_no_crossing_is_said(through: xr.Dataset) -> None:
    slow = through.assign(critical_speed=0.0 * through["critical_speed"] + 1000.0 * np.pi)
    message = "passes no critical speed; the lowest one is 30000 rpm"  # 500 turns a second
    with pytest.raises(ViewError, match=message):
        RunFigures(slow).draw("critical-orbits")


def test_the_waterfall_has_the_orders_of_a_vibration(through: xr.Dataset) -> None:
    figures = RunFigures(through)
    angle = rotation.angles(through)
    orbit = figures.orbit
    second = np.column_stack([np.cos(-2.0 * angle), np.sin(-2.0 * angle)])
    figures.orbit = orbit.assign(static=(("time", "axis"), 1e-3 * second))
    figure, data = figures.draw("waterfall")
    assert_legible(figure)
    assert [axes.get_title() for axes in figure.axes[:2]] == [
        "shaft, rising speed",
        "shaft, falling speed",
    ]
    changing = np.abs(data["rising"].values) == 1
    strongest = data["frequency"].values[data["shaft"].values.argmax(axis=0)]
    resolution = 4.0 * np.diff(data["frequency"].values)[0]
    np.testing.assert_allclose(
        strongest[changing], -2.0 * data["speed"].values[changing], atol=resolution
    )
    assert float(data["shaft"].max()) == pytest.approx(1e-3, rel=0.3)
    top = data["speed"].values.argmax()
    assert (data["rising"].values[: top - 2] == 1).all()
    assert (data["rising"].values[top + 2 :] == -1).all()


def test_the_waterfall_marks_speeds_at_which_an_imbalance_excites(through: xr.Dataset) -> None:
    """A backward critical speed, and one beyond the windows, have no line."""
    rpm = np.array([6000.0, 7000.0, 20000.0])
    marked = through.drop_dims("critical_speed").assign(
        critical_speed=("critical_speed", rpm * np.pi / 30.0),
        critical_whirl=("critical_speed", ["backward", "elliptic", "forward"]),
    )
    figure, _ = RunFigures(marked).draw("waterfall")
    for axes in figure.axes[:2]:
        lines = [line for line in axes.lines if line.get_label() == "critical speed"]
        np.testing.assert_allclose([np.asarray(line.get_xdata()) for line in lines], [[7000.0] * 2])
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["critical speed"]


def test_the_waterfall_of_a_probe_has_the_order_of_the_imbalance(through: xr.Dataset) -> None:
    figure, data = RunFigures(through).draw("sensor-waterfall")
    assert_legible(figure)
    strongest = data["probe_frequency"].values[data["probe"].values.argmax(axis=0)]
    late = slice(len(strongest) // 3, None)
    resolution = 4.0 * np.diff(data["probe_frequency"].values)[0]
    np.testing.assert_allclose(strongest[late], data["probe_speed"].values[late], atol=resolution)


def test_windows_of_a_waterfall_are_as_long_as_the_speed_of_their_change_allows(
    through: xr.Dataset,
) -> None:
    """7,100 rpm in 50 ms are 2,367 Hz/s: a window of 2 / sqrt(rate) = 41.1 ms; an amplitude of 3 in
    it is drawn as 3."""
    time = through["time"].values
    signal = xr.DataArray(3.0 * np.cos(600.0 * time), {"time": time}, attrs={"type": "centre"})
    data = sensor_waterfall(xr.Dataset({"probe": signal}), through)
    assert float(data["probe_time"][0]) == pytest.approx(0.5 * 41.1e-3, rel=5e-3)
    assert float(data["probe"].max()) == pytest.approx(3.0, rel=1e-2)


def test_a_constant_speed_has_no_waterfall(through: xr.Dataset) -> None:
    time = through["time"].values
    steady = through.assign(
        rotation_speed=("time", np.full(len(time), 300.0)),
        rotation_angle=("time", 300.0 * time),
    )
    with pytest.raises(ViewError, match="a speed that changes"):
        RunFigures(steady).draw("waterfall")

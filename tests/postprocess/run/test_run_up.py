"""Runs whose speed varies: angles, orbits in static axes, tip timing and the figure over speed."""

from pathlib import Path

import meshio
import numpy as np
import pytest
import xarray as xr

from bladewhirl.models.case.file import loads
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.result import completed
from bladewhirl.postprocess.paraview.series import export_vtk
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.run.tip_timing import tip_timing
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

CASE = """
[bladed_disk]
blades = 5
[reduction]
fixed_interface_modes = 15
[excitation]
type = "imbalance"
unbalance = 0.02
[march]
time_step = "2 us"
duration = "0.06 s"
speed_table = [["0 s", 0.3], ["0.03 s", 1.2], ["0.06 s", 0.6]]
record_step = "0.05 ms"
"""


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return march_in_memory(prepare(loads(CASE)))[0]


def test_angles_follow_the_course_also_between_records(result: xr.Dataset) -> None:
    stage = prepare(loads(CASE)).stage
    course = stage.case.march.course(stage.reference_frequency)
    assert course is not None
    times = np.linspace(0.0, 0.06, 1777)
    np.testing.assert_allclose(rotation.angle_at(result, times), course.angle(times), atol=1e-7)
    np.testing.assert_allclose(rotation.speed_at(result, times), course.speed(times), rtol=1e-5)
    assert result.attrs["highest_speed"] == pytest.approx(course.range[1])


def test_the_orbit_in_static_axes_is_turned_by_the_angle(result: xr.Dataset) -> None:
    orbit = shaft_orbit(result)
    turned = orbit["rotating"].values @ [1.0, 1j] * np.exp(1j * rotation.angles(result))
    np.testing.assert_allclose(orbit["static"].values @ [1.0, 1j], turned, atol=1e-18)
    moved = np.gradient(orbit["static"].values, result["time"].values, axis=0)
    largest = np.abs(moved).max()
    np.testing.assert_allclose(
        orbit["static_velocity"].values[5:-5], moved[5:-5], atol=2e-2 * largest
    )


def test_tips_arrive_at_the_true_angle(result: xr.Dataset) -> None:
    timing = tip_timing(result, ["0 deg"])
    arrival, deflection = timing["arrival"].values[0], timing["deflection"].values[0]
    radius = float(result["contact_radius"][0])
    angle = rotation.angle_at(result, np.nan_to_num(arrival)) + deflection / radius
    angle = angle + result["tip_angle"].values[:, None]
    whole = angle / (2.0 * np.pi)
    here = np.isfinite(arrival)
    assert here.sum() > 5
    np.testing.assert_allclose(whole[here], np.round(whole[here]), atol=1e-9)


def test_series_turn_by_the_angle(result: xr.Dataset, tmp_path: Path) -> None:
    records = np.array([100, 700])
    export_vtk(result, tmp_path, records=records)
    angles = rotation.angles(result)[records]
    assert EnlargedStage(
        result, records, factor=1.0, pieces=1, per_element=1
    ).turns == pytest.approx(angles)
    places = []
    for n in range(2):
        contact = meshio.read(tmp_path / "frames" / f"contact_0000{n}.vtu")
        first = contact.points[contact.cell_data["blade"][0].tolist().index(0)]
        places.append(np.arctan2(first[1], first[0]))
    turned = np.exp(1j * np.array(places)) / np.exp(1j * angles)
    np.testing.assert_allclose(turned, turned[0], atol=1e-6)


def test_the_figure_tells_rising_from_falling_speeds(result: xr.Dataset, tmp_path: Path) -> None:
    figure, data = RunFigures(result).draw("run-up")
    rising = data["rising"].values
    assert rising[200] == 1
    assert rising[900] == -1
    assert len(figure.axes) == 2 + bool(data["force"].any())
    assert "0.3 to 1.2" in figure.get_suptitle()


def test_the_figure_marks_first_contact_and_critical_speeds(result: xr.Dataset) -> None:
    """Only forward critical speeds between the slowest and the fastest speed are marked."""
    speeds = np.array([0.5, 0.9, 2.0]) * float(result.attrs["reference_frequency"])
    touched = result["contact_steps"].copy(data=np.zeros_like(result["contact_steps"]))
    touched[7:, 2] = 1
    known = result.assign(
        contact_steps=touched,
        critical_speed=("critical_speed", speeds),
        critical_whirl=("critical_speed", ["backward", "forward", "forward"]),
    )
    figure, data = RunFigures(known).draw("run-up")
    assert data["critical_speed"].values.tolist() == speeds[1:].tolist()
    upper, lower = figure.axes[:2]
    lines = {str(line.get_label()): line for line in lower.get_lines()}
    rpm = 30.0 / np.pi
    touch, critical = (
        np.asarray(lines[name].get_xdata()) for name in ("first contact", "critical speed")
    )
    assert touch.tolist() == [rpm * data["speed"].values[7]]
    assert critical.tolist() == [rpm * speeds[1]] * 2
    assert np.asarray(upper.get_lines()[-1].get_xdata()).tolist() == [result["time"].values[7]]


def test_without_a_shaft_the_figures_show_contact_nodes(result: xr.Dataset) -> None:
    """A mode vibrates with 2.5 times the fastest speed; its amplitude is that of its shape."""
    fastest = np.abs(rotation.speeds(result)).max()
    motion, time = np.zeros(result["rotor_displacement"].shape), result["time"].values
    motion[:, 3] = 1e-3 * np.sin(2.5 * fastest * time)
    force = np.zeros_like(result["contact_impulse"].values)
    force[400:500, 2] = 0.05 * result.attrs["record_step"]
    known = result.drop_vars(["centre_shape", "contact_displacement"]).assign(
        rotor_displacement=result["rotor_displacement"].copy(data=motion),
        contact_impulse=result["contact_impulse"].copy(data=force),
    )
    known = completed(known)
    shape = known["contact_displacement"].values
    figure, data = RunFigures(known).draw("run-up")
    assert data.attrs["moves"] == "tips"
    largest = np.linalg.norm(shape[..., :2], axis=-1).max(axis=1)
    np.testing.assert_allclose(data["displacement"].values, largest, rtol=1e-12)
    assert float(data["force"].max()) == pytest.approx(0.05)
    assert len(figure.axes) == 3
    assert "contact node" in figure.axes[1].get_ylabel()
    _, data = RunFigures(known).draw("waterfall")
    window = int(np.abs(data["time"].values - 0.03).argmin())
    spectrum = data["tip"].values[:, window]
    found = data["frequency"].values[spectrum.argmax()]
    width = np.diff(data["frequency"].values)[0]
    assert found == pytest.approx(2.5 * fastest, abs=1.1 * width)
    assert spectrum.max() == pytest.approx(np.abs(shape[..., 1]).max(), rel=0.15)

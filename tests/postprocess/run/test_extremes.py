"""Works, drive, largest values and late motion of a run, against motions in closed form."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from scipy.interpolate import CubicHermiteSpline

import bladewhirl as bw
from bladewhirl.postprocess.energy.regimes import classify
from bladewhirl.postprocess.energy.works import (
    drive_work,
    friction_supply,
    friction_torque_impulse,
    late_rate,
    leading_source,
    works,
)
from bladewhirl.postprocess.fields.kinematics import clearance_at
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.run.extremes import casing_peaks, largest_force, stress_peaks
from bladewhirl.postprocess.run.stresses import peak_stresses, stress_history
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.sweep.digest import late_motion, radius_peaks


@pytest.fixture
def result() -> xr.Dataset:
    """Tips push into the casing."""
    return synthetic.synthetic_result(shaft_radius=1.5e-3, records=1001)


def test_the_drive_gives_what_contact_does_and_what_is_rubbed_away(result: xr.Dataset) -> None:
    actual = works(result)
    dragged = float(result["friction_impulse"].sum()) * synthetic.SPEED * synthetic.TIP_RADIUS
    assert actual["drive"] == pytest.approx(dragged)  # normal forces do no work here
    assert actual["heat"] == pytest.approx(dragged - actual["friction"])
    risen = float(result["energy"][-1] - result["energy"][0])
    assert actual["springs"] is not None
    fed = actual["load"] + actual["normal"] + actual["friction"] + actual["springs"]
    assert risen == pytest.approx(fed + actual["damping"])
    power = late_rate(result, drive_work(result))
    assert power == pytest.approx(dragged, rel=0.2)  # in one second
    torque = late_rate(result, friction_torque_impulse(result))
    assert torque == pytest.approx(power / synthetic.SPEED)


def test_the_largest_source_is_named_in_the_reason(result: xr.Dataset) -> None:
    turned = xr.DataArray(np.linspace(0.0, 414e3, 1001), dims="time")
    fed = result.assign(normal_work=turned, external_work=0.0 * turned + 700.0)
    assert leading_source(fed).startswith("most energy came from normal contact forces (the wall")
    assert "4.14e+05 J" in classify(fed, np.ones(1001)).reason
    still = fed.assign(normal_work=0 * turned, external_work=0 * turned, coupling_work=0 * turned)
    assert leading_source(still) == ""
    still["rotor_frequency"][:2] *= -1.0
    still["energy"] -= 2.0 * float(still["energy"].max())
    assert leading_source(still).startswith("damping of the bladed disk drives its whirl")


def test_the_casing_moves_most_where_and_when_it_does(result: xr.Dataset) -> None:
    shape, motion = result["casing_shape"].values, result["casing_displacement"].values
    for way, component in (("radial", 0), ("tangential", 2)):
        values, slopes = motion @ shape[:, component].T, motion @ shape[:, component + 1].T
        arc = np.linspace(0.0, 2.0 * np.pi * result.attrs["casing_radius"], 41)
        closed = [np.append(field, field[:, :1], axis=1) for field in (values, slopes)]
        wall = CubicHermiteSpline(arc, *closed, axis=1)(np.linspace(0.0, arc[-1], 1000))
        peak = casing_peaks(result)[way]
        record = round(1e3 * peak["time"])
        assert abs(peak["displacement"]) == pytest.approx(np.abs(wall).max(), rel=1e-2)
        there = wall[record, round(peak["angle"] / 360.0 * 999)]
        assert peak["displacement"] == pytest.approx(there, rel=1e-2)


def test_a_force_is_a_mean_over_a_stated_time() -> None:
    impulse = np.zeros((401, 22))
    impulse[100:110, 3] = 0.2
    impulse[250, 7] = 1.0
    result = synthetic.synthetic_result().assign(
        contact_impulse=(("time", "contact_node"), impulse)
    )
    coarse = largest_force(result)
    assert (coarse["blade"], coarse["averaged_over"]) == (7, 1e-3)
    assert coarse["force"] == pytest.approx(1.0 / 1e-3)
    assert coarse["on_blade"] == coarse["force"]  # a single node
    fine = largest_force(result.assign_attrs(record_step=1e-4))
    assert fine["blade"] == 3
    assert fine["averaged_over"] == pytest.approx(1e-3)
    assert fine["force"] == pytest.approx(10 * 0.2 / 1e-3)


def test_stresses_are_the_peaks_of_their_history(result: xr.Dataset) -> None:
    history = stress_history(result)
    actual = stress_peaks(peak_stresses(result))
    blades = np.abs(history["peak_stress"].values[:-1])
    assert abs(actual["bladed_disk"]["stress"]) == pytest.approx(blades.max())
    assert actual["bladed_disk"]["member"] == history["member"].values[blades.argmax()]
    assert actual["casing"]["stress"] == pytest.approx(float(history["peak_stress"][-1]))
    assert actual["casing"]["member"] == "casing"


def of(result: xr.Dataset) -> dict[str, Any]:
    late = late_part(result)
    return late_motion(late, shaft_orbit(late))


def test_a_drifting_whirl_scatters() -> None:
    """A chirp from 15 to 25 Hz over the last third: its rates are evenly spread."""
    result = synthetic.synthetic_result(records=3001)
    time = result["time"].values
    begin, end = time[-1] * 2 / 3, time[-1]
    rate = 2 * np.pi * (15.0 + 10.0 * (time - begin) / (end - begin))
    angle = np.concatenate([[0.0], np.cumsum(np.diff(time) * (rate[1:] + rate[:-1]) / 2)])
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    result["rotor_displacement"][:, :2] = 1e-3 * circle
    result["rotor_velocity"][:, :2] = 1e-3 * rate[:, None] * (circle[:, ::-1] * [-1.0, 1.0])
    result["rotor_displacement"][:, 2:] = 0.0
    actual = of(result)
    assert actual["whirl_frequency"] == pytest.approx(20.0, rel=1e-3)
    assert actual["whirl_scatter"] == pytest.approx(10.0 / np.sqrt(12.0), rel=0.02)


def test_maxima_of_an_ellipse_are_its_long_half_axis() -> None:
    """Seven records a turn: the maxima lie between them."""
    time = 0.01 * np.arange(100)
    turn = 2 * np.pi * 100.0 / 7.0 * time
    place = np.column_stack([3.0 * np.cos(turn), 2.0 * np.sin(turn)])
    velocity = 200.0 * np.pi / 7.0 * np.column_stack([-3.0 * np.sin(turn), 2.0 * np.cos(turn)])
    orbit = xr.Dataset(
        {"rotating": (("time", "axis"), place), "rotating_velocity": (("time", "axis"), velocity)},
        coords={"time": time},
    )
    peaks = radius_peaks(orbit)
    assert len(peaks) == 28  # twice a turn, the first record itself left out
    np.testing.assert_allclose(peaks, 3.0, rtol=0.02)


@pytest.mark.parametrize("records", [1, 2, 401])
def test_a_shaft_at_rest_has_no_whirl(records: int) -> None:
    result = synthetic.synthetic_result(shaft_radius=0.0, records=records, speed=0.0)
    actual = of(result)
    assert actual["late_radius"] == 0.0
    assert np.isnan(actual["whirl_frequency"])
    assert actual["whirl_rotating"] == "none"
    assert actual["scenario"] == "at-rest"
    assert len(actual["section"]) == len(actual["radius_peak"]) == 0


WALLS: dict[str, dict[str, Any]] = {
    "bare": {},
    "closing": {"closure": {"amount": "1 mm", "time_constant": "0.02 s"}},
    "coated": {
        "coating": {"thickness": "0.3 mm", "young_modulus": "2 GPa", "yield_stress": "5 MPa"}
    },
}


def rub(folder: Path, wall: dict[str, Any], speed: float, **load: object) -> xr.Dataset:
    """Six blades that rub without friction."""
    case = bw.case_from(
        {
            "bladed_disk": {"blades": 6, "elements_per_blade": 3},
            "casing": {"elements": 16, "support": 8e6, "clearance": "0.5 mm", **wall},
            "contact": {"friction": 0.0},
            "reduction": {"fixed_interface_modes": 20},
            "excitation": load or {"type": "casing-distortion"},
            "march": {"speed": speed, "duration": "50 ms", "record_step": "10 us"},
        }
    )
    with bw.run(case, folder, frames=0, overwrite=True).open() as result:
        return result.load()


def test_the_late_power_of_the_drive_is_that_of_whole_revolutions() -> None:
    """Of one revolution of 0.628 s in the last second, in which the work t^2 has the mean power
    6 - 0.628 at 3 s, by hand."""
    time = np.linspace(0.0, 3.0, 30_001)
    data = xr.Dataset(coords={"time": time}, attrs={"speed": -10.0})
    assert late_rate(data, time**2) == pytest.approx(6.0 - 0.2 * np.pi, rel=1e-6)


@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.slow
def test_works_add_up_and_a_drive_at_rest_does_none(tmp_path: Path, wall: str) -> None:
    result = rub(tmp_path / "run", WALLS[wall], speed=0.0)
    actual = works(result)
    sources = ("load", "normal", "friction", "springs", "damping")
    rise = float(result["energy"][-1] - result["energy"][0])
    assert sum(actual[name] for name in sources) == pytest.approx(rise, rel=1e-9)  # type: ignore[literal-required]
    assert actual["damping"] < 0.0
    assert actual["drive"] == late_rate(result, drive_work(result)) == 0.0
    assert abs(actual["normal"]) > 5.0
    # The same terms without the rule for a speed of zero.
    balance = drive_work(result.assign_attrs(speed=1e-12))[-1]
    assert np.isnan(balance) if wall == "coated" else abs(balance) < 1e-3 * abs(actual["normal"])


def test_friction_takes_the_work_of_the_mean_speed_since_the_last_record() -> None:
    """2 N s before each of four records, while the speed rises from 10 to 50 rad/s."""
    speed, impulse = np.array([10.0, 20.0, 30.0, 40.0, 50.0]), np.zeros((5, 22))
    impulse[1:, 3] = 2.0
    result = synthetic.resting(5).assign(
        friction_impulse=(("time", "contact_node"), impulse),
        rotation_speed=("time", speed),
        rotation_angle=("time", 1e-3 * np.cumsum(speed)),
    )
    radius = float(result.attrs["tip_radius"])
    expected = 2.0 * radius * np.array([0.0, 15.0, 40.0, 75.0, 120.0])
    np.testing.assert_allclose(friction_supply(result), expected, rtol=1e-12)


@pytest.mark.slow
def test_the_drive_works_against_the_slope_of_the_wall(tmp_path: Path) -> None:
    """The torque of normal forces on a rigid wall, from its forces and its slope."""
    wall = {"clearance_lobes": [{"lobes": 3, "amplitude": "0.49 mm"}], "support": 1e12}
    result = rub(tmp_path / "run", wall, 1.05, type="imbalance", unbalance="5 kg m", ramp="10 ms")
    omega, time = float(result.attrs["speed"]), result["time"].values
    angle = result["tip_angle"].values + omega * (time - 0.5 * np.diff(time, prepend=0.0))[:, None]
    node = np.linspace(0.0, 2.0 * np.pi, 3601)
    slope = np.interp(angle, node, np.gradient(clearance_at(result, node), node), period=2 * np.pi)
    passed = -omega * np.sum(result["contact_impulse"].values * slope)
    assert passed > 1.0
    assert works(result)["drive"] == pytest.approx(passed, rel=0.05)

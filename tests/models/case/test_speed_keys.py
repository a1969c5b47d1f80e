"""Keys of a speed that varies: the speed over time that they give, and what is refused."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import bladewhirl as bw
from bladewhirl.models.case.excitation import Imbalance
from bladewhirl.models.case.speed_course import SpeedCourse

RPM = np.pi / 30.0
TABLE = [["0.5 s", "3000 rpm"], ["2 s", "9000 rpm"], ["3 s", "9000 rpm"], ["5 s", "-600 rpm"]]


def course_of(**march: Any) -> SpeedCourse:
    course = bw.case_from({"march": {"duration": 6.0, **march}}).march.course(1.0)
    assert course is not None
    return course


@pytest.mark.parametrize(
    "march",
    [
        {"speed_table": TABLE},
        {"speed_table": TABLE, "speed_blend": "0.4 s"},
        {"run_up": {"from": "1000 rpm", "to": "9000 rpm", "start": "1 s", "end": "3 s"}},
    ],
)
def test_angle_and_acceleration_belong_to_a_smooth_speed(march: dict[str, Any]) -> None:
    course = course_of(**march)
    times = np.linspace(0.0, 6.0, 4001)
    speed, rate = course.speed(times), course.acceleration(times)
    np.testing.assert_allclose(np.gradient(speed, times)[1:-1], rate[1:-1], atol=4.0)
    assert np.abs(np.diff(rate)).max() < 30.0  # of up to 1000 rad/s2: no step
    assert rate[0] == rate[-1] == 0.0
    for end in (0.7, 2.05, 6.0):
        points = course.pieces[1:, 0][course.pieces[1:, 0] < end]
        turned, _ = quad(lambda t: float(course.speed(t)), 0.0, end, points=points, limit=200)
        assert float(course.angle(end)) == pytest.approx(turned, rel=1e-12)
    low, high = course.range
    assert low == pytest.approx(speed.min(), rel=1e-5)
    assert high == pytest.approx(speed.max(), rel=1e-5)


def test_the_speed_is_that_of_the_table_and_linear_between_its_rows() -> None:
    course = course_of(speed_table=TABLE, speed_blend="0.2 s")
    np.testing.assert_allclose(
        course.speed([0.0, 0.5, 5.0, 6.0]), np.array([3000.0, 3000.0, -600.0, -600.0]) * RPM
    )
    inner = course.speed(np.linspace(0.75, 1.75, 7))
    np.testing.assert_allclose(np.diff(inner, 2), 0.0, atol=1e-9)
    held = course.speed(np.linspace(2.0, 3.0, 11))
    np.testing.assert_allclose(held, 9000.0 * RPM, rtol=1e-14)
    risen = course_of(speed_table=[["0 s", 1.0], ["1 s", 3.0], ["2 s", 2.0]], speed_blend=0.2)
    np.testing.assert_allclose(risen.speed([0.0, 1.0, 2.0]), [1.0, 3.0, 2.0], rtol=1e-14)
    sharp = course_of(speed_table=TABLE, speed_blend=0.0)
    np.testing.assert_allclose(sharp.speed([0.5, 2.0, 2.5, 3.0, 5.0]) / RPM, [
        3000.0, 9000.0, 9000.0, 9000.0, -600.0
    ])  # fmt: skip


def test_a_run_up_is_the_smooth_step() -> None:
    course = course_of(run_up={"from": 1.0, "to": 3.0, "start": 1.0, "end": 2.0})
    share = np.array([0.0, 0.0, 0.25, 0.5, 1.0, 1.0])
    expected = 1.0 + 2.0 * (3.0 * share**2 - 2.0 * share**3)
    np.testing.assert_allclose(course.speed([0.0, 1.0, 1.25, 1.5, 2.0, 5.0]), expected)


@pytest.mark.parametrize(
    ("march", "message"),
    [
        (
            {"speed_table": [["1 s", "30 rpm"], ["0.5 s", "40 rpm"]]},
            'march.speed_table = [["1 s", "30 rpm"], ["0.5 s", "40 rpm"]]: expected rows in'
            " ascending order of time; row 1 is at 0.5 s",
        ),
        ({"speed_table": []}, "march.speed_table = []: expected from 1 to 10000 rows"),
        ({"speed_blend": 0.1}, "march.speed_blend = 0.1: expected a key that needs"),
        (
            {"speed_table": [[0.0, 1.0], [1.0, 2.0]], "speed_blend": 0.6},
            "march.speed_blend = 0.6: expected at most 0.5 s",
        ),
        (
            {"speed_table": [[0.0, 1.0], [1.0, "90 rpm"]]},
            "expected either numbers or texts with a unit as speeds",
        ),
        (
            {"speed_table": [[0.0, 1.0], [1e-3, 2.0]]},
            "march.record_step = 1e-4: expected at most",
        ),
        (
            {"run_up": {"from": 1.0, "to": 2.0, "start": 2.0, "end": 1.0}},
            "march.run_up.end = 1.0: expected a time after start = 2 s",
        ),
        (
            {"run_up": {"from": 1.0, "to": 2.0, "end": 1.0}, "speed_table": [[0.0, 1.0]]},
            "march.run_up",
        ),
        (
            {"run_up": {"from": 1.0, "to": 2.0, "end": 1.0}, "speed": 1.0},
            "march.speed = 1.0: not allowed together with march.run_up",
        ),
        (
            {"run_up": {"from": 1.0, "to": 2.0, "end": 1.0}, "revolutions": 10.0},
            "march.revolutions = 10.0: not allowed with a speed that varies",
        ),
    ],
)
def test_what_is_refused(march: dict[str, Any], message: str) -> None:
    with pytest.raises(bw.CaseError) as error:
        bw.case_from({"march": {"record_step": 1e-4, **march}})
    assert message in str(error.value)


def test_an_unbalance_by_its_grade() -> None:
    """G 6.3 is e Omega = 6.3 mm/s: for 120 kg at 3000 rpm 2.41 kg mm."""
    size = 6.3e-3 * 120.0 / (3000.0 * RPM)
    for grade in ("G 6.3", "6.3 mm/s", 6.3e-3):
        balance = {"grade": grade, "mass": "120 kg", "speed": "3000 rpm"}
        case = bw.case_from({"excitation": {"type": "imbalance", "balance": balance}})
        load = case.excitations["excitation"]
        assert isinstance(load, Imbalance)
        assert load.size(1.0) == pytest.approx(size, rel=1e-12)
    given = bw.case_from({"excitation": {"type": "imbalance", "unbalance": "2406 g mm"}})
    load = given.excitations["excitation"]
    assert isinstance(load, Imbalance)
    assert load.size(1.0) == pytest.approx(size, rel=1e-3)

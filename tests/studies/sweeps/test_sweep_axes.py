"""What a sweep runs over: ranges, lists, units, keys, and everything wrong with them."""

import numpy as np
import pytest
from faults import fault

import bladewhirl as bw
from bladewhirl.models.case.analysis import March
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.table import path_of, value_at
from bladewhirl.studies.sweeps.axes import (
    Axis,
    Value,
    check_key,
    coordinate,
    make_grid,
    parse_over,
)
from bladewhirl.studies.sweeps.plan import plan_sweep


def values(option: str) -> tuple[Value, ...]:
    [actual] = parse_over([option]).values()
    return actual


def test_a_range_holds_the_numbers_one_would_type() -> None:
    actual = values("march.speed=0.95:2.0:0.005")
    assert len(actual) == 211
    assert actual == tuple(float(f"{0.95 + 0.005 * i:.3f}") for i in range(211))


@pytest.mark.parametrize(
    ("option", "expected"),
    [
        ("a=1:2:0.5", (1, 1.5, 2)),
        ("a=0:1:0.3", (0, 0.3, 0.6, 0.9)),
        ("a=0:1:0.3333333333", (0, 0.3333333333, 0.6666666666, 1)),
        ("a=-1:1:1", (-1, 0, 1)),
        ("a=20:24:2", (20, 22, 24)),
        ("a=2000 rpm:2020 rpm:10 rpm", ("2000 rpm", "2010 rpm", "2020 rpm")),
        ("a=0.05,0.1", (0.05, 0.1)),
        ("a=3, 1, 2", (3, 1, 2)),
        ("a=1e-3,2e-3", (0.001, 0.002)),
        ("a=0.5 mm,1 mm", ("0.5 mm", "1 mm")),
    ],
)
def test_ranges_and_lists(option: str, expected: tuple[Value, ...]) -> None:
    assert values(option) == expected
    assert [type(value) for value in values(option)] == [type(value) for value in expected]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("march.speed", "expected KEY="),
        ("a=1:2", "START:STOP:STEP"),
        ("a=1:nan:1", "expected numbers"),
        ("a=1:2:0", "a positive STEP"),
        ("a=1:1.05:0.1", "2 to 10000000 points"),
        ("a=1,,2", "expected numbers"),
        ("a=1 mm:2:1", "the same unit"),
        ("a=1,2 a=3,4", "each key at most once"),
    ],
)
def test_bad_ranges_say_what_was_expected(options: str, message: str) -> None:
    given = [options] if " mm" in options else options.split()
    line = fault(parse_over, given)
    assert line.startswith("--over")
    assert message in line


def test_products_run_fastest_over_the_last_key() -> None:
    grid = make_grid(
        Case(), {"march.speed": (1.0, 1.1), "contact.friction": (0.0, 0.1, 0.2)}, large=False
    )
    assert (grid.shape, grid.size) == ((2, 3), 6)
    assert grid.label(4) == "march.speed = 1.1, contact.friction = 0.1"
    cases = list(grid.cases(Case()))
    assert [case.contact.friction for case in cases] == [0.0, 0.1, 0.2] * 2
    assert [case.march.speed.value for case in cases] == [1.0] * 3 + [1.1] * 3


def test_large_sweeps_are_asked_for() -> None:
    over = {"march.speed": range(1, 1001), "contact.friction": range(101)}
    with pytest.raises(UserError, match="101000 points are more than 100000; --yes"):
        make_grid(Case(), over, large=False)
    assert make_grid(Case(), over, large=True).size == 101_000


@pytest.mark.slow
def test_more_steps_than_a_cluster_marches_in_weeks_are_asked_for() -> None:
    speeds = [1 + 1e-3 * number for number in range(1000)]
    over = {"march.duration": (500.0, 600.0), "march.speed": speeds}
    grid = make_grid(Case(), over, large=False)
    with pytest.raises(UserError, match=r"1.1e\+12 steps of all marches are more than 1e\+12"):
        plan_sweep(Case(), grid, large=False)


@pytest.mark.slow
def test_coordinates_are_si_numbers_with_their_unit() -> None:
    over = {"casing.clearance": ("0.5 mm", "1 mm"), "march.speed": ("60 rpm", "120 rpm")}
    case = Case(march=March(duration=1e-3))
    plan = plan_sweep(case, make_grid(case, over, large=False))
    clearance, metre = plan.coordinates["casing.clearance"]
    assert (clearance.tolist(), metre) == ([5e-4, 1e-3], "m")
    speed, unit = plan.coordinates["march.speed"]
    np.testing.assert_allclose(speed, [2 * np.pi, 4 * np.pi], rtol=1e-15)
    assert unit == "rad/s"


def test_speeds_of_two_kinds_share_no_axis() -> None:
    speeds = [March(speed=given).speed for given in (1.0, "60 rpm")]
    with pytest.raises(UserError, match="all speeds as numbers"):
        coordinate(speeds)


def test_values_of_several_units_have_no_coordinate_in_one_of_them() -> None:
    for values, unit in (
        (("2500 rpm", "40 Hz"), ""),
        (("1 mm", "0.2 cm"), ""),
        (("1 mm", 2e-3), ""),
        (("2500 rpm", "2600rpm"), "rpm"),
        (("40 Hz", "50 Hz"), "Hz"),
        ((1.0, 2.0), ""),
    ):
        assert Axis(key="march.speed", values=values).unit == unit
    np.testing.assert_array_equal(
        Axis(key="k", values=("2500 rpm", "26e2rpm")).numbers, [2500, 2600]
    )


def test_keys_have_the_names_of_the_case_file() -> None:
    """Not those of attributes, as `from` is no name in Python."""
    lost = bw.case_from({"blade_loss": {"blade": 3, "time": "1 ms", "from": 0.5}})
    ramp = {"from": "100 rpm", "to": "200 rpm", "end": "2 s"}
    faster = bw.case_from({"march": {"run_up": ramp}})
    for case, key, other in (
        (lost, "blade_loss.from", "blade_loss.share"),
        (faster, "march.run_up.from", "march.run_up.first"),
    ):
        check_key(case, key)
        assert value_at(case, path_of(key)) is not None
        with pytest.raises(UserError, match="holds a number"):
            check_key(case, other)

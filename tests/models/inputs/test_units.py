"""Text with units: SI values, and refusals that say why."""

import math
from contextlib import suppress
from typing import Literal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bladewhirl.models.inputs import units
from bladewhirl.models.inputs.units import RAD_PER_S, TURN_PER_S, Speed, handy, rotation, to_si


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1 mm", "m", 1e-3),
        ("  2.5e1mm ", "m", 0.025),
        ("1 inch", "m", 0.0254),
        ("-3 µm", "m", -3e-6),
        ("210 GPa", "Pa", 2.1e11),
        ("30e6 psi", "Pa", 30e6 * 4.4482216152605 / 0.0254**2),
        ("7.8 g/cm3", "kg/m3", 7800.0),
        ("7800 kg/m³", "kg/m3", 7800.0),
        ("34 MN/m", "N/m", 3.4e7),
        ("1508 N/m per metre", "N/m2", 1508.0),
        ("7.975 N/mm**2", "N/m2", 7.975e6),
        ("30 kN/kg^0.5", "N/kg^0.5", 3e4),
        ("590 g·m", "kg m", 0.59),
        ("1 us", "s", 1e-6),
    ],
)
def test_text_becomes_si(text: str, unit: str, value: float) -> None:
    assert to_si(text, unit) == pytest.approx(value, rel=1e-15)


NUMBERS = "210", "0.1", "-7.975e-6", "1.2345678901234567e10", "3"


@pytest.mark.parametrize("unit", [*units._PREFIXED, *units._OTHERS])
def test_what_is_read_without_pint_is_what_pint_reads(
    unit: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts = [f"{number} {name}" for number in NUMBERS for name in units._factors(unit)]
    quick = [to_si(text, unit) for text in texts]
    monkeypatch.setattr(units, "_known", lambda text, factors: None)
    assert quick == [to_si(text, unit) for text in texts]


@pytest.mark.parametrize("unit", [RAD_PER_S, TURN_PER_S])
def test_speeds_read_without_pint_are_what_pint_reads(
    unit: Literal["rad/s", "turn/s"], monkeypatch: pytest.MonkeyPatch
) -> None:
    texts = [f"{number} {name}" for number in NUMBERS for name in units._SPEEDS]
    quick = [rotation(text, unit) for text in texts]
    monkeypatch.setattr(units, "_known", lambda text, factors: None)
    assert quick == [rotation(text, unit) for text in texts]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("3 kg", r"kilogram is \[mass\], not \[length\]"),
        ("1 m2", r"not \[length\]"),
        ("20 degC", r"\[temperature\]"),
        ("1", "no unit"),
        ("1 furlongz", "unknown unit"),
        ("", "not a number"),
        ("nan m", "not a number"),
        ("1e999 m", "not finite"),
        ("1 mm + 1 mm", "not a number"),
        ("9**9**9**9 m", "not a number"),
        ("1 dB m", "cannot be converted"),
        ("__import__('os') m", "not a number"),
        ("1 " + "m*" * 200 + "m", "not a number"),
    ],
)
def test_refusals_say_why(text: str, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        to_si(text, "m")


@settings(max_examples=40)
@given(st.text() | st.from_regex(r"\A[0-9]{1,3} ?[a-zA-Z*/^.0-9 -]{0,8}\Z"))
def test_any_text_is_a_number_or_a_refusal(text: str) -> None:
    with suppress(ValueError):
        assert math.isfinite(to_si(text, "m"))


@pytest.mark.parametrize(
    ("text", "turns"),
    [
        ("2500 rpm", 2500 / 60),
        ("2500 RPM", 2500 / 60),
        ("-60 rpm", -1.0),
        ("50 Hz", 50.0),
        ("0.05 kHz", 50.0),
        ("50 turn/s", 50.0),
        ("360 deg/s", 1.0),
        ("0 Hz", 0.0),
        ("314 rad/s", 314 / (2 * math.pi)),
    ],
)
def test_rotation_counts_hertz_as_turns(text: str, turns: float) -> None:
    assert rotation(text, TURN_PER_S) == pytest.approx(turns, rel=1e-15)
    assert rotation(text, RAD_PER_S) == pytest.approx(2 * math.pi * turns, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["50 1/s", "50 s", "50 Hz^2", "50 rad Hz", "50 rad", "50", "50 m/s"]
)
def test_rotation_refuses_what_is_not_an_angle_per_time(text: str) -> None:
    with pytest.raises(ValueError, match=r"not an angle per time|no unit"):
        rotation(text, RAD_PER_S)


def test_a_plain_speed_counts_the_reference() -> None:
    assert Speed(1.05).rad_per_s(200.0) == 210.0
    assert Speed(-2).rad_per_s(200.0) == -400.0
    assert Speed(0).rad_per_s(200.0) == 0.0
    assert Speed(1.05).kind == "normalised"


def test_a_speed_with_a_unit_ignores_the_reference_and_keeps_its_text() -> None:
    speed = Speed("3000 rpm")
    assert speed.rad_per_s(7.0) == pytest.approx(100 * math.pi, rel=1e-15)
    assert (speed.kind, speed.given) == ("rad/s", "3000 rpm")
    assert Speed("3000 rpm") == speed != Speed("3001 rpm")


@pytest.mark.parametrize("given_", [True, None, [1.0], math.nan, math.inf, 10**400, "1", "3 kg"])
def test_a_speed_is_a_finite_number_or_text_with_a_unit(given_: object) -> None:
    with pytest.raises(ValueError, match=r"."):
        Speed(given_)  # type: ignore[arg-type]


def test_zero_has_no_sign() -> None:
    assert handy(-0.0, "J") == "0 J"

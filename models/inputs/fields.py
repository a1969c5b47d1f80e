"""Types of the keys of a case: numbers in SI units or text with a unit, counts, speeds, rows.

For an invalid value, each type raises a pydantic error of type `EXPECTED` with a phrase that states
the expected value.
"""

import math
import os
import re
from collections.abc import Callable
from functools import cache
from numbers import Integral, Real
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, PlainSerializer, PlainValidator, TypeAdapter, ValidationError
from pydantic_core import PydanticCustomError

from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.inputs.units import LARGEST, TURN_PER_S, Speed, finite, rotation, to_si

EXPECTED = "expected"  #: type of the errors raised here, and the key of the phrase in their context

SMALLEST = 1.0 / LARGEST
"""Smallest accepted positive quantity, so that squares and ratios do not underflow or overflow."""

MOST = 100_000
"""Largest number of blades, elements or modes; a larger number is assumed to be a typing error."""

Sign = Literal["positive", "not negative", "any"]

_NUMBERS: dict[Sign, str] = {
    "positive": "a positive number",
    "not negative": "a number of zero or more",
    "any": "a finite number",
}

_EXAMPLES = {
    "m": "1 mm",
    "m/s": "5 mm/s",
    "m/s2": "9.81 m/s2",
    "s": "1 us",
    "N": "2 kN",
    "Pa": "210 GPa",
    "kg/m3": "7.8 g/cm3",
    "N/m": "34 MN/m",
    "N/m2": "1508 N/m2",
    "N s/m": "2 kN s/m",
    "N/kg^0.5": "30 kN/kg^0.5",
    "kg": "50 g",
    "kg m": "0.59 kg m",
    "kg m2": "2 kg cm2",
    "N m": "1 kN m",
    "N m s": "0.2 N m s",
    "rad": "30 deg",
    "Hz": "50 Hz",
}
"""Example of text with a unit, for each SI unit."""


def expectation(phrase: str, reason: object = "") -> PydanticCustomError:
    """Return an error that states the expected value and, in parentheses, the reason."""
    phrase = f"{phrase} ({reason})" if reason else phrase
    return PydanticCustomError(EXPECTED, "expected {expected}", {"expected": phrase})


def quantity(unit: str, sign: Sign = "positive") -> BeforeValidator:
    """Return a validator of numbers in ``unit``, or of text with a unit of the same dimension."""
    phrase = f'{_NUMBERS[sign]} in {unit}, or text with a unit such as "{_EXAMPLES[unit]}"'

    def convert(text: str) -> float:
        return rotation(text, TURN_PER_S) if unit == "Hz" else to_si(text, unit)

    return _checked(phrase, sign, convert)


def number(sign: Sign) -> BeforeValidator:
    """Return a validator of numbers without a unit."""

    def refuse(text: str) -> float:
        raise ValueError("this key has no unit")

    return _checked(_NUMBERS[sign], sign, refuse)


def count(least: int) -> BeforeValidator:
    """Return a validator of integers from ``least`` to `MOST`."""
    phrase = f"a whole number from {least} to {MOST}"

    def validate(value: Any) -> int:
        whole = isinstance(value, Integral) and not isinstance(value, bool)
        if not whole or not least <= int(value) <= MOST:
            raise expectation(phrase)
        return int(value)

    return BeforeValidator(validate)


def converted(validator: BeforeValidator, value: object) -> Any:
    """Return a value as the validator of a key converts it.

    Raises:
        PydanticCustomError: the value is invalid.
    """
    convert: Any = validator.func
    return convert(value)


def _checked(phrase: str, sign: Sign, convert: Callable[[str], float]) -> BeforeValidator:
    def validate(value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, str | Real):
            raise expectation(phrase)
        try:
            result = convert(value) if isinstance(value, str) else finite(value)
        except ValueError as error:
            raise expectation(phrase, error) from None
        if sign != "any" and 0.0 < result < SMALLEST:
            raise expectation(phrase, "too small")
        if (sign == "positive" and result <= 0.0) or (sign == "not negative" and result < 0.0):
            raise expectation(phrase)
        return result

    return BeforeValidator(validate)


_SPEED_PHRASE = (
    "a number (a multiple of the reference frequency) or text in rpm, Hz or rad/s such as "
    '"2500 rpm"'
)


def _speed(value: Any) -> Speed:
    try:
        return value if isinstance(value, Speed) else Speed(value)
    except ValueError as error:
        raise expectation(_SPEED_PHRASE, error) from None


def _positive_speed(value: object) -> Speed:
    speed = _speed(value)
    if speed.value < SMALLEST:
        raise expectation(f"a positive speed: {_SPEED_PHRASE}")
    return speed


def text(pattern: re.Pattern[str], phrase: str) -> BeforeValidator:
    """Return a validator of text that matches a pattern."""

    def validate(value: object) -> str:
        if not isinstance(value, str) or not pattern.fullmatch(value):
            raise expectation(phrase)
        return value

    return BeforeValidator(validate)


def file_path(phrase: str) -> BeforeValidator:
    """Return a validator of paths, which become absolute, valid from every working directory."""

    def validate(value: object) -> str:
        if not isinstance(value, str | os.PathLike) or "\0" in os.fspath(value):
            raise expectation(phrase)
        return os.path.abspath(value)

    return BeforeValidator(validate)


def listed(value: Any, phrase: str, least: int = 1) -> tuple[Any, ...]:
    """Return the items of a list, a tuple or an array.

    Raises:
        PydanticCustomError: another value, or fewer items than `least`.
    """
    value = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(value, list | tuple) or len(value) < least:
        raise expectation(phrase)
    return tuple(value)


def _items(phrase: str, length: int | None = None) -> BeforeValidator:
    def validate(value: Any) -> tuple[object, ...]:
        items = listed(value, phrase, least=length or 0)
        if length and len(items) > length:
            raise expectation(phrase)
        return items

    return BeforeValidator(validate)


def rows(phrase: str) -> BeforeValidator:
    """Return a validator of an array of tables; ``phrase`` completes "rows of" in messages."""
    return _items(f"rows of {phrase}")


def positive(key: str, value: object, unit: str) -> float:
    """Convert a number, or text with a unit, to a positive number in ``unit``.

    Raises:
        CaseError: the value is not valid; the error names ``key``.
    """
    try:
        return _positive(unit).validate_python(value)
    except ValidationError as error:
        expected = error.errors()[0]["ctx"][EXPECTED]
        raise CaseError([Fault(key=key, value=value, expected=expected)]) from None


@cache
def _positive(unit: str) -> TypeAdapter[float]:
    return TypeAdapter(Annotated[float, quantity(unit)])


Length = Annotated[float, quantity("m")]
Modulus = Annotated[float, quantity("Pa")]
Density = Annotated[float, quantity("kg/m3")]
Mass = Annotated[float, quantity("kg", "not negative")]
Inertia = Annotated[float, quantity("kg m2", "not negative")]
LengthOrZero = Annotated[float, quantity("m", "not negative")]
Time = Annotated[float, quantity("s")]
TimeOrZero = Annotated[float, quantity("s", "not negative")]
Stiffness = Annotated[float, quantity("N/m")]
StiffnessOrZero = Annotated[float, quantity("N/m", "not negative")]
DampingOrZero = Annotated[float, quantity("N s/m", "not negative")]
Angle = Annotated[float, quantity("rad", "any")]
NumberOrZero = Annotated[float, number("not negative")]

_AS_GIVEN = PlainSerializer(lambda speed: speed.given)
RotationSpeed = Annotated[Speed, PlainValidator(_speed), _AS_GIVEN]
PositiveSpeed = Annotated[Speed, PlainValidator(_positive_speed), _AS_GIVEN]

_Coordinate = Annotated[float, quantity("m", "any")]


def _from_polar(value: Any) -> Any:
    """Return x and y [m] of a radius with an angle as text; other values as they are."""
    if not isinstance(value, list | tuple) or len(value) != 2 or not isinstance(value[1], str):
        return value
    try:
        angle = to_si(value[1], "rad")
    except ValueError:  # text in a unit of length
        return value
    radius = converted(quantity("m", "any"), value[0])
    return radius * math.cos(angle), radius * math.sin(angle)


Position = Annotated[
    tuple[_Coordinate, _Coordinate],
    _items('two coordinates in m, or a radius and an angle such as "15 deg"', 2),
    BeforeValidator(_from_polar),
]
"""x and y, or a radius and, as text with its unit, an angle from the x axis."""

Place = Annotated[tuple[_Coordinate, _Coordinate, _Coordinate], _items("three coordinates in m", 3)]
_Velocity = Annotated[float, quantity("m/s", "any")]
DisplacementPair = Annotated[tuple[_Coordinate, _Coordinate], _items("two displacements in m", 2)]
VelocityPair = Annotated[tuple[_Velocity, _Velocity], _items("two velocities in m/s", 2)]
DisplacementRows = Annotated[
    tuple[DisplacementPair, ...], _items("rows of two displacements in m, one row for each blade")
]
VelocityRows = Annotated[
    tuple[VelocityPair, ...], _items("rows of two velocities in m/s, one row for each blade")
]

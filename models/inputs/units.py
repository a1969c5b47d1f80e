"""Conversion of text with units to SI floats with pint: "1 mm", "210 GPa", "2500 rpm"."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cache
from itertools import pairwise
from numbers import Real
from typing import TYPE_CHECKING, Any, Final, Literal, SupportsFloat

from bladewhirl.models.inputs.errors import UserError

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pint

# Only text that matches this syntax is passed to pint, which would also evaluate "9**9**9 m".
_EXPONENT = r"-?(?:[1-9](?:\.[0-9])?|0\.[1-9])"
_FACTOR = rf"[^\W\d_][^\W\d]*(?:(?:\*\*|\^)?{_EXPONENT})?"
_TEXT = re.compile(
    r"\s*(?P<number>[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)\s*"
    rf"(?P<unit>(?:(?:1\s*/\s*)?{_FACTOR}(?:\s*[*/·]\s*{_FACTOR}|\s+{_FACTOR})*)?)\s*"
)
_POWER = re.compile(rf"(?<=[^\W\d])(?:\*\*|\^)?({_EXPONENT})")
_LONGEST = 80

_PREFIXED = ("m", "s", "N", "Pa", "N/m")
_PREFIXES = {"": 0, "u": -6, "µ": -6, "m": -3, "c": -2, "k": 3, "M": 6, "G": 9}
"""Powers of ten of common prefixes, converted without loading pint, which takes long."""

_TURN = 2 * Decimal("3.141592653589793238462643383280")
_SPEEDS = {"rad/s": Decimal(1), "rpm": _TURN / 60, "RPM": _TURN / 60, "Hz": _TURN}
"""Units of angular speed [rad/s] that are converted without loading pint."""
_OTHERS = {
    "kg": {"t": Decimal(1000), "kg": Decimal(1), "g": Decimal("0.001")},
    "rad": {"rad": Decimal(1), "deg": _TURN / 360},
    "kg/m3": {"kg/m3": Decimal(1), "g/cm3": Decimal(1000)},
}
"""Likewise, other units of a quantity."""

RAD_PER_S: Final = "rad/s"
TURN_PER_S: Final = "turn/s"


def to_si(text: str, unit: str) -> float:
    """Convert a number with its unit, such as "1 mm", to ``unit``, such as "m".

    Powers are written m2, m^2, m**2 or m².

    Raises:
        ValueError: the text is not a number with a unit, the unit is unknown or of another
            dimension, or the number is too large.
    """
    if (known := _known(text, _factors(unit))) is not None:
        return finite(known)
    quantity = _parse(text)
    needed = _registry().Unit(_spelled_out(unit))
    if quantity.dimensionality != needed.dimensionality:
        raise ValueError(_mismatch(quantity, str(needed.dimensionality)))
    return finite(quantity.to(_spelled_out(unit)).magnitude)


def rotation(text: str, unit: Literal["rad/s", "turn/s"]) -> float:
    """Convert text such as "2500 rpm", "50 Hz" (turns per second) or "314 rad/s" to ``unit``.

    In pint, Hz is 1/s and therefore equal to rad/s. Here Hz means turns per second, and 1/s is an
    error, because it could mean turns or radians per second.

    Raises:
        ValueError: the text is not a number with a unit of angular speed, or is too large.
    """
    if (known := _known(text, _SPEEDS)) is not None:
        return finite(known if unit == RAD_PER_S else known / _TURN)
    quantity = _parse(text)
    if any(name.endswith("hertz") for name, _ in quantity.unit_items()):
        quantity = quantity * _registry().Unit("turn")
    if quantity.to_root_units().units != _registry().Unit("radian / second"):
        raise ValueError(_mismatch(quantity, "an angle per time"))
    return finite(quantity.to(_spelled_out(unit)).magnitude)


_SCALES = (("G", 1e-9), ("M", 1e-6), ("k", 1e-3), ("", 1.0), ("m", 1e3), ("µ", 1e6))
_SCALED = re.compile(r"(m|s|g|N|W|Pa|Hz)\b")


def handy_unit(amount: float, unit: str) -> tuple[str, float]:
    """Return a unit with a prefix that suits an amount, and the factor that converts to the unit.

    The unit is the largest in which the amount is at least 0.1 (for units without prefix, or with m
    or µ) or at least 1 (for units with k, M or G): 0.5 mm, 0.2 s, 300 MPa. Metres are used from 1 m
    on. Lengths and times do not get the prefixes k, M and G.

    Args:
        amount: amount in the SI unit, zero or positive.
        unit: SI unit. Only units of length, time, mass, force, torque, power, stress and frequency
            get a prefix.
    """
    if unit.startswith("kg"):
        name, scale = handy_unit(1e3 * amount, unit.removeprefix("k"))
        return name, 1e3 * scale
    if amount > 0.0 and _SCALED.match(unit):
        for prefix, scale in _SCALES[3 if unit[0] in "ms" else 0 :]:
            least = 1.0 if scale < 1.0 or (unit == "m" and not prefix) else 0.1
            if amount * scale >= least * (1.0 - 1e-9) or prefix == "µ":
                return prefix + unit, scale
    return unit, 1.0


def handy(value: float, unit: str, digits: int = 6) -> str:
    """Return a value in SI units as text with a suitable prefix, such as "500 mm", for a case."""
    name, scale = handy_unit(abs(value), unit)
    return f"{scale * value + 0.0:.{digits}g} {name}"


@dataclass(frozen=True)
class Speed:
    """A speed of rotation as the user wrote it: positive, zero or negative.

    A number is a multiple of a reference frequency. Text has a unit: rpm, Hz (turns per second) or
    rad/s; the text is stored unchanged, so that a case is written as it was read.

    Raises:
        ValueError: the value is not a finite number, or text that is not valid for `rotation`.
    """

    given: float | str  #: multiple of the reference frequency, or text with a unit
    value: float = field(init=False, repr=False, compare=False)
    """Multiple of the reference frequency, or speed [rad/s], see `kind`."""

    def __post_init__(self) -> None:
        if isinstance(self.given, str):
            value = rotation(self.given, RAD_PER_S)
        elif isinstance(self.given, Real) and not isinstance(self.given, bool):
            value = finite(self.given)
            object.__setattr__(self, "given", value)
        else:
            raise ValueError("neither a number nor text")
        object.__setattr__(self, "value", value)

    def __str__(self) -> str:
        """Return text such as "1.05 x reference frequency" or "2500 rpm"."""
        given = self.given
        return given if isinstance(given, str) else f"{given:g} x reference frequency"

    @property
    def kind(self) -> Literal["normalised", "rad/s"]:
        """Unit of `value`."""
        return RAD_PER_S if isinstance(self.given, str) else "normalised"

    def rad_per_s(self, reference: float) -> float:
        """Return the angular speed [rad/s] for a ``reference`` frequency [rad/s]."""
        return self.value if self.kind == RAD_PER_S else self.value * reference

    def multiple(self, reference: float) -> float:
        """Return the speed as a multiple of a ``reference`` frequency [rad/s]."""
        return self.value / reference if self.kind == RAD_PER_S else self.value


def speed_of(value: Any, label: str) -> Speed:
    """Convert a multiple of the reference frequency, or text such as "2500 rpm", to a speed.

    Raises:
        UserError: the value is not a speed; the message begins with the label.
    """
    try:
        return Speed(value)
    except ValueError as error:
        raise UserError(
            f"{label}: expected multiples of the reference frequency, or text in rpm, Hz or rad/s"
            f" ({error})"
        ) from None


def ascending(label: str, values: Any, expected: str, least: float = -math.inf) -> list[float]:
    """Return one or more ascending finite numbers of at least `least`, (values,).

    Raises:
        UserError: the values are something else; the message is "LABEL: expected EXPECTED".
    """
    try:
        numbers = [finite(value) for value in values]
    except (TypeError, ValueError):
        numbers = []
    if not numbers or numbers[0] < least or any(b <= a for a, b in pairwise(numbers)):
        raise UserError(f"{label}: expected {expected}")
    return numbers


LARGEST = 1e30
"""Largest accepted number; SI quantities are far smaller, and products of numbers remain finite."""


def finite(number: SupportsFloat) -> float:
    """Convert a number to a finite float.

    Raises:
        ValueError: the number is NaN, infinite, or larger than `LARGEST`.
    """
    try:
        value = float(number)
    except OverflowError:
        raise ValueError("too large") from None
    if not math.isfinite(value):
        raise ValueError("not finite")
    if abs(value) > LARGEST:
        raise ValueError("too large")
    return value


def _known(text: str, factors: Mapping[str, Decimal]) -> Decimal | None:
    """Convert text with one of the units; None if pint is needed."""
    match = _TEXT.fullmatch(text) if len(text) <= _LONGEST else None
    factor = None if match is None else factors.get(match["unit"])
    return None if match is None or factor is None else Decimal(match["number"]) * factor


@cache
def _factors(unit: str) -> Mapping[str, Decimal]:
    """Return the factors to ``unit`` of units that are converted without loading pint."""
    if unit in _PREFIXED:
        return {prefix + unit: Decimal(1).scaleb(n) for prefix, n in _PREFIXES.items()}
    return _OTHERS.get(unit, {})


@cache
def _registry() -> pint.UnitRegistry[Decimal]:
    import pint

    # Decimals keep conversions exact: 210 GPa is 2.1e11 Pa to the last bit.
    return pint.UnitRegistry(non_int_type=Decimal)


def _parse(text: str) -> pint.Quantity[Decimal]:
    import pint

    match = _TEXT.fullmatch(text) if len(text) <= _LONGEST else None
    if match is None:
        raise ValueError("not a number followed by a unit")
    if not match["unit"]:
        raise ValueError("no unit")
    try:
        unit = _registry().parse_units(_spelled_out(match["unit"]))
    except pint.UndefinedUnitError:
        raise ValueError(f"unknown unit in {match['unit']!r}") from None
    except (pint.PintError, TypeError, ValueError):
        raise ValueError(f"{match['unit']!r} is not understood") from None
    quantity = _registry().Quantity(Decimal(match["number"]), unit)
    try:
        quantity.to_root_units()
    except (pint.PintError, TypeError, LookupError, AttributeError, ArithmeticError):  # as "dB m"
        raise ValueError(f"{match['unit']!r} cannot be converted") from None
    return quantity


def _spelled_out(unit: str) -> str:
    plain = unit.replace("·", "*").replace("²", "2").replace("³", "3").replace("RPM", "rpm")
    return _POWER.sub(r"**\1", plain)


def _mismatch(quantity: pint.Quantity[Decimal], needed: str) -> str:
    return f"{quantity.units} is {quantity.dimensionality}, not {needed}"

"""The `[[sensor]]` tables of a case: what a rig records, with one class for each type of sensor."""

import math
import re
from collections.abc import Iterable, Iterator
from numbers import Real
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, StrictStr, ValidationInfo
from pydantic_core import PydanticCustomError

from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.rules import Inconsistency
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.sections.wall import TURN

Quantity = Literal["displacement", "velocity", "acceleration"]

MOTION_UNITS: dict[str, str] = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s2"}
"""SI unit of each quantity of a moving point."""

RESERVED = ("time", "blade", "wear")
"""Names that a sensor must not have: coordinates of the signals, and the name of the file
wear.csv that a run with a coating writes."""

MOST_PROBES, NAMED_PROBES = 1000, 4
"""Largest number of probes of a sensor, and of probes that are all part of its name."""

_NAME = fields.text(
    re.compile(
        rf"(?!(?i:{'|'.join(RESERVED)})$)"
        r"(?:[A-Za-z0-9](?:[A-Za-z0-9. -]{0,58}[A-Za-z0-9.-])?)?"
    ),
    "up to 60 letters, digits, dots, hyphens and blanks, as the name of a file, other than"
    f" {', '.join(RESERVED)}",
)


def _within_a_turn(angle: float) -> float:
    if abs(angle) > TURN:
        raise fields.expectation('an angle within a turn, in rad or text such as "90 deg"')
    return angle


def _listed(value: Any) -> tuple[Any, ...]:
    value = value.tolist() if hasattr(value, "tolist") else value
    items = value if isinstance(value, list | tuple) else [value]
    if len(items) > MOST_PROBES:
        raise fields.expectation(f"at most {MOST_PROBES} angles")
    return fields.listed(items, 'an angle such as "90 deg", or a list of angles')


def _share(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, Real) or not 0.0 <= float(value) <= 1.0:
        raise fields.expectation("a number from 0 at the root to 1 at the tip")
    return float(value)


def _blade(value: Any) -> Any:
    try:
        if isinstance(value, str) and value == "all":
            return value
        return fields.converted(fields.count(0), value)
    except PydanticCustomError:
        raise fields.expectation('"all" or the number of a blade, from 0') from None


def _direction(value: Any) -> tuple[float, ...]:
    value = value.tolist() if hasattr(value, "tolist") else value
    listed = isinstance(value, list | tuple) and len(value) == 3
    if not (listed and all(isinstance(x, Real) and not isinstance(x, bool) for x in value)):
        raise fields.expectation("three numbers [x, y, z]")
    if not 0.0 < math.hypot(*value) < math.inf:
        raise fields.expectation("three numbers [x, y, z] that are not all zero")
    largest = max(map(abs, value))  # squares of tiny numbers would vanish
    return tuple(float(x) if 1e-100 < largest < 1e100 else float(x / largest) for x in value)


def _noise(value: Any, info: ValidationInfo) -> float:
    unit = MOTION_UNITS[(info.data or {}).get("quantity", "displacement")]
    return float(fields.converted(fields.quantity(unit, "not negative"), value))


Angle = Annotated[fields.Angle, AfterValidator(_within_a_turn)]


class SensorTable(Table):
    """Keys of every sensor."""

    type: str
    """"strain", "tip-timing", "wall" or "centre"."""
    name: Annotated[str, _NAME] = ""
    """Name of the signal and of its file NAME.csv; by default made of the type and the position,
    such as "wall-90"."""
    sampling_rate: Annotated[float, fields.quantity("Hz")] | None = Field(
        default=None, examples=['"20 kHz"']
    )
    """Samples per second [Hz], by default one sample for each record. There is no filter: a
    vibration above half the rate appears at a lower frequency."""
    seed: Annotated[int, fields.count(0)] = 0
    """Seed of the noise: the same seed gives the same noise."""

    @property
    def label(self) -> str:
        """Name of the signal: the key `name`, or a name from the type and the position."""
        return self.name or f"{self.type}-{self._place}"

    @property
    def _place(self) -> str:
        raise NotImplementedError


class StrainGauge(SensorTable):
    """A strain gauge, aligned with the blade, on the surface of one blade or of every blade."""

    type: Literal["strain"]
    """Strain along the surface [m/m], relative to the state of steady rotation."""
    span: Annotated[float, BeforeValidator(_share)] | None = None
    """Position from 0 at the root to 1 at the tip, measured along the centre line of the blade.
    Give one of span, element, gauge, point, position and group."""
    element: Annotated[int, fields.count(0)] | None = Field(default=None, examples=[0])
    """Number of the element of the blade, from 0 at the root; the gauge is at its middle."""
    gauge: Annotated[int, fields.count(0)] | None = Field(default=None, examples=[0])
    """Number of the gauge on its blade, from 0; for a superelement whose file has
    strain_recovery."""
    point: Annotated[int, fields.count(0)] | None = Field(default=None, examples=[0])
    """Number of a point of the surface, from 0, with direction; for a superelement whose file has
    stress_recovery, young_modulus and poisson_ratio, as those of bw.mesh3d."""
    position: fields.Place | None = Field(default=None, examples=['["12 mm", "110 mm", "-3 mm"]'])
    """Position of the gauge in the axes of the mesh from which bw.mesh3d made the superelement [m],
    with direction in the same axes; the gauge is at the nearest point of the surface, which becomes
    point."""
    group: StrictStr | None = Field(default=None, examples=['"GAUGE_1"'])
    """Group of nodes of this mesh in place of a position: the gauge is at the point of the surface
    that is nearest to the middle of the group."""
    direction: Annotated[tuple[float, float, float], BeforeValidator(_direction)] | None = Field(
        default=None, examples=[[1.0, 0.0, 0.0]]
    )
    """Direction of the gauge at a point: x, y and z in the axes of the file, which turn with the
    blade; of any length. With position or group and without point, in the axes of the mesh."""
    side: Literal["+theta", "-theta"] = "+theta"
    """Side of the blade with the gauge: "+theta" faces counter-clockwise, "-theta" clockwise."""
    blade: Annotated[int | Literal["all"], BeforeValidator(_blade)] = "all"
    """Number of the blade with the gauge, counted from 0, or "all" for a gauge on every blade."""
    noise: Annotated[float, fields.number("not negative")] = 0.0
    """Standard deviation of the noise [m/m]."""

    @property
    def _place(self) -> str:
        at = f"{self.span:g}" if self.span is not None else f"element-{self.element}"
        if self.gauge is not None:
            at = f"gauge-{self.gauge}"
        if self.point is not None:
            at = f"point-{self.point}"
        side = "" if self.side == "+theta" else "-minus"
        return f"{at}{side}" if self.blade == "all" else f"blade-{self.blade}-{at}{side}"


class TipTiming(SensorTable):
    """Probes in the casing that record when the blade tips arrive."""

    type: Literal["tip-timing"]
    """Arrival times [s], and the tangential deflection of the tip [m] that follows from each.
    Arrival times are rounded to the ticks of a clock with the frequency sampling_rate; without this
    key they are exact."""
    probes: Annotated[tuple[Angle, ...], BeforeValidator(_listed)]
    """Angle of the probe in the casing, counter-clockwise from the x axis [rad], or a list of the
    angles of several probes."""
    noise: fields.TimeOrZero = 0.0
    """Standard deviation of the noise of the arrival times [s]."""

    @property
    def _place(self) -> str:
        places = [*map(_degrees, self.probes)]
        if len(places) > NAMED_PROBES:
            return f"{places[0]}-to-{places[-1]}-{len(places)}-probes"
        return "-".join(places)


class WallSensor(SensorTable):
    """A sensor of the motion of the casing's wall at one angle."""

    type: Literal["wall"]
    """Motion of the wall in the static frame."""
    angle: Angle
    """Angle of the sensor, counter-clockwise from the x axis [rad]."""
    direction: Literal["radial", "tangential"] = "radial"
    """"radial", positive outward, or "tangential", positive counter-clockwise."""
    quantity: Quantity = "displacement"
    """"displacement" [m], "velocity" [m/s] or "acceleration" [m/s2]."""
    noise: Annotated[float, BeforeValidator(_noise)] = 0.0
    """Standard deviation of the noise, in the unit of the quantity."""

    @property
    def _place(self) -> str:
        words = [_degrees(self.angle)]
        words += ["tangential"] if self.direction == "tangential" else []
        return "-".join(words + _unless_displacement(self.quantity))


class CentreSensor(SensorTable):
    """A probe of the motion of the shaft's centre in the static frame."""

    type: Literal["centre"]
    """Motion of the shaft's centre in the static frame, in one direction."""
    angle: Angle = 0.0
    """Direction that counts as positive, counter-clockwise from the x axis [rad]."""
    quantity: Quantity = "displacement"
    """"displacement" [m], "velocity" [m/s] or "acceleration" [m/s2]."""
    noise: Annotated[float, BeforeValidator(_noise)] = 0.0
    """Standard deviation of the noise, in the unit of the quantity."""

    @property
    def _place(self) -> str:
        return "-".join([_degrees(self.angle), *_unless_displacement(self.quantity)])


def _degrees(angle: float) -> str:
    return f"{round(math.degrees(angle) % 360.0, 3):g}"


def _unless_displacement(quantity: str) -> list[str]:
    return [] if quantity == "displacement" else [quantity]


SENSORS: dict[str, type[SensorTable]] = {
    "strain": StrainGauge,
    "tip-timing": TipTiming,
    "wall": WallSensor,
    "centre": CentreSensor,
}
"""Table class of each `type` of a sensor."""

EXAMPLES: tuple[SensorTable, ...] = (
    StrainGauge(type="strain", span=0.1),
    TipTiming(type="tip-timing", probes=(0.0, 0.25 * TURN)),
    WallSensor(type="wall", angle=0.25 * TURN),
    CentreSensor(type="centre"),
)
"""A sensor of each type, for the template of a case file."""

Sensor = Annotated[StrainGauge | TipTiming | WallSensor | CentreSensor, Field(discriminator="type")]
SensorRows = Annotated[tuple[Sensor, ...], fields.rows('{ type = "strain", span = 0.1 }')]


class SensorList(Table):
    """Sensors without the other tables of a case."""

    sensor: SensorRows = ()


def sensor_faults(sensors: Iterable[Sensor], blades: int) -> Iterator[Inconsistency]:
    """Yield the sensors on blades that do not exist, and those with the name of another sensor.

    Args:
        sensors: all sensors of a case.
        blades: number of blades.
    """
    names: dict[str, int] = {}
    for number, sensor in enumerate(sensors):
        blade = sensor.blade if isinstance(sensor, StrainGauge) else "all"
        if isinstance(blade, int) and blade >= blades:
            expected = f'"all" or a blade from 0 to {blades - 1}'
            yield Inconsistency(f"sensor.{number}.blade", expected, blade)
        first = names.setdefault(sensor.label.lower(), number)
        if first != number:
            expected = f"a different name; sensor[{first}] has this one"
            yield Inconsistency(f"sensor.{number}.name", expected, sensor.label)

"""Keys of the `[march]` table of a case for a speed of rotation that varies over time."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any

from pydantic import ConfigDict, Field, SerializerFunctionWrapHandler, model_serializer

from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.table import Inconsistency, Table
from bladewhirl.models.inputs.units import Speed

MOST_ROWS = 10_000  #: largest number of rows of a table of speeds

BLEND = 0.1
"""Default time in which the acceleration changes, as a share of the shortest time between rows."""

LARGEST_CHANGE = 0.02
"""Largest change of the speed between two records, as a share of the fastest speed."""

SpeedRows = Annotated[
    tuple[tuple[fields.TimeOrZero, fields.RotationSpeed], ...],
    fields.rows('[time, speed], as in ["10 s", "9000 rpm"]'),
]


class RunUp(Table):
    """A smooth change of the speed; the speed is constant before and after."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)

    first: fields.RotationSpeed = Field(alias="from")
    """Speed before the change, the key `from`."""
    to: fields.RotationSpeed
    """Speed after the change."""
    start: fields.TimeOrZero = 0.0
    """Time at which the change begins [s]."""
    end: fields.Time
    """Time at which the change ends [s]."""

    @model_serializer(mode="wrap")
    def _with_alias(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {"from" if name == "first" else name: each for name, each in serialize(self).items()}

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield an error for an end that is not after the start."""
        if not self.end > self.start:
            yield Inconsistency("end", f"a time after start = {self.start:g} s", ("start",))


class Drive(Table):
    """A drive whose torque, with friction and losses, changes the speed from march.speed on."""

    inertia: Annotated[float, fields.quantity("kg m2", "not negative")] = 0.0
    """Moment of inertia about the axis of all that turns with the bladed disk, without the bladed
    disk itself [kg m2]; with a superelement that of all that turns, the superelement included."""
    torque: Annotated[float, fields.quantity("N m", "any")] = 0.0
    """Torque of the drive in the sense of a positive speed [N m]; 0 for a rotor that coasts."""
    loss: Annotated[float, fields.quantity("N m s", "not negative")] = 0.0
    """Torque of losses divided by the speed in rad/s [N m s]."""


def course_faults(
    table: SpeedRows | None, blend: float | None, run_up: RunUp | None, record_step: float
) -> Iterator[Inconsistency]:
    """Yield errors of the keys of a varying speed, relative to the table `march`."""
    key = "speed_table" if table is not None else "run_up"
    if table is not None and run_up is not None:
        yield Inconsistency("run_up", "not allowed together with march.speed_table", (key,))
        return
    if table is not None:
        times = [time for time, _ in table]
        gaps = [after - before for before, after in pairwise(times)]
        if not 1 <= len(table) <= MOST_ROWS:
            yield Inconsistency(key, f"from 1 to {MOST_ROWS} rows [time, speed]")
            return
        for row, gap in enumerate(gaps, 1):
            if not gap > 0.0:
                expected = (
                    f"rows in ascending order of time; row {row} is at {times[row]:g} s, the row"
                    f" before it at {times[row - 1]:g} s"
                )
                yield Inconsistency(key, expected)
                return
        if gaps and (blend or 0.0) > 0.5 * min(gaps):
            expected = f"at most {0.5 * min(gaps):g} s, half of the shortest time between rows"
            yield Inconsistency("speed_blend", expected, (key,))
            return
    elif blend is not None:
        yield Inconsistency("speed_blend", "a key that needs march.speed_table", (key,))
    if table is None and run_up is None:
        return
    speeds = speeds_of(table, run_up)
    if len({speed.kind for speed in speeds}) > 1:
        expected = "either numbers or texts with a unit as speeds, not both"
        yield Inconsistency(key, expected)
        return
    largest = max(abs(speed.value) for speed in speeds)
    rate = course_of(table, blend, run_up, 1.0).largest_acceleration
    if rate * record_step > LARGEST_CHANGE * largest:
        expected = (
            f"at most {LARGEST_CHANGE * largest / rate:.3g} s, in which the speed changes by"
            f" {100.0 * LARGEST_CHANGE:g} % of the fastest speed (or a slower march.{key})"
        )
        yield Inconsistency("record_step", expected, (key,))


def speeds_of(table: SpeedRows | None, run_up: RunUp | None) -> list[Speed]:
    """Return the speeds of a table or of a change of the speed; none without both."""
    if run_up is not None:
        return [run_up.first, run_up.to]
    return [speed for _, speed in table or ()]


def course_of(
    table: SpeedRows | None, blend: float | None, run_up: RunUp | None, reference: float
) -> SpeedCourse:
    """Return the speed over time for a reference frequency, of which numbers are multiples
    [rad/s]. One of `table` and `run_up` is given."""
    speeds = [speed.rad_per_s(reference) for speed in speeds_of(table, run_up)]
    if run_up is not None:
        return SpeedCourse.smooth_step(speeds[0], speeds[1], run_up.start, run_up.end)
    assert table is not None
    times = [time for time, _ in table]
    if blend is None:
        gaps = [after - before for before, after in pairwise(times)]
        blend = BLEND * min(gaps, default=0.0)
    return SpeedCourse.through(times, speeds, blend)

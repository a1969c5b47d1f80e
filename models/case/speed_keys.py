"""Keys of the `[march]` table of a case for a speed of rotation that varies over time."""

from itertools import pairwise
from typing import Annotated, Any

from pydantic import ConfigDict, Field, SerializerFunctionWrapHandler, model_serializer

from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.inputs.units import Speed

BLEND = 0.1
"""Default time in which the acceleration changes, as a share of the shortest time between rows."""

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


class Drive(Table):
    """A drive whose torque, with friction and losses, changes the speed from march.speed on."""

    inertia: Annotated[float, fields.quantity("kg m2", "not negative")] = 0.0
    """Moment of inertia about the axis of all that turns with the bladed disk, without the bladed
    disk itself [kg m2]; with a superelement that of all that turns, the superelement included."""
    torque: Annotated[float, fields.quantity("N m", "any")] = 0.0
    """Torque of the drive in the sense of a positive speed [N m]; 0 for a rotor that coasts."""
    loss: Annotated[float, fields.quantity("N m s", "not negative")] = 0.0
    """Torque of losses divided by the speed in rad/s [N m s]."""


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

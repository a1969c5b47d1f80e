"""Tables of a case for the analysis: reduction, damping, contact, start, coupling and march."""

import math
import sys
from collections.abc import Iterator, Mapping
from itertools import islice, pairwise
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, StrictBool, StrictStr, model_validator

from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.case.speed_keys import (
    Drive,
    RunUp,
    SpeedRows,
    course_of,
    speeds_of,
)
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.mode_names import mode_choice
from bladewhirl.models.inputs.rules import Inconsistency, broken
from bladewhirl.models.inputs.table import ReplacedKeys, Table
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.inputs.units import Speed

MOST_STEPS = 1e12
"""Largest number of time steps; so many steps take days, and step numbers are far from overflow."""

REMOVED_DEFAULTS = {"restitution": 0.0, "penalty_stiffness": 1e9, "stick_speed": 0.01}
"""Removed keys of the table contact, with values that had no effect."""

REMOVED_LAWS = "restitution and penalty contact were removed in this version"
"""Reason for which other values of march.scheme, and keys of their contact laws, are refused."""

MOST_ROWS = 10_000  #: largest number of rows of a table of speeds

LARGEST_CHANGE = 0.02
"""Largest change of the speed between two records, as a share of the fastest speed."""

WHOLE = 1e-6  #: relative tolerance with which record_step / time_step must be an integer

MODES = 110
"""Default number of fixed-interface modes; a bladed disk with fewer keeps all of its modes."""


class Reduction(Table):
    """Craig-Bampton reduction of the bladed disk to tips and centre, and modes for the march."""

    fixed_interface_modes: Annotated[int, fields.count(1)] = MODES
    """Number of fixed-interface modes of all blades together (eta in the paper, Section 2.2). The
    default, five per blade of 22 blades, gives errors below 1 % in the frequencies of family 5F;
    scale it with the number of blades. A smaller bladed disk keeps all of its modes. bladewhirl
    show prints the errors."""
    boundary: Literal["massless", "consistent"] = "massless"
    """Model of the contact nodes of a superelement. "massless": contact nodes without mass,
    described by free-interface modes and a residual flexibility, which a contact force deforms
    until the gap is zero. "consistent": contact nodes with mass, described by all modes of the
    Craig-Bampton model with fixed_interface_modes."""
    free_interface_modes: Annotated[int, fields.count(1)] = 50
    """Number of free-interface modes of a superelement with a massless boundary. For a sector it is
    the number per sector: its wheel has this number times copies. With a wheel on a shaft line it
    is the number of modes of the whole rotor; modes of the frequency of the last are kept too."""
    modes: Annotated[StrictStr, BeforeValidator(mode_choice)] = "all"
    """Modes that a march keeps: "all"; "six", the paper's truncated space of Eqs (4)-(10), which is
    "1F:1,suspension:1,casing:1"; or names, FAMILY:k on the bladed disk and casing:FAMILY:k on the
    casing, with the nodal diameter k. A name without ":k" selects all nodal diameters; "*" is every
    family; "casing:k" is the lowest radial mode with k. Loads and initial motion are
    projected on the modes."""


class Damping(Table):
    """Modal damping of bladed disk and casing."""

    ratio: fields.NumberOrZero = 0.005
    """Damping ratio xi of every mode (not in the paper; suspension transients decay within about
    1.1 s)."""
    boundary_ratio: fields.NumberOrZero = 0.05
    """Damping ratio of the highest modes, which are mostly motions of the contact nodes; used with
    reduction.boundary = "consistent". The lowest modes, as many as reduction.fixed_interface_modes,
    have damping.ratio."""


class Contact(Table):
    """Contact between tips and casing."""

    friction: fields.NumberOrZero = 0.1
    """Coulomb friction coefficient (paper, Table 2)."""
    sliding: Literal["permanent", "signed", "full"] = "permanent"
    """"permanent": friction drags every tip against the rotation ("sliding is assumed" in the
    paper). "signed": friction opposes the relative velocity; there is no sticking, so at speed 0
    the sign is determined by rounding errors. "full": friction opposes the slip velocity at the
    end of each step, tangential and axial, elastic velocities included."""
    tip_rotation: StrictBool = False
    """Add u_t / R to the angle at which a tip meets the casing; u_t is the tangential displacement
    of the tip, R the tip radius."""
    foreshortening: StrictBool = False
    """Increase the gap of a tip by the second-order shortening of its bent blade: about
    0.58 y^2 / L in the first bending mode of a blade of length L whose tip has the tangential
    displacement y. The shortening is measured along the blade. The tip also moves along a tangent,
    which brings it nearer to a round wall by y^2 / (2 R); this is included if tip_rotation is true
    as well."""

    @model_validator(mode="before")
    @classmethod
    def _without_effect(cls, given: Any) -> Any:
        """Drop removed keys with the values that earlier versions wrote into every case."""
        if not isinstance(given, Mapping):
            return given
        return {
            name: value
            for name, value in given.items()
            if name not in REMOVED_DEFAULTS or value != REMOVED_DEFAULTS[name]
        }


class Initial(Table):
    """Motion at t = 0 along the rotating axes, which coincide with the static axes at that time.

    Velocities are relative to the rotating axes, without the transport velocity Omega x r. Tips
    and centre have the given motion; all other nodes of the bladed disk follow statically. The
    casing is at rest.
    """

    centre_velocity: fields.VelocityPair = (0.0, 0.0)
    """Velocity of the centre, x and y [m/s]; at speed 0 the velocity in space. The nodes between
    centre and tips follow statically; moving only the mass of the centre would change the effect by
    a factor of 4 to 45."""
    centre_displacement: fields.DisplacementPair = (0.0, 0.0)
    """Displacement of the centre, x and y [m]."""
    tip_velocity: fields.VelocityRows | None = Field(
        default=None, examples=["[[0.0, 0.0], [0.0, 0.0], ...]"]
    )
    """Velocity of each tip, radial and tangential [m/s], blades x 2; default 0. The other nodes
    of the blade follow statically. With a superelement the velocity is the mean velocity of the
    contact nodes of the blade."""
    tip_displacement: fields.DisplacementRows | None = Field(
        default=None, examples=["[[0.0, 0.0], [0.0, 0.0], ...]"]
    )
    """Displacement of each tip, radial and tangential [m], blades x 2; default 0."""


class Coupling(Table):
    """Coupling of bladed disk and casing through frame and bearings (Eqs 4-10)."""

    stiffness: fields.StiffnessOrZero = 0.0
    """Stiffness kappa of the springs [N/m] (0 in the paper's Table 2)."""
    modes: Annotated[StrictStr, BeforeValidator(mode_choice)] = "six"
    """Modes that the springs couple, named as in reduction.modes. Springs can couple the modes that
    a march keeps: on the bladed disk 1F to 5F and suspension, on the casing the lowest radial mode
    of each nodal diameter."""
    amplitude: Literal["paper", "physical"] = "paper"
    """Radial amplitude of each mode at the springs: "paper" is 1 for every mode, "physical" is the
    amplitude of the mass-normalised mode."""
    pi: StrictBool = True
    """Keep the factor pi of the integral in Eq. (8), which Eq. (9) omits."""


def _known_scheme(value: object) -> object:
    if value != "central-difference":
        raise fields.expectation('"central-difference"', REMOVED_LAWS)
    return value


class March(ReplacedKeys):
    """The march, that is, the time integration."""

    replacements: ClassVar = {
        "steps_per_revolution": ("time_step",),
        "revolutions": ("duration",),
        "speed_table": ("speed",),
        "run_up": ("speed",),
    }

    speed: fields.RotationSpeed = Speed(1.05)
    """Speed of rotation. A number is a multiple of the reference frequency, the lowest natural
    frequency of the bladed disk, before modal reduction and with a free centre (even if this case
    clamps it). Text is an absolute speed: "2500 rpm", "42 Hz" (revolutions per second) or "262
    rad/s". Zero and negative speeds are allowed (1.05 in the paper, Section 4.3; 0.25 by default
    for a superelement, where engine order 4 meets the reference frequency)."""
    speed_table: SpeedRows | None = Field(
        default=None, examples=['[["0 s", "3000 rpm"], ["10 s", "9000 rpm"]]']
    )
    """Speed over time in place of march.speed, rows of [time, speed] in ascending order of time:
    time [s] and speed as for march.speed, all as numbers or all as text. The speed is linear
    between rows, and constant before the first and after the last row. Needs rotation.effects
    "none" or "full". Studies at one speed, such as bladewhirl modes, use the fastest speed of the
    table."""
    speed_blend: fields.TimeOrZero | None = Field(default=None, examples=['"0.1 s"'])
    """Time in which the acceleration changes at a row of march.speed_table [s], so that no step of
    the acceleration excites vibration: at the first row and after a constant speed this time
    begins, at the last row and before a constant speed it ends, and on other rows it is centred.
    The speeds at the rows remain those of the table. By default a tenth of the shortest time
    between rows; 0 keeps the corners."""
    run_up: RunUp | None = Field(
        default=None,
        examples=['{ from = "1000 rpm", to = "9000 rpm", start = "0 s", end = "2 s" }'],
    )
    """Speed over time in place of march.speed: from one speed to another as 3 s^2 - 2 s^3, where s
    rises from 0 to 1 between start and end; constant before and after."""
    drive: Drive | None = Field(
        default=None, examples=['{ inertia = "2 kg m2", torque = "0 N m", loss = "0 N m s" }']
    )
    """Drive of a rotor whose speed is free: it starts at march.speed, and the torque of the drive,
    of losses, of friction at the tips and of static dampers changes it."""
    time_step: fields.Time = 1e-6
    """Time step [s] (paper, Section 4.2). The error is of second order for free motion and of first
    order in contact: halve the step to see its effect."""
    steps_per_revolution: Annotated[int, fields.count(1)] | None = Field(
        default=None, examples=["4096"]
    )
    """Number of time steps in a revolution. If it is given, march.time_step is not used, and
    record_step is rounded to whole time steps. In a sweep over the speed the step follows the
    speed. 4096 for a superelement, unless march.time_step is given."""
    duration: fields.TimeOrZero = 3.0
    """Simulated time [s] (paper, Table 2)."""
    revolutions: Annotated[float, fields.number("positive")] | None = Field(
        default=None, examples=["50"]
    )
    """Simulated time in revolutions. If it is given, march.duration is not used. 20 for a
    superelement at constant speed, unless march.duration is given."""
    record_step: fields.Time = 1e-4
    """Time between records [s], a whole number of time steps."""
    displacement_limit: fields.Length | None = Field(default=None, examples=["0.5"])
    """A march ends as divergent if a displacement exceeds this limit [m]: in any direction at a
    blade tip or a contact node, radial at the casing. By default the length of a blade; for a
    superelement the extent in radius of the surface of a blade, or a fifth of the radius if its
    file is a sector or a wheel, or has no surface (a choice: at a third of the length of a blade
    the linear model has errors of 10 %, but larger transients can still decay)."""
    unsolved_share: fields.NumberOrZero = 1e-3
    """Largest share of time steps whose contact problem may remain unsolved; a march with more ends
    as an error. 1 allows all."""
    scheme: Annotated[Literal["central-difference"], BeforeValidator(_known_scheme)] = (
        "central-difference"
    )
    """Time integration, which has one scheme: central differences with Lagrange multipliers, as in
    the paper."""

    def in_seconds(self, omega: float) -> "March":
        """Return the march with its steps and duration in seconds at a speed of rotation [rad/s],
        which is not zero if they are given in revolutions."""
        changed: dict[str, float] = {}
        if self.steps_per_revolution is not None:
            step = 2.0 * math.pi / abs(omega) / self.steps_per_revolution
            every = max(1, round(self.record_step / step))
            changed = {"time_step": step, "record_step": every * step}
        if self.revolutions is not None:
            changed["duration"] = 2.0 * math.pi / abs(omega) * self.revolutions
        return self.model_copy(update=changed) if changed else self

    @model_validator(mode="after")
    def _fastest(self) -> Self:
        """Set `speed` to the fastest speed of a table of speeds, of which it is the replacement."""
        if self.speeds:
            self.__dict__["speed"] = max(self.speeds, key=lambda speed: abs(speed.value))
        return self

    @property
    def varies(self) -> bool:
        """True if the speed of rotation is given over time, or free."""
        return any(each is not None for each in (self.speed_table, self.run_up, self.drive))

    def course(self, reference: float) -> SpeedCourse | None:
        """Return the speed over time for a reference frequency [rad/s], that at the start if it is
        free; None if it is constant."""
        if self.drive is not None:
            return SpeedCourse.through([0.0], [self.speed.rad_per_s(reference)], 0.0)
        if not self.varies:
            return None
        return course_of(self.speed_table, self.speed_blend, self.run_up, reference)

    @property
    def speeds(self) -> list[Speed]:
        """Speeds of march.speed_table or march.run_up."""
        return speeds_of(self.speed_table, self.run_up)

    @property
    def gaps(self) -> list[float]:
        """Times between rows of march.speed_table [s]."""
        return [after - before for (before, _), (after, _) in pairwise(self.speed_table or ())]

    @property
    def late(self) -> int:
        """First row of march.speed_table that is not after the row before it; 0 without one."""
        return next((row for row, gap in enumerate(self.gaps, 1) if not gap > 0.0), 0)

    @property
    def longest_record(self) -> float:
        """Largest `record_step` at which the speed between two records hardly changes [s]."""
        course = course_of(self.speed_table, self.speed_blend, self.run_up, 1.0)
        fastest = max(abs(speed.value) for speed in self.speeds)
        rate = course.largest_acceleration
        return LARGEST_CHANGE * fastest / rate if rate else math.inf

    @property
    def ratio(self) -> float:
        """Record step divided by the time step."""
        return self.record_step / self.time_step

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield the rules that are broken."""
        here = sys.modules[__name__]
        yield from super().inconsistencies()
        if self.speed_table is not None or self.run_up is not None:
            yield from islice(broken("March course", self, here), 1)
        if self.steps_per_revolution is None:
            yield from broken("March in seconds", self, here)

    @property
    def steps(self) -> int:
        """Number of time steps in ``duration``."""
        return self.timing.steps

    @property
    def timing(self) -> Timing:
        """Duration, time step and record step of the march."""
        return Timing(
            time_step=self.time_step, duration=self.duration, record_step=self.record_step
        )

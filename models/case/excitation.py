"""The `[excitation]` table of a case: loads on a stage, with one class for each type."""

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Tag, ValidationInfo, model_validator
from pydantic_core import PydanticCustomError

from bladewhirl.models.inputs.fields import (
    PositiveSpeed,
    TimeOrZero,
    converted,
    count,
    expectation,
    listed,
    number,
    quantity,
)
from bladewhirl.models.inputs.table import ReplacedKeys, Table
from bladewhirl.models.inputs.units import Speed


def _orders(value: Any) -> tuple[int, ...]:
    phrase = "an engine order, a whole number of zero or more, or a list of different ones"
    items = listed(value, phrase) if hasattr(value, "__len__") else (value,)
    orders = tuple(int(converted(count(0), item)) for item in items)
    if len(set(orders)) < len(orders):
        raise expectation(phrase)
    return orders


def _position(value: Any) -> str | float | tuple[float, float]:
    phrase = '"tip", a number from 0 (root) to 1 (tip), two such numbers, or the name of a node set'
    if isinstance(value, str) and value:
        return value
    items = listed(value, phrase) if hasattr(value, "__len__") else (value,)
    shares = [float(converted(number("not negative"), item)) for item in items]
    if len(shares) > 2 or shares != sorted(set(shares)) or shares[-1] > 1.0:
        raise expectation(phrase)
    return shares[0] if len(shares) == 1 else (shares[0], shares[1])


def _points(value: Any) -> tuple[int, ...]:
    phrase = "different whole numbers of zero or more"
    points = listed(value, phrase, least=0)
    whole = all(isinstance(each, int) and not isinstance(each, bool) for each in points)
    if not whole or min(points, default=0) < 0 or len(set(points)) < len(points):
        raise expectation(phrase)
    return points


def _amplitude(value: Any, info: ValidationInfo) -> float:
    spread = isinstance((info.data or {}).get("position"), tuple)
    return float(converted(quantity("N/m" if spread else "N", "not negative"), value))


def _direction(value: Any) -> str | float:
    if value in ("tangential", "radial"):
        return str(value)
    try:
        return float(converted(quantity("rad", "any"), value))
    except PydanticCustomError:
        phrase = '"tangential", "radial" or an angle in rad or with a unit, such as "30 deg"'
        raise expectation(phrase) from None


def _phases(value: Any) -> float | tuple[float, ...]:
    angle = quantity("rad", "any")
    if isinstance(value, str) or not hasattr(value, "__len__"):
        return float(converted(angle, value))
    return tuple(converted(angle, item) for item in listed(value, "phases, one for each blade"))


def _factors(value: Any) -> tuple[float, ...]:
    items = listed(value, "factors, one for each blade", least=0)
    return tuple(converted(number("any"), item) for item in items)


LOWEST_SPEED = Speed(0.95)  #: lowest speed of the paper's Table 2


ActsOn = Literal["nothing", "casing", "centre", "blades"]
"""Part of a stage on which an excitation acts: a stage that lacks it refuses the excitation."""


class TypedLoad(ReplacedKeys):
    """A load, which is written with its type."""

    always: ClassVar = ("type",)


class NoExcitation(TypedLoad):
    """No load; motion starts from the initial conditions only."""

    acts_on: ClassVar[ActsOn] = "nothing"

    type: Literal["none"] = "none"
    """"none", or "casing-distortion", "imbalance", "harmonic" or "engine-order" with their keys."""


class CasingDistortion(TypedLoad):
    """A pulse on one casing mode (the paper's scenario A)."""

    acts_on: ClassVar[ActsOn] = "casing"

    type: Literal["casing-distortion"] = "casing-distortion"
    """Force during [0, duration] on the lowest radial casing mode with nodal diameter k. The mode
    is mass-normalised; its radial displacement varies as +cos k theta in the static frame."""
    nodal_diameter: Annotated[int, count(1)] = 1
    """Nodal diameter k of the mode; at most half the number of casing elements."""
    modal_force: Annotated[float, quantity("N/kg^0.5", "not negative")] = 3e4
    """Modal force [N/kg^0.5] (30 kN in the paper's Table 2)."""
    duration: TimeOrZero = 0.15
    """Duration of the load [s] (the paper: a "short time interval")."""
    shape: Literal["rectangular", "half-sine"] = "rectangular"
    """Force as a function of time, "rectangular" or "half-sine"."""


def _grade(value: Any) -> float:
    if isinstance(value, str) and (digits := value.strip()[1:]) and value.strip()[0] in "Gg":
        value = f"{digits} mm/s"
    return float(converted(quantity("m/s", "not negative"), value))


class BalanceGrade(Table):
    """Residual unbalance by the grade G of ISO 21940-11: G times mass divided by speed."""

    grade: Annotated[float, BeforeValidator(_grade)] = Field(examples=["G 6.3"])
    """Balance quality grade, "G 6.3", or its velocity e Omega [m/s]: G 6.3 is 6.3 mm/s."""
    mass: Annotated[float, quantity("kg")] = Field(examples=["120 kg"])
    """Mass of the rotor [kg]."""
    speed: PositiveSpeed = Field(examples=["3000 rpm"])
    """Service speed of the grade, see march.speed."""


class Imbalance(TypedLoad):
    """A force at the centre, constant in the rotating frame (scenario B).

    The unbalance m e is given, or follows from ``grade`` or ``clearance_speed``; one of them.
    """

    acts_on: ClassVar[ActsOn] = "centre"

    type: Literal["imbalance"] = "imbalance"
    """Force m e Omega^2 at the centre, constant in the rotating frame, along +x unless phase or
    blade are given. Blade 0 is on this axis unless a mesh or a sketch places it elsewhere. Give one
    of clearance_speed, unbalance and balance."""
    clearance_speed: PositiveSpeed | None = None
    """Speed at which the static response just closes the clearance: a number is in multiples of the
    reference frequency (see march.speed), text such as "2500 rpm" is absolute. If unbalance is not
    given either, the speed is 0.95, the lowest of the paper's Table 2."""
    unbalance: Annotated[float, quantity("kg m", "not negative")] | None = Field(
        default=None, examples=[0.59]
    )
    """Unbalance m e [kg m], or text such as "590 g mm", instead of clearance_speed."""
    balance: BalanceGrade | None = None
    """Unbalance by a balance quality grade, { grade = "G 6.3", mass = "120 kg", speed = "3000 rpm"
    }, instead of clearance_speed."""
    phase: Annotated[float, quantity("rad", "any")] = 0.0
    """Angle of the force from +x, or from the blade, counter-clockwise [rad]."""
    blade: Annotated[int, count(0)] | None = None
    """Number of the blade to which the force points, such as the one with additional mass. The
    force acts at the centre."""
    ramp: TimeOrZero = 0.2
    """Duration of the half-cosine ramp of the force [s], 0 for a step (not in the paper; a step
    overshoots to twice the static answer)."""

    @model_validator(mode="before")
    @classmethod
    def _default_speed(cls, values: Any) -> Any:
        if isinstance(values, dict) and not {*_SIZES} & values.keys():
            return {**values, "clearance_speed": LOWEST_SPEED}
        return values

    def size(self, reference: float) -> float | None:
        """Return the unbalance m e [kg m] for a reference frequency [rad/s]; None if it follows
        from clearance_speed."""
        if self.balance is None:
            return self.unbalance
        return self.balance.grade * self.balance.mass / self.balance.speed.rad_per_s(reference)


_SIZES = ("clearance_speed", "unbalance", "balance")
"""Keys that determine the unbalance."""


class Harmonic(TypedLoad):
    """A harmonic force at the centre, or at a position along a shaft line (not in the paper)."""

    acts_on: ClassVar[ActsOn] = "centre"

    type: Literal["harmonic"] = "harmonic"
    """Force cos(2 pi frequency t) at the centre along x of a frame."""
    force: Annotated[float, quantity("N", "not negative")] = 1e3
    """Amplitude [N]; as a static force the default deflects the default shaft by 0.03 mm."""
    frequency: Annotated[float, quantity("Hz")] = 40.0
    """Frequency in cycles per second [Hz]; the default is near the first bending frequency of the
    blades of the default stage."""
    frame: Literal["rotating", "static"] = "static"
    """Frame in which the force is fixed, "rotating" or "static"."""
    position: Annotated[float, quantity("m", "any")] | None = Field(
        default=None, examples=['"0.3 m"']
    )
    """Position along a shaft line, whose nearest node feels the force [m]; by default that of
    shaft_line.wheel."""


class EngineOrder(TypedLoad):
    """Forces on the blades that vary r times in each revolution; r is the engine order."""

    acts_on: ClassVar[ActsOn] = "blades"
    replacements: ClassVar = {"points": ("position",)}

    type: Literal["engine-order"] = "engine-order"
    """Force F cos(r (Omega t + theta_n) + phase) on blade n at the angle theta_n. Its direction
    turns with the blade; its r maxima around the circle are at rest in the static frame."""
    order: Annotated[tuple[int, ...], BeforeValidator(_orders)] = (1,)
    """Engine order r, a whole number of zero or more, or a list of engine orders, each with the
    same amplitude."""
    position: Annotated[str | float | tuple[float, float], BeforeValidator(_position)] = "tip"
    """Point of application: "tip"; a number from 0 at the root to 1 at the tip, measured along the
    centre line of the blades; two such numbers for a load distributed between them; or the name of
    a node set with one node on each blade."""
    points: Annotated[tuple[int, ...], BeforeValidator(_points)] = ()
    """Numbers of points of a superelement file, on which the force of each blade acts in equal
    parts, in place of position; of a file of kind "wheel", the points of all blades."""
    amplitude: Annotated[float, BeforeValidator(_amplitude)] = 1.0
    """Amplitude F of the force on each blade [N]; for a distributed load, force per length of the
    blade [N/m]."""
    direction: Annotated[str | float, BeforeValidator(_direction)] = "tangential"
    """"tangential", positive towards +theta; "radial", positive outward; or an angle from the
    radial direction towards +theta [rad], each at the loaded point."""
    phase: Annotated[float | tuple[float, ...], BeforeValidator(_phases)] = 0.0
    """Phase [rad], or a list with one phase for each blade."""
    factors: Annotated[tuple[float, ...], BeforeValidator(_factors)] = ()
    """Factors on the amplitude, one for each blade; 1 by default."""
    ramp: TimeOrZero = 0.0
    """Duration of the half-cosine ramp of the force [s], 0 for a step."""

    @property
    def inclination(self) -> float:
        """Angle of the force from the radial direction towards +theta [rad]."""
        if isinstance(self.direction, str):
            return {"radial": 0.0, "tangential": 0.5 * np.pi}[self.direction]
        return self.direction


ONE, SEVERAL = "one", "several"
"""Names by which pydantic tells a single excitation from a list of excitations."""


def _empty_is_none(value: object) -> object:
    return {"type": "none"} if value in ({}, [], ()) else value


def _number_of_tables(value: object) -> str:
    return SEVERAL if isinstance(value, list | tuple) else ONE


EXCITATIONS: dict[str, type[Table]] = {
    "casing-distortion": CasingDistortion,
    "imbalance": Imbalance,
    "harmonic": Harmonic,
    "engine-order": EngineOrder,
    "none": NoExcitation,
}
"""Table class of each `excitation.type`."""

Excitation = Annotated[
    CasingDistortion | Imbalance | Harmonic | EngineOrder | NoExcitation,
    Field(discriminator="type"),
]
ExcitationTable = Annotated[
    Annotated[Excitation, Tag(ONE)] | Annotated[tuple[Excitation, ...], Tag(SEVERAL)],
    Discriminator(_number_of_tables),
    BeforeValidator(_empty_is_none),
]
"""One excitation, or several that act together."""

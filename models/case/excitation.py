"""The `[excitation]` table of a case: the load on a stage, with one class for each type."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from bladewhirl.models.inputs.fields import PositiveSpeed, TimeOrZero, count, quantity
from bladewhirl.models.inputs.table import Inconsistency, Table
from bladewhirl.models.inputs.units import Speed

LOWEST_SPEED = Speed(0.95)
"""Lowest speed of the paper's Table 2."""


class NoExcitation(Table):
    """No load; motion starts from the initial conditions only."""

    type: Literal["none"] = "none"
    """"none", or "casing-distortion", "imbalance" or "harmonic" with their keys."""


class CasingDistortion(Table):
    """A pulse on one casing mode (the paper's scenario A)."""

    type: Literal["casing-distortion"] = "casing-distortion"
    """Force during [0, duration] on the lowest radial casing mode with nodal diameter k, which is
    mass-normalised and follows w = +cos k theta in the static frame."""
    nodal_diameter: Annotated[int, count(1)] = 1
    """Nodal diameter k of the mode, at most half the casing's elements."""
    modal_force: Annotated[float, quantity("N/kg^0.5", "not negative")] = 3e4
    """Modal force [N/kg^0.5] (30 kN in the paper's Table 2)."""
    duration: TimeOrZero = 0.15
    """Duration of the load [s] (the paper: a "short time interval")."""
    shape: Literal["rectangular", "half-sine"] = "rectangular"
    """Force as a function of time, "rectangular" or "half-sine"."""


class Imbalance(Table):
    """A force along +x at the centre, constant in the rotating frame (scenario B).

    The unbalance m e is given, or follows from ``clearance_speed``; exactly one of them is None.
    """

    type: Literal["imbalance"] = "imbalance"
    """Force m e Omega^2 at the centre, constant along +x of the rotating frame. Blade 0 is on this
    axis unless a mesh or a sketch places it elsewhere. Give clearance_speed or unbalance, not both.
    """
    clearance_speed: PositiveSpeed | None = None
    """Speed at which the static response just closes the clearance: a number is in multiples of the
    reference frequency (see march.speed), text such as "2500 rpm" is absolute. If unbalance is not
    given either, the speed is 0.95, the lowest of the paper's Table 2."""
    unbalance: Annotated[float, quantity("kg m", "not negative")] | None = Field(
        default=None, examples=[0.59]
    )
    """Unbalance m e [kg m], instead of clearance_speed."""
    ramp: TimeOrZero = 0.2
    """Half-cosine ramp of the force [s], 0 for a step (not in the paper; a step overshoots to twice
    the static answer)."""

    @model_validator(mode="before")
    @classmethod
    def _default_speed(cls, values: Any) -> Any:
        if isinstance(values, dict) and not {"clearance_speed", "unbalance"} & values.keys():
            return {**values, "clearance_speed": LOWEST_SPEED}
        return values

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield an error if not exactly one of unbalance and clearance_speed is given."""
        if (self.clearance_speed is None) == (self.unbalance is None):
            expected = "either unbalance or clearance_speed, not both"
            yield Inconsistency("unbalance", expected, ("clearance_speed",))


class Harmonic(Table):
    """A harmonic force at the centre (not in the paper)."""

    type: Literal["harmonic"] = "harmonic"
    """Force cos(2 pi frequency t) at the centre along x of a frame."""
    force: Annotated[float, quantity("N", "not negative")] = 1e3
    """Amplitude [N]; as a static force the default deflects the default shaft by 0.03 mm."""
    frequency: Annotated[float, quantity("Hz")] = 40.0
    """Frequency in cycles per second [Hz]; the default is near the first blade bending of the
    default stage."""
    frame: Literal["rotating", "static"] = "static"
    """Frame in which the force is fixed, "rotating" or "static"."""


def _empty_is_none(value: object) -> object:
    return {"type": "none"} if value == {} else value


EXCITATIONS: dict[str, type[Table]] = {
    "casing-distortion": CasingDistortion,
    "imbalance": Imbalance,
    "harmonic": Harmonic,
    "none": NoExcitation,
}
"""Table class of each `excitation.type`."""

Excitation = Annotated[
    CasingDistortion | Imbalance | Harmonic | NoExcitation, Field(discriminator="type")
]
ExcitationTable = Annotated[Excitation, BeforeValidator(_empty_is_none)]

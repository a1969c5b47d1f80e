"""The `[shaft]` table of a case: springs and dampers under the centre of the bladed disk."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, StrictBool, model_serializer

from bladewhirl.models.inputs.fields import DampingOrZero, Stiffness, quantity
from bladewhirl.models.inputs.table import Inconsistency, Table
from bladewhirl.models.inputs.units import handy


class Shaft(Table):
    """The two springs that carry the centre; it does not rotate in the plane."""

    stiffness: Stiffness = 3.4e7
    """Of each of the two springs, x and y, or of that along x [N/m] (paper, Section 2.1)."""
    stiffness_y: Stiffness | None = Field(default=None, examples=["2e7"])
    """Of the spring along y [N/m], where it differs."""
    suspension_frequency: Annotated[float, quantity("Hz")] | None = Field(
        default=None, examples=["300 Hz"]
    )
    """Frequency wanted of the suspension pair, of the full bladed disk at rest [Hz], instead of
    shaft.stiffness; bladewhirl show tells the stiffness that both springs get. Near the first
    bending family of the blades no springs give it: the message tells the nearest frequencies below
    and above that some do."""
    frame: Literal["rotating", "static"] = "rotating"
    """Where springs that differ stand: "rotating", they turn with the bladed disk as a shaft does
    that is not round, along rotating axes, and its matrices are constant; "static", they stand
    still as unequal bearings do, and its stiffness swings twice a turn about the mean of both.
    Modes are then those on the mean. With rotation.effects = "full" a round rotor answers them as
    on bearings that stand still; without Coriolis and centrifugal terms a speed near the suspension
    frequency excites it by the swing, which it would not."""
    damping: DampingOrZero = 0.0
    """Of a damper beside each of the springs, or beside that along x [N s/m]. With dampers, contact
    is of the first order in march.time_step; with rotation.effects = "full" they feel it within the
    step."""
    damping_y: DampingOrZero | None = Field(default=None, examples=["1e3"])
    """Of the damper along y [N s/m], where it differs."""
    damping_frame: Literal["rotating", "static"] = "rotating"
    """Where the dampers stand: "rotating", they turn with the bladed disk, see its velocity in
    rotating axes, and feed forward whirl above its critical speed; "static", they stand still as
    those of bearings do, c (v + Omega z x u), and hold it. That takes Coriolis forces,
    rotation.effects = "full", and dampers that are equal."""
    clamped: StrictBool = False
    """Hold the centre instead."""

    @property
    def summary(self) -> str:
        """Its springs and dampers."""
        if self.clamped:
            return "clamped"
        if self.suspension_frequency is not None:
            return f"springs for a suspension at {self.suspension_frequency:g} Hz"
        both = dict.fromkeys(handy(stiffness, "N/m") for stiffness in self.springs)
        frame = f" in the {self.frame} frame" if len(both) > 1 else ""
        dampers = " and ".join(dict.fromkeys(handy(d, "N s/m") for d in self.dampings if d))
        return " and ".join(both) + frame + (f", dampers of {dampers}" if dampers else "")

    @model_serializer(mode="wrap")
    def _springs_in_one_way(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """The keys of the table; a stiffness that a frequency replaces is none of them."""
        written: dict[str, Any] = handler(self)
        if self.suspension_frequency is not None:
            written.pop("stiffness", None)
        return written

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Dampers that stand still and differ, springs given in two ways."""
        if self.suspension_frequency is not None:
            given = [name for name in ("stiffness_y", "clamped") if getattr(self, name)]
            if "stiffness" in self.model_fields_set:
                given.insert(0, "stiffness")
            if given:
                expected = f"to be left out beside shaft.{given[0]}"
                yield Inconsistency("suspension_frequency", expected, tuple(given))
        if self.damping_frame == "static" and len(set(self.dampings)) > 1:
            expected = 'shaft.damping, or shaft.damping_frame = "rotating"'
            yield Inconsistency("damping_y", expected, ("damping", "damping_frame"))

    @property
    def stiffnesses(self) -> tuple[float, float]:
        """Constant stiffness along x and y of the rotating axes [N/m]."""
        along_x, along_y = self.springs
        if self.frame == "rotating":
            return along_x, along_y
        mean = 0.5 * (along_x + along_y)
        return mean, mean

    @property
    def anisotropy(self) -> float:
        """Half the difference of the stiffnesses along the static x and y axes [N/m]."""
        along_x, along_y = self.springs
        return 0.0 if self.frame == "rotating" else 0.5 * (along_x - along_y)

    @property
    def springs(self) -> tuple[float, float]:
        """Stiffness along x and y of the frame that the springs stand in [N/m]."""
        return self.stiffness, self.stiffness if self.stiffness_y is None else self.stiffness_y

    @property
    def dampings(self) -> tuple[float, float]:
        """Damping along x and y [N s/m]."""
        return self.damping, self.damping if self.damping_y is None else self.damping_y

"""The `[shaft]` and `[rotation]` tables of a case."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, StrictBool, model_serializer

from bladewhirl.models.inputs.fields import DampingOrZero, Stiffness, quantity
from bladewhirl.models.inputs.table import Inconsistency, Table

Effects = Literal["none", "centrifugal", "full"]
"""Rotation effects: none; centrifugal tension with its geometric stiffness, and spin softening;
or these and Coriolis forces."""


class Rotation(Table):
    """Forces on the bladed disk due to its rotation; the paper leaves them out."""

    effects: Effects = "none"
    """"none", as in the paper; "centrifugal": tension in blades and disk with its geometric
    stiffness, spin softening and static growth of the tips; "full": Coriolis forces as well. All at
    march.speed."""
    clearance: Literal["hot", "cold"] = "hot"
    """State in which casing.clearance is measured: "hot", at march.speed; "cold", at rest: the
    static growth of the tips at march.speed is subtracted from it, which needs effects other than
    "none"."""

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield an error for a cold clearance without rotation effects, where tips do not grow."""
        if self.effects == "none" and self.clearance == "cold":
            expected = (
                '"hot", or rotation.effects = "centrifugal" or "full": only then do tips grow'
            )
            yield Inconsistency("clearance", expected, ("effects",))


class Shaft(Table):
    """The two springs that carry the centre; it does not rotate in the plane."""

    stiffness: Stiffness = 3.4e7
    """Stiffness of each of the two springs, x and y, or of the one along x [N/m] (paper, Section
    2.1)."""
    stiffness_y: Stiffness | None = Field(default=None, examples=["2e7"])
    """Stiffness of the spring along y [N/m], if different."""
    suspension_frequency: Annotated[float, quantity("Hz")] | None = Field(
        default=None, examples=["300 Hz"]
    )
    """Required frequency of the suspension pair, of the full bladed disk at rest [Hz], in place of
    shaft.stiffness; bladewhirl show prints the resulting stiffness of both springs. Frequencies
    near the first bending family of the blades cannot be reached: the message states the nearest
    possible frequencies."""
    frame: Literal["rotating", "static"] = "rotating"
    """Frame of unequal springs: "rotating", fixed in the bladed disk like a shaft that is not
    round, with constant matrices; "static", fixed in space like unequal bearings, with a stiffness
    that varies twice per revolution about the mean of both. Modes are then those on the mean. With
    rotation.effects = "full" the response of a symmetric rotor is that on fixed unequal bearings;
    without Coriolis and centrifugal terms the variation excites the suspension at speeds near its
    frequency, an artefact."""
    damping: DampingOrZero = 0.0
    """Damping parallel to each spring, or to the one along x [N s/m]. With dampers, contact is of
    first order in march.time_step; with rotation.effects = "full" they act within the step."""
    damping_y: DampingOrZero | None = Field(default=None, examples=["1e3"])
    """Damping along y [N s/m], if different."""
    damping_frame: Literal["rotating", "static"] = "rotating"
    """Frame of the dampers: "rotating", internal damping, which acts on the velocity in rotating
    axes and destabilises forward whirl above its critical speed; "static", bearing damping, c (v +
    Omega z x u), which stabilises it. "static" needs rotation.effects = "full" and equal dampers.
    """
    clamped: StrictBool = False
    """Hold the centre instead."""

    @model_serializer(mode="wrap")
    def _springs_in_one_way(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Return the keys to write, without the stiffness if a suspension frequency replaces it."""
        written: dict[str, Any] = handler(self)
        if self.suspension_frequency is not None:
            written.pop("stiffness", None)
        return written

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield errors for unequal dampers in the static frame, and for springs specified twice."""
        if self.suspension_frequency is not None:
            given = [name for name in ("stiffness_y", "clamped") if getattr(self, name)]
            if "stiffness" in self.model_fields_set:
                given.insert(0, "stiffness")
            if given:
                expected = f"no such key beside shaft.{given[0]}"
                yield Inconsistency("suspension_frequency", expected, tuple(given))
        if self.damping_frame == "static" and len(set(self.dampings)) > 1:
            expected = 'the value of shaft.damping, or shaft.damping_frame = "rotating"'
            yield Inconsistency("damping_y", expected, ("damping", "damping_frame"))

    @property
    def stiffnesses(self) -> tuple[float, float]:
        """Constant part of the stiffness along x and y of the rotating axes [N/m]."""
        along_x, along_y = self.springs
        if self.frame == "rotating":
            return along_x, along_y
        mean = 0.5 * (along_x + along_y)
        return mean, mean

    @property
    def anisotropy(self) -> float:
        """Half the difference of the stiffnesses along static x and y [N/m]; 0 for springs in the
        rotating frame."""
        along_x, along_y = self.springs
        return 0.0 if self.frame == "rotating" else 0.5 * (along_x - along_y)

    @property
    def springs(self) -> tuple[float, float]:
        """Stiffness along x and y of the frame in which the springs are fixed [N/m]."""
        return self.stiffness, self.stiffness if self.stiffness_y is None else self.stiffness_y

    @property
    def dampings(self) -> tuple[float, float]:
        """Damping along x and y [N s/m]."""
        return self.damping, self.damping if self.damping_y is None else self.damping_y

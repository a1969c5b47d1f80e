"""Springs and struts that hold the casing, as a case describes them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from pydantic import Field

from bladewhirl.models.case.materials import BeamSection
from bladewhirl.models.inputs.fields import Angle, DampingOrZero, Length, StiffnessOrZero
from bladewhirl.models.inputs.table import Inconsistency, Table

QUARTER = np.pi / 2.0
"""A quarter turn [rad]."""


class SpringSupport(Table):
    """Springs and dampers from the wall to the ground at an angle."""

    angle: Angle = Field(description="From the x axis [rad].")
    radial: StiffnessOrZero = Field(default=0.0, description="Stiffness [N/m].")
    tangential: StiffnessOrZero = Field(default=0.0, description="Stiffness [N/m].")
    radial_damping: DampingOrZero = Field(default=0.0, description="Damping [N s/m].")
    tangential_damping: DampingOrZero = Field(default=0.0, description="Damping [N s/m].")

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Supports that are none."""
        if not (self.radial or self.tangential or self.radial_damping or self.tangential_damping):
            others = ("tangential", "radial_damping", "tangential_damping")
            yield Inconsistency("radial", f"more than 0 here or in {', '.join(others)}", others)


class Strut(BeamSection):
    """A straight strut from the wall to the ground."""

    angle: Angle = Field(description="Of its foot on the wall from the x axis [rad].")
    inclination: Angle = Field(
        default=0.0,
        description="Angle from the outward normal to the strut, counter-clockwise, less than a"
        " quarter turn either way [rad].",
    )
    length: Length = Field(description="Length [m].")
    ends: Literal["pinned", "built-in"] = Field(
        default="pinned", description="Pinned: a bar. Built in: a beam."
    )

    damping: DampingOrZero = Field(default=0.0, description="Of a damper along the strut [N s/m].")

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """A strut that runs inward."""
        if not abs(self.inclination) < QUARTER:
            expected = "less than a quarter turn either way: struts run outward"
            yield Inconsistency("inclination", expected, ())

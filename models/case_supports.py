"""Springs and struts that hold the casing, as a case describes them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from pydantic import Field

from bladewhirl.models.case_fields import Angle, Length, StiffnessOrZero
from bladewhirl.models.case_section import BeamSection
from bladewhirl.models.case_table import Inconsistency, Table

QUARTER = np.pi / 2.0
"""A quarter turn [rad]."""


class SpringSupport(Table):
    """Springs from the wall to the ground at an angle."""

    angle: Angle = Field(description="From the x axis [rad].")
    radial: StiffnessOrZero = Field(default=0.0, description="Stiffness [N/m].")
    tangential: StiffnessOrZero = Field(default=0.0, description="Stiffness [N/m].")

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Springs that are none."""
        if self.radial == 0.0 and self.tangential == 0.0:
            yield Inconsistency("radial", "a stiffness here or in tangential", ("tangential",))


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

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """A strut that runs inward."""
        if not abs(self.inclination) < QUARTER:
            expected = "less than a quarter turn either way: struts run outward"
            yield Inconsistency("inclination", expected, ())

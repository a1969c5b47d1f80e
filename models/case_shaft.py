"""What carries the centre of the bladed disk, as a case describes it."""

from __future__ import annotations

from pydantic import Field, StrictBool

from bladewhirl.models.case_fields import DampingOrZero, Stiffness
from bladewhirl.models.case_table import Table


class Shaft(Table):
    """The two springs that carry the centre; it does not rotate in the plane."""

    stiffness: Stiffness = Field(
        default=3.4e7,
        description="Of each of the two springs, x and y, or of that along x [N/m] (paper,"
        " Section 2.1).",
    )
    stiffness_y: Stiffness | None = Field(
        default=None,
        description="Of the spring along y [N/m], where it differs. Both springs turn with the"
        " bladed disk, as a shaft does that is not round: x runs along blade 0.",
        examples=["2e7"],
    )
    damping: DampingOrZero = Field(
        default=0.0,
        description="Of a damper beside each of the springs, or beside that along x [N s/m]. They"
        " turn with the bladed disk as the springs do, and see its velocity in rotating axes.",
    )
    damping_y: DampingOrZero | None = Field(
        default=None,
        description="Of the damper along y [N s/m], where it differs.",
        examples=["1e3"],
    )
    clamped: StrictBool = Field(default=False, description="Hold the centre instead.")

    @property
    def stiffnesses(self) -> tuple[float, float]:
        """Of the springs along x and y [N/m]."""
        return self.stiffness, self.stiffness if self.stiffness_y is None else self.stiffness_y

    @property
    def dampings(self) -> tuple[float, float]:
        """Of the dampers along x and y [N s/m]."""
        return self.damping, self.damping if self.damping_y is None else self.damping_y

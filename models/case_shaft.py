"""What carries the centre of the bladed disk, as a case describes it."""

from __future__ import annotations

from pydantic import Field, StrictBool

from bladewhirl.models.case_fields import Stiffness
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
    clamped: StrictBool = Field(default=False, description="Hold the centre instead.")

    @property
    def stiffnesses(self) -> tuple[float, float]:
        """Of the springs along x and y [N/m]."""
        return self.stiffness, self.stiffness if self.stiffness_y is None else self.stiffness_y

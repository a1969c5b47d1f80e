"""The `{ width, thickness }` of a rectangular beam section in a case."""

from __future__ import annotations

from pydantic import Field

from bladewhirl.models.case_fields import Length
from bladewhirl.models.case_table import Table


class BeamSection(Table):
    """A rectangular beam section."""

    width: Length = Field(default=0.1, description="Size out of the plane of motion [m].")
    thickness: Length = Field(default=0.01, description="Size in the plane of motion [m].")

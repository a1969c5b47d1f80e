"""The `{ width, thickness }` of a rectangular beam section in a case, and its material."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from bladewhirl.models.case_fields import Length, quantity
from bladewhirl.models.case_table import Table


class BeamSection(Table):
    """A rectangular beam section."""

    width: Length = Field(default=0.1, description="Size out of the plane of motion [m].")
    thickness: Length = Field(default=0.01, description="Size in the plane of motion [m].")


class Material(Table):
    """Material of the bladed disk and the casing."""

    young_modulus: Annotated[float, quantity("Pa")] = Field(
        default=2.1e11, description='Young\'s modulus [Pa] (the paper: "steel").'
    )
    density: Annotated[float, quantity("kg/m3")] = Field(
        default=7800.0, description='Density [kg/m3] (the paper: "steel").'
    )

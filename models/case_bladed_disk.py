"""The `[bladed_disk]` table of a case."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from bladewhirl.models.case_fields import MOST, Length, count
from bladewhirl.models.case_section import BeamSection
from bladewhirl.models.case_table import Inconsistency, Table


class DiskSection(BeamSection):
    """The rectangular section of the disk's beams, thicker by default."""

    thickness: Length = Field(default=0.03, description="Size in the plane of motion [m].")


class BladedDisk(Table):
    """Straight beams: radial blades, spokes from the centre, a rim polygon through the roots."""

    blades: Annotated[int, count(3)] = Field(
        default=22, description="Number of blades (paper, Section 2.1)."
    )
    tip_radius: Length = Field(
        default=0.5, description="Radius of the blade tips [m] (paper, Table 1)."
    )
    disk_radius: Length = Field(
        default=0.05, description="Radius of the blade roots [m] (paper, Table 1)."
    )
    elements_per_blade: Annotated[int, count(1)] = Field(
        default=10, description="Beam elements along each blade (paper, Section 2.1)."
    )
    blade: BeamSection = Field(
        default=BeamSection(),
        description="Section of the blades: width out of the plane, thickness in it [m] (paper,"
        " Table 1; 10 mm must be in the plane for k_o to be 500 blade stiffnesses).",
    )
    disk: DiskSection = Field(
        default=DiskSection(),
        description="Section of spokes and rim [m]; 30 mm in the plane is a choice (the paper has"
        ' "a dedicated set of beams"), which puts the suspension modes at 2.53.',
    )

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Blades without length, more nodes than can be meant."""
        if self.disk_radius >= self.tip_radius:
            expected = f"less than bladed_disk.tip_radius = {self.tip_radius!r}"
            yield Inconsistency("disk_radius", expected, ("tip_radius",))
        if self.blades * self.elements_per_blade > MOST:
            expected = f"at most {MOST} elements on bladed_disk.blades = {self.blades} blades"
            yield Inconsistency("elements_per_blade", expected, ("blades",))

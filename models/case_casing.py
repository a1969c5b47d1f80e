"""The `[casing]` and `[shaft]` tables of a case: what the bladed disk turns in and stands on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, StrictBool

from bladewhirl.models.case_fields import Angle, LengthOrZero, Stiffness, count, quantity, rows
from bladewhirl.models.case_section import BeamSection
from bladewhirl.models.case_table import Inconsistency, Table
from bladewhirl.models.ring_profile import Lobes, RingProfile

ELEMENTS_PER_LOBE = 4
"""Fewer elements on a wave of the clearance can't follow it: the cubic between two nodes is then
off by more than 2 % of the amplitude."""


class Shaft(Table):
    """The two springs that carry the centre; it does not rotate in the plane."""

    stiffness: Stiffness = Field(
        default=3.4e7, description="Of each of the two springs, x and y [N/m] (paper, Section 2.1)."
    )
    clamped: StrictBool = Field(default=False, description="Hold the centre instead.")


class Lobe(Table):
    """Waves around the ring: amplitude * cos(lobes * (angle - phase)); 2 lobes are an ellipse."""

    lobes: Annotated[int, count(1)] = Field(description="Number of waves around the ring.")
    amplitude: LengthOrZero = Field(description="Height of a crest [m].")
    phase: Angle = Field(default=0.0, description="Angle of a crest from the x axis [rad].")


class Casing(Table):
    """A ring of curved beams at tip_radius + clearance."""

    elements: Annotated[int, count(3)] = Field(
        default=40, description="Number of curved beam elements (paper, Section 2.1)."
    )
    clearance: LengthOrZero = Field(
        default=1e-3,
        description="Gap between tips and casing at rest [m] (paper, Table 1); its mean where there"
        " are lobes.",
    )
    clearance_lobes: Annotated[
        tuple[Lobe, ...], rows('{ lobes = 2, amplitude = "0.2 mm", phase = "30 deg" }')
    ] = Field(
        default=(),
        description='Out-of-round clearance, rows of { lobes = 2, amplitude = "0.2 mm", phase ='
        ' "30 deg" }: amplitude * cos(lobes * (angle - phase)) on top of clearance, fixed in the'
        " static frame; 2 lobes make an ellipse. The clearance alone is out of round: the beams"
        " stay on a circle.",
    )
    wall: BeamSection = Field(
        default=BeamSection(), description="Section of the wall [m] (paper, Table 1)."
    )
    curvature: Literal["exact", "shallow"] = Field(
        default="exact",
        description='Bending strain, "exact" or "shallow" (not in the paper; a free exact ring has'
        " its three rigid motions, a shallow one has not).",
    )
    support: Annotated[float, quantity("N/m2", "not negative")] = Field(
        default=1508.0,
        description="Uniform elastic support, radial and tangential [N/m per metre of"
        " circumference] (not in the paper; puts the casing's lowest mode at 0.055, which is"
        ' "very low" as the paper says, for modal work).',
    )
    rotation: Literal["free", "fixed"] = Field(
        default="fixed",
        description='Rigid rotation of the ring, "free" or "fixed" (not in the paper; free,'
        " friction would spin the ring up).",
    )

    @property
    def clearance_profile(self) -> RingProfile:
        """Clearance [m] around the ring."""
        return RingProfile(mean=self.clearance, lobes=_lobes(self.clearance_lobes))

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """A clearance that the elements can't follow, or that is none."""
        most = max((row.lobes for row in self.clearance_lobes), default=0)
        if most * ELEMENTS_PER_LOBE > self.elements:
            expected = (
                f"at most {self.elements // ELEMENTS_PER_LOBE} lobes with casing.elements ="
                f" {self.elements}, {ELEMENTS_PER_LOBE} a lobe"
            )
            yield Inconsistency("clearance_lobes", expected, ("elements",))
        smallest = self.clearance_profile.smallest
        if smallest < 0.0:
            expected = (
                f"lobes that leave a gap: with casing.clearance = {self.clearance!r} the smallest"
                f" would be {smallest:.6g} m"
            )
            yield Inconsistency("clearance_lobes", expected, ("clearance",))


def _lobes(given: tuple[Lobe, ...]) -> tuple[Lobes, ...]:
    return tuple(Lobes(count=row.lobes, amplitude=row.amplitude, phase=row.phase) for row in given)

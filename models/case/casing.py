"""The `[casing]` table of a case: the ring around the bladed disk, and its supports."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field

from bladewhirl.models.case.closure import Closure
from bladewhirl.models.case.coating import Coating
from bladewhirl.models.case.wall_profile import ClearanceProfile
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.rules import SAME_ANGLE
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.sections.rectangular import BeamSection
from bladewhirl.models.sections.wall import TURN, Arc, Lobe, LobeRows, RingProfile

STEEPEST = math.radians(30.0)  #: largest slope of a conical wall [rad]

ELEMENTS_PER_LOBE = 4
"""Smallest number of elements per wave. With fewer elements, the error of the clearance, which is a
cubic polynomial between nodes, exceeds 2 % of the amplitude."""

OF_ANGLES = ("clearance_lobes", "profile", "closure", "coating")
"""Keys of walls that are not round, or not always."""


class Station(Table):
    """Thickness of the wall at one angle around the ring."""

    angle: fields.Angle
    """Angle from the x axis [rad]."""
    thickness: fields.Length
    """Size in the plane of motion [m]."""


Place = tuple[Annotated[float, fields.quantity("m", "any")], fields.Length]


class SpringSupport(Table):
    """Springs and dampers that connect the wall to the ground at one angle around the ring."""

    angle: fields.Angle
    """Angle from the x axis [rad]."""
    radial: fields.StiffnessOrZero = 0.0
    """Radial stiffness [N/m]."""
    tangential: fields.StiffnessOrZero = 0.0
    """Tangential stiffness [N/m]."""
    radial_damping: fields.DampingOrZero = 0.0
    """Radial damping [N s/m]."""
    tangential_damping: fields.DampingOrZero = 0.0
    """Tangential damping [N s/m]."""


class Strut(BeamSection):
    """A straight strut from the wall to the ground."""

    angle: fields.Angle
    """Angle of the foot on the wall from the x axis [rad]."""
    inclination: fields.Angle = 0.0
    """Angle from the outward normal to the strut, counter-clockwise, less than a quarter turn in
    either direction [rad]."""
    length: fields.Length
    """Length [m]."""
    ends: Literal["pinned", "built-in"] = "pinned"
    """A pinned strut is a bar, a built-in strut is a beam."""
    damping: fields.DampingOrZero = 0.0
    """Damping along the strut [N s/m]."""


def steepest(contour: Sequence[tuple[float, float]]) -> float:
    """Return the largest slope between rows of a contour, in either direction [rad]."""
    return max(abs(math.atan((s - r) / (b - a))) for (a, r), (b, s) in pairwise(contour))


class Casing(Table):
    """A ring of curved beams at tip_radius + clearance, or a rigid wall."""

    elements: Annotated[int, fields.count(3)] = 40
    """Number of curved beam elements (paper, Section 2.1). With four elements per wavelength the
    error of a frequency is 0.5 %. Twice the number of blades gives four elements to every wave that
    the blades can distinguish."""
    clearance: fields.LengthOrZero = 1e-3
    """Gap between tips and casing at rest [m] (paper, Table 1); the mean gap if there are lobes. By
    default a thousandth of the radius of the contact nodes of a superelement."""
    clearance_lobes: LobeRows = ()
    """Out-of-round clearance, rows of { lobes = 2, amplitude = "0.2 mm", phase = "30 deg" }:
    amplitude * cos(lobes * (angle - phase)) added to clearance, fixed in the static frame; 2 lobes
    are an ellipse. Only the clearance is out of round: the beams stay on a circle."""
    profile: ClearanceProfile | None = Field(default=None, examples=['{ file = "wall.csv" }'])
    """Measured clearance around the casing: { file = "wall.csv" } with the first line "angle
    [deg],clearance [mm]", { points = [[0, 1e-3], ...] }, or { harmonics = [{ lobes = 2, amplitude =
    "0.2 mm" }] }; by default there is none."""
    closure: Closure | None = Field(
        default=None, examples=['{ amount = "0.3 mm", time_constant = "1 s" }']
    )
    """Clearance lost over time: { amount = "0.3 mm", time_constant = "1 s" } or { table = [["0 s",
    "0 mm"], ["2 s", "0.3 mm"]] }, with lobes if it varies around the casing; by default there is
    none."""
    coating: Coating | None = Field(
        default=None,
        examples=[
            '{ thickness = "5 mm", young_modulus = "1 GPa", yield_stress = "10 MPa",'
            ' hardening = "50 MPa" }'
        ],
    )
    """Abradable coating on the inner face: { thickness = "5 mm", young_modulus = "1 GPa",
    yield_stress = "10 MPa", hardening = "50 MPa" }; by default there is none."""
    wall: BeamSection = BeamSection()
    """Section of the wall [m] (paper, Table 1)."""
    thickness_lobes: Annotated[
        tuple[Lobe, ...], fields.rows('{ lobes = 2, amplitude = "1 mm", phase = "30 deg" }')
    ] = ()
    """Waves of the wall's thickness, rows as in clearance_lobes, added to wall.thickness or to
    thickness_stations."""
    thickness_stations: Annotated[
        tuple[Station, ...], fields.rows('{ angle = "90 deg", thickness = "12 mm" }')
    ] = ()
    """Thickness of the wall at angles, rows of { angle = "90 deg", thickness = "12 mm" }, with
    linear interpolation between them around the ring. If there are rows, wall.thickness is not
    used."""
    stiffened_arcs: Annotated[
        tuple[Arc, ...], fields.rows('{ start = "30 deg", end = "60 deg", thickness = "20 mm" }')
    ] = ()
    """Arcs of the wall with another section or material, rows of { start = "30 deg", end = "60
    deg", thickness = "20 mm" } with any of thickness, width, young_modulus and density; keys that
    are left out have the values of the wall. All sections are centred on the same circle. Results
    converge fastest if arcs end at nodes, which are 9 degrees apart with 40 elements."""
    curvature: Literal["exact", "shallow"] = "exact"
    """Bending strain, "exact" or "shallow" (not in the paper; a ring without supports has its three
    rigid motions with "exact" only)."""
    support: Annotated[float, fields.quantity("N/m2", "not negative")] = 1508.0
    """Uniform elastic support, radial and tangential [N/m per metre of circumference] (not in the
    paper; the lowest casing frequency is then 0.055 times the reference frequency, "very low" as in
    the paper)."""
    springs: Annotated[
        tuple[SpringSupport, ...], fields.rows('{ angle = "90 deg", radial = "1 MN/m" }')
    ] = ()
    """Springs from the wall to the ground, rows of { angle = "90 deg", radial = "1 MN/m",
    tangential = 0, radial_damping = "2 kN s/m", tangential_damping = 0 }, in addition to support.
    If springs or struts prevent a rigid rotation of the ring, rotation = "free" is possible.
    Dampers act in a march, in which the error of contact is then of first order in march.time_step;
    modes are computed without dampers."""
    struts: Annotated[
        tuple[Strut, ...],
        fields.rows('{ angle = "90 deg", length = "300 mm", thickness = "8 mm" }'),
    ] = ()
    """Straight struts from the wall to the ground, rows of { angle = "90 deg", inclination = 0,
    length = "300 mm", width = "100 mm", thickness = "10 mm", ends = "pinned", damping = 0 }; with
    ends = "built-in" they also bend, and results converge fastest if their feet are at nodes.
    Struts have mass, but no internal modes. With damping, the error of contact is of first order in
    march.time_step."""
    rotation: Literal["free", "fixed"] = "fixed"
    """Rigid rotation of the ring, "free" or "fixed" (not in the paper; with "free" friction would
    spin the ring up)."""
    type: Literal["ring", "rigid"] = "ring"
    """"ring": a flexible ring; "rigid": a wall that does not move, for a superelement; only its
    clearance (with lobes, profile and closure) and its coating are used. All contact nodes of a
    superelement press on the ring at their angle, wherever they are along the axis."""
    radius: fields.Length | None = Field(default=None, examples=["0.25"])
    """Radius from which the clearance of a rigid wall is measured [m]. By default the clearance of
    each contact node is measured from the radius of this node, so that the wall follows the shape
    of the tip."""
    slope: Annotated[float, fields.quantity("rad", "any")] = Field(
        default=0.0, examples=['"3 deg"']
    )
    """Slope of a conical wall under a superelement, at most 30 deg [rad]: its radius grows by the
    tangent of the slope along the axis. The clearance still counts at each contact node along the
    radius; gap, normal force and friction have the directions of the wall. On a flexible casing,
    the radial part of the friction along the slope is left out."""
    contour: Annotated[
        tuple[Place, ...], fields.rows('[axial position, radius], as in ["5 mm", "301 mm"]')
    ] = ()
    """Contour of a rigid wall under a superelement in place of a slope, rows of [axial position,
    radius] in ascending order of the position [m]. Each contact node has the slope of the contour
    at its axial position, by a monotone cubic interpolation between the rows; the clearance counts
    at each node as with a slope."""

    @property
    def clearance_profile(self) -> RingProfile:
        """Clearance [m] around the ring."""
        measured = self.profile
        return RingProfile(
            mean=self.clearance,
            lobes=(*self.clearance_lobes, *(measured.harmonics if measured else ())),
            points=measured.points if measured else (),
        )

    @property
    def most_lobes(self) -> int:
        """Largest number of lobes that the elements resolve."""
        return fields.MOST if self.type == "rigid" else self.elements // ELEMENTS_PER_LOBE

    @property
    def overlap(self) -> tuple[Arc, Arc] | None:
        """First stiffened arc that reaches into the next one, and this one; None without one."""
        arcs = sorted(self.stiffened_arcs, key=lambda arc: arc.start % TURN)
        for arc, following in zip(arcs, [*arcs[1:], *arcs[:1]], strict=True):
            ahead = (following.start - arc.start) % TURN if len(arcs) > 1 else TURN
            if arc.end - arc.start > ahead + SAME_ANGLE:
                return arc, following
        return None

    @property
    def thickness_profile(self) -> RingProfile:
        """Thickness of the wall around the ring, without the stiffened arcs [m]."""
        return RingProfile(
            mean=self.wall.thickness,
            lobes=self.thickness_lobes,
            stations=tuple((row.angle, row.thickness) for row in self.thickness_stations),
        )

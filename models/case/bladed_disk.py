"""The `[bladed_disk]` table of a case and its inner tables: taper, shrouds, rings, masses."""

import math
import sys
from collections.abc import Iterable, Iterator
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, StrictStr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.mesh_file import MeshTable
from bladewhirl.models.case.superelement import SuperelementTable
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.rules import Inconsistency, broken
from bladewhirl.models.inputs.table import ReplacedKeys, Table
from bladewhirl.models.sections.rectangular import BeamSection

MOST_SPREAD = 0.2
"""Largest standard deviation of random factors; a larger deviation makes factors below zero likely.
"""

FACTORS = ("stiffness", "mass", "length")
"""Quantities of a blade with factors, in the order of their random streams."""

Blades = tuple[Annotated[int, fields.count(0)], ...]
Factors = tuple[Annotated[float, fields.number("positive")], ...]


class TaperStation(Table):
    """Section at one point along the blade; keys left out have the values of bladed_disk.blade."""

    width: fields.Length | None = None
    """Size out of the plane [m]."""
    thickness: fields.Length | None = None
    """Size in the plane [m]."""
    material: StrictStr | None = None
    """Name of a material in material.named."""


class CentrePoint(Table):
    """Point on the centre line of a blade."""

    span: Annotated[float, fields.number("positive")]
    """Radial distance from the root, as a share of the distance from root to tip."""
    angle: fields.Angle
    """Angular position of the point about the axis of rotation, from the radial line through the
    root, positive counter-clockwise [rad]."""


class Shroud(BeamSection):
    """A ring of beams from blade to blade."""

    radius: fields.Length
    """Radius at which the shroud meets the blades [m]."""
    elements: Annotated[int, fields.count(1)] = 1
    """Number of beams from blade to blade: one straight beam, or several along the arc."""
    cuts: Blades = ()
    """Blades after which the ring is cut; an empty list is a closed ring."""


class DiskRing(BeamSection):
    """A ring of straight beams within the disk, from spoke to spoke."""

    thickness: fields.Length = 0.03
    """Size in the plane of motion [m]."""
    radius: fields.Length
    """Radius at which the ring meets the spokes [m]."""


class PointMass(Table):
    """A point mass at the centre, or equal point masses at one radius of some or all blades."""

    radius: fields.LengthOrZero
    """Radius [m]: 0 at the centre, otherwise between root and tip."""
    mass: fields.Mass
    """Mass on each blade, or at the centre [kg]."""
    inertia: fields.Inertia = 0.0
    """Rotary inertia on each blade, or at the centre [kg m2]."""
    blades: Blades | None = None
    """Blades with the mass; all by default."""


class Mistuning(Table):
    """Differences between blades: a list with one factor for each blade, or random factors."""

    stiffness: Factors = ()
    """Factors on Young's modulus of each blade."""
    mass: Factors = ()
    """Factors on the density of each blade."""
    length: Factors = ()
    """Factors on the length of each blade from root to tip. Shrouds and masses along the blade keep
    their radius: only the part of the blade beyond the outermost shroud or mass changes length.
    Sections of a taper stay with their elements."""
    stiffness_spread: fields.NumberOrZero = 0.0
    """Standard deviation of random factors on Young's modulus, whose mean is 1."""
    mass_spread: fields.NumberOrZero = 0.0
    """Standard deviation of random factors on the density, whose mean is 1."""
    length_spread: fields.NumberOrZero = 0.0
    """Standard deviation of random factors on the length, whose mean is 1."""
    seed: Annotated[int, fields.count(0)] = 0
    """Seed of the random factors; each quantity has a random stream of its own."""

    def factors(self, name: str, blades: int) -> FloatArray:
        """Return the factors on stiffness, mass or length, (blades,): the given list, otherwise
        random factors."""
        listed = getattr(self, name)
        if listed:
            return np.array(listed)
        stream = FACTORS.index(name)
        drawn = np.random.default_rng([self.seed, stream]).standard_normal(blades)
        return np.asarray(1.0 + getattr(self, f"{name}_spread") * drawn)

    def is_given(self, blades: int) -> bool:
        """Return true if a factor of a blade is not 1."""
        return any((self.factors(name, blades) != 1.0).any() for name in FACTORS)

    @property
    def changed(self) -> set[str]:
        """Keys that differ from their defaults."""
        return {*self.model_dump(exclude_defaults=True)}


TaperRows = Annotated[tuple[TaperStation, ...], fields.rows('{ thickness = "12 mm" }')]
CentreRows = Annotated[tuple[CentrePoint, ...], fields.rows('{ span = 1.0, angle = "10 deg" }')]
ShroudRows = Annotated[tuple[Shroud, ...], fields.rows('{ radius = "0.4 m", thickness = "5 mm" }')]
RingRows = Annotated[tuple[DiskRing, ...], fields.rows('{ radius = "25 mm", thickness = "20 mm" }')]
MassRows = Annotated[tuple[PointMass, ...], fields.rows('{ radius = "0.4 m", mass = "50 g" }')]


class DiskSection(BeamSection):
    """The rectangular section of the disk's beams, by default thicker than the section of the
    blades."""

    thickness: fields.Length = 0.03
    """Size in the plane of motion [m]."""


class BladedDisk(ReplacedKeys):
    """A bladed disk of beams: blades from root to tip, spokes, and a rim through the roots."""

    blades: Annotated[int, fields.count(3)] = 22
    """Number of blades (paper, Section 2.1)."""
    tip_radius: fields.Length = 0.5
    """Radius of the blade tips [m] (paper, Table 1)."""
    disk_radius: fields.Length = 0.05
    """Radius of the blade roots [m] (paper, Table 1)."""
    elements_per_blade: Annotated[int, fields.count(1)] = 10
    """Beam elements along each blade (paper, Section 2.1)."""
    blade: BeamSection = BeamSection()
    """Section of the blades: width out of the plane of motion, thickness in the plane [m] (paper,
    Table 1; the paper's shaft stiffness k_o equals 500 blade stiffnesses only if the 10 mm are in
    the plane)."""
    taper: TaperRows = ()
    """Sections of the blades from root to tip at equal distances, linear in between, rows of {
    thickness = "12 mm", width = "0.1 m" }; keys that are left out have the values of blade."""
    centre_line: CentreRows = ()
    """Points on the smooth centre line of the blades after the root, rows of { span = 0.5, angle =
    "4 deg" }: share of the radial distance from root to tip, and angular position about the axis of
    rotation, from the radial line through the root, positive counter-clockwise; the last point has
    span = 1. Without points the blades are straight and radial. The tips keep their position, the
    roots move."""
    shrouds: ShroudRows = ()
    """Rings of beams from blade to blade, rows of { radius = "0.4 m", width = "20 mm", thickness =
    "5 mm" }; elements = 3 follows the arc with three beams, cuts = [21] leaves the ring open after
    blade 21."""
    disk_kind: Literal["spokes-and-rim", "spokes", "rim", "rigid"] = "spokes-and-rim"
    """"spokes-and-rim" (the paper), "spokes", "rim" or "rigid". "rim" is a ring that springs
    connect to the centre, which then needs a point mass. Spokes are beams from the centre to each
    root; near the centre, where spokes overlap, each of them has its full mass and stiffness."""
    disk: DiskSection = DiskSection()
    """Section of spokes and rim [m]. The thickness of 30 mm is a choice (the paper has "a dedicated
    set of beams"); the suspension modes are then at 2.53 times the reference frequency."""
    disk_rings: RingRows = ()
    """More rings within the disk, rows of { radius = "25 mm", thickness = "20 mm" }; the spokes
    have nodes at the rings."""
    web_radial: fields.Stiffness = 1e9
    """Radial stiffness of each spring from centre to root for disk_kind = "rim" [N/m]."""
    web_tangential: fields.Stiffness = 1e9
    """Tangential stiffness of each spring from centre to root for disk_kind = "rim" [N/m]."""
    tip_mass: fields.Mass = 0.0
    """Point mass at each tip [kg]."""
    point_masses: MassRows = ()
    """More point masses, rows of { radius = "0.4 m", mass = "50 g" }. Every blade has the mass,
    unless blades = [0, 7] lists the blades that have it; inertia = "2 kg cm2" adds a rotary
    inertia; radius = 0 is the centre."""
    mistuning: Mistuning = Mistuning()
    """Mistuning: lists of factors on stiffness, mass and length with one entry per blade; or
    standard deviations of random factors with mean 1, and a seed. A longer blade has a smaller
    clearance."""

    mesh: MeshTable | None = Field(
        default=None,
        examples=[
            '{ file = "a.msh", unit = "mm", sections.blades = { width = 0.1, thickness = 0.01 } }'
        ],
    )
    """Mesh file that replaces all other keys of [bladed_disk]; by default there is none. The table
    has the file, its unit of length, the names of its groups of nodes at the tips and at the centre
    (tips = "tips", centre = "centre"), and sections of its groups of lines."""
    superelement: SuperelementTable | None = Field(
        default=None, examples=['{ file = "blade.npz", copies = 22 }']
    )
    """File with the matrices of a blade, a sector or a wheel, which replaces all other keys of
    [bladed_disk] except the mistuning of the stiffness: { file = "blade.npz", copies = 22, kind =
    "blade" }; by default there is none."""

    @property
    def matrices(self) -> SuperelementTable:
        """Table of the superelement of a bladed disk that is one."""
        assert self.superelement is not None
        return self.superelement

    @property
    def count(self) -> int:
        """Number of blades, or copies of a superelement."""
        if self.superelement is not None:
            return self.superelement.copies
        return self.blades if self.mesh is None else len(self.mesh.tip_points)

    @property
    def radius(self) -> float:
        """Largest radius of a tip or of a contact node [m]; of a mesh, its `tip_radius`."""
        if self.superelement is not None:
            return float(self.superelement.part.contact_radius.max())
        if self.mesh is None:
            return self.tip_radius
        return self.mesh.tip_radius or max(math.hypot(*tip) for tip in self.mesh.tip_points)

    @property
    def cut_radii(self) -> list[float]:
        """Radii between root and tip at which a blade needs a node, ascending [m]."""
        radii = {shroud.radius for shroud in self.shrouds}
        radii |= {mass.radius for mass in self.point_masses}
        return sorted(r for r in radii if self.disk_radius < r < self.tip_radius)

    @property
    def sector_elements(self) -> int:
        """Number of elements on a blade and on the shrouds from it to the next."""
        return self.elements_per_blade + sum(shroud.elements for shroud in self.shrouds)

    @property
    def shortest_radius(self) -> float:
        """Radius of the tip of the shortest blade [m]."""
        factor = float(self.mistuning.factors("length", self.blades).min())
        return self.disk_radius + factor * (self.tip_radius - self.disk_radius)

    @property
    def source(self) -> str:
        """Key with a file that replaces the other keys; empty without one."""
        return next((key for key in ("superelement", "mesh") if getattr(self, key)), "")

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield the rules that are broken."""
        yield from super().inconsistencies()
        here = sys.modules[__name__]
        if not self.source and self.disk_radius < self.tip_radius:
            yield from broken("BladedDisk of beams", self, here)
        if self.mesh is None:
            yield from broken("BladedDisk with mistuning", self, here)

    def written(self) -> Iterable[str]:
        """Return the keys to write, without those that a mesh file or a superelement replaces."""
        if self.superelement is not None:
            return ("superelement", "mistuning")
        return type(self).model_fields if self.mesh is None else ("mesh",)

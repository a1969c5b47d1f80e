"""The `[bladed_disk]` table of a case and its inner tables: taper, shrouds, rings, masses."""

import math
from collections.abc import Iterable, Iterator
from itertools import combinations, pairwise
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, StrictStr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.mesh_file import MeshTable
from bladewhirl.models.case.superelement import SuperelementTable
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.table import Inconsistency, ReplacedKeys, Table
from bladewhirl.models.sections.rectangular import BeamSection

MOST_SPREAD = 0.2
"""Largest standard deviation of random factors; a larger deviation makes factors below zero likely.
"""

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
        stream = ("stiffness", "mass", "length").index(name)
        drawn = np.random.default_rng([self.seed, stream]).standard_normal(blades)
        return np.asarray(1.0 + getattr(self, f"{name}_spread") * drawn)

    def is_given(self, blades: int) -> bool:
        """Return true if a factor of a blade is not 1."""
        return any(
            (self.factors(name, blades) != 1.0).any() for name in ("stiffness", "mass", "length")
        )

    def faults(self, blades: int) -> Iterator[Inconsistency]:
        """Yield lists of wrong length, and spreads that are too large or given in addition to a
        list."""
        for name in ("stiffness", "mass", "length"):
            listed, spread = getattr(self, name), getattr(self, f"{name}_spread")
            key = f"mistuning.{name}"
            if listed and len(listed) != blades:
                expected = f"{blades} factors, one for each blade, not {len(listed)}"
                yield Inconsistency(key, expected, ("blades",))
            if listed and spread:
                expected = f"either factors or bladed_disk.mistuning.{name}_spread, not both"
                yield Inconsistency(key, expected, (f"mistuning.{name}_spread",))
            elif spread > MOST_SPREAD or not np.all(self.factors(name, blades) > 0.0):
                yield Inconsistency(f"{key}_spread", f"at most {MOST_SPREAD:g}")


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

    def written(self) -> Iterable[str]:
        """Return the keys to write, without those that a mesh file or a superelement replaces."""
        if self.superelement is not None:
            return ("superelement", "mistuning")
        return type(self).model_fields if self.mesh is None else ("mesh",)

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield errors for blades without length, parts at wrong radii and too many elements."""
        if self.superelement is not None or self.mesh is not None:
            source = "mesh" if self.superelement is None else "superelement"
            for name in self.given(kept=[*self.written()]):
                expected = f"not allowed together with bladed_disk.{source}; remove this key"
                yield Inconsistency(name, expected, (source,))
            if self.superelement is not None:
                yield from self._factor_faults(self.superelement)
            return
        if self.disk_radius >= self.tip_radius:
            expected = f"less than bladed_disk.tip_radius = {self.tip_radius!r}"
            yield Inconsistency("disk_radius", expected, ("tip_radius",))
            return
        sector = self.elements_per_blade + sum(shroud.elements for shroud in self.shrouds)
        if self.blades * sector > fields.MOST:
            expected = (
                f"at most {fields.MOST} elements on bladed_disk.blades = {self.blades} blades"
            )
            if self.shrouds:
                expected += f", including those of shrouds, not {self.blades * sector}"
            yield Inconsistency("elements_per_blade", expected, ("blades", "shrouds"))
        if self.elements_per_blade <= len(self.cut_radii):
            expected = f"at least {len(self.cut_radii) + 1}, for shrouds and masses along the blade"
            yield Inconsistency("elements_per_blade", expected, ("shrouds", "point_masses"))
        spans = [0.0, *(point.span for point in self.centre_line)]
        if len(spans) > 1 and (spans[-1] != 1.0 or any(b <= a for a, b in pairwise(spans))):
            yield Inconsistency("centre_line", "ascending spans that end with span = 1")
        yield from self._radius_faults()
        for key, blades in (
            *(("shrouds", shroud.cuts) for shroud in self.shrouds),
            *(("point_masses", mass.blades or ()) for mass in self.point_masses),
        ):
            if max(blades, default=0) >= self.blades or len(set(blades)) < len(blades):
                expected = f"blades from 0 to {self.blades - 1}, each at most once"
                yield Inconsistency(key, expected, ("blades",))
        yield from self.mistuning.faults(self.blades)

    def _factor_faults(self, table: SuperelementTable) -> Iterator[Inconsistency]:
        """Yield errors for mistuning beside a superelement: only the stiffness of blades may
        differ, and a sector or a wheel needs the stiffness of its blades."""
        given = self.mistuning.model_dump(exclude_defaults=True)
        for name in given.keys() - {"stiffness", "stiffness_spread", "seed"}:
            expected = "not allowed together with bladed_disk.superelement; remove this key"
            yield Inconsistency(f"mistuning.{name}", expected, ("superelement",))
        if given and table.kind != "blade" and table.part.blade_stiffness is None:
            expected = (
                f'a file with blade_stiffness for bladed_disk.superelement.kind = "{table.kind}",'
                " which bw.mesh3d writes with blade = GROUP; or remove this key"
            )
            yield Inconsistency("mistuning", expected, ("superelement",))
        yield from self.mistuning.faults(table.copies)

    def _radius_faults(self) -> Iterator[Inconsistency]:
        root, tip = self.disk_radius, self.tip_radius
        lengths = self.mistuning.factors("length", self.blades)
        if len(lengths) == self.blades:
            shortest = root + float(lengths.min()) * (tip - root)
            if self.cut_radii and self.cut_radii[-1] >= shortest:
                expected = f"radii below the shortest blade's tip at {shortest:.6g} m"
                at_fault = "shrouds" if self.shrouds else "point_masses"
                yield Inconsistency(at_fault, expected, ("mistuning",))
        if not all(root < shroud.radius <= tip for shroud in self.shrouds):
            expected = f"radii above bladed_disk.disk_radius = {root!r}, up to tip_radius = {tip!r}"
            yield Inconsistency("shrouds", expected, ("disk_radius", "tip_radius"))
        for one, other in combinations(self.shrouds, 2):
            if one.radius == other.radius and len({*one.cuts, *other.cuts}) < self.blades:
                expected = "at most one shroud at each radius between two blades"
                yield Inconsistency("shrouds", expected)
        if not all(mass.radius == 0.0 or root <= mass.radius <= tip for mass in self.point_masses):
            expected = f"radii of 0 or from disk_radius = {root!r} to tip_radius = {tip!r}"
            yield Inconsistency("point_masses", expected, ("disk_radius", "tip_radius"))
        if any(mass.radius == 0.0 and mass.blades is not None for mass in self.point_masses):
            expected = "masses at the centre, radius = 0, without the key blades"
            yield Inconsistency("point_masses", expected)
        radii = [ring.radius for ring in self.disk_rings]
        if not all(radius < root for radius in radii) or len(set(radii)) < len(radii):
            expected = f"different radii below bladed_disk.disk_radius = {root!r}"
            yield Inconsistency("disk_rings", expected, ("disk_radius",))
        hub = sum(mass.mass for mass in self.point_masses if mass.radius == 0.0)
        if self.disk_kind == "rim" and not hub > 0.0:
            expected = 'a mass at radius = 0: without it, the centre of a "rim" has no mass'
            yield Inconsistency("point_masses", expected, ("disk_kind",))
        if radii and not self.disk_kind.startswith("spokes"):
            expected = (
                f'not allowed with bladed_disk.disk_kind = "{self.disk_kind}"; remove the rings, or'
                ' choose a kind with spokes, such as "spokes-and-rim"'
            )
            yield Inconsistency("disk_rings", expected, ("disk_kind",))

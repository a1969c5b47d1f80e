"""The `[bladed_disk]` table of a case and its parts: stations, shrouds, rings, masses."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, StrictStr, model_serializer

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.mesh_file import MeshTable
from bladewhirl.models.inputs.fields import (
    MOST,
    Angle,
    Inertia,
    Length,
    LengthOrZero,
    Mass,
    NumberOrZero,
    Stiffness,
    count,
    number,
    rows,
)
from bladewhirl.models.inputs.table import Inconsistency, Table
from bladewhirl.models.sections.rectangular import BeamSection

MOST_SPREAD = 0.2
"""Largest standard deviation of random factors; with a larger one, factors below zero are likely.
"""

Blades = tuple[Annotated[int, count(0)], ...]
Factors = tuple[Annotated[float, number("positive")], ...]


class TaperStation(Table):
    """A section along the blade; keys left out are as in bladed_disk.blade."""

    width: Length | None = None
    """Size out of the plane [m]."""
    thickness: Length | None = None
    """Size in the plane [m]."""
    material: StrictStr | None = None
    """Name in material.named."""


class CentrePoint(Table):
    """Point on the centre line of a blade."""

    span: Annotated[float, number("positive")]
    """Share of the way from root to tip, by radius."""
    angle: Angle
    """Angle from the radial line through the root [rad]."""


class Shroud(BeamSection):
    """A ring of beams from blade to blade."""

    radius: Length
    """Radius at which it meets the blades [m]."""
    elements: Annotated[int, count(1)] = 1
    """Beams from blade to blade; a straight one, or several on the arc."""
    cuts: Blades = ()
    """Blades after which the ring is cut; none: it is closed."""


class DiskRing(BeamSection):
    """A ring of straight beams within the disk, from spoke to spoke."""

    thickness: Length = 0.03
    """Size in the plane of motion [m]."""
    radius: Length
    """Radius at which it meets the spokes [m]."""


class PointMass(Table):
    """A mass at a radius, on all blades or on some."""

    radius: LengthOrZero
    """0 for the centre, else from root to tip [m]."""
    mass: Mass
    """Each [kg]."""
    inertia: Inertia = 0.0
    """Rotary inertia, each [kg m2]."""
    blades: Blades | None = None
    """Blades with the mass; all by default."""


class Mistuning(Table):
    """Differences between blades: factors, one a blade, or random ones."""

    stiffness: Factors = ()
    """On Young's modulus of each blade."""
    mass: Factors = ()
    """On the density of each blade."""
    length: Factors = ()
    """Factors on the length from root to tip. Shrouds and masses along the blade keep their radius:
    the part beyond the last of them changes length. Sections of a taper stay with their elements.
    """
    stiffness_spread: NumberOrZero = 0.0
    """Standard deviation of random factors about 1."""
    mass_spread: NumberOrZero = 0.0
    """The same for the density."""
    length_spread: NumberOrZero = 0.0
    """The same for the length."""
    seed: Annotated[int, count(0)] = 0
    """Seed of the random factors; each quantity has a random stream of its own."""

    def factors(self, name: str, blades: int) -> FloatArray:
        """Return the factors on stiffness, mass or length: the listed ones, random ones or ones,
        (blades,)."""
        listed = getattr(self, name)
        if listed:
            return np.array(listed)
        stream = ("stiffness", "mass", "length").index(name)
        drawn = np.random.default_rng([self.seed, stream]).standard_normal(blades)
        return np.asarray(1.0 + getattr(self, f"{name}_spread") * drawn)

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
                yield Inconsistency(f"{key}_spread", f"at most {MOST_SPREAD:g}", ())


TaperRows = Annotated[tuple[TaperStation, ...], rows('{ thickness = "12 mm" }')]
CentreRows = Annotated[tuple[CentrePoint, ...], rows('{ span = 1.0, angle = "10 deg" }')]
ShroudRows = Annotated[tuple[Shroud, ...], rows('{ radius = "0.4 m", thickness = "5 mm" }')]
RingRows = Annotated[tuple[DiskRing, ...], rows('{ radius = "25 mm", thickness = "20 mm" }')]
MassRows = Annotated[tuple[PointMass, ...], rows('{ radius = "0.4 m", mass = "50 g" }')]


class DiskSection(BeamSection):
    """The rectangular section of the disk's beams, thicker by default."""

    thickness: Length = 0.03
    """Size in the plane of motion [m]."""


class BladedDisk(Table):
    """Beams: blades from root to tip, a disk of spokes and a rim polygon through the roots."""

    blades: Annotated[int, count(3)] = 22
    """Number of blades (paper, Section 2.1)."""
    tip_radius: Length = 0.5
    """Radius of the blade tips [m] (paper, Table 1)."""
    disk_radius: Length = 0.05
    """Radius of the blade roots [m] (paper, Table 1)."""
    elements_per_blade: Annotated[int, count(1)] = 10
    """Beam elements along each blade (paper, Section 2.1)."""
    blade: BeamSection = BeamSection()
    """Section of the blades: width out of the plane, thickness in it [m] (paper, Table 1; 10 mm
    must be in the plane for k_o to be 500 blade stiffnesses)."""
    taper: TaperRows = ()
    """Sections of the blades from root to tip at equal distances, linear in between, rows of {
    thickness = "12 mm", width = "0.1 m" }; what is left out is as in blade."""
    centre_line: CentreRows = ()
    """Points on the smooth centre line of the blades after the root, rows of { span = 0.5, angle =
    "4 deg" }: share of the radial distance from root to tip, and angle from the radial line through
    the root; the last has span = 1. None: straight and radial. The tips keep their position, the
    roots move."""
    shrouds: ShroudRows = ()
    """Rings of beams from blade to blade, rows of { radius = "0.4 m", width = "20 mm", thickness =
    "5 mm" }; elements = 3 follows the arc with three beams, cuts = [21] leaves the ring open after
    blade 21."""
    disk_kind: Literal["spokes-and-rim", "spokes", "rim", "rigid"] = "spokes-and-rim"
    """"spokes-and-rim" (the paper), "spokes", "rim": a ring connected to the centre by springs,
    which needs a point mass there, or "rigid". Spokes are beams from the centre to each root: where
    they overlap near the centre, each has its full mass and stiffness."""
    disk: DiskSection = DiskSection()
    """Section of spokes and rim [m]; 30 mm in the plane is a choice (the paper has "a dedicated set
    of beams"), which puts the suspension modes at 2.53."""
    disk_rings: RingRows = ()
    """More rings within the disk, rows of { radius = "25 mm", thickness = "20 mm" }; they cut the
    spokes."""
    web_radial: Stiffness = 1e9
    """Stiffness of each spring from centre to root for disk = "rim" [N/m]."""
    web_tangential: Stiffness = 1e9
    """The same spring across the radius [N/m]."""
    tip_mass: Mass = 0.0
    """Point mass at each tip [kg]."""
    point_masses: MassRows = ()
    """More point masses, rows of { radius = "0.4 m", mass = "50 g" }, on all blades or with blades
    = [0, 7] on some; with inertia = "2 kg cm2"; radius = 0 is the centre."""
    mistuning: Mistuning = Mistuning()
    """Mistuning: factors on stiffness, mass and length as lists with one entry per blade, or the
    standard deviation of random factors about 1, with a seed. A longer blade has a smaller
    clearance."""

    mesh: MeshTable | None = Field(
        default=None,
        examples=[
            '{ file = "a.msh", unit = "mm", sections.blades = { width = 0.1, thickness = 0.01 } }'
        ],
    )
    """A mesh file instead, left out here: its unit of length, its groups of nodes that are the tips
    and the centre (tips = "tips", centre = "centre"), sections of its groups of lines; all other
    keys of [bladed_disk] are then left out."""

    @property
    def cut_radii(self) -> list[float]:
        """Radii between root and tip at which a blade needs a node, ascending [m]."""
        radii = {shroud.radius for shroud in self.shrouds}
        radii |= {mass.radius for mass in self.point_masses}
        return sorted(r for r in radii if self.disk_radius < r < self.tip_radius)

    @model_serializer(mode="wrap")
    def _without_keys_of_no_meaning(
        self, serialize: SerializerFunctionWrapHandler
    ) -> dict[str, Any]:
        """Leave out the other keys if a mesh replaces them."""
        tables: dict[str, Any] = serialize(self)
        return tables if self.mesh is None else {"mesh": tables["mesh"]}

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield errors for blades without length, parts at wrong radii and too many elements."""
        if self.mesh is not None:
            for name, field in type(self).model_fields.items():
                if name != "mesh" and getattr(self, name) != field.default:
                    yield Inconsistency(name, "no such key beside bladed_disk.mesh", ("mesh",))
            return
        if self.disk_radius >= self.tip_radius:
            expected = f"less than bladed_disk.tip_radius = {self.tip_radius!r}"
            yield Inconsistency("disk_radius", expected, ("tip_radius",))
            return
        sector = self.elements_per_blade + sum(shroud.elements for shroud in self.shrouds)
        if self.blades * sector > MOST:
            expected = f"at most {MOST} elements on bladed_disk.blades = {self.blades} blades"
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
                expected = f"blades from 0 to {self.blades - 1}, each once"
                yield Inconsistency(key, expected, ("blades",))
        yield from self.mistuning.faults(self.blades)

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
                yield Inconsistency(
                    "shrouds", "at most one shroud at each radius between two blades", ()
                )
        if not all(mass.radius == 0.0 or root <= mass.radius <= tip for mass in self.point_masses):
            expected = f"radii of 0 or from disk_radius = {root!r} to tip_radius = {tip!r}"
            yield Inconsistency("point_masses", expected, ("disk_radius", "tip_radius"))
        if any(mass.radius == 0.0 and mass.blades is not None for mass in self.point_masses):
            yield Inconsistency(
                "point_masses", "no list of blades for a mass at radius = 0, the centre", ()
            )
        radii = [ring.radius for ring in self.disk_rings]
        if not all(radius < root for radius in radii) or len(set(radii)) < len(radii):
            expected = f"different radii below bladed_disk.disk_radius = {root!r}"
            yield Inconsistency("disk_rings", expected, ("disk_radius",))
        hub = sum(mass.mass for mass in self.point_masses if mass.radius == 0.0)
        if self.disk_kind == "rim" and not hub > 0.0:
            expected = (
                'a mass at radius = 0: with bladed_disk.disk_kind = "rim" the centre has none'
            )
            yield Inconsistency("point_masses", expected, ("disk_kind",))
        if radii and not self.disk_kind.startswith("spokes"):
            expected = 'no rings, or a bladed_disk.disk_kind with spokes, such as "spokes-and-rim"'
            yield Inconsistency("disk_rings", expected, ("disk_kind",))

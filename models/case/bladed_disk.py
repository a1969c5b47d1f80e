"""The `[bladed_disk]` table of a case."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise
from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from bladewhirl.models.case.disk_parts import (
    CentreRows,
    MassRows,
    Mistuning,
    RingRows,
    ShroudRows,
    TaperRows,
)
from bladewhirl.models.case.mesh_file import MeshTable
from bladewhirl.models.inputs.fields import MOST, Length, Mass, Stiffness, count
from bladewhirl.models.inputs.table import Inconsistency, Table
from bladewhirl.models.sections.materials import BeamSection


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
        """Leave the other keys unwritten where a mesh replaces them."""
        tables: dict[str, Any] = serialize(self)
        return tables if self.mesh is None else {"mesh": tables["mesh"]}

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield blades without length, parts outside the geometry and too many nodes."""
        if self.mesh is not None:
            for name, field in type(self).model_fields.items():
                if name != "mesh" and getattr(self, name) != field.default:
                    yield Inconsistency(name, "to be left out beside bladed_disk.mesh", ("mesh",))
            return
        if self.disk_radius >= self.tip_radius:
            expected = f"less than bladed_disk.tip_radius = {self.tip_radius!r}"
            yield Inconsistency("disk_radius", expected, ("tip_radius",))
            return
        sector = self.elements_per_blade + sum(shroud.elements for shroud in self.shrouds)
        if self.blades * sector > MOST:
            expected = f"at most {MOST} elements on bladed_disk.blades = {self.blades} blades"
            if self.shrouds:
                expected += f", those of shrouds counted: {self.blades * sector}"
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
                yield Inconsistency("shrouds", "one shroud at a radius between two blades", ())
        if not all(mass.radius == 0.0 or root <= mass.radius <= tip for mass in self.point_masses):
            expected = f"radii of 0 or from disk_radius = {root!r} to tip_radius = {tip!r}"
            yield Inconsistency("point_masses", expected, ("disk_radius", "tip_radius"))
        if any(mass.radius == 0.0 and mass.blades is not None for mass in self.point_masses):
            yield Inconsistency(
                "point_masses", "no blades for a mass at radius = 0, the centre", ()
            )
        radii = [ring.radius for ring in self.disk_rings]
        if not all(radius < root for radius in radii) or len(set(radii)) < len(radii):
            expected = f"different radii below bladed_disk.disk_radius = {root!r}"
            yield Inconsistency("disk_rings", expected, ("disk_radius",))
        hub = sum(mass.mass for mass in self.point_masses if mass.radius == 0.0)
        if self.disk_kind == "rim" and not hub > 0.0:
            expected = 'a mass at radius = 0, which bladed_disk.disk_kind = "rim" does not give'
            yield Inconsistency("point_masses", expected, ("disk_kind",))
        if radii and not self.disk_kind.startswith("spokes"):
            expected = 'none, or a bladed_disk.disk_kind with spokes, such as "spokes-and-rim"'
            yield Inconsistency("disk_rings", expected, ("disk_kind",))

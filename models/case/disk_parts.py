"""Parts of the `[bladed_disk]` table: stations, shrouds, rings, masses, mistuning."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

import numpy as np
from pydantic import StrictStr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.fields import (
    Angle,
    Inertia,
    Length,
    LengthOrZero,
    Mass,
    NumberOrZero,
    count,
    number,
    rows,
)
from bladewhirl.models.inputs.table import Inconsistency, Table
from bladewhirl.models.sections.materials import BeamSection

MOST_SPREAD = 0.2
"""Largest standard deviation of a random factor; more would soon make one that is not positive."""

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
        """Factors on stiffness, mass or length, (blades,): as listed, drawn, or all one."""
        listed = getattr(self, name)
        if listed:
            return np.array(listed)
        stream = ("stiffness", "mass", "length").index(name)
        drawn = np.random.default_rng([self.seed, stream]).standard_normal(blades)
        return np.asarray(1.0 + getattr(self, f"{name}_spread") * drawn)

    def faults(self, blades: int) -> Iterator[Inconsistency]:
        """Yield lists of the wrong length and spreads that are too large or given beside lists."""
        for name in ("stiffness", "mass", "length"):
            listed, spread = getattr(self, name), getattr(self, f"{name}_spread")
            key = f"mistuning.{name}"
            if listed and len(listed) != blades:
                expected = f"{blades} factors, one a blade, not {len(listed)}"
                yield Inconsistency(key, expected, ("blades",))
            if listed and spread:
                expected = f"either factors or bladed_disk.mistuning.{name}_spread"
                yield Inconsistency(key, expected, (f"mistuning.{name}_spread",))
            elif spread > MOST_SPREAD or not np.all(self.factors(name, blades) > 0.0):
                yield Inconsistency(f"{key}_spread", f"at most {MOST_SPREAD:g}", ())


TaperRows = Annotated[tuple[TaperStation, ...], rows('{ thickness = "12 mm" }')]
CentreRows = Annotated[tuple[CentrePoint, ...], rows('{ span = 1.0, angle = "10 deg" }')]
ShroudRows = Annotated[tuple[Shroud, ...], rows('{ radius = "0.4 m", thickness = "5 mm" }')]
RingRows = Annotated[tuple[DiskRing, ...], rows('{ radius = "25 mm", thickness = "20 mm" }')]
MassRows = Annotated[tuple[PointMass, ...], rows('{ radius = "0.4 m", mass = "50 g" }')]

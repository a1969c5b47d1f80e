"""Rectangular beam sections and the stiffnesses they give along a mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes import LineMesh
from bladewhirl.meshes.line_mesh import FloatArray


@dataclass(frozen=True, kw_only=True)
class Section:
    """A rectangular section of one material.

    Raises:
        ValueError: a size or a material constant is not positive.
    """

    width: float  #: size out of the plane [m]
    thickness: float  #: size in the plane of motion [m]
    young_modulus: float  #: [Pa]
    density: float  #: [kg/m3]

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value > 0.0:
                raise ValueError(f"section {name} must be positive; got {value}")

    @property
    def axial_stiffness(self) -> float:
        """E A [N]."""
        return self.young_modulus * self.width * self.thickness

    @property
    def bending_stiffness(self) -> float:
        """E I for bending in the plane [N m2]."""
        return self.young_modulus * self.width * self.thickness**3 / 12.0

    @property
    def line_mass(self) -> float:
        """Mass per unit length [kg/m]."""
        return self.density * self.width * self.thickness


@dataclass(frozen=True, kw_only=True)
class LineProperties:
    """What each line of a mesh is made of."""

    axial_stiffness: FloatArray  #: E A [N], (lines,)
    bending_stiffness: FloatArray  #: E I [N m2], (lines,)
    line_mass: FloatArray  #: rho A [kg/m], (lines,)
    thickness: FloatArray  #: in the plane [m], (lines,)
    width: FloatArray  #: out of the plane [m], (lines,)
    young_modulus: FloatArray  #: [Pa], (lines,)


def line_properties(mesh: LineMesh, sections: Mapping[str, Section]) -> LineProperties:
    """Spread sections, given by line set, over the lines of a mesh.

    Raises:
        ValueError: a line has no section, or a section names a set the mesh does not have.
    """
    unknown = sorted(set(sections) - set(mesh.line_sets))
    if unknown:
        raise ValueError(
            f"section for unknown line set {unknown[0]!r}; mesh has {[*mesh.line_sets]}"
        )
    table = np.full((6, len(mesh.lines)), np.nan)
    for name, section in sections.items():
        table[:, mesh.line_sets[name]] = np.array(
            [
                section.axial_stiffness,
                section.bending_stiffness,
                section.line_mass,
                section.thickness,
                section.width,
                section.young_modulus,
            ]
        )[:, None]
    bare = np.flatnonzero(np.isnan(table[0]))
    if bare.size:
        raise ValueError(f"line {bare[0]} (of set {mesh.line_parts[bare[0]]!r}) has no section")
    return LineProperties(
        axial_stiffness=table[0],
        bending_stiffness=table[1],
        line_mass=table[2],
        thickness=table[3],
        width=table[4],
        young_modulus=table[5],
    )

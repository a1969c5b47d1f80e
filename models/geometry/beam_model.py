"""A bladed disk as it is described, before any matrix: beams, masses, springs, rigid links.

A `Sketch` builds one; so may anything else that has a mesh, its sections and its named sets.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray, LineMesh
from bladewhirl.models.sections.rectangular import LineProperties

GROUND = -1
"""Other end of a spring that leads to the rotating frame itself."""

ROUNDING = 1e-13
"""Relative differences of lengths below this are rounding errors."""


def _ints(values: Any = ()) -> IntArray:
    return np.asarray(values, dtype=np.int64)


def _floats(*shape: int) -> FloatArray:
    return np.zeros(shape)


@dataclass(frozen=True, kw_only=True)
class PointMasses:
    """Masses at nodes."""

    node: IntArray = field(default_factory=_ints)  #: (masses,)
    mass: FloatArray = field(default_factory=lambda: _floats(0))  #: [kg], (masses,)
    inertia: FloatArray = field(default_factory=lambda: _floats(0))  #: rotary [kg m2], (masses,)


@dataclass(frozen=True, kw_only=True)
class NodeSprings:
    """Springs between nodes, or between a node and the rotating frame.

    They act on the difference of the displacements of both ends along the displacement axes of
    the first (radial and tangential there, x and y at the origin), and on that of the rotations.
    """

    node: IntArray = field(default_factory=_ints)  #: first end, (springs,)
    other: IntArray = field(default_factory=_ints)  #: second end or `GROUND`, (springs,)
    stiffness: FloatArray = field(default_factory=lambda: _floats(0, 3))
    """Along both axes [N/m] and against rotation [N m], (springs, 3)."""


@dataclass(frozen=True, kw_only=True)
class RigidLinks:
    """Nodes that another node leads as if on a rigid arm; a leader is not tied itself."""

    led: IntArray = field(default_factory=_ints)  #: (links,)
    leader: IntArray = field(default_factory=_ints)  #: (links,)


@dataclass(frozen=True, kw_only=True)
class BeamModel:
    """A bladed disk: a mesh of straight Bernoulli beams and what hangs on its nodes.

    The mesh has the node sets ``tips`` (in blade order) and ``centre`` (one node, at the origin).
    """

    mesh: LineMesh
    properties: LineProperties
    masses: PointMasses = field(default_factory=PointMasses)
    springs: NodeSprings = field(default_factory=NodeSprings)
    links: RigidLinks = field(default_factory=RigidLinks)
    tip_radius: float  #: that the clearance counts from; a tip may be shorter or longer [m]

    def __repr__(self) -> str:
        """Its size and mass, in one line."""
        mesh = self.mesh
        return (
            f"<BeamModel: {len(mesh.points)} nodes, {len(mesh.lines)} lines, {len(self.tips)} tips,"
            f" {self.mass:.4g} kg>"
        )

    @property
    def tips(self) -> IntArray:
        """Node of each blade tip, (blades,)."""
        return self.mesh.node_sets["tips"]

    @property
    def joints(self) -> IntArray:
        """Pairs of nodes that lines, springs or rigid links join, (joints, 2)."""
        springs = np.column_stack([self.springs.node, self.springs.other])
        links = np.column_stack([self.links.led, self.links.leader])
        return np.vstack([self.mesh.lines, springs[self.springs.other != GROUND], links])

    @property
    def centre(self) -> int:
        """The node that the shaft carries."""
        return int(self.mesh.node_sets["centre"][0])

    @property
    def tip_recess(self) -> FloatArray:
        """Distance of each tip inward from `tip_radius` [m], (blades,)."""
        radii = np.linalg.norm(self.mesh.points[self.tips], axis=1)
        recess = self.tip_radius - radii
        return np.where(np.abs(recess) <= ROUNDING * self.tip_radius, 0.0, recess)

    @property
    def blade_length(self) -> float:
        """Mean length of a blade's beams [m]; the tip radius where no lines are called blades."""
        blade_lines = self.mesh.line_sets.get("blades", _ints())
        length = float(self.mesh.lengths[blade_lines].sum()) / len(self.tips)
        return length or self.tip_radius

    @property
    def mass(self) -> float:
        """Mass of all parts [kg]."""
        return sum(self.part_masses.values())

    @property
    def part_masses(self) -> dict[str, float]:
        """Mass of the beams of each part and of the point masses, if any [kg]."""
        line_mass = self.properties.mean_line_mass * self.mesh.lengths
        parts = np.array(self.mesh.line_parts)
        masses = {str(name): float(line_mass[parts == name].sum()) for name in dict.fromkeys(parts)}
        hung = float(self.masses.mass.sum())
        return masses | ({"point masses": hung} if hung else {})

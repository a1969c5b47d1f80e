"""Beam model of a bladed disk, before matrices are assembled: beams, masses, springs, rigid links.

A beam model is made from the standard disk, a `Sketch` or a mesh file. All three are checked for
unconnected parts and unusable sets.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from bladewhirl.meshes.line_mesh import FloatArray, IntArray, LineMesh
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.sections.rectangular import LineProperties

GROUND = -1  #: number in place of the second node of a spring that ends at the rotating frame

ROUNDING = 1e-13  #: relative difference below which two lengths count as equal

AT_ORIGIN = 1e-9  #: largest allowed distance of the centre from the origin, in tip radii

OUTSIDE = 1e-9
"""A node counts as inside a radius if it exceeds the radius by at most this fraction."""


@dataclass(frozen=True, kw_only=True)
class PointMasses:
    """Masses at nodes."""

    node: IntArray  #: node of each mass, (masses,)
    mass: FloatArray  #: mass [kg], (masses,)
    inertia: FloatArray  #: rotary inertia [kg m2], (masses,)


@dataclass(frozen=True, kw_only=True)
class NodeSprings:
    """Springs between nodes, or between a node and the rotating frame.

    Springs act on the relative displacement of both ends, along the axes of the first end (radial
    and tangential, or x and y at the origin), and on the relative rotation.
    """

    node: IntArray  #: first end, (springs,)
    other: IntArray  #: second end or `GROUND`, (springs,)
    stiffness: FloatArray
    """Stiffness along both axes [N/m] and against rotation [N m], (springs, 3)."""


@dataclass(frozen=True, kw_only=True)
class RigidLinks:
    """Rigid links: a rigid arm connects each led node to its leader; leaders are not led nodes."""

    led: IntArray  #: led nodes, (links,)
    leader: IntArray  #: leader of each led node, (links,)


@dataclass(frozen=True, kw_only=True)
class BeamModel:
    """A bladed disk: a mesh of straight Bernoulli beams, with masses, springs and links at nodes.

    The mesh has the node sets ``tips`` (in blade order) and ``centre`` (one node, at the origin).
    """

    mesh: LineMesh
    properties: LineProperties
    masses: PointMasses
    springs: NodeSprings
    links: RigidLinks
    tip_radius: float
    """Radius from which the clearance is measured [m]; tips can have other radii."""

    def __repr__(self) -> str:
        """Return the size and the mass in one line."""
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
        """Pairs of nodes connected by lines, springs or rigid links, (joints, 2)."""
        springs = np.column_stack([self.springs.node, self.springs.other])
        links = np.column_stack([self.links.led, self.links.leader])
        return np.vstack([self.mesh.lines, springs[self.springs.other != GROUND], links])

    @property
    def centre(self) -> int:
        """Centre node, which is on the shaft."""
        return int(self.mesh.node_sets["centre"][0])

    @property
    def tip_recess(self) -> FloatArray:
        """`tip_radius` minus the radius of each tip [m], (blades,)."""
        radii = np.linalg.norm(self.mesh.points[self.tips], axis=1)
        recess = self.tip_radius - radii
        return np.where(np.abs(recess) <= ROUNDING * self.tip_radius, 0.0, recess)

    @property
    def blade_length(self) -> float:
        """Mean total length of the beams of a blade [m]; the tip radius if there is no line set
        ``blades``."""
        blade_lines = self.mesh.line_sets.get("blades", np.zeros(0, np.int64))
        length = float(self.mesh.lengths[blade_lines].sum()) / len(self.tips)
        return length or self.tip_radius

    @property
    def mass(self) -> float:
        """Mass of all parts [kg]."""
        return sum(self.part_masses.values())

    @property
    def part_masses(self) -> dict[str, float]:
        """Mass of the beams of each part, by its name, and of all point masses if there are any
        [kg]."""
        line_mass = self.properties.mean_line_mass * self.mesh.lengths
        parts = np.array(self.mesh.line_parts)
        masses = {str(name): float(line_mass[parts == name].sum()) for name in dict.fromkeys(parts)}
        hung = float(self.masses.mass.sum())
        return masses | ({"point masses": hung} if hung else {})


def check_model(model: BeamModel, key: str) -> None:
    """Check that a beam model is a valid bladed disk.

    Args:
        model: beam model to check.
        key: key of the case from which the model was made, for messages.

    Raises:
        CaseError: the model is invalid; the error lists all faults with the names of the parts.
    """
    faults = [*_sets(model), *_links(model), *_massless(model), *_doubled(model)]
    faults = faults or [*_loose_parts(model)]
    if faults:
        raise CaseError(Fault(key=key, expected=expected) for expected in faults)


def _sets(model: BeamModel) -> Iterator[str]:
    """Yield faults of the sets as texts that complete "expected ..."."""
    sets = model.mesh.node_sets
    if len(sets["centre"]) != 1:
        yield f'one node in the set "centre", not {len(sets["centre"])}'
        return
    if np.linalg.norm(model.mesh.points[model.centre]) > AT_ORIGIN * model.tip_radius:
        x, y = model.mesh.points[model.centre]
        yield f"the centre at the origin, not at ({x:.6g}, {y:.6g}) m"
    tips = model.mesh.points[model.tips]
    angles = np.arctan2(tips[:, 1], tips[:, 0])
    steps = np.mod(np.diff(angles, append=angles[0]), 2.0 * np.pi)
    if model.centre in model.tips:
        yield 'a centre that is not in the set "tips"'
    elif len(tips) > 1 and not (np.all(steps > 0.0) and abs(steps.sum() - 2.0 * np.pi) < 1e-6):
        yield 'the set "tips" in counter-clockwise order, each tip at a different angle'


def _links(model: BeamModel) -> Iterator[str]:
    led = model.links.led
    for node in np.flatnonzero(np.bincount(led, minlength=1) > 1):
        yield f"one leader for {_node(model, int(node))}, not several leaders"
    for node in np.intersect1d(led, model.links.leader):
        yield f"a leader that is not led by another node; {_node(model, int(node))} is led"
    for name in ("tips", "centre"):
        for node in np.intersect1d(led, model.mesh.node_sets[name])[:1]:
            yield f'a set "{name}" of nodes that are not tied; {_node(model, int(node))} is tied'


def _massless(model: BeamModel) -> Iterator[str]:
    """Yield nodes that are connected by springs only and have no mass or no inertia."""
    count = len(model.mesh.points)
    bare = np.ones(count, dtype=np.bool_)
    bare[model.mesh.lines] = bare[model.links.led] = False
    bare[model.links.leader] = False
    mass, inertia = np.zeros(count), np.zeros(count)
    np.add.at(mass, model.masses.node, model.masses.mass)
    np.add.at(inertia, model.masses.node, model.masses.inertia)
    inertia[model.mesh.node_sets["centre"]] = np.inf  # the centre does not rotate
    for node in np.flatnonzero(bare & ((mass <= 0.0) | (inertia <= 0.0))):
        yield f"a beam, or a mass with rotary inertia, at {_node(model, int(node))}"


def _doubled(model: BeamModel) -> Iterator[str]:
    """Yield overlapping lines, whose mass would count twice."""
    parts = np.array(model.mesh.line_parts)
    ends = np.sort(model.mesh.lines, axis=1)
    _, first, number = np.unique(ends, axis=0, return_index=True, return_inverse=True)
    again = np.flatnonzero(first[number.ravel()] != np.arange(len(ends)))
    if again.size:
        line = again[0]
        names = dict.fromkeys([str(parts[first[number.ravel()[line]]]), str(parts[line])])
        between = " and ".join(_node(model, int(node)) for node in ends[line])
        coincide = " and ".join(map(repr, names))
        yield f"one beam between two nodes; {coincide} coincide between {between}"


def _loose_parts(model: BeamModel) -> Iterator[str]:
    """Yield the first part that is not connected to the centre by beams, springs or links."""
    joints, count = model.joints, len(model.mesh.points)
    graph = sp.csr_array((np.ones(len(joints)), (joints[:, 0], joints[:, 1])), shape=(count, count))
    _, group = connected_components(graph, directed=False)
    loose = np.flatnonzero(group != group[model.centre])
    if loose.size:
        yield f"all parts joined to the centre; {_part(model, int(loose[0]))} is not joined"


def part_outside(model: BeamModel, radius: float) -> str | None:
    """Describe the part that extends farthest beyond a radius [m]; None if all are inside."""
    away = np.linalg.norm(model.mesh.points, axis=1)
    node = int(away.argmax())
    if away[node] <= radius * (1.0 + OUTSIDE):
        return None
    return f"{_part(model, node)} is outside by {away[node] - radius:.3g} m"


def _part(model: BeamModel, node: int) -> str:
    """Return as text the part to which a node belongs (the node if its part has no name), and the
    position of the node."""
    lines = np.flatnonzero((model.mesh.lines == node).any(axis=1))
    names = [model.mesh.line_parts[line] for line in lines if model.mesh.line_parts[line]]
    return f"part {names[0]!r} at {_at(model, node)}" if names else _node(model, node)


def _node(model: BeamModel, node: int) -> str:
    names = [name for name, nodes in model.mesh.node_sets.items() if node in nodes]
    called = f" of {names[0]!r}" if names else ""
    return f"node {node}{called} at {_at(model, node)}"


def _at(model: BeamModel, node: int) -> str:
    x, y = model.mesh.points[node]
    return f"({x:.4g}, {y:.4g}) m"

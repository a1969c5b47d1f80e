"""Parts of a sketch, as `Sketch` collects them and case files contain them.

Nodes are named within a sector: "root" is the node in the sector of the part that refers to it,
"root+1" and "root-1" are the nodes in the next and the previous sector. A shared node, such as the
centre, is a single node for all sectors.
"""

import re
from typing import Annotated

from pydantic import BeforeValidator, StrictBool, StrictStr

from bladewhirl.models.inputs.fields import (
    Inertia,
    Mass,
    Position,
    StiffnessOrZero,
    count,
    expectation,
    number,
    quantity,
)
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.sections.rectangular import Section

_REFERENCE = re.compile(r"(?P<name>[A-Za-z_][\w ]*)(?P<shift>[+-]\d{1,6})?", re.ASCII)


def _name(value: object) -> str:
    if not isinstance(value, str) or not re.fullmatch(r"[A-Za-z_][\w ]*", value, re.ASCII):
        raise expectation('a name of letters, digits, spaces and underscores such as "blade root"')
    return value


def _reference(value: object) -> str:
    if not isinstance(value, str) or not _REFERENCE.fullmatch(value):
        raise expectation('the name of a node, such as "root", or "root+1" in the next sector')
    return value


def split_reference(reference: str) -> tuple[str, int]:
    """Split a reference into the name of the node and the offset of its sector."""
    match = _REFERENCE.fullmatch(reference)
    assert match is not None  # references are validated
    return match["name"], int(match["shift"] or 0)


Chosen = tuple[int, ...] | None
"""Sectors that have a part; None for all."""

Name = Annotated[str, BeforeValidator(_name)]
Reference = Annotated[str, BeforeValidator(_reference)]
Factor = Annotated[float, number("positive")]


class SketchNode(Table):
    """A node."""

    name: Name
    at: Position  #: x and y in sector 0 [m]
    shared: StrictBool = False  #: one node for all sectors


class SketchMember(Table):
    """Beams along a straight or curved centre line between two nodes."""

    name: Name
    first: Reference
    second: Reference
    section: Section | None = None  #: section along the entire member
    stations: tuple[Section, ...] = ()  #: sections at equal distances, in place of `section`
    elements: Annotated[int, count(1)] = 1
    path: tuple[Position, ...] = ()  #: points in between, in sector 0 [m]
    part: Name | None = None  #: name of its line set; the name of the member if None
    sectors: Chosen = None

    @property
    def references(self) -> tuple[str, ...]:
        """Nodes at both ends."""
        return self.first, self.second

    @property
    def line_set(self) -> str:
        """Name of the line set that its elements belong to."""
        return self.part or self.name


class SketchMass(Table):
    """A point mass."""

    node: Reference
    mass: Mass  #: mass [kg]
    inertia: Inertia = 0.0  #: rotary [kg m2]
    sectors: Chosen = None

    @property
    def references(self) -> tuple[str, ...]:
        """Node of the mass."""
        return (self.node,)


class SketchSpring(Table):
    """A spring between two nodes, or between a node and the rotating frame."""

    node: Reference
    other: Reference | None = None  #: second node; None is the rotating frame
    radial: StiffnessOrZero = 0.0  #: along the first node's radius; along x at the origin [N/m]
    tangential: StiffnessOrZero = 0.0  #: across this radius; along y at the origin [N/m]
    rotation: Annotated[float, quantity("N m", "not negative")] = 0.0  #: against rotation [N m/rad]
    sectors: Chosen = None

    @property
    def references(self) -> tuple[str, ...]:
        """Nodes at both ends; only one node if the other end is the rotating frame."""
        return (self.node,) if self.other is None else (self.node, self.other)


class SketchLink(Table):
    """A rigid link: the led node moves as if a rigid arm connected it to the leader."""

    leader: Reference
    led: Reference
    sectors: Chosen = None

    @property
    def references(self) -> tuple[str, ...]:
        """Nodes at both ends."""
        return self.leader, self.led


class SketchEdit(Table):
    """Change in one sector only: the position of a node, or the properties of a member."""

    sector: Annotated[int, count(0)]
    node: Name | None = None  #: node to move
    at: Position | None = None  #: new position, in the coordinates of sector 0 [m]
    member: Name | None = None  #: member to change
    stiffness: Factor = 1.0  #: factor on Young's modulus of the member
    mass: Factor = 1.0  #: factor on the density of the member
    section: Section | None = None
    stations: tuple[Section, ...] = ()
    path: tuple[Position, ...] | None = None


class SketchSet(Table):
    """A named set that contains the listed nodes of every sector."""

    name: StrictStr
    nodes: tuple[Reference, ...]

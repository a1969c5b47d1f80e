"""Contents of input of Abaqus and CalculiX, before they become a mesh of lines or of solids."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sized
from copy import copy
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np

from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.line_mesh import IntArray

MOST_MEMBERS = 5_000_000
"""Largest number of members of all sets, couplings and instances; decks of a few lines can have
any number of them."""

Sets = dict[str, dict[int, bool]]
"""Members of each set in their order; true for those that are listed by their numbers."""


@dataclass
class AbaqusMesh:
    """Contents of a file or a part, with the numbers that nodes and elements have in the file.

    Names of sets are not case-sensitive; the spelling of their first occurrence is used.
    """

    points: dict[int, list[float]] = field(default_factory=dict)  #: node -> x, y, z
    elements: dict[int, list[int]] = field(default_factory=dict)  #: element -> nodes
    types: dict[int, str] = field(default_factory=dict)  #: element -> type, in capitals
    node_sets: Sets = field(default_factory=dict)
    element_sets: Sets = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)  #: name in capitals -> name
    solid_sections: list[tuple[str, str]] = field(default_factory=list)  #: set and material
    sectioned: set[str] = field(default_factory=set)  #: sets with a section
    sections: list[tuple[str, str, float, float]] = field(default_factory=list)
    """Set, material, width and thickness of each rectangular section."""
    materials: dict[str, dict[str, float]] = field(default_factory=dict)
    unread: dict[str, str] = field(default_factory=dict)  #: material -> keyword that is not read
    masses: list[tuple[str, str, float]] = field(default_factory=list)  #: type of data, set, value
    material: str = ""  #: name of the material that is being read
    couplings: list[tuple[str, list[int], list[int]]] = field(default_factory=list)
    """Keyword, reference node and nodes of each coupling whose nodes move as a rigid body."""
    distributed: list[list[int]] = field(default_factory=list)
    """Reference nodes of each coupling whose nodes move independently."""
    turns: dict[int, list[int]] = field(default_factory=dict)
    """Reference node -> nodes whose displacements are its rotations, as in CalculiX."""
    others: Counter[str] = field(default_factory=Counter)
    """Other keywords that change the motion, and how often they are there."""
    held: dict[int, set[int]] = field(default_factory=dict)
    """Node -> displacements (1 to 3) and rotations (4 to 6) that are held."""
    earlier: dict[int, set[int]] = field(default_factory=dict)
    """Node -> displacements and rotations that were held before OP=NEW."""
    step: int = 0  #: number of the step that is being read
    renewed: int = 0  #: number of the last step with OP=NEW
    built: set[int] = field(default_factory=set)  #: elements with a section of any kind
    instances: dict[str, tuple[dict[int, int], dict[int, int]]] = field(default_factory=dict)
    """Instance in capitals -> numbers of its nodes and elements by their numbers in the part."""
    counted: list[int] = field(default_factory=lambda: [0])
    """Number of members so far, shared by the parts of a file, see `MOST_MEMBERS`."""

    def count(self, members: int) -> None:
        """Count members before they are made; too many are an error."""
        self.counted[0] += members
        if self.counted[0] > MOST_MEMBERS:
            raise MeshFileError(f"at most {MOST_MEMBERS} members of all sets and instances")

    def part(self) -> "AbaqusMesh":
        """Return an empty part of the file, which shares materials and numbers of members."""
        return AbaqusMesh(materials=self.materials, unread=self.unread, counted=self.counted)

    def instance(self) -> "AbaqusMesh":
        """Return a copy of a part, whose contents can be extended."""
        shared = ("materials", "unread", "counted")
        own: dict[str, Any] = {k: copy(v) for k, v in vars(self).items() if k not in shared}
        for kind in ("node_sets", "element_sets"):
            own[kind] = {name: {**members} for name, members in own[kind].items()}
            self.count(sum(map(len, own[kind].values())))
        self.count(sum(len(each) for each in own.values() if isinstance(each, Sized)))
        return replace(self, **own)

    def extend(
        self, sets: Sets, name: str | None, members: Iterable[int], *, listed: bool = False
    ) -> None:
        """Add members to a set of this mesh without repetition; without a name, do nothing."""
        if name is not None:
            own = sets.setdefault(name, {})
            for member in members:
                own.setdefault(member, listed)

    def check_sets(self) -> None:
        """Check that members that are listed by their numbers exist, ranges may have gaps, and
        reference nodes."""
        references = [(keyword, reference) for keyword, reference, _ in self.couplings]
        references += [("*DISTRIBUTING", reference) for reference in self.distributed]
        for keyword, reference in references:
            if lost := [n for n in reference if n not in self.points]:
                raise MeshFileError(f"a reference node that is defined; {keyword} has {lost[0]}")
        nodes, elements = self.node_sets.items(), self.element_sets.items()
        for kind, known, sets in (
            ("node", self.points, nodes),
            ("element", self.elements, elements),
        ):
            for name, members in sets:
                if lost := [n for n, listed in members.items() if listed and n not in known]:
                    text = f"{kind}s of the mesh in set {name}; {kind} {lost[0]} is not defined"
                    raise MeshFileError(text)

    def held_nodes(self) -> tuple[list[int], list[str]]:
        """Return the nodes that are held along x, y and z, also as parts of rigid bodies, and notes
        on those that are held in part."""
        whole = {node for node, axes in self.held.items() if {1, 2, 3} <= axes}
        partly, notes = self.held.keys() - whole, Counter[str]()
        for keyword, reference, nodes in self.couplings:
            axes = set[int]().union(*(self.held.get(node, ()) for node in reference))
            if any(whole.issuperset(self.turns.get(node, [-1])) for node in reference):
                axes |= {4, 5, 6}
            if axes >= {1, 2, 3, 4, 5, 6}:
                whole.update(nodes)
            elif axes and not whole.issuperset(nodes):
                notes[f"{keyword} with a reference node that is held in part"] += 1
            partly -= {*reference}
        notes["*DISTRIBUTING with a reference node that is held"] += sum(
            not self.held.keys().isdisjoint(reference) for reference in self.distributed
        )
        freed = sum(not axes <= self.held.get(node, set()) for node, axes in self.earlier.items())
        notes["*BOUNDARY, OP=NEW, which frees nodes held before it"] += bool(freed)
        single = sum(bool({1, 2, 3} & self.held[node]) for node in partly)
        listed = [f"{count} {note}" for note, count in notes.items() if count]
        if single:
            listed.append(f"*BOUNDARY of single displacements of {single} nodes")
        return [node for node in whole if node in self.points], listed

    def nodes_of(self, elements: Iterable[int]) -> list[int]:
        """Return the nodes of elements, each once; elements that are not defined are skipped."""
        return [*dict.fromkeys(chain.from_iterable(self.elements.get(n, []) for n in elements))]

    def groups(self) -> dict[str, list[int]]:
        """Return the nodes of each set of nodes and of each set of elements. To a reference node
        belong the nodes that are coupled to it."""
        groups = {name: list(nodes) for name, nodes in self.node_sets.items()}
        for name, elements in self.element_sets.items():
            groups[name] = [*groups.get(name, []), *self.nodes_of(elements)]
        leaders = {node for _, reference, _ in self.couplings for node in reference}
        names = defaultdict[int, set[str]](set)
        for name, members in groups.items():
            for node in leaders.intersection(members):
                names[node].add(name)
        for _, reference, nodes in self.couplings:
            for name in set[str]().union(*(names[node] for node in reference)):
                self.count(len(nodes))
                groups[name] += nodes
                for node in leaders.intersection(nodes):
                    names[node].add(name)
        return groups


def by_place(sets: Mapping[str, Iterable[int]], place: Mapping[int, int]) -> dict[str, IntArray]:
    """Return sets with the place of each member; members without a place are left out."""
    return {
        name: np.array([place[n] for n in members if n in place], dtype=np.int64)
        for name, members in sets.items()
    }

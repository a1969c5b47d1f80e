"""Contents of input of Abaqus and CalculiX, before they become a mesh of lines or of solids."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import chain

import numpy as np

from bladewhirl.meshes.line_mesh import IntArray


@dataclass
class AbaqusMesh:
    """Contents of a file or a part, with the numbers that nodes and elements have in the file.

    Names of sets are not case-sensitive; the spelling of their first occurrence is used.
    """

    points: dict[int, list[float]] = field(default_factory=dict)  #: node -> x, y, z
    elements: dict[int, list[int]] = field(default_factory=dict)  #: element -> nodes
    types: dict[int, str] = field(default_factory=dict)  #: element -> type, in capitals
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)  #: name in capitals -> name
    solid_sections: list[tuple[str, str]] = field(default_factory=list)  #: set and material
    sections: list[tuple[str, str, float, float]] = field(default_factory=list)
    """Set, material, width and thickness of each rectangular section."""
    materials: dict[str, dict[str, float]] = field(default_factory=dict)
    unread: dict[str, str] = field(default_factory=dict)  #: material -> keyword that is not read
    masses: list[tuple[str, str, float]] = field(default_factory=list)  #: type of data, set, value
    material: str = ""  #: name of the material that is being read
    couplings: list[tuple[str, list[int], list[int]]] = field(default_factory=list)
    """Keyword, reference node and nodes of each coupling whose nodes move as a rigid body."""
    constraints: set[str] = field(default_factory=set)  #: other keywords that connect nodes
    instances: dict[str, tuple[dict[int, int], dict[int, int]]] = field(default_factory=dict)
    """Instance in capitals -> numbers of its nodes and elements by their numbers in the part."""

    def nodes_of(self, elements: Iterable[int]) -> list[int]:
        """Return the nodes of elements, each once; elements that are not defined are skipped."""
        return [*dict.fromkeys(chain.from_iterable(self.elements.get(n, []) for n in elements))]

    def groups(self) -> dict[str, list[int]]:
        """Return the nodes of each set of nodes and of each set of elements. To a reference node
        belong the nodes that are coupled to it."""
        groups = {name: list(members) for name, members in self.node_sets.items()}
        for name, members in self.element_sets.items():
            groups[name] = [*groups.get(name, []), *self.nodes_of(members)]
        for _, reference, nodes in self.couplings:
            for members in groups.values():
                if not set(reference).isdisjoint(members):
                    members += nodes
        return groups


def extend(sets: dict[str, list[int]], name: str | None, members: Iterable[int]) -> None:
    """Add members to a set without repetition; without a name, do nothing."""
    if name is not None:
        sets[name] = list(dict.fromkeys([*sets.get(name, []), *members]))


def by_place(sets: Mapping[str, list[int]], place: Mapping[int, int]) -> dict[str, IntArray]:
    """Return sets with the place of each member; members without a place are left out."""
    return {
        name: np.array([place[n] for n in members if n in place], dtype=np.int64)
        for name, members in sets.items()
    }

"""Sets of nodes and elements, and surfaces, in input of Abaqus and CalculiX."""

from collections import defaultdict
from collections.abc import Collection
from itertools import chain

from bladewhirl.meshes.files.abaqus_faces import surface_nodes
from bladewhirl.meshes.files.abaqus_mesh import AbaqusMesh
from bladewhirl.meshes.files.abaqus_text import Card, whole
from bladewhirl.meshes.files.groups import MeshFileError

NODES, ELEMENTS = 0, 1


def read_members(card: Card, content: AbaqusMesh, kind: int, name: str) -> None:
    """Add the members that a keyword lists as numbers, ranges or names of earlier sets to a set.

    Args:
        card: keyword.
        content: contents so far.
        kind: `NODES` or `ELEMENTS`.
        name: name of the set.
    """
    sets = (content.node_sets, content.element_sets)[kind]
    instance = card.parameters.get("INSTANCE")
    content.extend(sets, name, ())
    if "GENERATE" not in card.parameters:
        prefix = "" if instance is None else f"{instance}."
        for value in filter(None, chain.from_iterable(card.rows)):
            members = named(f"{prefix}{value}", content, kind)
            content.extend(sets, name, members, listed=isinstance(members, list))
        return
    placed = None if instance is None else content.instances[instance.upper()][kind]
    for row in card.rows:
        first, last, step = ([whole(value) for value in row if value] + [1])[:3]
        if not step or (last - first) % step or (last - first) // step < 0:
            raise MeshFileError(
                f"ranges whose step leads from the first number to the last, got {', '.join(row)}"
            )
        run = range(first, last + (1 if step > 0 else -1), step)
        content.count(len(run))
        content.extend(
            sets, name, run if placed is None else (placed[n] for n in run if n in placed)
        )


def named(value: str, content: AbaqusMesh, kind: int) -> Collection[int]:
    """Return the members of a set, or a list of the node or element with a number, perhaps after
    the name of an instance and a point."""
    sets = (content.node_sets, content.element_sets)[kind]
    if (name := content.names.get(value.upper(), value)) in sets:
        content.count(len(sets[name]))
        return sets[name]
    instance, point, number = value.rpartition(".")
    try:
        if not point:
            return [whole(number)]
        return [content.instances[instance.upper()][kind][whole(number)]]
    except (MeshFileError, KeyError):
        text = f"sets that consist of numbers and earlier sets; {value!r} is neither"
        raise MeshFileError(text) from None


def read_surface(card: Card, content: AbaqusMesh) -> None:
    """Read a surface of faces of solids as a set of nodes; faces of other elements are skipped, and
    surfaces of sets that are not defined before."""
    instance = card.parameters.get("INSTANCE")
    faces = defaultdict[str, list[int]](list)
    for row in card.rows:
        value = row[0] if instance is None else f"{instance}.{row[0]}"
        try:
            elements = named(value, content, ELEMENTS)
        except MeshFileError:
            return
        faces[row[1].upper() if len(row) > 1 else ""] += elements
    content.count(len(content.elements) if "" in faces else 0)
    nodes = [node for face, of in faces.items() for node in surface_nodes(content, of, face)]
    content.extend(content.node_sets, card.needs("NAME"), nodes)

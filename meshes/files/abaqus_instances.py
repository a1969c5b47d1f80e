"""Instances of parts in an assembly of Abaqus: their nodes, elements and sets."""

import numpy as np

from bladewhirl.meshes.files.abaqus_mesh import AbaqusMesh
from bladewhirl.meshes.files.abaqus_text import Card, real
from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.line_mesh import FloatArray

FIRST_PLACED = 10**12
"""Number of the first node and of the first element of instances, beyond those of the assembly."""


def place_instance(card: Card, part: AbaqusMesh, whole: AbaqusMesh) -> None:
    """Add an instance of a part to an assembly; its sets have the name of the instance before them.

    Args:
        card: keyword *INSTANCE, with translation and rotation.
        part: contents of the part, and of the instance itself.
        whole: assembly.
    """
    name = card.needs("NAME")
    part.check_sets()
    if name.upper() in whole.instances:
        raise MeshFileError(f"each instance once; *INSTANCE, NAME={name} is defined twice")
    nodes, elements = (
        {number: FIRST_PLACED + len(there) + n for n, number in enumerate(here)}
        for here, there in ((part.points, whole.points), (part.elements, whole.elements))
    )
    whole.instances[name.upper()] = nodes, elements
    with np.errstate(all="ignore"):  # results that are not finite are an error of the mesh
        points = _moved(np.array([*part.points.values()]).reshape(-1, 3), card)
    whole.points |= dict(zip(nodes.values(), points.tolist(), strict=True))
    for number, place in elements.items():
        whole.elements[place] = [nodes.get(node, -1) for node in part.elements[number]]
        whole.types[place] = part.types[number]
    for mine, sets, placed in (
        (part.node_sets, whole.node_sets, nodes),
        (part.element_sets, whole.element_sets, elements),
    ):
        for key, members in mine.items():
            full = f"{name}.{key}"
            whole.names.setdefault(full.upper(), full)
            whole.extend(sets, full, (placed[member] for member in members if member in placed))
    whole.solid_sections += [(f"{name}.{group}", one) for group, one in part.solid_sections]
    whole.sections += [(f"{name}.{one[0]}", *one[1:]) for one in part.sections]
    whole.masses += [(kind, f"{name}.{group}", value) for kind, group, value in part.masses]
    whole.others.update(part.others)
    whole.built |= {elements[number] for number in part.built if number in elements}
    whole.distributed += [[nodes[n] for n in reference] for reference in part.distributed]
    whole.turns |= {
        nodes[n]: [nodes[one] for one in of] for n, of in part.turns.items() if n in nodes
    }
    whole.couplings += [
        (keyword, [nodes[n] for n in reference], [nodes[n] for n in coupled if n in nodes])
        for keyword, reference, coupled in part.couplings
    ]


def name_sets(whole: AbaqusMesh) -> None:
    """Give the sets of instances the names in their parts, unless sets of the assembly have them;
    with several instances keep those with the names of the instances too."""
    several, short_of = len(whole.instances) > 1, dict[str, str]()
    for sets in (whole.node_sets, whole.element_sets):
        own = {key.upper() for key in sets if not _instance_of(key, whole)}
        for full in [key for key in sets if _instance_of(key, whole)]:
            short = full[len(_instance_of(full, whole)) + 1 :]
            if short.upper() in own:
                continue
            whole.extend(sets, whole.names.setdefault(short.upper(), short), sets[full])
            if not several:
                del sets[full]
                if sets is whole.element_sets:
                    short_of[full] = short
    whole.solid_sections = [(short_of.get(group, group), m) for group, m in whole.solid_sections]
    whole.sections = [(short_of.get(one[0], one[0]), *one[1:]) for one in whole.sections]
    whole.masses = [(kind, short_of.get(group, group), v) for kind, group, v in whole.masses]


def _instance_of(key: str, whole: AbaqusMesh) -> str:
    """Return the name of the instance in the name of a set; nothing for a set of the assembly."""
    name = key.upper()
    while "." in name:
        name = name.rpartition(".")[0]
        if name in whole.instances:
            return name
    return ""


def _moved(points: FloatArray, card: Card) -> FloatArray:
    """Return points after the translation and the rotation of an instance, in this order."""
    rows = [[real(value or "0") for value in row] for row in card.rows]
    if rows:
        shift = np.zeros(3)
        shift[: len(rows[0])] = rows[0][:3]
        points = points + shift
    if len(rows) > 1:
        from scipy.spatial.transform import Rotation  # loaded only if a part is turned

        first, second, (angle,) = np.split(np.array(rows[1]), [3, 6])
        axis = (second - first) / np.linalg.norm(second - first)
        turn = Rotation.from_rotvec(np.radians(angle) * axis)
        points = first + turn.apply(points - first)
    return points

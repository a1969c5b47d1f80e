"""Wheels in one piece: from a sector, how often a mesh repeats in a turn, and its contact nodes
blade by blade."""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from bladewhirl.meshes.coincident import COINCIDENT
from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.solids.sectors import largest_gap

GAP = np.radians(45.0)
"""Angle about the axis within which a wheel in one piece has nodes [rad]."""


def goes_round(points: FloatArray) -> bool:
    """Return whether points, (n, 3), are all around the axis z."""
    return bool(largest_gap(points) < GAP)


def wheel_of_sector(
    mesh: VolumeMesh, left: IntArray, right: IntArray, copies: int
) -> tuple[VolumeMesh, IntArray]:
    """Return the mesh of a whole wheel, and the numbers of the nodes of each sector in it, (copies,
    nodes).

    Its nodes are those of the sector without the right face, sector by sector, as the coordinates
    of `superelements.wheel.whole_wheel`. Groups contain the nodes and cells of all sectors.

    Args:
        mesh: sector with the axis of rotation z.
        left, right: nodes of its faces in the same order.
        copies: number of sectors.
    """
    kept = np.setdiff1d(np.arange(len(mesh.points)), right)
    place = np.empty(len(mesh.points), dtype=np.int64)
    place[kept] = np.arange(len(kept))
    place[right] = len(kept) + place[left]  # on the next sector
    sector = np.arange(copies)[:, None]
    numbers = (place + len(kept) * sector) % (copies * len(kept))
    turned = [rotate(mesh.points[kept], 2.0 * np.pi / copies * s) for s in range(copies)]
    counts = [len(cells) for _, cells in mesh.blocks]
    start = np.repeat(np.cumsum([0, *counts[:-1]]), counts)
    size, cell = np.repeat(counts, counts), np.arange(sum(counts))
    cells_of = (copies - 1) * start + cell + size * sector  # block by block, then by sector
    return replace(
        mesh,
        points=np.concatenate(turned),
        blocks=tuple(
            (element, numbers[:, cells].reshape(-1, cells.shape[1]))
            for element, cells in mesh.blocks
        ),
        groups={
            name: np.unique(numbers[:, nodes]).astype(np.int64)
            for name, nodes in mesh.groups.items()
        },
        cell_groups={
            name: cells_of[:, each].ravel().astype(np.int64)
            for name, each in mesh.cell_groups.items()
        },
        rigid=tuple((text, own) for text, each in mesh.rigid for own in numbers[:, each]),
        rows=np.zeros(0, dtype=np.int64),
    ), numbers


def equal_blades(points: FloatArray, contact: IntArray) -> int:
    """Return the largest number of equal parts of a turn about z by each of which contact nodes and
    all nodes of a wheel come to lie on such nodes.

    Args:
        points: positions of all nodes [m], (n, 3).
        contact: contact nodes of the wheel, (m,).
    """
    for number in range(len(contact), 1, -1):
        if len(contact) % number == 0 and all(
            _ahead(points, one, number) is not None for one in (contact, np.arange(len(points)))
        ):
            return number
    return 1


def blade_by_blade(points: FloatArray, contact: IntArray, blades: int) -> IntArray | None:
    """Return the contact nodes of each blade, counter-clockwise and in the same order on all
    blades, (blades, nodes); None if they do not repeat.

    Blades begin in the middle of the largest angle between contact nodes; the first has nodes at
    the angle 0 or follows it.

    Args:
        points: positions of all nodes [m], (n, 3).
        contact: contact nodes of all blades, (m,).
        blades: number of blades.
    """
    pitch = 2.0 * np.pi / blades
    angle = np.arctan2(points[contact, 1], points[contact, 0])
    within = np.sort(angle % pitch)
    gaps = np.diff(within, append=within[0] + pitch)
    start = within[gaps.argmax()] + gaps.max() / 2.0 - pitch
    nodes = [contact[(angle - start) % (2.0 * np.pi) < pitch]]
    for _ in range(1, blades):
        ahead = _ahead(points, contact, blades, nodes[-1])
        if ahead is None:
            return None
        nodes.append(ahead)
    found = np.array(nodes)
    return found if len(np.unique(found)) == len(contact) else None


def _ahead(
    points: FloatArray, among: IntArray, number: int, nodes: IntArray | None = None
) -> IntArray | None:
    """Return which nodes among some are where nodes, by default the same, come to lie by a part of
    a turn; None if there are none."""
    turned = rotate(points[among if nodes is None else nodes], 2.0 * np.pi / number)
    distance, found = cKDTree(points[among]).query(turned)
    return among[found] if distance.max() <= COINCIDENT * abs(points).max() else None

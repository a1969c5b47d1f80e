"""Structured meshes of solids: boxes of a grid, of which each is a hexahedron,
two wedges or six tetrahedra."""

import json
from collections.abc import Callable
from itertools import count, permutations, product
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from places import ROOT

from bladewhirl.meshes.cells import CELL_TYPES, CellType
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.frequencies import lowest_frequencies
from bladewhirl.models.superelements.superelement import Superelement

Array = np.ndarray[Any, Any]


def grid_mesh(
    boxes: tuple[int, int, int],
    shape: Callable[[Array], Array],
    cell_type: str,
    inside: Callable[[Array], Any] = lambda centre: True,
    **groups: Callable[[Array], Any],
) -> meshio.Mesh:
    """Return a mesh of the unit cube, mapped to another shape.

    Args:
        boxes: number of boxes along each edge of the cube.
        shape: map from coordinates in the cube, (n, 3), to positions, (n, 3).
        cell_type: type of the cells, named as in meshio.
        inside: whether the box with a centre, (3,), in the cube belongs to the mesh.
        groups: masks of the members of each group, by coordinates in the cube, (n, 3).
    """
    kind = CELL_TYPES[cell_type]
    steps = 2 * np.array(boxes)
    cells = []
    for box in product(*map(range, boxes)):
        if not inside((np.array(box) + 0.5) / boxes):
            continue
        for corners in _parts(kind):
            span = corners[1:4] - corners[0]
            nodes = corners[0] + kind.reference @ (np.eye(3) if len(corners) == 8 else span)
            cells.append(2 * np.array(box) + (2 * nodes).round().astype(int))
    numbers = np.ravel_multi_index(np.moveaxis(np.array(cells), -1, 0), tuple(steps + 1))
    used, numbers = np.unique(numbers, return_inverse=True)
    place = np.stack(np.unravel_index(used, tuple(steps + 1)), axis=1) / steps
    return meshio.Mesh(
        shape(place),
        [(cell_type, numbers.reshape(len(cells), -1))],
        point_sets={name: np.flatnonzero(mask(place)) for name, mask in groups.items()},
    )


def _parts(kind: CellType) -> list[Array]:
    """Return the corners of cells that fill the unit cube."""
    if len(kind.corners) == 4:
        return _tetrahedra()
    turned = np.array([1, 1, 0]) + kind.corners * [-1, -1, 1]
    return [kind.corners, turned] if len(kind.corners) == 6 else [kind.corners]


def _tetrahedra() -> list[Array]:
    """Return the corners of six tetrahedra that fill the unit cube, all about one diagonal."""
    actual = []
    for order in permutations(range(3)):
        corners = np.array([[0, 0, 0], *np.cumsum(np.eye(3)[[*order]], axis=0)])
        if np.linalg.det(np.diff(corners, axis=0)) < 0.0:
            corners[[1, 2]] = corners[[2, 1]]
        actual.append(corners)
    return actual


def cantilever(cell_type: str, boxes: tuple[int, int, int] = (6, 2, 1)) -> meshio.Mesh:
    """Return a blade of 100 x 30 x 5 mm at a radius of 0.2 m, staggered by 30 degrees."""
    return _cantilever(cell_type, boxes, lambda centre: True)


RIGID_TIP = """*NODE
1000, 0.3, 0, 0
1001, 0.3, 0, 0
*RIGID BODY, NSET=tip, REF NODE=1000, ROT NODE=1001
"""
"""Part of a deck after which the nodes of the tip of `cantilever` move as a rigid body."""


def _cantilever(
    cell_type: str, boxes: tuple[int, int, int], inside: Callable[[Array], Any]
) -> meshio.Mesh:
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)

    def shape(place: Array) -> Array:
        x, y, z = (place * [0.1, 0.03, 0.005] + [0.2, -0.015, -0.0025]).T
        return np.stack([x, c * y - s * z, s * y + c * z], axis=1)

    return grid_mesh(
        *(boxes, shape, cell_type, inside),
        root=lambda place: place[:, 0] == 0.0,
        tip=lambda place: place[:, 0] == 1.0,
    )


SECTORS = 12

STEEL: dict[str, Any] = {"young_modulus": "210 GPa", "poisson_ratio": 0.3, "density": 7800.0}
TIE: dict[str, Any] = {"left": "left", "right": "right", "copies": SECTORS}
CALCULIX = json.loads((ROOT / "tests" / "data" / "solids" / "calculix.json").read_text())
"""Natural frequencies [Hz], printed with seven digits by CalculiX; calculix.py made the file."""


def bladed_sector(cell_type: str, *, shroud: bool = False) -> meshio.Mesh:
    """Return a twelfth of a bladed disk with curved cells: a ring of radii 50 to 90 mm, which holds
    a blade up to 150 mm that leans backward and may have a shroud at its end."""

    def shape(place: Array) -> Array:
        r = 0.05 + 0.1 * place[:, 0]
        theta = 2.0 * np.pi / SECTORS * (place[:, 1] - 0.5)
        blade = np.maximum(r - 0.09, 0.0)
        theta = theta * (1.0 if shroud else 1.0 - 5.0 * blade) - 3.0 * blade
        z = 0.02 * (place[:, 2] - 0.5) * (1.0 - 5.0 * blade)
        if not shroud:
            z += blade * (place[:, 1] - 0.5)
        return np.stack([r * np.cos(theta), r * np.sin(theta), z], axis=1)

    return grid_mesh(
        *((5, 3, 1), shape, cell_type),
        lambda centre: centre[0] < 0.4 or 1 / 3 < centre[1] < 2 / 3 or (shroud and centre[0] > 0.8),
        root=lambda place: place[:, 0] == 0.0,
        tip=lambda place: place[:, 0] == 1.0,
        left=lambda place: (place[:, 1] == 0.0) & (place[:, 0] <= 0.4 + 1e-9),
        right=lambda place: (place[:, 1] == 1.0) & (place[:, 0] <= 0.4 + 1e-9),
        clockwise=lambda place: (place[:, 1] == 0.0) & (place[:, 0] >= 0.8 - 1e-9),
        ahead=lambda place: (place[:, 1] == 1.0) & (place[:, 0] >= 0.8 - 1e-9),
    )


def wheel_frequencies(
    part: Superelement, sectors: int, count: int, diameters: Any = None
) -> np.ndarray[Any, Any]:
    """Return the lowest natural frequencies [Hz] of a wheel by nodal diameter, (diameters, count).

    Args:
        part: sector with left_dofs and right_dofs.
        sectors: number of sectors.
        count: number of frequencies for each nodal diameter. Frequencies with 0 < k < sectors / 2
            belong to two waves, which travel in opposite directions.
        diameters: nodal diameters; 0 to sectors // 2 by default.

    Raises:
        SuperelementError: the superelement is not a sector.
    """
    chosen = range(sectors // 2 + 1) if diameters is None else diameters
    ties = (transformation(part, sectors, int(k)) for k in chosen)
    blocks = (part.projected(tie, ("mass", "stiffness")) for tie in ties)
    return np.array([lowest_frequencies(**block, count=count) for block in blocks])


def deck_text(mesh: meshio.Mesh, *elements: str) -> str:
    """Return an Abaqus deck of nodes, elements and sets of nodes; the set of all elements is all.

    Args:
        mesh: mesh.
        elements: name of the elements of each block of cells, such as C3D20R.
    """
    text = "*NODE, NSET=every\n"
    for number, (x, y, z) in enumerate(mesh.points.tolist(), 1):
        text += f"{number}, {x:.13f}, {y:.13f}, {z:.13f}\n"
    numbers = count(1)
    for element, block in zip(elements, mesh.cells, strict=True):
        text += f"*ELEMENT, TYPE={element}, ELSET=all\n"
        for nodes in (block.data + 1).tolist():
            row = list(map(str, [next(numbers), *nodes]))
            lines = [", ".join(row[at : at + 10]) for at in range(0, len(row), 10)]
            text += ",\n".join(lines) + "\n"
    return text + "".join(node_set(*one) for one in mesh.point_sets.items())


def joined(first: meshio.Mesh, second: meshio.Mesh) -> meshio.Mesh:
    """Return two meshes as one; nodes at one place become one node."""
    points = np.concatenate([first.points, second.points]).round(13)
    kept, number = np.unique(points, axis=0, return_inverse=True)
    number = number.ravel()
    sides = (number[: len(first.points)], number[len(first.points) :])
    cells = [
        (block.type, side[block.data])
        for side, mesh in zip(sides, (first, second), strict=True)
        for block in mesh.cells
    ]
    sets = {
        name: np.union1d(sides[0][first.point_sets[name]], sides[1][second.point_sets[name]])
        for name in first.point_sets
    }
    return meshio.Mesh(kept, cells, point_sets=sets)


def half_cantilever(cell_type: str, *, outer: bool) -> meshio.Mesh:
    """Return the inner or the outer half of `cantilever`."""

    def inside(centre: Array) -> bool:
        return bool((centre[0] > 0.5) == outer)

    return _cantilever(cell_type, (6, 2, 1), inside)


def node_set(name: str, nodes: Any) -> str:
    """Return a set of nodes of a deck; nodes are numbered from 0."""
    return f"*NSET, NSET={name}\n" + "".join(f"{node + 1},\n" for node in nodes)


def deck(folder: Path, mesh: meshio.Mesh, element: str) -> Path:
    """Write an Abaqus deck of a mesh with elements of one name."""
    path = folder / "deck.inp"
    path.write_text(deck_text(mesh, element))
    return path


def fan_sector(sectors: int, cell_type: str = "hexahedron20") -> meshio.Mesh:
    """Return a sector of a small fan: a hub ring of radii 40 to 80 mm, off the plane z = 0, and a
    straight blade up to 160 mm that leans out of the plane of the ring."""

    def shape(place: Array) -> Array:
        r = 0.04 + 0.12 * place[:, 0]
        theta = 2.0 * np.pi / sectors * (place[:, 1] - 0.5) * np.minimum(1.0, 0.08 / r)
        z = 0.03 * (place[:, 2] - 0.3) + np.maximum(r - 0.08, 0.0) * 2.0 * (place[:, 1] - 0.4)
        return np.stack([r * np.cos(theta), r * np.sin(theta), z], axis=1)

    return grid_mesh(
        *((3, 3, 1), shape, cell_type),
        lambda centre: centre[0] < 1 / 3 or 1 / 3 < centre[1] < 2 / 3,
        root=lambda place: place[:, 0] == 0.0,
        tip=lambda place: (place[:, 0] == 1.0) & (abs(place[:, 1] - 0.5) < 0.01),
        left=lambda place: (place[:, 1] == 0.0) & (place[:, 0] <= 1 / 3 + 1e-9),
        right=lambda place: (place[:, 1] == 1.0) & (place[:, 0] <= 1 / 3 + 1e-9),
    )


def whole(sector: meshio.Mesh, sectors: int) -> meshio.Mesh:
    """Return the wheel of a sector; nodes at one place become one node."""
    made = sector
    for angle in 2.0 * np.pi / sectors * np.arange(1, sectors):
        c, s = np.cos(angle), np.sin(angle)
        x, y, z = sector.points.T
        turned = np.stack([c * x - s * y, s * x + c * y, z], axis=1)
        made = joined(made, meshio.Mesh(turned, sector.cells, point_sets=sector.point_sets))
    groups = {name: nodes for name, nodes in made.point_sets.items() if name in ("root", "tip")}
    return meshio.Mesh(made.points, [merged_cells(made)], point_sets=groups)


def merged_cells(mesh: meshio.Mesh) -> tuple[str, Array]:
    """Return the cells of all blocks of one type as one block."""
    return mesh.cells[0].type, np.concatenate([block.data for block in mesh.cells])

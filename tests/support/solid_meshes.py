"""Structured meshes of solids: boxes of a grid, of which each is a hexahedron or six tetrahedra."""

from collections.abc import Callable
from itertools import permutations, product
from typing import Any

import meshio
import numpy as np

from bladewhirl.models.solids.cells import CELL_TYPES
from bladewhirl.models.superelements.cyclic import cyclic_reduction
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
        for corners in _tetrahedra() if len(kind.corners) == 4 else [kind.corners]:
            mean = kind.reference @ (corners[1:4] - corners[0]) if len(corners) == 4 else None
            nodes = kind.reference if mean is None else corners[0] + mean
            cells.append(2 * np.array(box) + (2 * nodes).round().astype(int))
    numbers = np.ravel_multi_index(np.moveaxis(np.array(cells), -1, 0), tuple(steps + 1))
    used, numbers = np.unique(numbers, return_inverse=True)
    place = np.stack(np.unravel_index(used, tuple(steps + 1)), axis=1) / steps
    return meshio.Mesh(
        shape(place),
        [(cell_type, numbers.reshape(len(cells), -1))],
        point_sets={name: np.flatnonzero(mask(place)) for name, mask in groups.items()},
    )


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
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)

    def shape(place: Array) -> Array:
        x, y, z = (place * [0.1, 0.03, 0.005] + [0.2, -0.015, -0.0025]).T
        return np.stack([x, c * y - s * z, s * y + c * z], axis=1)

    return grid_mesh(
        *(boxes, shape, cell_type),
        root=lambda place: place[:, 0] == 0.0,
        tip=lambda place: place[:, 0] == 1.0,
    )


SECTORS = 12


def bladed_sector(cell_type: str) -> meshio.Mesh:
    """Return a twelfth of a bladed disk with curved cells: a ring of radii 50 to 90 mm, which holds
    a blade up to 150 mm that leans backward."""

    def shape(place: Array) -> Array:
        r = 0.05 + 0.1 * place[:, 0]
        theta = 2.0 * np.pi / SECTORS * (place[:, 1] - 0.5)
        blade = np.maximum(r - 0.09, 0.0)
        theta = theta * (1.0 - 5.0 * blade) - 3.0 * blade
        z = 0.02 * (place[:, 2] - 0.5) * (1.0 - 5.0 * blade) + blade * (place[:, 1] - 0.5)
        return np.stack([r * np.cos(theta), r * np.sin(theta), z], axis=1)

    return grid_mesh(
        *((5, 3, 1), shape, cell_type),
        lambda centre: centre[0] < 0.4 or 1 / 3 < centre[1] < 2 / 3,
        root=lambda place: place[:, 0] == 0.0,
        tip=lambda place: place[:, 0] == 1.0,
        left=lambda place: (place[:, 1] == 0.0) & (place[:, 0] <= 0.4 + 1e-9),
        right=lambda place: (place[:, 1] == 1.0) & (place[:, 0] <= 0.4 + 1e-9),
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
    reductions = (cyclic_reduction(part, sectors, int(k)) for k in chosen)
    return np.array([lowest_frequencies(one.mass, one.stiffness, count) for one in reductions])

"""Line mesh of a bladed disk: radial blades on spokes and a rim polygon."""

from __future__ import annotations

import numpy as np

from bladewhirl.meshes.line_mesh import LineMesh


def bladed_disk_mesh(
    *, blades: int, tip_radius: float, disk_radius: float, elements_per_blade: int
) -> LineMesh:
    """Mesh the bladed disk of the paper's Fig. 3(a).

    Each sector holds one blade of equal elements from ``disk_radius`` to ``tip_radius`` [m], one
    spoke from the centre to the blade root, and one straight rim line to the next root. Blade 0
    lies on +x and blades follow counter-clockwise. Nodes are numbered sector by sector, root to
    tip, the centre last. Displacement axes are polar at every node but the centre.

    Node sets: ``tips`` and ``roots`` (in blade order), ``centre``. Line sets: ``blades``,
    ``spokes``, ``rim``.

    Raises:
        ValueError: fewer than 3 blades, no element, or radii not 0 < disk < tip.
    """
    if blades < 3 or elements_per_blade < 1 or not 0.0 < disk_radius < tip_radius:
        raise ValueError(
            "a bladed disk needs 3 blades or more, 1 element or more and 0 < disk_radius < "
            f"tip_radius; got {blades}, {elements_per_blade}, {disk_radius}, {tip_radius}"
        )
    per_sector = elements_per_blade + 1
    angles = 2.0 * np.pi * np.arange(blades) / blades
    radii = np.linspace(disk_radius, tip_radius, per_sector)
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    points = (directions[:, None, :] * radii[None, :, None]).reshape(-1, 2)

    sectors = np.arange(blades * per_sector).reshape(blades, per_sector)
    centre = blades * per_sector
    roots, tips = sectors[:, 0], sectors[:, -1]
    blade_lines = np.stack([sectors[:, :-1], sectors[:, 1:]], axis=-1).reshape(-1, 2)
    spokes = np.column_stack([np.full(blades, centre), roots])
    rim = np.column_stack([roots, np.roll(roots, -1)])
    count = len(blade_lines)
    return LineMesh(
        points=np.vstack([points, [0.0, 0.0]]),
        lines=np.vstack([blade_lines, spokes, rim]),
        node_axes=np.append(np.repeat(angles, per_sector), 0.0),
        node_sets={"tips": tips, "roots": roots, "centre": np.array([centre])},
        line_sets={
            "blades": np.arange(count),
            "spokes": np.arange(count, count + blades),
            "rim": np.arange(count + blades, count + 2 * blades),
        },
        sectors=sectors,
    )

"""A small blade with several contact nodes, and the tables of its case."""

from pathlib import Path
from typing import Any

import numpy as np

from bladewhirl.models.superelements.superelement import Superelement


def blade(nodes: int = 3, levels: int = 6) -> Superelement:
    """Return a blade of rods of masses on springs, side by side along the axis."""
    along = 3 * nodes
    size = along * levels
    stiffness = np.zeros((size, size))
    springs = np.tile([2e8, 2e6, 2e6], nodes)
    for level in range(levels):
        here = along * level + np.arange(along)
        stiffness[here, here] += springs
        if level:
            stiffness[here - along, here - along] += springs
            stiffness[here, here - along] -= springs
            stiffness[here - along, here] -= springs
        for node in range(nodes - 1):
            for i in range(3):
                a, b = here[3 * node + i], here[3 * node + 3 + i]
                stiffness[a, a] += 1e7
                stiffness[b, b] += 1e7
                stiffness[a, b] -= 1e7
                stiffness[b, a] -= 1e7
    tips = along * (levels - 1) + np.arange(along).reshape(nodes, 3)
    radius, axial = np.meshgrid(np.linspace(0.25, 0.3, levels), np.linspace(-0.02, 0.02, nodes))
    points = np.stack([radius.T, np.zeros((levels, nodes)), axial.T], axis=-1).reshape(-1, 3)
    cells = [[n, n + 1, n + nodes] for n in range(nodes * (levels - 1)) if (n + 1) % nodes]
    return Superelement(
        mass=5e-3 * np.eye(size),
        stiffness=stiffness,
        contact_position=points[-nodes:],
        contact_dofs=tips,
        points=points,
        recovery=np.eye(size),
        triangles=np.array(cells),
        name="rods",
    )


def tables(file: Path, **changes: Any) -> dict[str, Any]:
    given: dict[str, Any] = {
        "bladed_disk": {"superelement": {"file": str(file), "copies": 3}},
        "casing": {
            "type": "rigid",
            "clearance": 3e-4,
            "profile": {"harmonics": [{"lobes": 2, "amplitude": 3.1e-4, "phase": 0.3}]},
            "closure": {"amount": 4e-5, "time_constant": 2e-3},
        },
        "contact": {"sliding": "full", "friction": 0.1},
        "reduction": {"free_interface_modes": 15},
        "damping": {"ratio": 0.01},
        "march": {
            "speed": "6000 rpm",
            "time_step": 2e-6,
            "duration": 0.02,
            "record_step": 4e-5,
        },
    }
    for key, value in changes.items():
        table, _, name = key.partition("__")
        given[table] = {**given[table], name: value} if name else value
    return given

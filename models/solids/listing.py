"""Content of a mesh of solids for the user, and the call that makes a superelement of it."""

from typing import Any, NamedTuple

import numpy as np

from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.models.superelements.superelement import RADII

ROOTS, TIPS = ("root", "hub", "clamp", "fix"), ("tip", "contact", "shroud")
"""Parts of the names of groups that are probably clamped, and that probably touch."""

STEEL = {"young_modulus": "210 GPa", "poisson_ratio": 0.3, "density": "7.8 g/cm3"}


class SolidListing(NamedTuple):
    """Content of a mesh of solids."""

    size: str  #: number of nodes and elements, extent and unit
    groups: tuple[dict[str, Any], ...]  #: name, kind and number of members of each group
    materials: tuple[dict[str, Any], ...]  #: group, material and constants in the units of the file
    call: str  #: call of `mesh3d` with probable arguments


def solid_listing(mesh: VolumeMesh, source: str) -> SolidListing:
    """Return the content of a mesh of solids.

    Args:
        mesh: mesh in the unit of its file.
        source: path of the file, for the call.
    """
    elements = ", ".join(f"{len(cells)} elements {name}" for name, cells in mesh.blocks)
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    extent = ", ".join(f"{c} {a:.6g} to {b:.6g}" for c, a, b in zip("xyz", low, high, strict=True))
    millimetres = float(abs(mesh.points).max()) > RADII[1]
    unit = "in the unit of the file, probably mm" if millimetres else "in the unit of the file"
    kinds = (("nodes", mesh.groups), ("elements", mesh.cell_groups))
    return SolidListing(
        size=f"{len(mesh.points)} nodes, {elements}, {extent}, {unit}",
        groups=tuple(
            {"name": name, "kind": kind, "members": len(members)}
            for kind, groups in kinds
            for name, members in groups.items()
        ),
        materials=tuple(
            {"group": one.group, "material": one.material, **one.properties}
            for one in mesh.sections
        ),
        call=_call(mesh, source, millimetres),
    )


def _call(mesh: VolumeMesh, source: str, millimetres: bool) -> str:
    radius = np.hypot(mesh.points[:, 0], mesh.points[:, 1]) * (1e-3 if millimetres else 1.0)
    lowest = radius.min() + 0.01 * np.ptp(radius)
    given: dict[str, Any] = {
        "clamped": _named(mesh, ROOTS) or f"r < {lowest:.3g}",
        "contact": _named(mesh, TIPS) or "outermost",
    }
    given |= {} if mesh.sections else STEEL
    given |= {"unit": "mm"} if millimetres else {}
    given |= {"mass_unit": "t"} if millimetres and mesh.sections else {}
    arguments = ", ".join(f"{key}={value!r}" for key, value in given.items())
    return (
        f"To make a superelement, in Python: part = bw.mesh3d({source!r}, {arguments});"
        ' bw.write_superelement("part.npz", part)'
    )


def _named(mesh: VolumeMesh, parts: tuple[str, ...]) -> str:
    """Return the first group of nodes whose name contains one of the words; nothing without one."""
    named = (name for word in parts for name in mesh.groups if word in name.lower())
    return next(named, "")

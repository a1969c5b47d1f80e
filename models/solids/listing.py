"""Content of a mesh of solids for the user, and the arguments that make a superelement of it."""

from typing import Any, NamedTuple

from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.models.solids.proposal import Proposal, proposed


class SolidListing(NamedTuple):
    """Content of a mesh of solids."""

    size: str  #: number of nodes and elements, extent and unit
    groups: tuple[dict[str, Any], ...]  #: name, kind and number of members of each group
    materials: tuple[dict[str, Any], ...]  #: group, material and constants in the units of the file
    proposal: Proposal  #: arguments of `mesh3d` that the mesh suggests


def solid_listing(mesh: VolumeMesh) -> SolidListing:
    """Return the content of a mesh of solids in the unit of its file."""
    elements = ", ".join(f"{len(cells)} elements {name}" for name, cells in mesh.blocks)
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    extent = ", ".join(f"{c} {a:.6g} to {b:.6g}" for c, a, b in zip("xyz", low, high, strict=True))
    kinds = (("nodes", mesh.groups), ("elements", mesh.cell_groups))
    return SolidListing(
        size=f"{len(mesh.points)} nodes, {elements}, {extent}, in the unit of the file",
        groups=tuple(
            {"name": name, "kind": kind, "members": len(members)}
            for kind, groups in kinds
            for name, members in groups.items()
        ),
        materials=tuple(
            {"group": one.group, "material": one.material, **one.properties}
            for one in mesh.sections
        ),
        proposal=proposed(mesh),
    )

"""Bladed disks of beams with shrouds that are cut between the blades, as a superelement."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import directions
from bladewhirl.models.case.joint import Joint
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.export import to_cartesian, wheel_superelement
from bladewhirl.models.geometry.standard_disk import ENDS, ring_end
from bladewhirl.models.superelements.superelement import Superelement

CORNERS = 4  #: corners of a section

DIRECTIONS = 3  #: displacements of a contact node, along x, y and z


@dataclass(frozen=True, kw_only=True)
class WheelOfBeams:
    """A bladed disk of beams as a wheel in place of a table `bladed_disk.superelement`. Its contact
    nodes are, blade by blade, the tip and the left and right ends of the parts of cut rings."""

    in_plane: Superelement  #: the beams, see `wheel_superelement`
    part: Superelement
    """The same with the displacements of the ends along the axis as last coordinates, by bending of
    the parts out of the plane. They have no mass and nothing in the plane excites them: joints only
    need that they are not without flexibility. Its points are corners of the beams."""
    rings: tuple[int, ...]  #: the rings that are cut
    copies: int  #: number of blades
    kind: Literal["wheel"] = "wheel"
    angle: float = 0.0  #: angle by which it is turned about the axis [rad]
    left_out: int = 0  #: number of contact nodes that are left out

    @classmethod
    def of(cls, disk: BladedDiskModel, rings: Sequence[int], name: str) -> "WheelOfBeams":
        """Return a bladed disk at rest, with a name, some rings of which are cut."""
        ends = [disk.mesh.node_sets[ring_end(ring, side)] for ring in rings for side in ENDS]
        surface = _surface(disk, np.column_stack([disk.model.tips, *ends]).ravel())
        flat = replace(wheel_superelement(disk, name, ends), **surface)
        return cls(
            in_plane=flat,
            part=_with_axial(disk, flat, np.column_stack(ends)),
            rings=tuple(rings),
            copies=len(disk.model.tips),
        )

    def joint_nodes(self, joint: Joint) -> tuple[list[int], list[int]]:
        """Return the contact nodes of a blade on the left and the right side of a joint."""
        first = 1 + len(ENDS) * self.rings.index(joint.cut_ring)
        return [first], [first + 1]


def _with_axial(disk: BladedDiskModel, flat: Superelement, ends: IntArray) -> Superelement:
    """Return the wheel with the axial displacements of nodes, (blades, nodes of a blade)."""
    nodes, size = ends.ravel(), flat.size
    count = len(nodes)
    own = {key: _extended(matrix, 0.0, count) for key, matrix in flat.given(flat.FORMS).items()}
    own["stiffness"] = _extended(flat.stiffness, _out_of_plane(disk, nodes), count)
    own |= {key: np.append(load, np.zeros(count)) for key, load in flat.given(flat.LOADS).items()}
    dofs = flat.contact_dofs.reshape(len(ends), -1, DIRECTIONS).copy()
    dofs[:, 1:, -1] = size + np.arange(count).reshape(ends.shape)
    number = 1 + np.arange(ends.shape[1])  # of the ends on the first blade, after its tip
    still = sp.csr_array((DIRECTIONS * flat.point_count, count))
    return replace(
        flat,
        **own,
        contact_dofs=dofs.reshape(-1, DIRECTIONS),
        recovery=sp.csr_array(sp.hstack([flat.recovery, still])),
        joint_left=number[::2],
        joint_right=number[1::2],
        sectors=len(ends),
    )


def _extended(matrix: sp.csr_array, diagonal: FloatArray | float, count: int) -> sp.csr_array:
    """Return a matrix with further coordinates, of which it has a diagonal only."""
    return sp.csr_array(sp.block_diag([matrix, sp.diags_array(np.full(count, diagonal))]))


def _out_of_plane(disk: BladedDiskModel, nodes: IntArray) -> FloatArray:
    """Return the stiffness of the ends of parts of rings along the axis, of cantilevers from the
    blade [N/m], (nodes,)."""
    mesh, given = disk.mesh, disk.properties
    line = np.array([np.flatnonzero((mesh.lines == node).any(axis=1))[0] for node in nodes])
    bending = given.young_modulus[line] * given.thickness[line] * given.width[line] ** 3 / 12.0
    length = np.pi / len(disk.model.tips) * np.hypot(*mesh.points[nodes].T)
    return np.asarray(3.0 * bending / length**3)


def _surface(disk: BladedDiskModel, contacts: IntArray) -> dict[str, Any]:
    """Return points, their recovery and triangles of the four faces of each beam for coordinates
    that are along x and y at some nodes, see `to_cartesian`."""
    mesh, given = disk.mesh, disk.properties
    motion = disk.cartesian(to_cartesian(disk, contacts).toarray())
    across = directions(mesh.line_axes + 0.5 * np.pi)
    points, rows = [], []
    for end, share in enumerate((-0.5, 0.5)):  # of the changes along the beams
        node = mesh.lines[:, end]
        high = 0.5 * (given.thickness + share * given.thickness_change)
        wide = 0.5 * (given.width + share * given.width_change)
        for up, out in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
            aside = up * high[:, None] * across
            points.append(np.column_stack([mesh.points[node] + aside, out * wide]))
            x, y = (aside[:, k, None] for k in range(2))
            moved, turned = motion[node, :2], motion[node, 2]
            moved = moved + np.stack([-y * turned, x * turned], axis=1)
            rows.append(np.pad(moved, ((0, 0), (0, 1), (0, 0))))
    place = np.arange(2 * CORNERS * len(mesh.lines)).reshape(2, CORNERS, -1)
    (a, b), (c, d) = place, np.roll(place, -1, axis=1)
    faces = np.stack([[a, c, d], [a, d, b]])
    return {
        "points": np.concatenate(points),
        "recovery": sp.csr_array(np.concatenate(rows).reshape(-1, motion.shape[2])),
        "triangles": np.moveaxis(faces, 1, -1).reshape(-1, 3),
    }

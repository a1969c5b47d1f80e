"""Contact with a wall whose radius varies along the axis: a cone, R(z) = R0 + z tan(slope), or a
contour, under which each contact node has the slope of its own place.

The outward normal of the wall is e_n = cos(slope) e_r - sin(slope) e_z, and its generator e_s =
sin(slope) e_r + cos(slope) e_z. The clearance c along the radius counts at each contact node, so
that its gap is cos(slope) (c + w) - e_n . u with the displacements w of the wall and u of the node.
In the axes e_n, e_theta, e_s a contact problem is that of a cylinder whose radial lengths are
multiplied by cos(slope), and so is the radial force on a flexible casing. The part sin(slope) of
the friction along e_s that acts on the casing along its radius, and of the motion of the casing
along e_s, is left out.
"""

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.casing import Casing
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.wall import ReducedCasing

Rows = TypeVar("Rows", FloatArray, ComplexArray)


def in_wall_axes(rows: Rows, slope: ArrayLike) -> Rows:
    """Return rows of components along e_r, e_theta and e_z of each contact node as those along e_n,
    e_theta and e_s, (3 * nodes, ...); a negative slope reverses this.

    Args:
        rows: components of one node after the other, (3 * nodes, ...).
        slope: slope of the wall [rad], of all nodes or of each, (nodes,).
    """
    each = np.asarray(slope, dtype=np.float64)
    each = each.reshape(each.shape + (1,) * (rows.ndim - 1 if each.ndim else 0))
    c, s = np.cos(each), np.sin(each)
    turned = rows.copy()
    turned[0::3] = c * rows[0::3] - s * rows[2::3]
    turned[2::3] = s * rows[0::3] + c * rows[2::3]
    return turned


def compliance_in_wall_axes(compliance: FloatArray, slope: ArrayLike) -> FloatArray:
    """Return the flexibility of contact nodes in the axes of the wall [m/N], (3c, 3c)."""
    return in_wall_axes(in_wall_axes(compliance, slope).T, slope).T


def slopes(casing: Casing, axial: FloatArray) -> float | FloatArray:
    """Return the slope of a wall [rad]; under a contour that at each axial position [m], in their
    shape.

    Raises:
        CaseError: a position is outside the contour.
    """
    if not casing.contour:
        return casing.slope
    from scipy.interpolate import PchipInterpolator  # long to load

    place, radius = np.transpose(casing.contour)
    if axial.min() < place[0] or axial.max() > place[-1]:
        expected = (
            f"rows from {axial.min():.6g} m to {axial.max():.6g} m at least, between which the"
            " contact nodes lie"
        )
        raise CaseError([Fault(key="casing.contour", value=casing.contour, expected=expected)])
    return np.asarray(np.arctan(PchipInterpolator(place, radius)(axial, 1)))


def wall_share(slope: float | FloatArray) -> float:
    """Return the part of radial lengths that is normal to the whole wall; 1 under a contour, where
    it is a property of the contact nodes."""
    return 1.0 if np.ndim(slope) else float(np.cos(slope))


def in_cone(
    rotor: ReducedRotor, casing: ReducedCasing, slope: float | FloatArray
) -> tuple[ReducedRotor, ReducedCasing]:
    """Return a rotor with contact nodes in a cylinder, and its casing, as those in a cone with a
    slope [rad], or under a contour with a slope at each contact node of a copy, (nodes,).

    Under a contour the casing has to be rigid, because the radial force on it differs from node to
    node. With flexible rings around several wheels the slope is that of the ring of each node.
    """
    if not np.any(slope):
        return rotor, casing
    contact, compliance = in_wall_axes(rotor.contact, slope), rotor.compliance
    if compliance is not None:
        compliance = np.stack([compliance_in_wall_axes(each, slope) for each in compliance])
    part, shorter = np.cos(slope), np.full(len(casing.nodal), wall_share(slope))
    own = 1.0 if np.ndim(slope) == 0 or casing.is_flexible else part
    if np.ndim(slope) and casing.is_flexible:
        _, first = np.unique(rotor.wall, return_index=True)
        shorter = np.repeat(part[first], casing.elements)
    along = np.ones(casing.nodal.shape[:2])  # w, dw/ds, u, du/ds
    along[:, :2] = shorter[:, None]
    recess = (
        np.tile(np.broadcast_to(part, len(rotor.contact_radius)), rotor.copies) * rotor.tip_recess
    )
    return (
        replace(
            rotor,
            contact=contact,
            tip_recess=recess,
            compliance=compliance,
            normal_share=own,
        ),
        replace(
            casing,
            nodal=along[..., None] * casing.nodal,
            clearance=shorter[:, None] * casing.clearance,
        ),
    )

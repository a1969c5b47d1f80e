"""Contact with a conical wall, whose radius is R(z) = R0 + z tan(slope).

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

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem

Rows = TypeVar("Rows", FloatArray, ComplexArray)


def in_wall_axes(rows: Rows, slope: float) -> Rows:
    """Return rows of components along e_r, e_theta and e_z of each contact node as those along e_n,
    e_theta and e_s, (3 * nodes, ...); a negative slope reverses this."""
    c, s = np.cos(slope), np.sin(slope)
    turned = rows.copy()
    turned[0::3] = c * rows[0::3] - s * rows[2::3]
    turned[2::3] = s * rows[0::3] + c * rows[2::3]
    return turned


def compliance_in_wall_axes(compliance: FloatArray, slope: float) -> FloatArray:
    """Return the flexibility of contact nodes in the axes of the wall [m/N], (3c, 3c)."""
    return in_wall_axes(in_wall_axes(compliance, slope).T, slope).T


def in_cone(problem: ContactProblem, slope: float) -> ContactProblem:
    """Return a problem of contact nodes in a cylinder as that in a cone with a slope [rad]."""
    if slope == 0.0:
        return problem
    rotor, casing, closure = problem.rotor, problem.casing, problem.closure
    nodes = rotor.nodes
    assert nodes is not None
    contact, compliance = in_wall_axes(rotor.contact, slope), nodes.compliance
    if compliance is not None:
        compliance = np.stack([compliance_in_wall_axes(each, slope) for each in compliance])
    shorter = np.cos(slope)
    along = np.array([shorter, shorter, 1.0, 1.0])  # w, dw/ds, u, du/ds
    return replace(
        problem,
        rotor=replace(
            rotor,
            tip_radial=contact[0::3],
            tip_recess=shorter * rotor.tip_recess,
            nodes=replace(nodes, axial=contact[2::3], compliance=compliance),
        ),
        casing=replace(
            casing,
            nodal=along[:, None] * casing.nodal,
            clearance=shorter * casing.clearance,
        ),
        closure=None if closure is None else replace(closure, share=shorter * closure.share),
        slope=slope,
    )

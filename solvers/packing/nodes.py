"""Arrays of contact nodes, and of an abradable coating under them."""

import numpy as np

from bladewhirl.models.stage.contact_problem import ContactProblem, NodeCoating
from bladewhirl.solvers.kernel.structs import Struct
from bladewhirl.solvers.packing.casing import coating_law, nodal_response
from bladewhirl.solvers.packing.rotor import rotor_inverses

DIRECTIONS = 3
"""Components of the displacement of a contact node: radial, tangential, axial."""


def pack_nodes(problem: ContactProblem, dt: float) -> Struct | None:
    """Return the contact nodes; None if contact forces of the tips have two directions."""
    rotor, casing, nodes = problem.rotor, problem.casing, problem.rotor.nodes
    if nodes is None:
        return None
    contact, compliance = np.ascontiguousarray(rotor.contact), nodes.compliance
    if compliance is None:
        compliance = contact @ rotor_inverses(rotor, dt) @ contact.T
    response = np.zeros((0, 0))
    if casing.is_flexible:
        ends = np.append(np.arange(len(casing.nodal)), 0)
        around = nodal_response(casing, dt)[ends][:, :, ends]
        response = around.reshape(2 * (len(ends) * casing.nodal.shape[1],))
    return Struct(
        "Nodes",
        contact=contact,
        columns=np.ascontiguousarray(contact.T),
        normal=np.ascontiguousarray(rotor.tip_radial.T),
        compliance=np.ascontiguousarray(compliance),
        radius=np.asarray(nodes.radius, dtype=np.float64),
        response=np.ascontiguousarray(response),
        massless=float(nodes.compliance is not None),
        full=float(problem.sliding == "full"),
    )


def pack_node_coating(problem: ContactProblem) -> Struct | None:
    """Return the coating; None if the wall has none."""
    coating, closure, casing = problem.coating, problem.closure, problem.casing
    if not isinstance(coating, NodeCoating):
        return None
    # The kernel computes the slope of a flexible casing itself.
    steepest = 0.0 if casing.is_flexible else float(np.abs(casing.clearance[:, 1]).max())
    if closure is not None:
        steepest += abs(closure.course.largest) * float(np.abs(closure.share[:, 1]).max())
    return Struct(
        "NodeCoating",
        track=coating.track,
        rods=coating.strain.shape[1],
        steepest=steepest * casing.radius,
        **coating_law(coating),
    )


def node_sizes(problem: ContactProblem) -> dict[str, int]:
    """Return the lengths of the arrays of contact nodes in `kernel.h`, zero without them."""
    rotor = problem.rotor
    if rotor.nodes is None:
        copies = modes = nodes = group = 0
    else:
        copies, (nodes, modes) = rotor.copies, rotor.tip_radial.shape
        group = copies * nodes if problem.casing.is_flexible else nodes
    coated = isinstance(problem.coating, NodeCoating)
    under = 0
    if isinstance(problem.coating, NodeCoating):
        under = int(problem.coating.footprint.max() / problem.coating.arc) + 2
    return {
        "node_copies": copies,
        "node_tips": copies * nodes,
        "modes": modes,
        "components": DIRECTIONS * nodes,
        "twice_nodes": 2 * nodes,
        "all_components": copies * DIRECTIONS * nodes,
        "group": group,
        "group_components": DIRECTIONS * group,
        "twice_group": 2 * group,
        "coated_nodes": coated * copies * nodes,
        "bordered_group": group + 1,
        "under": under,
    }

"""Arrays of friction joints between blades."""

import numpy as np
import scipy.sparse as sp

from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel.structs import Struct, aligned_copy
from bladewhirl.solvers.packing.arrangement import lengthened
from bladewhirl.solvers.packing.rotor import rotor_inverses

DIRECTIONS = 3  #: values of a pair: normal and two tangents

ACTING = 0.4
"""Part of the forces at the end of a step that acts on the modes, see `solvers/kernel/joints.h`."""


def pack_joints(problem: ContactProblem, dt: float) -> Struct | None:
    """Return the joints of a contact problem for a time step [s]; None without joints."""
    joints, rotor = problem.joints, problem.rotor
    if joints is None:
        return None
    joined = np.zeros(len(rotor.tip_angle), dtype=np.int64)
    joined[joints.ends[joints.ends >= 0]] = 1
    answers = rotor.contact @ rotor_inverses(rotor, dt) @ rotor.contact.T
    rows = joints.rows(len(joined))
    by_dampers = joints.damper_rows
    modal = ((rows @ sp.block_diag(answers, format="csr")) @ rows.T).toarray()
    modal = ACTING * (modal + dt**2 * (by_dampers * joints.mobility.ravel()) @ by_dampers.T)
    compliance = joints.compliance + modal
    own = np.diag(compliance).reshape(-1, DIRECTIONS)
    return Struct(
        "Joints",
        node=joints.ends.ravel().astype(np.int64),
        axes=aligned_copy(joints.axes.reshape(-1, DIRECTIONS, DIRECTIONS)),
        joined=joined,
        friction=aligned_copy(joints.friction),
        gap=aligned_copy(joints.gap),
        soft=aligned_copy(own.max(axis=1)),
        compliance=lengthened(compliance.T),
        modal=lengthened(modal.T),
        given=aligned_copy(joints.by_load),
        body=joints.damper,
        body_axes=aligned_copy(-joints.axes[:, 1]),
        mobility=aligned_copy(joints.mobility.ravel()),
        pull=aligned_copy(joints.pull.ravel()),
    )

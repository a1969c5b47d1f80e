"""Linear limits of a bladed disk with joints: joints free, closed without friction, and stuck.

Displacements d of the joints that a limit holds at zero follow from those u = P q + s + C f of the
contact nodes with the rows R of the joints, d = R u, f = R^T l. Without d the forces are l =
-(R C R^T)^-1 R (P q + s), so that a limit is a bladed disk with the stiffness

    K + (R P)^T (R C R^T)^-1 R P

and with P and s less their parts C R^T (R C R^T)^-1 R P and C R^T (R C R^T)^-1 R s. A damper is a
body whose coordinates have no stiffness. Combinations of d that have hardly any flexibility C are
held by the modes alone. Equal blades under engine orders follow one another, and
the waves of the engine orders are enough.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.joints.surfaces import dampers_of, joint_nodes, surfaces_of
from bladewhirl.models.joints.wheel import DIRECTIONS
from bladewhirl.models.stage.forced import ForcedRotor, orders_of
from bladewhirl.models.stage.joint_contacts import damper_rows, rows_of
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.reduced_rotor import ReducedRotor

LIMITS: Mapping[str, tuple[int, ...]] = {
    "free": (),
    "closed without friction": (0,),
    "stuck": (0, 1, 2),
}
"""Linear limits, with the directions of the joint that do not move: normal, two tangents."""

RIGID = 1e-8  #: a flexibility up to this fraction of that by the modes is a rounding error
ROUNDING = 1e-13  #: of the largest flexibility of a motion of the bladed disk


@dataclass(frozen=True)
class Ties:
    """What joins the blades of a bladed disk in its linear limits."""

    rows: sp.csr_array
    """Displacements of all pairs by those of the contact nodes, (3 pairs, 3 nodes)."""
    bodies: FloatArray
    """Displacements of all pairs by the coordinates of dampers [kg^-1/2], (3 pairs, bodies)."""
    waves: FloatArray
    """Orthonormal motions of the copies, one after another, (copies, motions)."""

    @classmethod
    def of(cls, stage: Matrices, loads: Sequence[EngineOrder]) -> "Ties":
        """Return the ties of a stage under engine orders.

        Raises:
            CaseError: a damper has no centrifugal force, or several nodes.
        """
        pairs = joint_nodes(stage)
        surfaces = surfaces_of(stage, pairs)
        ends = np.array([each.ends for each in surfaces])
        axes = np.array([[each.axes.T, -each.axes.T] for each in surfaces])
        joint = pairs.joint[[each.pair for each in surfaces]]
        dampers = dampers_of(stage, joint, ends, pairs)
        mobility = dampers["mobility"].ravel()
        bodies = damper_rows(dampers["damper"], axes) * np.sqrt(mobility)
        return cls(rows_of(ends, axes, stage.angle.size), bodies, _waves(stage, loads))

    def held(self, disk: ForcedRotor, directions: Sequence[int]) -> ForcedRotor:
        """Return a bladed disk whose joints do not move in some directions, in its modes.

        Args:
            disk: bladed disk without joints.
            directions: of all pairs, 0 the normal one, 1 and 2 the tangents; none if free.
        """
        if not directions:
            return disk
        rotor, copies = disk.rotor, disk.rotor.copies
        motions = np.kron(self.waves, np.eye(len(rotor.frequency) // copies))
        of_bodies = np.kron(self.waves, np.eye(self.bodies.shape[1] // copies))
        shapes = rotor.all_contact @ motions
        kept = np.isin(np.arange(self.rows.shape[0]) % DIRECTIONS, directions)
        values = np.kron(self.waves, np.eye(int(kept.sum()) // copies))
        rows = sp.csr_array(values.T @ self.rows[kept])
        assert rotor.compliance is not None  # the case has a massless boundary
        answers = (sp.block_diag(rotor.compliance, format="csr") @ rows.T).toarray()
        by_modes = np.hstack([rows @ shapes, values.T @ self.bodies[kept] @ of_bodies])
        own, every = motions.shape[1], by_modes.shape[1]
        squares, damping = np.zeros(every), np.zeros((every, every))
        squares[:own] = (motions**2).T @ rotor.stiffness  # equal for copies that move together
        damping[:own, :own] = motions.T @ la.block_diag(*rotor.velocity_forces) @ motions
        rigid, soft = _parted(rows @ answers, by_modes, squares)
        free = la.null_space(rigid.T @ by_modes)
        pushing = soft @ (soft.T @ by_modes)
        squares, modes = _stiffened((free.T * squares) @ free, soft.T @ by_modes @ free)
        modes = free @ modes
        contact = np.pad(shapes, ((0, 0), (0, every - own))) - answers @ pushing
        forces, static = dict[int, ComplexArray](), dict[int, ComplexArray]()
        for order, force in disk.forces.items():
            moved = disk.static.get(order, np.zeros(len(shapes), dtype=np.complex128)).ravel()
            pressed = soft @ (soft.T @ (rows @ moved))
            static[order] = (moved - answers @ pressed)[None]
            felt = np.pad(motions.T @ force, (0, every - own)) - by_modes.T @ pressed
            forces[order] = modes.T @ felt
        own_modes = replace(
            _with_modes(rotor, squares, contact @ modes),
            centre=np.pad(rotor.centre @ motions, ((0, 0), (0, every - own))) @ modes,
            by_velocity=modes.T @ damping @ modes,
        )
        tips = la.block_diag(*[disk.tips] * copies)
        return replace(disk, rotor=own_modes, forces=forces, tips=tips, static=static)


def _parted(
    flexible: FloatArray, by_modes: FloatArray, squares: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return combinations of the values of pairs that are held: those that only modes move,
    (values, combinations), and all others, each divided by the root of its flexibility.

    Args:
        flexible: residual flexibility of the values [m/N], (values, values).
        by_modes: values by modal coordinates [kg^-1/2], (values, modes).
        squares: squared frequencies of the modes [rad2/s2], (modes,).
    """
    whole = flexible + (by_modes / (squares + _lowest(squares))) @ by_modes.T
    part, every = la.eigh(flexible, whole)
    stiff = part < RIGID
    return every[:, stiff], every[:, ~stiff] / np.sqrt(part[~stiff])


def _lowest(squares: FloatArray) -> float:
    """Return the lowest squared frequency of a motion that is not free [rad2/s2]."""
    return float(squares[squares > RIGID * squares.max()].min())


def _stiffened(stiffness: FloatArray, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return squared frequencies and modes of unit mass with the stiffness K + rows^T rows.

    The second part is larger than K by so much that rounding would reach the lowest frequencies:
    motions along it are measured in other units, and the largest flexibilities are looked for.
    Motions that are stiffer than rounding shows are left out.

    Args:
        stiffness: K of unit masses [rad2/s2], (motions, motions).
        rows: [rad/s], (combinations, motions).
    """
    largest, shift = np.linalg.norm(stiffness, 2), _lowest(la.eigvalsh(stiffness))
    size, axes = la.svd(rows)[1:]
    scale = np.ones(len(axes))
    scale[: len(size)] = np.sqrt(largest) / np.maximum(size, np.sqrt(largest))
    motions = axes.T * scale
    total = motions.T @ (stiffness + shift * np.eye(len(scale))) @ motions
    total[np.diag_indices(len(size))] += (size * scale[: len(size)]) ** 2
    flexible, modes = la.eigh(np.diag(scale**2), total)
    kept = np.flatnonzero(flexible > ROUNDING * flexible[-1])[::-1]
    modes = motions @ modes[:, kept] / np.sqrt(flexible[kept])
    return 1.0 / flexible[kept] - shift, modes


def _with_modes(rotor: ReducedRotor, squares: FloatArray, contact: FloatArray) -> ReducedRotor:
    """Return a rotor of one copy with other modes, all damping of which is in `by_velocity`."""
    return replace(
        rotor,
        frequency=np.sign(squares) * np.sqrt(np.abs(squares)),
        damping_ratio=np.zeros(len(squares)),
        contact=contact,
        column=np.full(len(squares), -1),
        dampers=np.zeros((0, len(squares))),
        copies=1,
        compliance=None,
    )


def _waves(stage: Matrices, loads: Sequence[EngineOrder]) -> FloatArray:
    """Return `Ties.waves`: those of the engine orders if all blades and forces are alike."""
    copies = stage.copies
    differ = stage.case.bladed_disk.mistuning.is_given(stage.table.copies)
    if differ or any(load.factors or not isinstance(load.phase, float) for load in loads):
        return np.eye(copies)
    angle = 2.0 * np.pi / copies * np.outer(np.arange(copies), orders_of(loads))
    return np.asarray(la.orth(np.hstack([np.cos(angle), np.sin(angle)]), rcond=1e-9))

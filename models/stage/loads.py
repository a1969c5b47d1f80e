"""Loads of all imbalances of a stage together, and its initial state in modal coordinates.

The initial state is in rotating axes, which coincide with the static axes at t = 0.
"""

from typing import Literal

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import unit
from bladewhirl.models.case.excitation import Imbalance
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.excitations import direction, unbalance_of
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.models.stage.stage import Stage

RANK, SAME = 1e-10, 1e-6
"""Flexibilities below the first fraction of the largest count as zero; the initial motion may have
errors up to the second fraction."""


def unbalance(stage: Stage) -> float:
    """Return the unbalance m e of an imbalance [kg m], or that of the sum of their forces if there
    are several; see `unbalance_of`.

    Raises:
        ValueError: the case has no imbalance.
    """
    return float(np.hypot(*_unbalance_vector(stage)))


def unbalance_direction(stage: Stage) -> FloatArray:
    """Return the direction of the sum of the imbalances in rotating axes, (2,).

    Raises:
        ValueError: the case has no imbalance.
    """
    return unit(_unbalance_vector(stage))


def _unbalance_vector(stage: Stage) -> FloatArray:
    """Return the sum of the imbalances in rotating axes [kg m], (2,)."""
    loads = [load for load in stage.case.excitations.values() if isinstance(load, Imbalance)]
    if not loads:
        raise ValueError('expected excitation.type = "imbalance"')
    angle = stage.blade_angle.ravel()
    vectors = [unbalance_of(load, stage) * direction(load, angle) for load in loads]
    return np.asarray(np.sum(vectors, axis=0))


def imbalance_force(stage: Stage) -> float:
    """Return the force m e Omega^2 of the imbalances [N]."""
    return unbalance(stage) * stage.speed**2


def initial_state(stage: Stage) -> Start:
    """Return the initial state in all modes from the initial displacements and velocities of a
    case.

    The case gives displacements and velocities of tips and centre in rotating axes; the velocities
    are relative to these axes, without the transport velocity Omega x r. Between tips and centre,
    the bladed disk has its static shape, the field with the least strain energy for these values.
    The casing starts at rest.

    Raises:
        CaseError: the modes cannot move in this way, or one of them is rigid.
    """
    return Start.of_rotor(
        _static_shape(stage, "displacement"),
        _static_shape(stage, "velocity"),
        len(stage.reduced_casing.frequency),
    )


def blade_means(blade: IntArray) -> FloatArray:
    """Return the matrix from values at the contact nodes to their means on each blade of a copy,
    (blades, nodes).

    Args:
        blade: blade of each contact node of a copy, (nodes,).
    """
    member = (blade == np.arange(int(blade.max()) + 1)[:, None]).astype(float)
    return np.asarray(member / member.sum(axis=1, keepdims=True))


def _static_shape(stage: Stage, key: Literal["displacement", "velocity"]) -> FloatArray:
    """Return the modal coordinates of least strain energy for the initial motion of the tips and of
    the centre, (modes,). The motion of a tip is the mean of the contact nodes of a blade."""
    case, rotor, initial = stage.case, stage.rotor, stage.case.initial
    tips, centre = getattr(initial, f"tip_{key}"), getattr(initial, f"centre_{key}")
    if tips is None and not any(centre):
        return stage.rotor_rest
    name = f"initial.{'centre' if tips is None else 'tip'}_{key}"
    stiffness = rotor.by_copy(rotor.stiffness)[0]
    if np.abs(stiffness).min() <= RANK**2 * np.abs(stiffness).max():
        expected = "not allowed for a bladed disk with rigid modes; remove this key"
        raise CaseError([case_fault(case, name, expected)])
    means = blade_means(stage.blade)
    rows = np.stack([means @ rotor.tip_radial, means @ rotor.tip_tangential], axis=1)
    rows = rows.reshape(-1, len(stiffness))
    values = np.zeros((rotor.copies, len(rows)))
    if tips is not None:
        values = np.reshape(tips, values.shape)
    if rotor.centre.any():
        rows = np.vstack([rows, rotor.centre[:, : len(stiffness)]])
        values = np.column_stack([values, np.tile(centre, (rotor.copies, 1))])
    flexible = rows / stiffness
    forces = np.linalg.lstsq(flexible @ rows.T, values.T, rcond=RANK)[0]
    moved = np.asarray(forces.T @ flexible)
    if np.abs(moved @ rows.T - values).max() > SAME * np.abs(values).max():
        expected = (
            'a motion that the modes can have; use more modes, or reduction.boundary = "consistent"'
        )
        raise CaseError([case_fault(case, name, expected)])
    return moved.ravel()

"""A bladed disk of beams at speed in modal coordinates."""

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray, chain_to
from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.bladed_disk import BeamMatrices, BladedDiskModel
from bladewhirl.models.elements.export import BLADES
from bladewhirl.models.modal.modes import Modes
from bladewhirl.models.stage.reduced_rotor import ReducedRotor, contact_rows
from bladewhirl.models.structure.eigenproblems import modal_damping

ROUNDING = 1e-11
"""Entries of a damping matrix below this share of its largest entry are set to zero."""


def boundary_sets(disk: BladedDiskModel) -> dict[str, IntArray]:
    """Return the degrees of freedom on which casing and shaft act, by name."""
    return {
        "tip_radial": disk.tip_radial,
        "tip_tangential": disk.tip_tangential,
        "centre": disk.centre,
    }


def reduced_rotor(
    case: Case, disk: BladedDiskModel, modes: Modes, recess: FloatArray
) -> ReducedRotor:
    """Return a bladed disk at speed in modal coordinates, with a recess of its tips [m],
    (blades,)."""
    centre = np.zeros((2, modes.count))
    centre[: len(disk.centre)] = modes.shapes[disk.centre]  # no rows if clamped
    by_velocity = _by_velocity(case, disk, modes)
    radius, whole = disk.model.tip_radius, np.zeros(len(recess))
    return ReducedRotor(
        frequency=modes.frequency,
        damping_ratio=np.full(modes.count, case.damping.ratio if by_velocity is None else 0.0),
        contact=contact_rows(
            modes.shapes[disk.tip_radial],
            modes.shapes[disk.tip_tangential],
            np.zeros((len(recess), modes.count)),
        ),
        centre=centre,
        tip_angle=disk.tip_angles,
        tip_radius=radius,
        tip_recess=recess,
        contact_radius=radius - (recess if case.contact.sliding == "full" else whole),
        column=disk.blade_columns(modes.column),
        dampers=np.sqrt(case.shaft.dampings)[:, None] * centre,
        anisotropy=0.0 if case.shaft.clamped else case.shaft.anisotropy,
        by_velocity=by_velocity,
        circulation=(
            case.shaft.damping * disk.speed if case.shaft.damping_frame == "static" else 0.0
        ),
    )


def _by_velocity(case: Case, disk: BladedDiskModel, modes: Modes) -> FloatArray | None:
    """Return the matrix of Coriolis forces and damping on the modes at speed, (modes, modes).

    The damping is the modal damping of the structure at rest. None without Coriolis forces: the
    modes at speed then have modal damping.
    """
    structure, shapes = disk.structure, modes.shapes
    if structure.gyroscopic is None:
        return None
    skew = disk.speed * (shapes.T @ (structure.gyroscopic @ shapes))
    strained = shapes.T @ (structure.elastic @ shapes)
    damping = modal_damping(np.eye(modes.count), strained, case.damping.ratio).real
    damping = (damping + damping.T) / 2.0
    damping[np.abs(damping) < ROUNDING * np.abs(damping).max()] = 0.0
    return np.asarray((skew - skew.T) / 2.0 + damping)


def stiffness_of_blades(disk: BladedDiskModel) -> list[sp.csr_array]:
    """Return the stiffness of the beams of each blade on the free degrees of freedom."""
    mesh, model = disk.mesh, disk.model
    among = np.zeros(len(mesh.lines), dtype=np.bool_)
    among[mesh.line_sets.get(BLADES, [])] = True
    beams, found = BeamMatrices(model), []
    for tip in model.tips.tolist():
        weight = np.zeros((len(mesh.lines), 1))
        weight[chain_to(tip, mesh.lines, among).lines] = 1.0
        found.append(sp.csr_array(disk.expansion.T @ beams.stiffness(weight) @ disk.expansion))
    return found

"""The bladed disk of a case, linearised about the state in which it rotates steadily."""

from dataclasses import replace

import numpy as np
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.rotation.matrices import rotation_matrices


def speed_of_growth(disk: BladedDiskModel, gap: float | FloatArray) -> float:
    """Return the lowest speed of rotation at which the growth of a tip equals its gap [rad/s].

    Growth is assumed to be proportional to Omega^2, which is accurate to about 0.1 %. The speed is
    infinite if no tip grows.

    Args:
        disk: the bladed disk with the loads of its rotation.
        gap: gap of each tip [m], (blades,), or one value for all tips.
    """
    rate = disk.structure.growth[disk.tip_radial]
    squares = np.divide(gap, rate, out=np.full(len(rate), np.inf), where=rate > 0.0)
    return float(np.sqrt(squares.min()))


def tip_answer(disk: BladedDiskModel, axis: int, omega: float) -> FloatArray:
    """Return the radial displacement of each tip due to a steady unit force at the centre [m/N],
    (blades,).

    Args:
        disk: the bladed disk at any speed.
        axis: direction of the force in the rotating frame, 0 for x and 1 for y.
        omega: speed of rotation [rad/s].
    """
    force = np.zeros(disk.structure.size)
    force[disk.centre[axis]] = 1.0
    answer = spla.spsolve(disk.structure.still.stiffness_at(omega).tocsc(), force)
    return np.asarray(answer[disk.tip_radial])


def tip_recess(case: Case, disk: BladedDiskModel, omega: float | None = None) -> FloatArray:
    """Return the distance by which each tip lies inside the radius from which the clearance is
    measured [m], (blades,).

    For a hot clearance the tip radius is the radius at rest. For a cold clearance, that is, a
    clearance measured at rest, the tip radius includes the growth at speed.

    Args:
        case: case with the clearance.
        disk: bladed disk of the case at its speed.
        omega: speed of rotation [rad/s]; the speed of the case if None.
    """
    recess = disk.model.tip_recess
    return recess if case.rotation.clearance == "hot" else recess - disk.growth(omega)


def turning_disk(case: Case, at_rest: BladedDiskModel, reference: float) -> BladedDiskModel:
    """Return the bladed disk at the speed of a case; at rest if the case has no rotation effects.

    Args:
        case: case with the effects and the speed.
        at_rest: bladed disk of the case at rest.
        reference: reference frequency, for speeds that are given as multiples of it [rad/s].

    Raises:
        CaseError: the speed reaches the lowest critical speed, and there are no Coriolis forces.
    """
    effects = case.rotation.effects
    if effects == "none":
        return at_rest
    omega = case.march.speed.rad_per_s(reference)
    structure = rotation_matrices(at_rest)
    check_stable(case, structure, omega, reference)
    return replace(at_rest, structure=structure.at(omega, effects))


def check_stable(case: Case, structure: Structure, omega: float, reference: float) -> None:
    """Check that a bladed disk without Coriolis forces is stable at a speed omega [rad/s].

    Raises:
        CaseError: the speed reaches the lowest critical speed.
    """
    highest = np.inf
    if case.rotation.effects == "centrifugal":
        highest = lowest_critical_speed(structure)
    if abs(omega) >= highest:
        expected = (
            f"less than {highest / reference:.6g}, the critical speed; above it only Coriolis"
            ' forces (rotation.effects = "full") stabilise the bladed disk'
        )
        raise CaseError([case_fault(case, "march.speed", expected)])


def lowest_critical_speed(structure: Structure) -> float:
    """Return the lowest speed at which K_Omega is singular [rad/s]; infinite if there is none."""
    (share,) = spla.eigsh(
        -structure.known("stiffness_speed").tocsc(),
        k=1,
        M=structure.elastic.tocsc(),
        which="LA",
        return_eigenvectors=False,
        v0=np.random.default_rng(0).standard_normal(structure.size),
    )
    return float(1.0 / np.sqrt(share)) if share > 0.0 else np.inf

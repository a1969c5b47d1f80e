"""Loss of blades: the rotor that remains, in coordinates of its own.

The lost lines, masses and springs have no mass, stiffness and load any more. Coordinates of what
remains are its modes among the motions that the modes before leave to it: with the modes V of the
rotor before the loss, and the matrices K' and M' of what remains, they follow from V^T K' V and
V^T M' V. Combinations of modes that hardly move what remains are left out. Displacements and
velocities at the loss are therefore those of what remains, without projection onto other shapes;
the momentum and the energy of the lost part leave with it.

Displacements count from the static state u_s before the loss. What remains is not in equilibrium
there: it feels the load

    Omega^2 M'_t (X + u_s) - K' u_s,

the pull of the lost part with opposite sign, which contains the imbalance. Without rotation effects
u_s is proportional to Omega^2, and the growth of the other blades remains neglected.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.lost_part import BladedMesh, LossError, LostPart
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.elements.bladed_disk import BladedDiskModel, assemble_bladed_disk
from bladewhirl.models.elements.cyclic import NO_COLUMN
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.modal.modes import collect_modes
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.stage.beam_rotor import reduced_rotor
from bladewhirl.models.stage.contact_problem import ContactProblem, LostBlades
from bladewhirl.models.stage.excitations import excitation_loads, felt
from bladewhirl.models.stage.foreshortening import Foreshortening
from bladewhirl.models.stage.modal_loads import Load, Start
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.speed_change import (
    inertia_of,
    modes_at_speed,
    with_course,
    with_drive,
)
from bladewhirl.models.stage.stage import Stage
from bladewhirl.models.stage.varying_speed import SpeedChange

TableT = TypeVar("TableT", bound=Any)

MOVING = 1e-2
"""Smallest share of the kinetic energy of a combination of modes that what remains must have."""


def lost_part(case: Case, model: BeamModel) -> LostPart:
    """Return the nodes and lines of beams that are lost with the blades of a case.

    Raises:
        CaseError: the blade is not a chain of beams that is joined to the disk at its root only, or
            the fracture is at its tip.
    """
    loss = case.blade_loss
    assert loss is not None
    mesh = BladedMesh(
        points=model.mesh.points,
        lines=model.mesh.lines,
        parts=np.array(model.mesh.line_parts),
        joints=model.joints,
        tips=model.tips,
        centre=model.centre,
    )
    try:
        return mesh.lost_with(np.array(loss.blade), loss.share)
    except LossError as error:
        argument, expected = error.args
        key = {"blades": "blade_loss.blade", "share": "blade_loss.from"}[argument]
        raise CaseError([case_fault(case, key, expected)]) from None


def without_part(model: BeamModel, lost: LostPart) -> BeamModel:
    """Return a beam model without its lost lines, masses and springs; its nodes stay, with their
    numbers."""
    mesh, masses, springs = model.mesh, model.masses, model.springs
    lines = np.setdiff1d(np.arange(len(mesh.lines)), lost.lines)
    number = np.full(len(mesh.lines), -1)
    number[lines] = np.arange(len(lines))
    sets = {name: number[each] for name, each in mesh.line_sets.items()}
    weights = np.flatnonzero(~np.isin(masses.node, lost.nodes))
    held = np.isin(springs.node, lost.nodes) | np.isin(springs.other, lost.nodes)
    return replace(
        model,
        mesh=replace(
            mesh,
            lines=mesh.lines[lines],
            line_sets={name: each[each >= 0] for name, each in sets.items()},
            sectors=None,
        ),
        properties=_rows(model.properties, lines),
        masses=_rows(masses, weights),
        springs=_rows(springs, np.flatnonzero(~held)),
    )


def remaining_disk(case: Case, model: BeamModel, lost: LostPart) -> BladedDiskModel:
    """Return the bladed disk of a case without a lost part, at rest with the matrices of its
    rotation, on the degrees of freedom before the loss; those of lost nodes have no mass and no
    stiffness."""
    shaft = case.shaft
    disk = assemble_bladed_disk(
        without_part(model, lost),
        shaft_stiffness=shaft.stiffnesses,
        clamped=shaft.clamped,
    )
    structure = disk.structure
    gone = structure.node_dofs[lost.nodes].ravel()
    held = np.zeros(structure.size)
    held[gone[gone >= 0]] = 1.0  # any stiffness, for a static displacement of zero
    stiff = sp.csr_array(structure.stiffness + sp.diags_array(held))
    turning = rotation_matrices(replace(disk, structure=replace(structure, stiffness=stiff)))
    return replace(disk, structure=replace(turning, stiffness=structure.stiffness))


def beams_after_loss(
    stage: Stage, whole: BladedDiskModel, before: FloatArray, given: ContactProblem
) -> LostBlades:
    """Return the contact problem after the loss of blades of a stage of beams.

    Args:
        stage: stage with the case.
        whole: its bladed disk.
        before: fields of the modes before the loss on the free DoF [kg^-1/2], (size, modes).
        given: contact problem at `Stage.speed`.

    Raises:
        CaseError: the loss is not possible, see `lost_part`, or the time step is too long for what
            remains.
    """
    case, lost = stage.case, lost_part(stage.case, whole.model)
    assert case.blade_loss is not None
    disk = remaining_disk(case, whole.model, lost)
    structure = disk.structure.at(stage.speed, case.rotation.effects)
    inertia = before.T @ (structure.mass @ before)
    share, ways = la.eigh(0.5 * (inertia + inertia.T))
    moving = share > MOVING
    ways = ways[:, moving] / np.sqrt(share[moving])
    square, extension = la.eigh(ways.T @ (before.T @ (structure.stiffness @ before)) @ ways)
    extension = ways @ extension
    shapes = before @ extension
    modes = collect_modes(structure, square, shapes, np.full(len(square), NO_COLUMN))
    disk = replace(disk, structure=structure)
    rotor = reduced_rotor(case, disk, modes, given.rotor.tip_recess)
    blades = np.array(case.blade_loss.blade)
    away = np.linalg.norm(disk.mesh.points[lost.cuts], axis=1)
    reach = rotor.tip_radius - away + float(case.casing.clearance_profile.smallest)
    rotor = _without_tips(rotor, given, blades, reach)
    after = replace(
        given,
        rotor=rotor,
        loads=tuple(
            replace(load, rotor=extension.T @ load.rotor)
            for load in _loads_without(stage, given, blades)
        ),
        start=replace(
            given.start,
            rotor=np.zeros(len(square)),
            rotor_velocity=np.zeros(len(square)),
        ),
        foreshortening=_without_bending(given.foreshortening, extension, blades),
    )
    after = _released(stage, whole, structure, shapes, after)
    limit = after.critical_time_step
    if not case.march.time_step < limit:
        expected = (
            f"less than the critical step {limit:.6g} s of what remains after the loss of a blade"
        )
        raise CaseError([case_fault(case, "march.time_step", expected)])
    return LostBlades(
        time=case.blade_loss.time,
        after=after,
        restriction=extension.T @ inertia,
        extension=extension,
        tips=blades,
        reach=reach,
    )


def copies_after_loss(stage: Stage, given: ContactProblem) -> LostBlades:
    """Return the contact problem after the loss of blades that are copies of one structure.

    Each copy is clamped at its root and moves by itself, or with the others through a flexible
    casing. A lost copy goes as a whole: its modes have no motion, no load and no contact any more.
    The root is held, so that nothing feels the imbalance; other blades continue as they are.

    Args:
        stage: stage with the case.
        given: contact problem with the speed over time of the case.
    """
    loss, rotor = stage.case.blade_loss, given.rotor
    assert loss is not None
    remains = np.isin(np.arange(rotor.copies), loss.blade, invert=True)
    modes, nodes = rotor.tip_radial.shape[1], len(stage.blade)
    kept, tips = np.repeat(remains, modes), np.flatnonzero(np.repeat(~remains, nodes))
    clearance = float(stage.case.casing.clearance_profile.smallest)
    reach = rotor.tip_recess[tips] + stage.blade_length + clearance
    after = replace(
        given,
        rotor=replace(rotor, tip_recess=recess_without(given, tips, reach)),
        loads=tuple(replace(load, rotor=np.where(kept, load.rotor, 0.0)) for load in given.loads),
        start=Start.of_rotor(np.zeros(len(kept)), np.zeros(len(kept)), len(given.casing.frequency)),
    )
    staying = np.diag(kept.astype(np.float64))
    return LostBlades(
        time=loss.time, after=after, restriction=staying, extension=staying, tips=tips, reach=reach
    )


def loss_faults(case: Case) -> Iterator[Fault]:
    """Yield a fault if the loss of a blade is not within the march."""
    loss = case.blade_loss
    if loss is not None and not 0 < round(loss.time / case.march.time_step) < case.march.steps:
        step = case.march.time_step
        expected = f"a time within the march, from {step:g} s to below {case.march.duration:g} s"
        yield case_fault(case, "blade_loss.time", expected)


def _released(
    stage: Stage,
    disk: BladedDiskModel,
    remaining: Structure,
    shapes: FloatArray,
    after: ContactProblem,
) -> ContactProblem:
    """Return the contact problem of what remains with the loads that it feels without the pull of
    the lost part, and with the speed over time of the case."""
    case, stiffness = stage.case, remaining.elastic
    course = case.march.course(stage.reference_frequency)
    casing, square = np.zeros(len(after.casing.frequency)), after.speed**2
    if disk.rotates:
        grown = disk.structure.static_displacement(disk.speed)
        moved = remaining.displaced(grown)
        rotor = modes_at_speed(moved, after.rotor.stiffness, shapes)
        pull = square * rotor.loads[:, 0] - shapes.T @ (stiffness @ grown)
        after = replace(after, loads=(*after.loads, Load(rotor=felt(pull), casing=casing)))
        if course is None:
            return after
        return with_drive(case, with_course(after, course, rotor), inertia_of(case, moved))
    before = rotation_matrices(disk)
    swept = spla.spsolve(disk.structure.stiffness.tocsc(), before.euler_load)
    pull = shapes.T @ (remaining.centrifugal_load - stiffness @ before.growth)
    drag = shapes.T @ (remaining.euler_load - stiffness @ swept)
    along = Load(rotor=square * felt(pull), casing=casing)
    if course is None:
        return replace(after, loads=(*after.loads, along))
    along = replace(along, rotor=felt(pull), constant=square, by_square=1.0)
    across = Load(rotor=felt(drag), casing=casing, constant=0.0, by_acceleration=1.0)
    change = SpeedChange(course=course)
    after = replace(after, loads=(*after.loads, along, across), change=change)
    return with_drive(case, after, inertia_of(case, remaining))


def _loads_without(stage: Stage, given: ContactProblem, blades: IntArray) -> tuple[Load, ...]:
    """Return the loads of a contact problem without the engine-order forces on lost blades."""
    case, changed = stage.case, False
    loads = list(case.excitations.values())
    for place, load in enumerate(loads):
        if isinstance(load, EngineOrder):
            factors = np.array(load.factors or np.ones(case.blades))
            factors[blades] = 0.0
            loads[place] = load.model_copy(update={"factors": tuple(factors.tolist())})
            changed = True
    if not changed:
        return given.loads
    several = isinstance(case.excitation, tuple)
    excitation = tuple(loads) if several else loads[0]
    other = replace(stage, case=case.model_copy(update={"excitation": excitation}))
    kept = stage.kept
    return tuple(load.take(kept.rotor, kept.casing) for load in excitation_loads(other))


def _without_tips(
    rotor: ReducedRotor, given: ContactProblem, blades: IntArray, reach: FloatArray
) -> ReducedRotor:
    """Return a rotor whose lost tips do not move and cannot reach the wall."""
    contact = rotor.contact.copy()
    contact.reshape(len(rotor.tip_angle), -1)[blades] = 0.0
    return replace(
        rotor,
        contact=contact,
        tip_recess=recess_without(given, blades, reach),
    )


def recess_without(given: ContactProblem, tips: IntArray, reach: FloatArray) -> FloatArray:
    """Return the recess of all tips, of which lost ones cannot reach the wall [m], (tips,)."""
    recess = given.rotor.tip_recess.copy()
    recess[tips] += reach + 3.0 * given.displacement_limit
    return recess


def _without_bending(
    given: Foreshortening | None, extension: FloatArray, blades: IntArray
) -> Foreshortening | None:
    """Return the foreshortening of what remains."""
    if given is None:
        return None
    rows, sign = given.rows @ extension, given.sign.copy()
    rows[blades] = sign[blades] = 0.0
    return replace(given, rows=rows, sign=sign)


def _rows(table: TableT, chosen: IntArray) -> TableT:
    """Return a dataclass of arrays with the chosen rows."""
    return replace(table, **{name: each[chosen] for name, each in vars(table).items()})

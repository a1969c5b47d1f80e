"""Multipliers along a march of a periodic motion, whose contacts begin and end at fine instants."""

from dataclasses import replace

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.periodic.blade import DIRECTIONS, Grid
from bladewhirl.solvers.periodic.contact import Motion
from bladewhirl.solvers.periodic.stability import monodromy
from bladewhirl.studies.sweeps.starts import begun

INSTANTS = 4096  #: least number of time steps in a period of the wall
STEP = 0.7  #: longest time step, relative to the critical one
LIKE = 0.01  #: largest relative difference of the impulse of the march from that of the motion


def multipliers(problem: ContactProblem, motion: Motion, number: int) -> ComplexArray:
    """Return the multipliers of a periodic motion of a blade, the largest first, (2 * modes,).

    Deviations depend on the instants at which nodes open and close, more than the motion does. In a
    rigid wall a march over one period, from the state of the motion, gives its contact forces at
    fine instants, and the multipliers are those of the motion under these forces. In a flexible
    ring, or if the march leaves the motion within the period, they are those at the instants of the
    motion.

    Args:
        problem: contact problem of the stage.
        motion: motion of one of its blades.
        number: number of the blade.
    """
    blade = motion.grid.blade
    if blade.ring is None:
        finer = _marched(problem, motion, number)
        if finer is not None and abs(finer.impulse - motion.impulse) <= LIKE * motion.impulse:
            motion = finer
    return monodromy(motion).multipliers


def _marched(problem: ContactProblem, motion: Motion, number: int) -> Motion | None:
    """Return the contact forces of a march over the period of a motion; None if it diverged."""
    blade = motion.grid.blade
    alone = _alone(problem, number)
    displacement, velocity = motion.modes
    start = Start(
        rotor=displacement[0],
        rotor_velocity=velocity[0],
        casing=np.zeros(0),
        casing_velocity=np.zeros(0),
        contact_force=motion.force[0].reshape(-1, DIRECTIONS),
    )
    instants = INSTANTS << (blade.periods - 1).bit_length()
    while blade.period / instants > STEP * alone.critical_time_step:
        instants *= 2
    scheme = CentralDifference(begun(alone, start), blade.period / instants, 1)
    _, chunk, end = scheme.advance(scheme.init(), instants)
    if end is not None:
        return None
    force = chunk.contact_force.reshape(instants, -1, DIRECTIONS)
    normal = np.maximum(0.0, -force[..., 0])
    turned = 0.0 if blade.speed > 0.0 else np.pi
    angle = np.where(normal > 0.0, np.arctan2(-force[..., 2], -force[..., 1]), turned)
    return Motion(Grid(blade, instants), normal, angle)


def _alone(problem: ContactProblem, number: int) -> ContactProblem:
    """Return the problem of one of the blades of a stage in a rigid wall."""
    rotor = problem.rotor
    modes = len(rotor.frequency) // rotor.copies
    assert rotor.compliance is not None
    own = slice(number * modes, (number + 1) * modes)
    one: ReducedRotor = replace(
        rotor,
        frequency=rotor.frequency[own],
        damping_ratio=rotor.damping_ratio[own],
        centre=rotor.centre[:, own],
        tip_angle=rotor.by_copy(rotor.tip_angle)[number],
        tip_recess=rotor.by_copy(rotor.tip_recess)[number],
        column=rotor.column[own],
        dampers=rotor.dampers[:, own],
        copies=1,
        compliance=rotor.compliance[[number]],
    )
    loads = tuple(replace(load, rotor=load.rotor[own]) for load in problem.loads)
    start = replace(problem.start, rotor=np.zeros(modes), rotor_velocity=np.zeros(modes))
    # The cone turned the axes of contact nodes already; forces of the march are in these axes.
    return replace(problem, rotor=one, loads=loads, start=start, slope=0.0)

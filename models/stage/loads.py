"""Loads and initial state of a stage of beams in modal coordinates.

Loads on the rotor are in rotating axes, which coincide with the static axes at t = 0. Loads on the
casing are in static axes.
"""

from functools import partial

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.excitation import Imbalance
from bladewhirl.models.rotation.at_speed import tip_recess
from bladewhirl.models.stage.contact_problem import Load, ReducedRotor, Start
from bladewhirl.models.stage.engine_order import engine_order_forces
from bladewhirl.models.stage.excitations import LoadedStage, X, closing_unbalance, loads_on
from bladewhirl.models.stage.stage import Stage


def excitation_loads(stage: Stage) -> tuple[Load, ...]:
    """Return the loads of all excitations of a case; none if they are zero.

    Raises:
        CaseError: the casing has no radial mode of the required nodal diameter, or the forces have
            no place on the blades.
    """
    return loads_on(
        LoadedStage(
            case=stage.case,
            speed=stage.speed,
            varies=stage.case.march.varies,
            centre=stage.rotor.centre,
            rest=np.zeros(len(stage.rotor.frequency)),
            ring=stage,
            unbalance=partial(_unbalance, stage),
            forces_of_order=partial(engine_order_forces, stage),
        )
    )


def unbalance(stage: Stage) -> float:
    """Return the unbalance m e of an imbalance [kg m], or the sum if there are several.

    If ``clearance_speed`` is given, the unbalance is such that the static response to m e Omega^2
    at that speed just brings a tip to the casing where the clearance is smallest. With two equal
    springs at the centre and blades of equal length, this force is the stiffness times the
    clearance at rest. With rotation effects, blades also bend, and the stiffness at speed is used.

    Raises:
        ValueError: the case has no imbalance.
    """
    loads = [load for load in stage.case.excitations.values() if isinstance(load, Imbalance)]
    if not loads:
        raise ValueError('expected excitation.type = "imbalance"')
    return sum(_unbalance(stage, load) for load in loads)


def _unbalance(stage: Stage, load: Imbalance) -> float:
    if load.unbalance is not None:
        return load.unbalance
    assert load.clearance_speed is not None  # a case has unbalance or clearance_speed
    return unbalance_to_touch(stage, load.clearance_speed.rad_per_s(stage.reference_frequency))


def unbalance_to_touch(stage: Stage, speed: float) -> float:
    """Return the unbalance whose static response at a speed [rad/s] just brings a tip to the casing
    [kg m], see `closing_unbalance`."""
    rotor = stage.rotor
    if stage.turning is None:
        outward = rotor.tip_radial @ (rotor.centre[X] / rotor.frequency**2)
    else:
        outward = stage.turning.tip_answer(X, speed)
    recess = tip_recess(stage.case, stage.disk, stage.turning, speed)
    gap = stage.reduced_casing.clearance[:, 0].min() + recess
    return closing_unbalance(outward, gap, speed)


def imbalance_force(stage: Stage) -> float:
    """Return the force m e Omega^2 of an imbalance, along x of the rotating frame [N]."""
    return unbalance(stage) * stage.speed**2


def initial_state(stage: Stage) -> Start:
    """Return the initial state from the initial displacements and velocities of a case.

    The case gives displacements and velocities of tips and centre in rotating axes; the velocities
    are relative to these axes, without the transport velocity Omega x r. Between tips and centre,
    the bladed disk has its static shape: in Craig-Bampton coordinates every fixed-interface
    coordinate is zero. This is the field with the least strain energy for these values at tips and
    centre. The casing starts at rest.
    """
    initial = stage.case.initial
    values = (
        boundary_values(stage, initial.tip_displacement, initial.centre_displacement),
        boundary_values(stage, initial.tip_velocity, initial.centre_velocity),
    )
    rotor, velocity = (_static_shape(stage.rotor, each) for each in values)
    return Start.of_rotor(rotor, velocity, len(stage.reduced_casing.frequency))


def boundary_values(
    stage: Stage, tips: tuple[tuple[float, float], ...] | None, centre: tuple[float, float]
) -> FloatArray:
    """Return the values of the boundary DoF in one array: radial values of all tips, tangential
    values of all tips (zero if None), and x and y of the centre, (2 blades + 2,)."""
    blades = len(stage.rotor.tip_angle)
    radial, tangential = np.array(tips or [(0.0, 0.0)] * blades).T
    return np.concatenate([radial, tangential, centre])


def _static_shape(rotor: ReducedRotor, values: FloatArray) -> FloatArray:
    """Return the modal coordinates of least strain energy for a given motion of tips and centre;
    `values` are in the order of `boundary_values`."""
    rows = np.vstack([rotor.tip_radial, rotor.tip_tangential, rotor.centre])
    free = np.any(rows != 0.0, axis=1)  # a clamped centre has no coordinates
    flexible = rows[free] / rotor.stiffness
    forces = np.linalg.solve(flexible @ rows[free].T, values[free])
    return np.asarray(flexible.T @ forces)

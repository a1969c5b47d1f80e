"""Loads and initial state of a stage of beams in modal coordinates.

Loads on the rotor are in rotating axes, which coincide with the static axes at t = 0. Loads on the
casing are in static axes.
"""

from collections.abc import Iterable
from functools import partial

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import unit
from bladewhirl.models.case.excitation import Imbalance
from bladewhirl.models.rotation.at_speed import tip_answer, tip_recess
from bladewhirl.models.stage.contact_problem import Load, ReducedRotor, Start
from bladewhirl.models.stage.engine_order import engine_order_forces
from bladewhirl.models.stage.excitations import (
    LoadedStage,
    X,
    Y,
    closing_unbalance,
    direction,
    loads_on,
)
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
            blade_angle=stage.rotor.tip_angle,
            unbalance=partial(_unbalance, stage),
            forces_of_order=partial(engine_order_forces, stage),
        )
    )


def unbalance(stage: Stage) -> float:
    """Return the unbalance m e of an imbalance [kg m], or that of the sum of their forces if there
    are several.

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
    return float(np.hypot(*_unbalance_vector(stage, loads)))


def _unbalance_vector(stage: Stage, loads: Iterable[Imbalance]) -> FloatArray:
    """Return the sum of unbalances in rotating axes [kg m], (2,)."""
    angle = stage.rotor.tip_angle
    vectors = [_unbalance(stage, load) * direction(load, angle) for load in loads]
    return np.asarray(np.sum(vectors, axis=0))


def _unbalance(stage: Stage, load: Imbalance) -> float:
    size = load.size(stage.reference_frequency)
    if size is not None:
        return size
    assert load.clearance_speed is not None  # a case has one key for the unbalance
    speed = load.clearance_speed.rad_per_s(stage.reference_frequency)
    return unbalance_to_touch(stage, speed, direction(load, stage.rotor.tip_angle))


def unbalance_to_touch(stage: Stage, speed: float, along: FloatArray | None = None) -> float:
    """Return the unbalance whose static response at a speed [rad/s] just brings a tip to the casing
    [kg m], see `closing_unbalance`. Its direction (2,) is by default that of the imbalances of the
    case."""
    rotor = stage.rotor
    if along is None:
        loads = [load for load in stage.case.excitations.values() if isinstance(load, Imbalance)]
        along = unit(_unbalance_vector(stage, loads))
    if not stage.disk.rotates:
        outward = rotor.tip_radial @ ((along @ rotor.centre) / rotor.stiffness)
    else:
        outward = sum(along[axis] * tip_answer(stage.disk, axis, speed) for axis in (X, Y))
    recess = tip_recess(stage.case, stage.disk, speed)
    gap = stage.reduced_casing.clearance[:, 0].min() + recess
    return closing_unbalance(outward, gap, speed)


def imbalance_force(stage: Stage) -> float:
    """Return the force m e Omega^2 of the imbalances [N]."""
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

"""Loads and initial state in modal coordinates, from the excitation and initial motion of a case.

Loads on the rotor are in rotating axes, which coincide with the static axes at t = 0. Loads on the
casing are in static axes.
"""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import U, W
from bladewhirl.models.case.excitation import (
    CasingDistortion,
    EngineOrder,
    Excitation,
    Harmonic,
    Imbalance,
)
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.coupling.stage_modes import is_radial
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.rotation.at_speed import tip_recess
from bladewhirl.models.stage.contact_problem import Load, ReducedRotor, Start
from bladewhirl.models.stage.engine_order import engine_order_loads
from bladewhirl.models.stage.ring import Ring
from bladewhirl.models.stage.stage import Stage

X, Y = range(2)  #: positions of x and y in the motion of the centre


def excitation_loads(stage: Stage) -> tuple[Load, ...]:
    """Return the loads of all excitations of a case; none if they are zero.

    Raises:
        CaseError: the casing has no radial mode of the required nodal diameter.
    """
    return tuple(load for each in stage.case.excitations.values() for load in _loads(stage, each))


def _loads(stage: Stage, load: Excitation) -> tuple[Load, ...]:
    rotor, casing = stage.rotor, stage.reduced_casing
    if isinstance(load, CasingDistortion):
        return distortion_loads(stage, load, len(rotor.frequency))
    if isinstance(load, Imbalance | Harmonic):
        unbalance = _unbalance(stage, load) if isinstance(load, Imbalance) else 0.0
        return centre_loads(load, unbalance, rotor.centre, stage.speed, len(casing.frequency))
    if isinstance(load, EngineOrder):
        return engine_order_loads(stage, load)
    return ()


def radial_mode(stage: Ring, k: int, key: str = "excitation") -> int:
    """Return the number of the lowest casing mode whose radial displacement varies as +cos k theta;
    `key` is the dotted key of the excitation that needs the mode.

    Raises:
        CaseError: there is no such mode.
    """
    modes, nodal = stage.casing_modes, stage.reduced_casing.nodal
    wall = nodal[:, W]
    cosine = np.cos(k * stage.casing.mesh.angles) @ wall
    positions = np.flatnonzero(
        (modes.nodal_diameter == k)
        & is_radial(wall, nodal[:, U])
        & (np.abs(cosine) > 1e-6 * np.linalg.norm(wall, axis=0))  # not the sine mode of the pair
    )
    if not positions.size:
        expected = "a nodal diameter for which the casing has a radial mode"
        raise CaseError([case_fault(stage.case, f"{key}.nodal_diameter", expected)])
    return int(positions[0])


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
    return closing_unbalance(stage, load.clearance_speed.rad_per_s(stage.reference_frequency))


def closing_unbalance(stage: Stage, speed: float) -> float:
    """Return the unbalance whose static response just brings a tip to the casing [kg m].

    Args:
        stage: the stage.
        speed: speed of rotation [rad/s].

    Returns:
        the unbalance, infinite if no unbalance brings a tip to the casing.
    """
    rotor = stage.rotor
    if stage.turning is None:
        outward = rotor.tip_radial @ (rotor.centre[X] / rotor.frequency**2)
    else:
        outward = stage.turning.tip_answer(X, speed)
    recess = tip_recess(stage.case, stage.disk, stage.turning, speed)
    smallest_gap = stage.reduced_casing.clearance[:, 0].min() + recess
    reaching = outward > 0.0
    if not reaching.any() or speed == 0.0:
        return float("inf")
    return float((smallest_gap[reaching] / outward[reaching]).min() / speed**2)


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


def distortion_loads(stage: Ring, load: CasingDistortion, rotor_modes: int) -> tuple[Load, ...]:
    """Return the loads of a casing distortion.

    Args:
        stage: the stage, or its flexible casing.
        load: the excitation.
        rotor_modes: number of modes of the rotor.

    Raises:
        CaseError: the casing has no radial mode of the required nodal diameter.
    """
    pattern = np.zeros(len(stage.reduced_casing.frequency))
    mode = radial_mode(stage, load.nodal_diameter, stage.case.key_of(load))
    pattern[mode] = load.modal_force
    still = np.zeros(rotor_modes)
    if load.duration == 0.0:
        return ()
    if load.shape == "rectangular":
        return (Load(rotor=still, casing=pattern, end=load.duration),)
    half_turn = np.pi / load.duration  # sin(pi t / T) is a cosine with the phase -pi / 2
    return (
        Load(
            rotor=still, casing=pattern, end=load.duration, frequency=half_turn, phase=-np.pi / 2.0
        ),
    )


def centre_loads(
    load: Harmonic | Imbalance,
    unbalance: float,
    centre: FloatArray,
    speed: float,
    casing_modes: int,
) -> tuple[Load, ...]:
    """Return the loads of a harmonic force or of an imbalance at the centre.

    A force F cos(omega t) along the static x axis is F cos(omega t) (cos Omega t, -sin Omega t) in
    rotating axes. Along each rotating axis this is the sum of two cosines of amplitude F / 2 with
    the frequencies Omega + omega and Omega - omega; along y their phase is pi / 2.

    Args:
        load: the excitation.
        unbalance: unbalance m e of an imbalance [kg m].
        centre: x and y of the centre for unit modal coordinates [kg^-1/2], (2, rotor modes).
        speed: speed of rotation [rad/s].
        casing_modes: number of modes of the casing.
    """
    still = np.zeros(casing_modes)
    if isinstance(load, Imbalance):
        force = unbalance * speed**2
        return (Load(rotor=force * centre[X], casing=still, ramp=load.ramp),)
    omega = 2.0 * np.pi * load.frequency
    if load.frame == "rotating":
        return (Load(rotor=load.force * centre[X], casing=still, frequency=omega),)
    return tuple(
        Load(
            rotor=0.5 * load.force * centre[axis], casing=still, frequency=speed + beat, phase=phase
        )
        for beat in (omega, -omega)
        for axis, phase in ((X, 0.0), (Y, np.pi / 2.0))
    )

"""Loads and start of a march in modes, from the case's excitation and initial values.

Rotor loads are in rotating axes, which lie on the static ones at t = 0; casing loads in static
axes.
"""

from __future__ import annotations

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.ring_mesh import U, W
from bladewhirl.models.case.excitation import CasingDistortion, Harmonic, Imbalance
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.coupling.stage_modes import is_radial
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.rotation.at_speed import tip_recess
from bladewhirl.models.stage.contact_problem import Load, ReducedRotor, Start
from bladewhirl.models.stage.stage import Stage

X, Y = range(2)
"""Axes of the centre."""


def excitation_loads(stage: Stage) -> tuple[Load, ...]:
    """Loads of the case's excitation; none where it is zero.

    Raises:
        CaseError: the casing has no radial mode of the nodal diameter asked for.
    """
    load = stage.case.excitation
    if isinstance(load, CasingDistortion):
        return _distortion(stage, load)
    if isinstance(load, Imbalance):
        return (_at_centre(stage, X, imbalance_force(stage), ramp=load.ramp),)
    if isinstance(load, Harmonic):
        return _harmonic(stage, load)
    return ()


def radial_mode(stage: Stage, k: int) -> int:
    """Number of the lowest radial casing mode w = +cos k theta.

    Raises:
        CaseError: there is none.
    """
    modes, nodal = stage.casing_modes, stage.reduced_casing.nodal
    wall = nodal[:, W]
    cosine = np.cos(k * stage.casing.mesh.angles) @ wall
    positions = np.flatnonzero(
        (modes.nodal_diameter == k)
        & is_radial(wall, nodal[:, U])
        & (np.abs(cosine) > 1e-6 * np.linalg.norm(wall, axis=0))  # not the sine of the pair
    )
    if not positions.size:
        expected = "a nodal diameter for which the casing has a radial mode"
        raise CaseError([case_fault(stage.case, "excitation.nodal_diameter", expected)])
    return int(positions[0])


def unbalance(stage: Stage) -> float:
    """Unbalance m e of an imbalance [kg m].

    Where ``clearance_speed`` is given, the static answer to m e Omega^2 at that speed just brings
    a tip to the casing where its clearance is smallest. Where the centre stands on two equal
    springs and all blades are of one length, that force is stiffness times clearance at rest; with
    rotation effects tips also bend, and the stiffness is that at the speed given.

    Raises:
        ValueError: the case's excitation is no imbalance.
    """
    load = stage.case.excitation
    if not isinstance(load, Imbalance):
        raise ValueError(f'expected excitation.type = "imbalance"; got "{load.type}"')
    if load.unbalance is not None:
        return load.unbalance
    assert load.clearance_speed is not None  # the case has one of the two
    return closing_unbalance(stage, load.clearance_speed.rad_per_s(stage.reference_frequency))


def closing_unbalance(stage: Stage, speed: float) -> float:
    """Unbalance whose static answer just brings a tip to the casing [kg m]; infinite if none does.

    Args:
        stage: see `unbalance`.
        speed: [rad/s].
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
    """Force m e Omega^2 of an imbalance, along blade 0 [N]."""
    return unbalance(stage) * stage.speed**2


def initial_state(stage: Stage) -> Start:
    """Start of a march from the case's initial displacements and velocities.

    They are those of tips and centre in rotating axes, velocities as seen in these axes (the
    transport velocity Omega x r is no part of them). Between tips and centre the bladed disk
    starts in its static shape: in Craig-Bampton coordinates the boundary is as given and every
    fixed-interface coordinate is zero. Of all fields with these boundary values it is the one of
    least strain energy. The casing starts at rest.
    """
    initial, rotor = stage.case.initial, stage.rotor
    still = np.zeros(len(stage.reduced_casing.frequency))
    return Start(
        rotor=_static_shape(
            rotor, boundary_values(stage, initial.tip_displacement, initial.centre_displacement)
        ),
        rotor_velocity=_static_shape(
            rotor, boundary_values(stage, initial.tip_velocity, initial.centre_velocity)
        ),
        casing=still,
        casing_velocity=still,
    )


def boundary_values(
    stage: Stage,
    tips: tuple[tuple[float, float], ...] | None,
    centre: tuple[float, float],
) -> FloatArray:
    """Values of tips (radial, tangential; zero when None) and centre, one after the other."""
    blades = len(stage.rotor.tip_angle)
    radial, tangential = np.array(tips or [(0.0, 0.0)] * blades).T
    return np.concatenate([radial, tangential, centre])


def _static_shape(rotor: ReducedRotor, values: FloatArray) -> FloatArray:
    """Return the modal coordinates of least strain energy for a displacement of the boundary."""
    rows = np.vstack([rotor.tip_radial, rotor.tip_tangential, rotor.centre])
    free = np.any(rows != 0.0, axis=1)  # a clamped centre has no coordinates
    flexible = rows[free] / rotor.stiffness
    forces = np.linalg.solve(flexible @ rows[free].T, values[free])
    return np.asarray(flexible.T @ forces)


def _distortion(stage: Stage, load: CasingDistortion) -> tuple[Load, ...]:
    pattern = np.zeros(len(stage.reduced_casing.frequency))
    pattern[radial_mode(stage, load.nodal_diameter)] = load.modal_force
    still = np.zeros(len(stage.rotor.frequency))
    if load.duration == 0.0:
        return ()
    if load.shape == "rectangular":
        return (Load(rotor=still, casing=pattern, end=load.duration),)
    half_turn = np.pi / load.duration  # sin(pi t / T) is a cosine, a quarter turn late
    return (
        Load(
            rotor=still,
            casing=pattern,
            end=load.duration,
            frequency=half_turn,
            phase=-np.pi / 2.0,
        ),
    )


def _harmonic(stage: Stage, load: Harmonic) -> tuple[Load, ...]:
    """A force along x of a frame.

    A force F cos(omega t) along the static x axis is F cos(omega t) (cos Omega t, -sin Omega t) in
    rotating axes: in each axis two cosines of half the size, with Omega + omega and Omega - omega,
    those along y a quarter turn ahead.
    """
    omega = 2.0 * np.pi * load.frequency
    if load.frame == "rotating":
        return (_at_centre(stage, X, load.force, frequency=omega),)
    return tuple(
        _at_centre(stage, axis, 0.5 * load.force, frequency=stage.speed + beat, phase=phase)
        for beat in (omega, -omega)
        for axis, phase in ((X, 0.0), (Y, np.pi / 2.0))
    )


def _at_centre(
    stage: Stage,
    axis: int,
    force: float,
    *,
    ramp: float = 0.0,
    frequency: float = 0.0,
    phase: float = 0.0,
) -> Load:
    return Load(
        rotor=force * stage.rotor.centre[axis],
        casing=np.zeros(len(stage.reduced_casing.frequency)),
        ramp=ramp,
        frequency=frequency,
        phase=phase,
    )

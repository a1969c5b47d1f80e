"""Modal forces of each excitation of a case, on any kind of stage.

Loads on the rotor are in rotating axes, which coincide with the static axes at t = 0. Loads on the
casing are in static axes. An excitation is a class in `models/case/excitation.py` and a function
here, which is registered for this class.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import singledispatch

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
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
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.models.stage.ring import Ring
from bladewhirl.models.stage.stage import Stage

ROUNDING = 1e-12
"""A modal force up to this fraction of the largest counts as zero."""

X, Y = range(2)
"""Positions of x and y in the motion of the centre."""


def direction(load: Imbalance, blade_angle: FloatArray) -> FloatArray:
    """Return the direction of an imbalance in rotating axes (2,).

    Args:
        load: the imbalance.
        blade_angle: angle of each blade at t = 0 [rad], (blades,).
    """
    angle = load.phase + (0.0 if load.blade is None else blade_angle[load.blade])
    return np.array([np.cos(angle), np.sin(angle)])


def excitation_loads(stage: Stage) -> tuple[Load, ...]:
    """Return the loads of all excitations of a case, on all modes of a stage; none if they are
    zero.

    Raises:
        CaseError: the casing has no radial mode of the required nodal diameter, or the forces have
            no place on the blades.
    """
    excitations: Iterable[Excitation] = stage.case.excitations.values()
    return tuple(load for each in excitations for load in modal_loads(each, stage))


@singledispatch
def modal_loads(load: object, stage: Stage) -> tuple[Load, ...]:
    """Return the loads of an excitation; none if it is zero."""
    return ()


@modal_loads.register
def _(load: CasingDistortion, stage: Stage) -> tuple[Load, ...]:
    """Return the loads of a casing distortion.

    Raises:
        CaseError: the casing has no radial mode of the required nodal diameter.
    """
    pattern, still = stage.casing_rest, stage.rotor_rest
    mode = radial_mode(stage, load.nodal_diameter, stage.case.key_of(load))
    pattern[mode] = load.modal_force
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


@modal_loads.register
def _(load: Imbalance, stage: Stage) -> tuple[Load, ...]:
    """Return the loads of an imbalance at the centre, which is fixed in rotating axes: the inertia
    force of a mass. If the speed varies, it has a part across its direction due to the
    acceleration."""
    size = unbalance_of(load, stage)
    force = size * stage.speed**2
    along = direction(load, stage.blade_angle.ravel())
    aside = np.array([-along[Y], along[X]])
    steady = Load(
        rotor=force * (along @ stage.rotor.centre), casing=stage.casing_rest, ramp=load.ramp
    )
    if not stage.case.march.varies or force == 0.0:
        return (steady,)
    across = replace(
        steady,
        rotor=felt(size * (aside @ stage.rotor.centre)),
        constant=0.0,
        by_acceleration=-1.0,
    )
    return replace(steady, by_square=1.0 / stage.speed**2), across


@modal_loads.register
def _(load: Harmonic, stage: Stage) -> tuple[Load, ...]:
    """Return the loads of a harmonic force.

    A force F cos(omega t) along the static x axis is F cos(omega t) (cos Omega t, -sin Omega t) in
    rotating axes. Along each rotating axis this is the sum of two cosines of amplitude F / 2 with
    the frequencies Omega + omega and Omega - omega; along y their phase is pi / 2.
    """
    still, omega, rows = stage.casing_rest, 2.0 * np.pi * load.frequency, stage.pushed(load)
    if load.frame == "rotating":
        return (Load(rotor=load.force * rows[X], casing=still, frequency=omega),)
    return tuple(
        Load(
            rotor=0.5 * load.force * rows[axis],
            casing=still,
            frequency=beat if stage.case.march.varies else stage.speed + beat,
            order=float(stage.case.march.varies),
            phase=phase,
        )
        for beat in (omega, -omega)
        for axis, phase in ((X, 0.0), (Y, np.pi / 2.0))
    )


@modal_loads.register
def _(load: EngineOrder, stage: Stage) -> tuple[Load, ...]:
    """Return the loads of engine-order forces, two for each order r: the force Re(f exp(i r Omega
    t)) is Re f times cos(r Omega t), and minus Im f times sin(r Omega t)."""
    loads = [
        Load(
            rotor=pattern,
            casing=stage.casing_rest,
            ramp=load.ramp,
            frequency=0.0 if stage.case.march.varies else order * stage.speed,
            order=float(order * stage.case.march.varies),
            phase=phase,
        )
        for order, force in forces_of_order(load, stage)
        for pattern, phase in ((force.real, 0.0), (force.imag, 0.5 * np.pi))
    ]
    return tuple(loads[:1] if load.order == (0,) else loads)


def felt(force: FloatArray) -> FloatArray:
    """Return modal forces without those on modes that feel the load only by rounding."""
    return np.where(np.abs(force) > ROUNDING * np.abs(force).max(initial=0.0), force, 0.0)


def forces_of_order(load: EngineOrder, stage: Stage) -> list[tuple[int, ComplexArray]]:
    """Return for each engine order r the complex modal forces on the bladed disk for the time
    factor exp(i r Omega t) [kg^1/2 m/s2], (modes,)."""
    return by_order(load, stage.unit_forces(load), stage.blade_angle)


def left_out(load: EngineOrder, stage: Stage) -> dict[int, ComplexArray]:
    """Return for each engine order r the complex displacements of the contact nodes by the modes
    that are left out, radial, tangential and axial, see `forces_of_order` [m], (3 * nodes,)."""
    answer = stage.static_answer(load)
    if answer is None:
        return {}
    copies = np.asarray(stage.factor)[:, None]
    return {
        order: (flat.reshape(len(copies), -1) / copies).ravel()
        for order, flat in by_order(load, answer, stage.blade_angle)
    }


def by_order(
    load: EngineOrder, acting: FloatArray, angle: FloatArray
) -> list[tuple[int, ComplexArray]]:
    """Return for each engine order r the complex answers of all copies to its forces.

    The force on the blade at the angle theta is F cos(r (Omega t + theta) + phase).

    Args:
        load: the excitation.
        acting: answer of a copy to a unit force on each of its blades, (blades, values).
        angle: angle of each blade at t = 0 [rad], (copies, blades of a copy).
    """
    factors = np.broadcast_to(np.asarray(load.factors or 1.0), angle.size).reshape(angle.shape)
    phases = np.broadcast_to(np.asarray(load.phase), angle.size).reshape(angle.shape)
    forces = (
        (order, load.amplitude * factors * np.exp(1j * (order * angle + phases)))
        for order in load.order
    )
    return [(order, (force @ acting).ravel()) for order, force in forces]


def unbalance_of(load: Imbalance, stage: Stage) -> float:
    """Return the unbalance m e of an imbalance [kg m].

    If ``clearance_speed`` is given, the static response to m e Omega^2 at that speed just brings a
    tip to the casing where the clearance is smallest. With two equal springs at the centre and
    blades of equal length, this force is the stiffness times the clearance at rest. With rotation
    effects, blades of beams also bend, and the stiffness at speed is used.
    """
    size = load.size(stage.reference_frequency)
    if size is not None:
        return size
    assert load.clearance_speed is not None  # a case has one key for the unbalance
    speed = load.clearance_speed.rad_per_s(stage.reference_frequency)
    return unbalance_to_touch(stage, speed, direction(load, stage.blade_angle.ravel()))


def unbalance_to_touch(stage: Stage, speed: float, along: FloatArray) -> float:
    """Return the unbalance in a direction (2,) whose static response at a speed [rad/s] just brings
    a tip to the casing [kg m], see `closing_unbalance`."""
    gap = stage.reduced_casing.clearance[:, 0].min() + stage.recess_at(speed)
    return closing_unbalance(stage.answer(along, speed), gap, speed)


def closing_unbalance(outward: FloatArray, gap: FloatArray, speed: float) -> float:
    """Return the unbalance whose static response just brings a tip to the casing [kg m], infinite
    if no unbalance does.

    Args:
        outward: static radial displacement of each tip per force along x at the centre [m/N],
            (tips,).
        gap: smallest gap of each tip around the casing [m], (tips,).
        speed: speed of rotation [rad/s].
    """
    reaching = outward > 0.0
    if not reaching.any() or speed == 0.0:
        return float("inf")
    return float((gap[reaching] / outward[reaching]).min() / speed**2)


def radial_mode(stage: Ring, k: int, key: str = "excitation") -> int:
    """Return the number of the lowest casing mode whose radial displacement varies as +cos k theta;
    `key` is the dotted key of the excitation that needs the mode.

    Raises:
        CaseError: there is no such mode.
    """
    modes = stage.casing_modes  # those of further rings and masses of supports follow them
    nodal = stage.casing.nodal(modes.fields(np.arange(modes.count)))
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

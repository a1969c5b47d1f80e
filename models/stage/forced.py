"""Linear equations of a bladed disk under engine-order forces at any speed of rotation, without
contact; they are those of the time integration."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.mode_names import ALL
from bladewhirl.models.stage.excitations import forces_of_order, left_out
from bladewhirl.models.stage.loads import blade_means
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.stage import Stage

EngineOrders = Sequence[EngineOrder]
"""Excitations of engine order."""


class Resonances(NamedTuple):
    """Eigenvectors of the Hermitian dynamic stiffness K - w^2 + i w G of each copy at w = r Omega.

    One eigenvalue passes through zero at each resonance of the engine order r.
    """

    value: FloatArray  #: eigenvalues [rad2/s2], ascending, (copies, modes)
    loss: FloatArray  #: damping w d of each eigenvector [rad2/s2], (copies, modes)
    drive: FloatArray  #: amplitude of a tip times the loss if in resonance [m rad2/s2]


@dataclass(frozen=True, kw_only=True)
class ForcedRotor:
    """A bladed disk at a speed of rotation, with the forces of engine orders."""

    rotor: ReducedRotor
    forces: Mapping[int, ComplexArray]
    """Complex modal forces of each engine order r for the time factor exp(i r Omega t)
    [kg^1/2 m/s2], (modes,)."""
    tips: FloatArray
    """Matrix from displacements of the contact nodes of a copy to those of its blade tips, (blades
    of a copy, nodes)."""
    static: Mapping[int, ComplexArray] = field(default_factory=dict)
    """Complex displacements of the contact nodes of each copy, radial, tangential and axial, due to
    the modes that are left out, by engine order [m], (copies, 3 * nodes)."""
    has_centre: bool = True  #: false if the bladed disk has no node at its centre

    def motion(self, order: int, omega: float) -> dict[str, ComplexArray]:
        """Return the complex displacements for an engine order at the speed omega [rad/s]:
        tip_tangential and tip_radial [m], (blades,), and, if there is one, centre [m], (2,)."""
        rotor, answers = self.rotor, self.response(order, omega)
        rows = rotor.tip_tangential, rotor.tip_radial
        moved = np.stack([answers @ row.T for row in rows])  # (2, copies, nodes)
        if order in self.static:
            moved = moved + np.stack([self.static[order][:, k::3] for k in (1, 0)])
        tangential, radial = (moved @ self.tips.T).reshape(2, -1)
        motion = {"tip_tangential": tangential, "tip_radial": radial}
        if self.has_centre:
            motion["centre"] = rotor.centre @ answers[0]
        return motion

    def response(self, order: int, omega: float) -> ComplexArray:
        """Return the complex modal amplitudes of an engine order at the speed omega [rad/s],
        (copies, modes)."""
        w = order * omega
        return np.stack(
            [
                np.linalg.solve(elastic - w**2 * np.eye(len(elastic)) + 1j * w * damping, force)
                for elastic, damping, force in self._copies(order)
            ]
        )

    def resonances(self, order: int, omega: float) -> Resonances:
        """Return what tells the resonances of an engine order near the speed omega [rad/s]."""
        w, rotor = order * omega, self.rotor
        rows = np.vstack([rotor.tip_tangential, rotor.tip_radial])
        found = []
        for elastic, damping, force in self._copies(order):
            skew = 0.5 * (damping - damping.T)
            dynamic = elastic - w**2 * np.eye(len(elastic))
            if skew.any() or np.count_nonzero(elastic) > len(elastic):
                values, vectors = np.linalg.eigh(0.5 * (dynamic + dynamic.T) + 1j * w * skew)
            else:
                values, vectors = np.diag(dynamic), np.eye(len(elastic))
            lost = np.einsum("im,im->m", vectors.conj(), damping @ vectors).real
            reached = np.abs(vectors.conj().T @ force) * np.abs(rows @ vectors).max(axis=0)
            ascending = np.argsort(values, kind="stable")
            found.append((values[ascending], w * lost[ascending], reached[ascending]))
        return Resonances(*(np.array(each) for each in zip(*found, strict=True)))

    def _copies(self, order: int) -> Iterator[tuple[FloatArray, FloatArray, ComplexArray]]:
        """Yield stiffness [1/s2] and matrix of the forces due to velocities [1/s], (modes, modes),
        and the complex modal forces, (modes,), of each copy."""
        rotor = self.rotor
        for squares, damping, force in zip(
            rotor.by_copy(rotor.stiffness),
            rotor.velocity_forces,
            self.forces[order].reshape(rotor.copies, -1),
            strict=True,
        ):
            stiffness = np.diag(squares)
            if rotor.circulation:  # only of a rotor of one copy
                stiffness = stiffness + rotor.circulation_stiffness
            yield stiffness, damping, force


def forced(stage: Stage, loads: EngineOrders, omegas: Sequence[float]) -> Iterator[ForcedRotor]:
    """Yield a bladed disk under engine-order forces at each speed [rad/s].

    Raises:
        CaseError: a speed reaches the lowest critical speed, and there are no Coriolis forces.
        UserError: the equations depend on time, or the case selects modes.
    """
    check_forced(stage)
    stage.check_speed(max(omegas, key=abs))
    made = forced_rotor(stage, loads)
    if (diameters := _diameters(loads, stage.blade_angle.size)) is not None:
        stage = stage.of_diameters(diameters)
    for omega in omegas:
        own = stage.at(omega)
        if own is not stage:  # the bladed disk depends on the speed
            made = forced_rotor(own, loads)
        yield made


def _diameters(loads: EngineOrders, blades: int) -> set[int] | None:
    """Return the nodal diameters of the forces on equal blades; None if the forces differ."""
    if any(load.factors or np.ndim(load.phase) for load in loads):
        return None
    return {min(order % blades, -order % blades) for order in orders_of(loads)}


def forced_rotor(stage: Stage, loads: EngineOrders) -> ForcedRotor:
    """Return a bladed disk under engine-order forces at the speed of the stage."""
    forces, static = dict[int, ComplexArray](), dict[int, ComplexArray]()
    for load in loads:
        for order, force in forces_of_order(load, stage):
            forces[order] = forces.get(order, 0.0) + force
        for order, moved in left_out(load, stage).items():
            static[order] = static.get(order, 0.0) + moved.reshape(stage.rotor.copies, -1)
    return ForcedRotor(
        rotor=stage.rotor,
        forces=forces,
        tips=_tip_means(stage),
        static=static,
        has_centre=stage.has_centre,
    )


def _tip_means(stage: Stage) -> FloatArray:
    """Return `ForcedRotor.tips`: nodes of joints are not at the tips, unless all nodes are."""
    every = np.arange(len(stage.blade))
    tips = np.setdiff1d(every, stage.rotor.joined)
    tips = tips if len(tips) else every
    means = np.zeros((int(stage.blade.max()) + 1, len(every)))
    means[:, tips] = blade_means(stage.blade[tips])
    return means


def check_forced(stage: Stage) -> None:
    """Check that linear equations under engine-order forces do not depend on time.

    Raises:
        UserError: they do, or the case selects modes.
    """
    if stage.rotor.anisotropy:
        raise UserError("response: expected equal shaft springs")
    if stage.case.coupling.stiffness:
        raise UserError("response: not allowed with springs between bladed disk and casing")
    if (modes := stage.case.reduction.modes) != ALL:
        raise UserError(f'reduction.modes = "{modes}": expected "{ALL}"')


def orders_of(loads: Iterable[EngineOrder]) -> list[int]:
    """Return the engine orders of all excitations, each once, in the order of the case."""
    return list(dict.fromkeys(order for load in loads for order in load.order))

"""Linear equations of a bladed disk under engine-order forces at any speed of rotation, without
contact; they are those of the time integration."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.mode_names import ALL
from bladewhirl.models.rotation.at_speed import check_stable
from bladewhirl.models.stage.contact_problem import ReducedRotor
from bladewhirl.models.stage.engine_order import complex_factors, unit_forces
from bladewhirl.models.stage.stage import Stage, rotor_at
from bladewhirl.models.stage.superelement_loads import blade_means
from bladewhirl.models.stage.superelement_stage import SuperelementStage, superelement_stage

EngineOrders = Sequence[EngineOrder]
"""Excitations of engine order."""


@dataclass(frozen=True, kw_only=True)
class ForcedRotor:
    """A bladed disk at a speed of rotation, with the forces of engine orders."""

    rotor: ReducedRotor
    forces: Mapping[int, ComplexArray]
    """Complex modal forces of each engine order r for the time factor exp(i r Omega t)
    [kg^1/2 m/s2], (modes,)."""
    tips: FloatArray | None = None
    """Matrix from displacements of the contact nodes of a copy to those of its blade tips, (blades
    of a copy, nodes); None if each blade has one tip."""
    has_centre: bool = True  #: false if the bladed disk has no node at its centre

    @property
    def blades(self) -> FloatArray:
        """Tangential and radial displacements of the blade tips of a copy for unit modal
        coordinates [kg^-1/2], (2, blades of a copy, modes)."""
        rows = np.stack([self.rotor.tip_tangential, self.rotor.tip_radial])
        return rows if self.tips is None else np.asarray(self.tips @ rows)

    def response(self, order: int, omega: float) -> ComplexArray:
        """Return the complex modal amplitudes of an engine order at the speed omega [rad/s],
        (copies, modes)."""
        rotor, w = self.rotor, order * omega
        copies = zip(
            rotor.by_copy(rotor.stiffness),
            rotor.velocity_forces,
            self.forces[order].reshape(rotor.copies, -1),
            strict=True,
        )
        answers = []
        for squares, damping, force in copies:
            stiffness = np.diag(squares)
            if rotor.circulation:  # only of a rotor of one copy
                stiffness = stiffness + rotor.circulation_stiffness
            dynamic = stiffness - w**2 * np.eye(len(squares)) + 1j * w * damping
            answers.append(np.linalg.solve(dynamic, force))
        return np.stack(answers)


def forced_beams(
    stage: Stage, loads: EngineOrders, omegas: Sequence[float]
) -> Iterator[ForcedRotor]:
    """Yield the equations of beams at each speed [rad/s].

    Raises:
        CaseError: a speed reaches the lowest critical speed, and there are no Coriolis forces.
        UserError: the equations depend on time, or the case selects modes.
    """
    case, disk = stage.case, stage.disk
    if stage.rotor.anisotropy:
        raise UserError("response: expected equal shaft springs")
    if stage.kept.springs is not None:
        raise UserError("response: not allowed with springs between bladed disk and casing")
    if case.reduction.modes != ALL:
        raise UserError(f'reduction.modes = "{case.reduction.modes}": expected "{ALL}"')
    if stage.turning is not None:
        fastest = max(omegas, key=abs)
        at_speed = {"march.speed": fastest / stage.reference_frequency}
        own = with_values(case, at_speed)
        check_stable(own, stage.turning.matrices, fastest, stage.reference_frequency)
    units = [(load, unit_forces(case, disk, load)) for load in loads]
    for omega in omegas:
        rotor, shapes = rotor_at(stage, omega)
        modal = [(load, unit @ shapes) for load, unit in units]
        forces = {
            order: np.asarray(
                sum(
                    load.amplitude * complex_factors(disk, load, order) @ unit
                    for load, unit in modal
                    if order in load.order
                )
            )
            for order in orders_of(loads)
        }
        yield ForcedRotor(rotor=rotor, forces=forces)


def forced_superelement(
    stage: SuperelementStage, loads: EngineOrders, omegas: Sequence[float]
) -> Iterator[ForcedRotor]:
    """Yield the equations of a superelement at each speed [rad/s].

    Raises:
        CaseError: a speed reaches the lowest critical speed.
        UserError: the equations depend on time.
    """
    reference = stage.reference_frequency
    if stage.rotor_at(stage.speed).anisotropy:
        raise UserError("response: expected equal shaft springs")
    if stage.case.coupling.stiffness:
        raise UserError("response: not allowed with springs between bladed disk and casing")
    for omega in omegas:
        if stage.case.rotation.effects != "none":
            at_speed = {"march.speed": omega / reference}
            stage = superelement_stage(with_values(stage.case, at_speed))
        forces: dict[int, ComplexArray] = {}
        for load in loads:
            for order, force in stage.forces_of_order(load):
                forces[order] = forces.get(order, 0.0) + force
        yield ForcedRotor(
            rotor=stage.rotor_at(omega),
            forces=forces,
            tips=blade_means(stage.blade),
            has_centre=stage.part.centre_dofs is not None,
        )


def orders_of(loads: Iterable[EngineOrder]) -> list[int]:
    """Return the engine orders of all excitations, each once, in the order of the case."""
    return list(dict.fromkeys(order for load in loads for order in load.order))

"""Stiffness of each blade on the modes of a tuned bladed disk, for many patterns of mistuning."""

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.forced import EngineOrders, ForcedRotor, check_forced, forced_rotor
from bladewhirl.models.stage.stage import BladeStiffness, Stage


@dataclass(frozen=True, kw_only=True)
class TunedRotor(BladeStiffness):
    """A tuned bladed disk at a speed of rotation under engine-order forces, and its blades."""

    omega: float  #: speed [rad/s]
    disk: ForcedRotor  #: modes and forces
    damping_ratio: float  #: damping ratio of the modes of the stiffness `damped`

    @property
    def damped(self) -> FloatArray:
        """Stiffness whose modes have modal damping [1/s2], (modes, modes)."""
        return np.diag(self.disk.rotor.stiffness) if self.at_rest is None else self.at_rest


def tuned_rotor(stage: Stage, loads: EngineOrders, omega: float) -> TunedRotor:
    """Return a bladed disk with equal blades under engine-order forces at a speed [rad/s], with the
    stiffness of each blade.

    Raises:
        CaseError: the speed reaches the lowest critical speed, and there are no Coriolis forces.
        UserError: the equations depend on time, the case selects modes, or the stiffness of the
            blades is not known.
    """
    check_forced(stage)
    stage.check_speed(omega)
    own, stiffness = stage.blade_stiffness(omega)
    return TunedRotor(
        **vars(stiffness),
        omega=omega,
        disk=forced_rotor(own, loads),
        damping_ratio=stage.case.damping.ratio,
    )


def without_mistuning(case: Case) -> Case:
    """Return a case with equal blades."""
    disk = case.bladed_disk
    tuned = disk.model_copy(update={"mistuning": type(disk.mistuning)()})
    return case.model_copy(update={"bladed_disk": tuned})


def drawn_factors(case: Case, draws: int) -> FloatArray:
    """Return random factors on the stiffness of each blade, (draws, blades): those of the mistuning
    of the case with its seed and the seeds that follow.

    Raises:
        UserError: the case has no spread of the stiffness, or also other mistuning.
    """
    mistuning, blades = case.bladed_disk.mistuning, case.bladed_disk.count
    given = mistuning.model_dump(exclude_defaults=True).keys() - {"seed"}
    if given != {"stiffness_spread"}:
        raise UserError(
            "response: draws: expected bladed_disk.mistuning.stiffness_spread as the only mistuning"
        )
    seeds = range(mistuning.seed, mistuning.seed + draws)
    each = (mistuning.model_copy(update={"seed": seed}) for seed in seeds)
    return np.array([one.factors("stiffness", blades) for one in each])

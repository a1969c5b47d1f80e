"""Stiffness of each blade on the modes of a tuned bladed disk, for many patterns of mistuning."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, chain_to
from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.bladed_disk import BeamMatrices, BladedDiskModel
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.export import BLADES
from bladewhirl.models.stage.forced import (
    EngineOrders,
    ForcedRotor,
    forced_beams,
    forced_stage,
)
from bladewhirl.models.stage.stage import Stage, build_stage, rotor_at
from bladewhirl.models.stage.superelement_stage import SuperelementStage, superelement_stage
from bladewhirl.models.stage.superelement_structure import wheel_over_speeds


@dataclass(frozen=True, kw_only=True)
class TunedRotor:
    """A tuned bladed disk at a speed of rotation under engine-order forces, and its blades."""

    omega: float  #: speed [rad/s]
    disk: ForcedRotor  #: modes and forces
    blades: FloatArray  #: stiffness of each blade on the modes [1/s2], (blades, modes, modes)
    slope: FloatArray
    """Change of the stiffness on the modes with the square of the speed, (modes, modes)."""
    damping_ratio: float  #: damping ratio of the modes of the stiffness `damped`
    at_rest: FloatArray | None
    """Stiffness at rest on the modes [1/s2], (modes, modes), if all modes have the damping of the
    structure at rest; None if the modes at speed are damped."""

    @property
    def damped(self) -> FloatArray:
        """Stiffness whose modes have modal damping [1/s2], (modes, modes)."""
        return np.diag(self.disk.rotor.stiffness) if self.at_rest is None else self.at_rest


def tuned_beams(stage: Stage, loads: EngineOrders, omega: float) -> TunedRotor:
    """Return a tuned bladed disk of beams at a speed [rad/s]."""
    (disk,) = forced_beams(stage, loads, [omega])
    _, shapes = rotor_at(stage, omega)
    count = shapes.shape[1]
    slope, at_rest = np.zeros((count, count)), None
    if stage.disk.rotates:
        still = stage.disk.structure.still
        if stage.case.rotation.effects == "full":
            at_rest = np.asarray(shapes.T @ (still.stiffness @ shapes))
        slope = np.asarray(shapes.T @ (still.slope(omega) @ shapes))
    blades = np.array([shapes.T @ (own @ shapes) for own in stiffness_of_blades(stage.disk)])
    return TunedRotor(
        omega=omega,
        disk=disk,
        blades=blades,
        slope=slope,
        damping_ratio=stage.case.damping.ratio,
        at_rest=at_rest,
    )


def stiffness_of_blades(disk: BladedDiskModel) -> list[sp.csr_array]:
    """Return the stiffness of the beams of each blade on the free degrees of freedom."""
    mesh, model = disk.mesh, disk.model
    among = np.zeros(len(mesh.lines), dtype=np.bool_)
    among[mesh.line_sets.get(BLADES, [])] = True
    beams, found = BeamMatrices(model), []
    for tip in model.tips.tolist():
        weight = np.zeros((len(mesh.lines), 1))
        weight[chain_to(tip, mesh.lines, among).lines] = 1.0
        found.append(sp.csr_array(disk.expansion.T @ beams.stiffness(weight) @ disk.expansion))
    return found


def tuned_sectors(stage: SuperelementStage, loads: EngineOrders, omega: float) -> TunedRotor:
    """Return a tuned wheel of sectors at a speed [rad/s].

    Raises:
        UserError: the superelement is not a sector, or does not give the stiffness of its blade.
    """
    table = stage.table
    if table.kind != "sector" or table.part.blade_stiffness is None:
        raise UserError(
            'response: draws: expected beams, or bladed_disk.superelement.kind = "sector" and a'
            " file with blade_stiffness (bw.mesh3d with blade = GROUP)"
        )
    own, blades = _with_blades(stage, omega)
    count, reduced = len(own.reduced.frequency), own.reduced
    slope = np.zeros((count, count))
    if own.case.rotation.effects != "none" and reduced.stiffness_speed is not None:
        slope = reduced.slope(omega)
    disk = forced_stage(own, loads, omega)
    at_rest = None
    if own.damped_as_at_rest:
        assert reduced.root is not None  # the rotation acts on the structure
        at_rest = reduced.root @ reduced.root
    return TunedRotor(
        omega=omega,
        disk=disk,
        blades=blades,
        slope=slope,
        damping_ratio=own.case.damping.ratio,
        at_rest=at_rest,
    )


def _with_blades(stage: SuperelementStage, omega: float) -> tuple[SuperelementStage, FloatArray]:
    """Return a stage of tuned sectors, with a file with blade_stiffness, reduced at a speed
    [rad/s], and the stiffness of each blade on its modes [1/s2], (sectors, modes, modes)."""
    wheel = wheel_over_speeds(stage.case, stage.given, omega)
    at = omega if stage.case.rotation.effects != "none" else 0.0
    part, reduced = wheel.at(at)
    return replace(stage, part=part, reduced=reduced), wheel.blades_at(at)


def tuned_stage(case: Case) -> Stage | SuperelementStage:
    """Return the stage of a case with equal blades, for `tuned_beams` or `tuned_sectors`."""
    disk = case.bladed_disk
    tuned = disk.model_copy(update={"mistuning": type(disk.mistuning)()})
    case = case.model_copy(update={"bladed_disk": tuned})
    if disk.superelement is None:
        return build_stage(case)
    return superelement_stage(case, blades=True)


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

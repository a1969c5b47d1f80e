"""Contact scenarios of the k = 1 modes of a stage, for two motions of the casing (Figs 9, 10)."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.modal.whirl_modes import whirl_modes
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.postprocess.modal.motion import shown_clearance
from bladewhirl.solvers.stability.coupled_modes import wave_coefficient
from bladewhirl.solvers.stability.scenario import (
    Scenario,
    mode_scenario,
    motion_scenario,
    smallest_clearance_angle,
)
from bladewhirl.studies.modal.campbell_at_speed import refuse_unequal_bearings
from bladewhirl.studies.runs.columns import quantity

TIMES, ANGLES = 97, 1440  #: number of instants in one turn, and of angles around the casing

SHAFT = 1  #: nodal diameter of the modes that move the shaft

HIGHEST = 2.0
"""Upper limit of the coincidence speed, divided by the sum of rotor and casing frequency."""

CASING_SHARES = {"standard": 0.5, "inverted": 2.0}
"""Ratio of casing amplitude to tip amplitude, in the picture of each scenario."""


@dataclass(frozen=True, kw_only=True)
class WhirlingModes:
    """Coincident k = 1 modes of rotor and casing, with amplitudes at which contact begins."""

    name: str  #: name of the rotor's mode
    shaft: float  #: displacement of the centre [m]
    rotor: float  #: radial amplitude of the tips, positive on the side of +x [m]
    casing: float  #: radial amplitude of the casing [m]
    frequency: float  #: frequency of the rotor's mode [rad/s]
    speed: float  #: speed at which the modes coincide [rad/s]
    clearance: float  #: clearance at rest [m]

    @property
    def scenario(self) -> Scenario:
        """Contact scenario: position of contact relative to the displacement of the shaft."""
        return mode_scenario(shaft=self.shaft, rotor=self.rotor, casing=self.casing)


def whirling_modes(stage: ModalModel, *, casing_share: float, family: str = "1F") -> WhirlingModes:
    """Combine a k = 1 mode of the bladed disk and the lowest k = 1 mode of the casing at the onset
    of contact.

    With Coriolis forces the mode of the bladed disk is the backward wave at the coincidence speed.

    Args:
        stage: finite element models with their modes.
        casing_share: ratio of casing amplitude to tip amplitude; not 1, because casing and tips
            would move together and never touch.
        family: family of the bladed disk's mode.

    Raises:
        UserError: the stage lacks the mode of the bladed disk or of the casing, or, with Coriolis
            forces, a coincidence speed.
    """
    disk_modes, casing_modes = stage.disk_modes, stage.casing_modes
    on_disk = disk_modes.find(family, SHAFT)
    on_casing = (casing_modes.nodal_diameter == SHAFT).nonzero()[0]
    if not on_disk.size:
        raise UserError(f"{family}: the bladed disk has no mode of this family with k = 1")
    if not on_casing.size:
        raise UserError("the casing has no mode with k = 1")
    wall = float(casing_modes.frequency[on_casing[0]])
    if stage.case.rotation.effects == "full":
        frequency, shape = _backward_wave(stage, family, wall)
    else:
        frequency = float(disk_modes.frequency[on_disk[0]])
        shape = disk_modes.fields(on_disk[:1])
    centre = stage.beams.mesh.node_sets["centre"][0]
    shaft = float(stage.beams.cartesian(shape)[centre, 0, 0])
    tips = shape[stage.beams.tip_radial, 0]
    rotor = float(wave_coefficient(tips, stage.beams.tip_angles, SHAFT).real)
    clearance = shown_clearance(stage)
    scale = clearance / abs(rotor * (1.0 - casing_share))
    return WhirlingModes(
        name=family,
        shaft=scale * shaft,
        rotor=scale * rotor,
        casing=scale * rotor * casing_share,
        frequency=frequency,
        speed=(wall + frequency) / SHAFT,
        clearance=clearance,
    )


def _backward_wave(stage: ModalModel, family: str, wall: float) -> tuple[float, FloatArray]:
    """Return frequency [rad/s] and field (size, 1) of the backward k = 1 wave of a family, at the
    speed at which it coincides with a casing wave of the frequency `wall` [rad/s]; the crest of the
    field is at angle 0.

    Raises:
        UserError: there is no coincidence speed, or the bearings are unequal.
    """
    refuse_unequal_bearings(family, stage.case)
    disk_waves = stage.disk.waves[SHAFT]
    branch, modes = stage.disk_modes.one_a_pair(), stage.disk_modes
    pairs = [i for i in branch if modes.nodal_diameter[i] == SHAFT]
    rank = [modes.family[i] for i in pairs].index(family)
    highest = HIGHEST * (wall + float(modes.frequency[pairs[rank]]))
    met = [
        speed
        for speed in disk_waves.meeting(wall, highest)
        if disk_waves.rank(float(speed), SHAFT * float(speed) - wall) == (rank, True)
    ]
    if not met:
        raise UserError(f"{family}: the backward wave coincides with the casing wave at no speed")
    structure = rotation_matrices(stage.beams).at(float(met[0]))
    whirl = whirl_modes(structure)
    backward = np.array(whirl.direction) == "backward"
    chosen = backward & (whirl.nodal_diameter == SHAFT) & (whirl.rank == rank)
    field = whirl.fields(np.flatnonzero(chosen))
    crest = np.exp(-1j * stage.beams.tip_angles) @ field[stage.beams.tip_radial, 0]
    return SHAFT * float(met[0]) - wall, (field * np.conj(crest) / np.abs(crest)).real


def scenario_dataset(modes: WhirlingModes, *, reference: float) -> xr.Dataset:
    """Compute one turn of the rotor in two coincident modes, in the rotating frame.

    The wave travels backward on the rotor. Phases are measured from the motion; the smallest
    clearance is searched around the casing. `reference` is the frequency by which speeds are
    normalised [rad/s].
    """
    time = 2.0 * np.pi / modes.speed * np.linspace(0.0, 1.0, TIMES)
    phasor = np.exp(-1j * modes.frequency * time)
    angle = 2.0 * np.pi * np.arange(ANGLES) / ANGLES
    crest = np.real(np.multiply.outer(phasor, np.exp(-1j * angle)))
    gap = modes.clearance + (modes.casing - modes.rotor) * crest
    place = smallest_clearance_angle(gap, angle)
    shaft = modes.shaft * np.stack([phasor.real, phasor.imag], axis=-1)
    measured = motion_scenario(shaft=shaft, clearance_angle=place)
    phase = np.angle(modes.shaft * phasor)
    return xr.Dataset(
        {
            "shaft_phase": quantity("time", phase, "rad"),
            "smallest_clearance_phase": quantity("time", np.angle(np.exp(1j * place)), "rad"),
            "smallest_clearance": quantity("time", gap.min(axis=1), "m"),
        },
        coords={"time": quantity("time", time, "s")},
        attrs={
            "title": f"{modes.name}: {measured.kind} contact scenario",
            "mode": modes.name,
            "scenario": measured.kind,
            "shaft_lead": measured.lead,
            "shaft_amplitude": modes.shaft,
            "rotor_amplitude": modes.rotor,
            "casing_amplitude": modes.casing,
            "clearance": modes.clearance,
            "frequency": modes.frequency,
            "speed": modes.speed,
            "reference_frequency": reference,
        },
    )

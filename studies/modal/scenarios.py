"""Contact scenarios of a stage's own k = 1 modes, by how much the casing moves (Figs 9 and 10)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.models.rotation.at_speed import TurningDisk
from bladewhirl.models.rotation.waves import waves
from bladewhirl.models.rotation.whirl_modes import whirl_modes
from bladewhirl.postprocess.modal.motion import shown_clearance
from bladewhirl.solvers.stability.coupled_modes import wave_coefficient
from bladewhirl.solvers.stability.scenario import (
    Scenario,
    mode_scenario,
    motion_scenario,
    smallest_clearance_angle,
)

TIMES, ANGLES = 97, 1440
"""Instants of one turn, and angles at which the gap is looked at."""

SHAFT = 1
"""Nodal diameter of the modes that move the shaft."""

HIGHEST = 2.0
"""Speeds that are looked at go up to that many times the sum of the frequencies."""

CASING_SHARES = {"standard": 0.5, "inverted": 2.0}
"""Radial motion of the casing over that of the tips, in the pictures of the two scenarios."""


@dataclass(frozen=True, kw_only=True)
class WhirlingModes:
    """A k = 1 mode of the rotor and one of the casing that move in step, contact just closing."""

    name: str  #: of the rotor's mode
    shaft: float  #: displacement of the centre [m]
    rotor: float  #: radial amplitude of the tips, positive on the side of +x [m]
    casing: float  #: radial amplitude of the casing [m]
    frequency: float  #: of the rotor's mode [rad/s]
    speed: float  #: at which the modes coincide [rad/s]
    clearance: float  #: at rest [m]

    @property
    def scenario(self) -> Scenario:
        """Place of contact with respect to the shaft."""
        return mode_scenario(shaft=self.shaft, rotor=self.rotor, casing=self.casing)


def whirling_modes(stage: ModalStage, *, casing_share: float, family: str = "1F") -> WhirlingModes:
    """Put a k = 1 mode of the bladed disk and the lowest of the casing in step, contact closing.

    With Coriolis forces that is the backward wave at the speed at which the two coincide.

    Args:
        stage: finite element models with their modes.
        casing_share: radial motion of the casing over that of the tips; not 1, where the two move
            alike.
        family: of the bladed disk's mode.

    Raises:
        UserError: the stage has no such mode, or with Coriolis forces no speed at which they meet.
    """
    disk_modes, casing_modes = stage.disk_modes, stage.casing_modes
    on_disk = disk_modes.find(family, SHAFT)
    on_casing = (casing_modes.nodal_diameter == SHAFT).nonzero()[0]
    if not (on_disk.size and on_casing.size):
        raise UserError(f"{family}: the stage has no such mode with one nodal diameter")
    wall = float(casing_modes.frequency[on_casing[0]])
    if stage.turning is not None and stage.case.rotation.effects == "full":
        frequency, shape = _backward_wave(stage, stage.turning, family, wall)
    else:
        frequency = float(disk_modes.frequency[on_disk[0]])
        shape = disk_modes.fields(on_disk[:1])
    centre = stage.disk.mesh.node_sets["centre"][0]
    shaft = float(stage.disk.cartesian(shape)[centre, 0, 0])
    tips = shape[stage.disk.tip_radial, 0]
    rotor = float(wave_coefficient(tips, stage.disk.tip_angles, SHAFT).real)
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


def _backward_wave(
    stage: ModalStage, turning: TurningDisk, family: str, wall: float
) -> tuple[float, FloatArray]:
    """Frequency [rad/s] and field (size, 1) of a family's k = 1 wave where it meets the casing's.

    The field is the wave when its crest is at angle 0.

    Raises:
        UserError: it does not meet it.
    """
    own = waves(turning.matrices, SHAFT, "full")
    branch, modes = stage.disk_modes.one_a_pair(), stage.disk_modes
    pairs = [i for i in branch if modes.nodal_diameter[i] == SHAFT]
    rank = [modes.family[i] for i in pairs].index(family)
    highest = HIGHEST * (wall + float(modes.frequency[pairs[rank]]))
    met = [
        speed
        for speed in own.meeting(wall, highest)
        if own.rank(float(speed), SHAFT * float(speed) - wall) == (rank, True)
    ]
    if not met:
        raise UserError(f"{family}: its backward wave meets the casing's at no speed")
    structure = turning.matrices.at_speed(float(met[0]), "full")
    whirl = whirl_modes(structure)
    backward = np.array(whirl.direction) == "backward"
    own_wave = backward & (whirl.nodal_diameter == SHAFT) & (whirl.rank == rank)
    field = whirl.fields(np.flatnonzero(own_wave))
    crest = np.exp(-1j * stage.disk.tip_angles) @ field[stage.disk.tip_radial, 0]
    return SHAFT * float(met[0]) - wall, (field * np.conj(crest) / np.abs(crest)).real


def scenario_dataset(modes: WhirlingModes, *, reference: float) -> xr.Dataset:
    """One turn of the rotor in two coincident modes, in the rotating frame: phases, as measured.

    The wave travels backward on the rotor. The smallest clearance is looked for along the tips.

    Args:
        modes: that move in step.
        reference: frequency that speeds are multiples of [rad/s].
    """
    time = 2.0 * np.pi / modes.speed * np.linspace(0.0, 1.0, TIMES)
    turning = np.exp(-1j * modes.frequency * time)
    angle = 2.0 * np.pi * np.arange(ANGLES) / ANGLES
    crest = np.real(np.multiply.outer(turning, np.exp(-1j * angle)))
    gap = modes.clearance + (modes.casing - modes.rotor) * crest
    place = smallest_clearance_angle(gap, angle)
    shaft = modes.shaft * np.stack([turning.real, turning.imag], axis=-1)
    measured = motion_scenario(shaft=shaft, clearance_angle=place)
    phase = np.angle(modes.shaft * turning)
    return xr.Dataset(
        {
            "shaft_phase": ("time", phase, {"units": "rad"}),
            "smallest_clearance_phase": (
                "time",
                np.angle(np.exp(1j * place)),
                {"units": "rad"},
            ),
            "smallest_clearance": ("time", gap.min(axis=1), {"units": "m"}),
        },
        coords={"time": ("time", time, {"units": "s"})},
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

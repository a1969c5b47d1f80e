"""Contact scenarios of a stage's own k = 1 modes, by how much the casing moves (Figs 9 and 10)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.postprocess.modal.motion import shown_clearance
from bladewhirl.solvers.stability.coincidence import coincidences
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

    Args:
        stage: finite element models with their modes.
        casing_share: radial motion of the casing over that of the tips; not 1, where the two move
            alike.
        family: of the bladed disk's mode.

    Raises:
        UserError: the stage has no such mode.
    """
    disk_modes, casing_modes = stage.disk_modes, stage.casing_modes
    on_disk = disk_modes.find(family, SHAFT)
    on_casing = (casing_modes.nodal_diameter == SHAFT).nonzero()[0]
    if not (on_disk.size and on_casing.size):
        raise UserError(f"{family}: the stage has no such mode with one nodal diameter")
    number, wall = int(on_disk[0]), int(on_casing[0])
    shape = disk_modes.fields(on_disk[:1])
    centre = stage.disk.mesh.node_sets["centre"][0]
    shaft = float(stage.disk.cartesian(shape)[centre, 0, 0])
    tips = shape[stage.disk.tip_radial, 0]
    rotor = float(wave_coefficient(tips, stage.disk.tip_angles, SHAFT).real)
    clearance = shown_clearance(stage)
    scale = clearance / abs(rotor * (1.0 - casing_share))
    met = coincidences(
        rotor_frequency=disk_modes.frequency[[number]],
        rotor_nodal_diameter=[SHAFT],
        casing_frequency=casing_modes.frequency[[wall]],
        casing_nodal_diameter=[SHAFT],
    )
    return WhirlingModes(
        name=family,
        shaft=scale * shaft,
        rotor=scale * rotor,
        casing=scale * rotor * casing_share,
        frequency=float(disk_modes.frequency[number]),
        speed=float(met.speed[0]),
        clearance=clearance,
    )


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

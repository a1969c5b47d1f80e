"""Contact scenarios of a stage's own k = 1 modes, by how much the casing moves (Figs 9 and 10)."""

from __future__ import annotations

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.postprocess.modal.motion import shown_clearance
from bladewhirl.postprocess.modal.scenarios import WhirlingModes
from bladewhirl.solvers.stability.coincidence import coincidences
from bladewhirl.solvers.stability.coupled_modes import wave_coefficient

SHAFT = 1
"""Nodal diameter of the modes that move the shaft."""

CASING_SHARES = {"standard": 0.5, "inverted": 2.0}
"""Radial motion of the casing over that of the tips, in the pictures of the two scenarios."""


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

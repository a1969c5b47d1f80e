"""Pictures and films of natural modes, and of the contact scenarios of the first k = 1 mode."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import cast, get_args

import numpy as np
from rich.console import Console
from rich.progress import Progress

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.models.modal.labels import Body
from bladewhirl.models.rotation.at_speed import check_effects
from bladewhirl.postprocess.fields.moving_stage import stage_dataset
from bladewhirl.postprocess.modal.mode_shapes import animate_mode, mode_title, plot_mode_shapes
from bladewhirl.postprocess.modal.motion import PICTURES, Wave, mode_motion
from bladewhirl.postprocess.modal.scenarios import plot_scenario
from bladewhirl.postprocess.paraview.series import export_vtk
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.studies.modal.mode_names import ChosenMode, choose_modes, family_of
from bladewhirl.studies.modal.scenarios import CASING_SHARES, scenario_dataset, whirling_modes
from bladewhirl.studies.runs.figures_folder import written_to

BODIES: tuple[Body, ...] = get_args(Body)
FED: dict[Body, Wave] = {"bladed-disk": "backward", "casing": "forward"}
"""Waves that contact feeds."""

PANELS = 6
"""Modes of a body that are pictured when nobody says which."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Modes to picture and to film; everything in it can be drawn."""

    shapes: list[ChosenMode]
    films: list[tuple[ChosenMode, Wave]]


def plan_pictures(
    stage: ModalStage, *, shapes: str | None, animate: str | None, wave: str | None
) -> Plan:
    """Choose what is drawn.

    Args:
        stage: finite element models with their modes.
        shapes: names of the modes to picture, the lowest when None.
        animate: names of the modes to film, none when empty, the leading ones when None.
        wave: that films show; the one contact feeds when None.

    Raises:
        UserError: a mode or wave that there is not.
    """
    if wave is not None and wave not in get_args(Wave):
        raise UserError(f"--wave {wave}: expected one of {', '.join(get_args(Wave))}")
    if animate is None:
        filmed = [
            mode
            for family in ("1F", "suspension")
            for mode in family_of(stage, "bladed-disk", family, [1])
        ]
    else:
        filmed = choose_modes(stage, "--animate", animate) if animate else []
    return Plan(
        shapes=_lowest(stage) if shapes is None else choose_modes(stage, "--shapes", shapes),
        films=[(mode, _wave(mode, wave)) for mode in filmed],
    )


def draw_modes(stage: ModalStage, plan: Plan, folder: Path) -> None:
    """Draw mode shapes, contact scenarios and films into a folder, with a progress bar.

    Raises:
        UserError: the folder or a file cannot be written.
    """
    check_effects(stage.case, "pictures of modes", "centrifugal")
    console = Console(stderr=True)
    quiet = not console.is_terminal
    with written_to(folder), Progress(console=console, transient=True, disable=quiet) as bar:
        task = bar.add_task("pictures", total=2 + len(plan.films))
        for body in BODIES:
            _draw_shapes(stage, body, [mode for mode in plan.shapes if mode.body == body], folder)
        bar.advance(task)
        _draw_scenarios(stage, folder)
        bar.advance(task)
        for mode, wave in plan.films:
            _film(stage, mode, wave, folder)
            bar.advance(task)


def _lowest(stage: ModalStage) -> list[ChosenMode]:
    """Modes that are pictured by default: of 1F, the suspension pair, the casing's lowest."""
    highest = int(stage.disk_modes.nodal_diameter.max())
    disk = family_of(stage, "bladed-disk", "suspension", [1])
    first = [*range(min(PANELS - 1 - len(disk), highest)), highest]
    disk = family_of(stage, "bladed-disk", "1F", first) + disk
    casing = stage.casing_modes
    wall = [
        mode
        for k in range(1, PANELS + 1)
        for number in np.flatnonzero(casing.nodal_diameter == k)[:1]
        for mode in family_of(stage, "casing", casing.family[number], [k])
    ]
    return disk + wall


def _wave(mode: ChosenMode, wanted: str | None) -> Wave:
    """The wave that a film of a mode shows.

    Raises:
        UserError: a travelling wave of a mode that stands.
    """
    pair = len(mode.numbers) == 2
    if wanted is None:
        return FED[mode.body] if pair else "standing"
    if wanted != "standing" and not pair:
        raise UserError(f"--wave {wanted}: expected standing; {mode.name} is no pair, it stands")
    return cast(Wave, wanted)


def _draw_shapes(stage: ModalStage, body: Body, modes: list[ChosenMode], folder: Path) -> None:
    if not modes:
        return
    numbers = np.array([mode.numbers[0] for mode in modes])
    other: IntArray = np.zeros(1, dtype=np.int64)
    on_disk = body == "bladed-disk"
    data = stage_dataset(stage.arrays(*((numbers, other) if on_disk else (other, numbers))))
    data = data.assign_attrs(
        title=f"mode shapes, {body}",
        tip_radius=stage.case.tip_radius,
        casing_radius=stage.casing.mesh.radius,
        reference_frequency=stage.reference_frequency,
    )
    save_figure(plot_mode_shapes(data, body), folder / f"{body}-shapes", data)


def _draw_scenarios(stage: ModalStage, folder: Path) -> None:
    """Draw both contact scenarios; there are none without a 1F pair that moves the shaft."""
    if stage.case.shaft.clamped or not stage.disk_modes.find("1F", 1).size:
        return
    for name, share in CASING_SHARES.items():
        modes = whirling_modes(stage, casing_share=share)
        data = scenario_dataset(modes, reference=stage.reference_frequency)
        save_figure(plot_scenario(data), folder / f"{name}-scenario", data)


def _film(stage: ModalStage, mode: ChosenMode, wave: Wave, folder: Path) -> None:
    words = f"{mode_title(mode.family, mode.nodal_diameter)}, {wave} wave"
    title = words if mode.body == "bladed-disk" else f"casing {words}"
    motion = mode_motion(stage, mode.body, mode.numbers, wave=wave, title=title)
    animate_mode(motion, mode.body, folder / f"{mode.stem}.gif")
    export_vtk(motion, folder / f"{mode.stem}-vtk", frames=PICTURES)

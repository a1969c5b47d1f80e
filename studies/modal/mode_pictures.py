"""Pictures and films of natural modes, and of the contact scenarios of the first k = 1 mode."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import cast, get_args

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import Progress

from bladewhirl.meshes.files.manifest import claim
from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.models.modal.full_stage import ModalStage, Whirl
from bladewhirl.models.modal.labels import Body
from bladewhirl.postprocess.modal.mode_shapes import (
    animate_mode,
    mode_title,
    plot_mode_shapes,
    plot_travelling_wave,
)
from bladewhirl.postprocess.modal.motion import PICTURES, Wave, mode_motion, shapes_dataset
from bladewhirl.postprocess.modal.scenarios import plot_scenario
from bladewhirl.postprocess.paraview.series import export_vtk
from bladewhirl.studies.modal.mode_names import ChosenMode, choose_modes, family_of, modes_of
from bladewhirl.studies.modal.scenarios import CASING_SHARES, scenario_dataset, whirling_modes
from bladewhirl.studies.runs.figures_folder import save_figures

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
        films=[(mode, _wave(stage, mode, wave)) for mode in filmed],
    )


def draw_modes(stage: ModalStage, plan: Plan, folder: Path, *, overwrite: bool = False) -> None:
    """Draw mode shapes, contact scenarios and films into a folder, with a progress bar.

    Raises:
        UserError: a file cannot be written, or is there and not the program's.
    """
    console = Console(stderr=True)
    quiet = not console.is_terminal
    with Progress(console=console, transient=True, disable=quiet) as bar:
        task = bar.add_task("pictures", total=1 + len(plan.films))
        figures = dict(_shapes(stage, plan.shapes)) | dict(_scenarios(stage))
        save_figures(folder, figures, overwrite=overwrite)
        bar.advance(task)
        for mode, wave in plan.films:
            _film(stage, mode, wave, folder, overwrite=overwrite)
            bar.advance(task)


def _lowest(stage: ModalStage) -> list[ChosenMode]:
    """Modes that are pictured by default: of 1F, the suspension pair, the casing's lowest."""
    highest = int(modes_of(stage, "bladed-disk").nodal_diameter.max())
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


def _wave(stage: ModalStage, mode: ChosenMode, wanted: str | None) -> Wave:
    """The wave that a film of a mode shows.

    Raises:
        UserError: one that the mode does not have.
    """
    ways = {*get_args(Wave)} if len(mode.numbers) == 2 else {"standing"}
    if mode.body == "bladed-disk" and stage.disk_whirl is not None:
        ways = {stage.disk_whirl.modes.direction[number] for number in mode.numbers}
    fed = FED[mode.body]
    if wanted is None:
        return fed if fed in ways else cast(Wave, min(ways))
    if wanted not in ways:
        words = "is a wave that travels"
        if ways == {"standing"}:
            words = "stands: it is no pair" + (", since blades differ" if mode.which else "")
        expected = " or ".join(sorted(ways))
        raise UserError(f"--wave {wanted}: expected {expected}; {mode.name} {words}")
    return cast(Wave, wanted)


Drawn = Iterator[tuple[str, tuple[Figure, xr.Dataset]]]
"""Names of figures, with the data behind them."""


def _shapes(stage: ModalStage, modes: list[ChosenMode]) -> Drawn:
    for body in BODIES:
        whirls = body == "bladed-disk" and stage.disk_whirl is not None
        numbers = [
            number
            for mode in modes
            if mode.body == body
            for number in (mode.numbers if whirls else mode.numbers[:1])
        ]
        if numbers:
            data = shapes_dataset(stage, body, np.array(numbers))
            data = data.assign_attrs(title=f"mode shapes, {body}")
            yield f"{body}-shapes", (plot_mode_shapes(data, body), data)


def _scenarios(stage: ModalStage) -> Drawn:
    """Both contact scenarios; there are none without a 1F pair that moves the shaft and meets the
    casing's.
    """
    if stage.case.shaft.clamped:
        return
    for name, share in CASING_SHARES.items():
        try:
            modes = whirling_modes(stage, casing_share=share)
        except UserError:
            return
        data = scenario_dataset(modes, reference=stage.reference_frequency)
        data = data.assign_attrs(case=stage.case.title)
        yield f"{name}-scenario", (plot_scenario(data), data)


def _film(
    stage: ModalStage, mode: ChosenMode, wave: Wave, folder: Path, *, overwrite: bool
) -> None:
    found = modes_of(stage, mode.body)
    purity = (found.modes if isinstance(found, Whirl) else found).purity[mode.numbers[0]]
    words = f"{mode_title(mode.family, mode.nodal_diameter, purity)}, {wave} wave"
    title = words if mode.body == "bladed-disk" else f"casing {words}"
    numbers, stem = mode.numbers, mode.stem
    if mode.body == "bladed-disk" and stage.disk_whirl is not None:
        ways = stage.disk_whirl.modes.direction
        numbers = np.array([number for number in numbers if ways[number] == wave][:1])
    motion = mode_motion(stage, mode.body, numbers, wave=wave, title=title)
    film = folder / f"{stem}.gif"
    if wave != "standing":
        figure = plot_travelling_wave(motion, mode.body)
        save_figures(folder, {f"{stem}-wave": (figure, motion)}, overwrite=overwrite)
    with writing(folder):
        claim(folder, [film.name], overwrite=overwrite)
        animate_mode(motion, mode.body, film)
        export_vtk(motion, folder / f"{stem}-vtk", frames=PICTURES, overwrite=overwrite)

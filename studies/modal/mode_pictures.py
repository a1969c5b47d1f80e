"""Pictures and films of natural modes, and of the contact scenarios of the first k = 1 mode.

Modes are named as on the command line: "1F:1", "suspension", "casing:1F:2", or lists of these."""

from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import get_args

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.files import claim
from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.models.inputs.mode_names import CASING
from bladewhirl.models.inputs.progress import report
from bladewhirl.models.modal.labels import Body
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.modal.modes import ListedModes
from bladewhirl.models.stage.modal import full_models
from bladewhirl.postprocess.modal.mode_shapes import (
    mode_title,
    plot_mode_shapes,
    plot_travelling_wave,
)
from bladewhirl.postprocess.modal.motion import PICTURES, Wave, mode_motion, shapes_dataset
from bladewhirl.postprocess.modal.scenarios import plot_scenario
from bladewhirl.postprocess.paraview.series import export_vtk
from bladewhirl.postprocess.pictures.bodies import NO_SURFACE
from bladewhirl.postprocess.pictures.render import render_animation
from bladewhirl.studies.modal.scenarios import CASING_SHARES, scenario_dataset, whirling_modes
from bladewhirl.studies.runs.figures_folder import save_figures

BODIES: tuple[Body, ...] = get_args(Body)
FED: dict[Body, Wave] = {"bladed-disk": "backward", "casing": "forward"}
"""Waves that contact amplifies."""

PANELS = 6  #: default number of pictured modes of a body


@dataclass(frozen=True, kw_only=True)
class ChosenMode:
    """A mode, or a degenerate pair, of a body: the bladed disk or the casing."""

    body: Body
    family: str
    nodal_diameter: int
    numbers: IntArray
    """Numbers among the modes of the body: a single mode, the cosine and sine modes of a pair, or
    waves in both directions."""
    rank: int = 0
    """Number from 1 if several modes have the same name, as with unequal sectors; 0 if the name is
    unique."""

    @property
    def name(self) -> str:
        """Name on the command line."""
        named = self.family != "suspension" and self.nodal_diameter >= 0
        diameter = f":{self.nodal_diameter}" if named else ""
        prefix = "" if self.body == "bladed-disk" else f"{CASING}:"
        return f"{prefix}{self.family}{diameter}"

    @property
    def stem(self) -> str:
        """Name of the mode's files without suffix."""
        return self.name.replace(":", "-") + (f"-{self.rank}" if self.rank else "")


@dataclass(frozen=True, kw_only=True)
class PicturePlan:
    """Modes to draw and to film, after validation."""

    shapes: list[ChosenMode]
    films: list[tuple[ChosenMode, Wave]]


def plan_pictures(
    stage: ModalModel, *, shapes: str | None, animate: str | None, wave: str | None
) -> PicturePlan:
    """Choose the modes to draw and to film.

    Args:
        stage: bladed disk and casing in their modes.
        shapes: names of the modes to draw; if None, the lowest modes.
        animate: names of the modes to film, "" for no films; if None, 1F:1 and the suspension.
        wave: wave shown by films; if None, the wave that contact amplifies.

    Raises:
        UserError: a mode or wave does not exist, or there is no surface to film.
    """
    if animate and not stage.disk.has_surface:
        raise UserError(f"--animate {animate}: {NO_SURFACE}")
    if wave is not None and wave not in get_args(Wave):
        raise UserError(f"--wave {wave}: expected one of {', '.join(get_args(Wave))}")
    if animate is None and not stage.disk.has_surface:
        filmed = []
    elif animate is None:
        filmed = _of_family(stage, "bladed-disk", "1F", [1, -1])[:1]
        filmed += _of_family(stage, "bladed-disk", "suspension", [1])
    else:
        filmed = _chosen(stage, "--animate", animate) if animate else []
    return PicturePlan(
        shapes=_lowest(stage) if shapes is None else _chosen(stage, "--shapes", shapes),
        films=[(mode, _wave(stage, mode, wave)) for mode in filmed],
    )


def draw_modes(
    stage: ModalModel, plan: PicturePlan, folder: Path, *, overwrite: bool = False
) -> None:
    """Draw mode shapes, contact scenarios and films into a folder.

    Raises:
        UserError: a file cannot be written, or exists and was not written by bladewhirl.
    """
    figures = dict(_shapes(stage, plan.shapes)) | dict(_scenarios(stage))
    save_figures(folder, figures, overwrite=overwrite)
    for mode, wave in plan.films:
        _film(stage, mode, wave, folder, overwrite=overwrite)


def _lowest(stage: ModalModel) -> list[ChosenMode]:
    """Return the default modes to draw: some 1F modes, the suspension, the lowest casing modes."""
    modes = _modes_of(stage, "bladed-disk")
    highest = int(modes.nodal_diameter.max())
    disk = _of_family(stage, "bladed-disk", "suspension", [1])
    first = [*range(min(PANELS - 1 - len(disk), highest)), highest]
    disk = _of_family(stage, "bladed-disk", "1F", first) + disk
    if not disk or highest < 0:  # no families, or no nodal diameters
        lowest = zip(modes.family[:PANELS], modes.nodal_diameter[:PANELS].tolist(), strict=True)
        disk = [
            ChosenMode(body="bladed-disk", family=name, nodal_diameter=k, numbers=np.array([i]))
            for i, (name, k) in enumerate(lowest)
        ]
    casing = stage.casing_modes
    wall = [
        mode
        for k in range(1, PANELS + 1)
        for number in np.flatnonzero(casing.nodal_diameter == k)[:1]
        for mode in _of_family(stage, "casing", casing.family[number], [k])
    ]
    return disk + wall


def _wave(stage: ModalModel, mode: ChosenMode, wave: str | None) -> Wave:
    """Return the wave that a film of a mode shows.

    Raises:
        UserError: the mode does not have the wave.
    """
    waves = _modes_of(stage, mode.body).waves_of(mode.numbers, stage.speed)
    amplified = FED[mode.body]
    if wave is None:
        return amplified if amplified in waves else min(waves)
    if wave not in waves:
        raise UserError(
            f"--wave {wave}: expected {' or '.join(sorted(waves))}, the only waves of {mode.name}"
        )
    return wave


Drawn = Iterator[tuple[str, tuple[Figure, xr.Dataset]]]  #: names of figures, with figures and data


def _shapes(stage: ModalModel, modes: list[ChosenMode]) -> Drawn:
    for body in BODIES:
        numbers = [
            number
            for mode in modes
            if mode.body == body
            for number in _modes_of(stage, body).drawn(mode.numbers)
        ]
        if numbers:
            data = shapes_dataset(stage, body, np.array(numbers))
            data = data.assign_attrs(title=f"mode shapes, {body}")
            yield f"{body}-shapes", (plot_mode_shapes(data, body), data)


def _scenarios(stage: ModalModel) -> Drawn:
    """Yield figures of standard and inverted contact, if a 1F pair moves the shaft and coincides
    with a casing mode."""
    if stage.case.shaft.clamped:
        return
    for name, share in CASING_SHARES.items():
        try:
            full = full_models(stage, "scenario", "its contact is that of tips of beams")
            modes = whirling_modes(full, casing_share=share)
        except UserError:
            return
        data = scenario_dataset(modes, reference=stage.reference_frequency)
        data = data.assign_attrs(case=stage.case.title)
        yield f"{name}-scenario", (plot_scenario(data), data)


def _film(
    stage: ModalModel, mode: ChosenMode, wave: Wave, folder: Path, *, overwrite: bool
) -> None:
    """Write the film and the VTK series of a mode, and the picture of a travelling wave."""
    modes = _modes_of(stage, mode.body)
    numbers = modes.waves_of(mode.numbers, stage.speed)[wave]
    purity, hertz = modes.purity[numbers[0]], modes.frequency[numbers[0]] / (2.0 * np.pi)
    name = mode_title(mode.family, mode.nodal_diameter, purity)
    on_casing = mode.body == "casing"
    does = "" if on_casing else stage.disk.tip_motions[numbers[0]]
    travels = f"{wave} wave" if on_casing or stage.case.bladed_disk.count > 1 else ""
    title = ", ".join(filter(None, [name, does, travels, f"{hertz:.4g} Hz"]))
    title = f"casing {title}" if on_casing else title
    motion = mode_motion(stage, mode.body, numbers, wave=wave, title=title)
    stem = mode.stem
    film = folder / f"{stem}.gif"
    if wave != "standing" and (stage.disk.of_lines or mode.body == "casing"):
        figure = plot_travelling_wave(motion, mode.body)
        save_figures(folder, {f"{stem}-wave": (figure, motion)}, overwrite=overwrite)
    with writing(folder):
        claim(folder, [film.name], overwrite=overwrite)
        frame = "static" if on_casing else "rotating"
        drawn = partial(report, f"film of {mode.name}")
        instants = np.arange(motion.sizes["time"])
        render_animation(motion, film, instants, frame=frame, progress=drawn)
        series = partial(report, f"series of {mode.name}")
        export_vtk(
            motion,
            folder / f"{stem}-vtk",
            frames=PICTURES,
            overwrite=overwrite,
            progress=series,
        )


def _chosen(stage: ModalModel, option: str, text: str) -> list[ChosenMode]:
    """Return the modes of a list of names, separated by commas; errors contain the option's name.

    A name without nodal diameter means all nodal diameters of the family. A name that several modes
    have, as with unequal sectors, means all of these modes.

    Raises:
        UserError: a family is unknown, or does not have the nodal diameter.
    """
    chosen = []
    for name in map(str.strip, text.split(",")):
        on_casing = name.startswith(f"{CASING}:")
        body: Body = "casing" if on_casing else "bladed-disk"
        family, colon, number = name.removeprefix(f"{CASING}:").partition(":")
        modes = _modes_of(stage, body)
        families = list(dict.fromkeys(modes.family))
        if family not in families:
            near = get_close_matches(family, families, n=1)
            hint = f" (did you mean {near[0]}?)" if near else ""
            expected = f"a family of the {'casing' if on_casing else 'bladed disk'}"
            listed = ", ".join(families)
            raise UserError(f"{option} {name or chr(34) * 2}: expected {expected}: {listed}{hint}")
        of_family = np.flatnonzero([other == family for other in modes.family])
        diameters = np.unique(modes.nodal_diameter[of_family]).tolist()
        if colon and (not number.isdecimal() or int(number) not in diameters):
            listed = ", ".join(map(str, diameters))
            raise UserError(f"{option} {name}: expected a nodal diameter of {family}: {listed}")
        chosen += _of_family(stage, body, family, [int(number)] if colon else diameters, every=True)
    return chosen


def _of_family(
    stage: ModalModel, body: Body, family: str, diameters: list[int], *, every: bool = False
) -> list[ChosenMode]:
    """Return the lowest mode of a family with each nodal diameter, or all of them with `every`;
    nodal diameters without such a mode are skipped."""
    modes, chosen = _modes_of(stage, body), []
    for k in diameters:
        numbers = modes.find(family, k)
        paired = numbers.size and modes.has_one_wave[numbers[0]]
        groups = [numbers] if paired else list(numbers[:, None])
        groups = groups if every else groups[:1]
        chosen += [
            ChosenMode(
                body=body,
                family=family,
                nodal_diameter=k,
                numbers=group,
                rank=place if len(groups) > 1 else 0,
            )
            for place, group in enumerate(groups, 1)
        ]
    return chosen


def _modes_of(stage: ModalModel, body: Body) -> ListedModes:
    """Return the modes of a body; for a bladed disk with Coriolis forces, its whirling modes."""
    return stage.listed_modes if body == "bladed-disk" else stage.casing_modes

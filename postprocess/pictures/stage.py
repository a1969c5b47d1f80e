"""Picture of a stage at rest: parts, supports and named sets."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from PIL import Image

from bladewhirl.files import replacing
from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.postprocess.fields.by_blade import blade_count
from bladewhirl.postprocess.fields.result import stage_dataset
from bladewhirl.postprocess.pictures.appearance import FAINT
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.offscreen import off_screen_plotter, pixels_of
from bladewhirl.postprocess.pictures.render import WINDOW
from bladewhirl.postprocess.plotting.files import checked_target

if TYPE_CHECKING:
    from bladewhirl.postprocess.pictures.scene import StageScene

SET_COLOURS = ("#ffffff", "#20262e", "#f0e442", "#cc79a7", "#56b4e9", "#009e73")
"""Colours of the dots at the nodes of the sets, in the order of the sets."""

DOT = 0.011  #: radius of the dots of the first set, relative to the radius of the picture


def stage_at_rest(
    arrays: StageArrays, attributes: Mapping[str, str | float | int], *, title: str
) -> xr.Dataset:
    """Return a Dataset of a stage at rest, with a single record. `attributes` are those that a
    result of the stage has."""
    motion = {"time": np.zeros(1), "rotor_displacement": np.zeros((1, len(arrays.rotor_frequency)))}
    if arrays.casing_frequency.size:
        motion["casing_displacement"] = np.zeros((1, len(arrays.casing_frequency)))
    return stage_dataset(arrays, motion).assign_attrs(attributes, title=title, speed=0.0)


def draw_stage(dataset: xr.Dataset, path: str | Path, *, node_sets: Mapping[str, IntArray]) -> Path:
    """Draw a stage from `stage_at_rest` with its parts, sets and supports as PNG; return the path.
    `node_sets` contains the nodes of beams, or the contact nodes of a surface, by the name of the
    set.

    Raises:
        ViewError: the path does not end in .png, or the rotor has neither beams nor a surface.
        OffScreenError: the system cannot draw without a display.
    """
    target = checked_target(path, ".png")
    drawing = Drawing(dataset, np.array([0]), colour="part")
    with off_screen_plotter(WINDOW) as plotter:
        from bladewhirl.postprocess.pictures.scene import StageScene

        scene = StageScene(plotter, drawing, marks=False)
        _mark_sets(scene, node_sets)
        _describe(scene, dataset, node_sets)
        scene.aim()
        picture = pixels_of(plotter)
    with replacing(target) as draft:
        Image.fromarray(picture).save(draft, format="png")
    return target


def _mark_sets(scene: StageScene, node_sets: Mapping[str, IntArray]) -> None:
    """Draw dots at the nodes of every set; the dots are smaller from set to set, so that all dots
    at a shared node are visible."""
    for number, (nodes, colour) in enumerate(zip(node_sets.values(), SET_COLOURS, strict=False)):
        size = DOT * (1.0 - number / (len(SET_COLOURS) + 1))
        scene.dots(scene.drawing.nodes[nodes], size, colour, layer=8 + 2 * number)


def _describe(scene: StageScene, dataset: xr.Dataset, node_sets: Mapping[str, IntArray]) -> None:
    """Write title, sizes, and keys of parts, sets and symbols."""
    from bladewhirl.postprocess.pictures import panel

    plotter, drawing = scene.plotter, scene.drawing
    panel.write_title(plotter, dataset)
    panel.write_bar(scene, panel.draw_scale_bar(scene, "clearance"))
    panel.write(plotter, _sizes(dataset), 0.885, 13)
    sets = [f"set “{name}”: {len(nodes)}" for name, nodes in node_sets.items()]
    dots = dict(zip(sets, SET_COLOURS, strict=False))
    top = 0.76
    for entries, sign in (
        (drawing.colouring.parts or {}, "\N{BLACK SQUARE}"),
        (dots, "\N{BLACK CIRCLE}"),
    ):
        panel.write_key(plotter, entries, top, sign=sign)
        top -= panel.KEY_STEP * len(entries) + 0.03
    top -= panel.KEY_STEP * panel.write_symbols(scene, top) + 0.03
    if drawing.exaggeration != 1:
        note = f"clearance drawn\n{drawing.exaggeration:g} times as large"
        panel.write(plotter, note, top, 13, color=FAINT)


def _sizes(dataset: xr.Dataset) -> str:
    """Return number of blades, tip radius and clearance as text of three lines."""
    clearance = dataset["clearance"].values[:, None] + dataset["tip_recess"].values
    unit, scale = handy_unit(clearance.max(), "m")
    blades = blade_count(dataset)
    limits = (clearance.min(), clearance.max())
    ends = dict.fromkeys(f"{scale * length:.3g}" for length in limits)
    return (
        f"{blades} blade{'s' if blades > 1 else ''}\n"
        f"tip radius {handy(float(dataset.attrs['tip_radius']), 'm', 4)}\n"
        f"clearance {' to '.join(ends)} {unit}"
    )

"""A picture of a stage before any run: what it consists of, what holds it, and its named sets."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import imageio.v2 as imageio
import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.postprocess.fields.mode_result import stage_dataset
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.look import FAINT
from bladewhirl.postprocess.pictures.off_screen import off_screen_plotter, pixels_of
from bladewhirl.postprocess.pictures.render import WINDOW
from bladewhirl.postprocess.pictures.stage_words import (
    count,
    holding_words,
    size_words,
    thickness_words,
)
from bladewhirl.postprocess.plotting.files import checked_target, replacing
from bladewhirl.solvers.march.schema import HISTORY

if TYPE_CHECKING:
    from bladewhirl.postprocess.pictures.scene import StageScene

SET_COLOURS = ("#ffffff", "#20262e", "#f0e442", "#cc79a7", "#56b4e9", "#009e73")
"""Of the dots that mark the nodes of sets, in turn."""

DOT = 0.011  #: radius of the first set's dots, as a share of the picture's; others are smaller


def stage_at_rest(
    arrays: StageArrays, *, title: str, tip_radius: float, casing_radius: float, clamped: bool
) -> xr.Dataset:
    """A stage laid out like the result of a run of one record in which nothing moves."""
    fixed = stage_dataset(arrays)
    sizes = {**fixed.sizes, "time": 1}
    history = {
        name: (
            variable.dimensions,
            np.zeros([sizes[dimension] for dimension in variable.dimensions]),
        )
        for name, variable in HISTORY.items()
    }
    return fixed.assign(history).assign_attrs(
        title=title,
        tip_radius=tip_radius,
        casing_radius=casing_radius,
        clamped=int(clamped),
        speed=0.0,
        record_step=1.0,
    )


def draw_stage(
    dataset: xr.Dataset,
    path: str | Path,
    *,
    node_sets: Mapping[str, IntArray],
    exaggeration: float | None = None,
    size: tuple[int, int] = WINDOW,
) -> Path:
    """A PNG of a stage with its parts, sets and supports named; returns its path.

    Args:
        dataset: from `stage_at_rest`, or a result, of which the first record is drawn.
        path: of the file.
        node_sets: nodes of the rotor by the name of their set.
        exaggeration: of the clearance; None for a round number that shows it (`Drawing`).
        size: [pixels].

    Raises:
        ViewError: a name that does not end in .png, or a bad factor.
        OffScreenError: the system can't draw.
    """
    target = checked_target(path, ".png")
    drawing = Drawing(dataset, np.array([0]), exaggeration=exaggeration, colour="part")
    with off_screen_plotter(size) as plotter:
        from bladewhirl.postprocess.pictures.scene import StageScene

        scene = StageScene(plotter, drawing, marks=False)
        _mark_sets(scene, node_sets)
        _describe(scene, dataset, node_sets)
        scene.look()
        picture = pixels_of(plotter)
    with replacing(target) as draft:
        imageio.imwrite(draft, picture)
    return target


def _mark_sets(scene: StageScene, node_sets: Mapping[str, IntArray]) -> None:
    """Dots at the nodes of every set; where sets share a node they are rings in each other."""
    for number, (nodes, colour) in enumerate(zip(node_sets.values(), SET_COLOURS, strict=False)):
        size = DOT * (1.0 - number / (len(SET_COLOURS) + 1))
        scene.dots(scene.drawing.nodes[nodes], size, colour, layer=8 + 2 * number)


def _describe(scene: StageScene, dataset: xr.Dataset, node_sets: Mapping[str, IntArray]) -> None:
    """Parts and sets with their colours, symbols, and what else there is to say."""
    from bladewhirl.postprocess.pictures.panel import (
        KEY_LETTERS,
        KEY_STEP,
        LINE_LETTERS,
        write,
        write_key,
        write_symbols,
        write_title,
    )

    plotter, drawing = scene.plotter, scene.drawing
    write_title(plotter, dataset)
    write(plotter, "\n".join(size_words(dataset)), 0.885, 13)
    parts = drawing.colouring.parts or {}
    top = 0.76
    told = [f"{name}, {thickness_words(dataset, name)}" for name in parts]
    thick = " thick" if max(map(len, told)) + len(" thick") <= KEY_LETTERS else ""
    key = {words + thick: colour for words, colour in zip(told, parts.values(), strict=True)}
    write_key(plotter, key, top)
    top -= KEY_STEP * len(key) + 0.03
    dots = {
        f"set “{name}”, {count(len(nodes), 'node')}": colour
        for (name, nodes), colour in zip(node_sets.items(), SET_COLOURS, strict=False)
    }
    write_key(plotter, dots, top, sign="\N{BLACK CIRCLE}")
    top -= KEY_STEP * len(dots) + 0.03
    symbols = write_symbols(scene, top)
    top -= KEY_STEP * symbols + 0.03 * (symbols > 0)
    notes = [textwrap.fill(each, LINE_LETTERS) for each in holding_words(dataset)]
    if drawing.exaggeration != 1:
        notes.append(f"clearance drawn\n{drawing.exaggeration:g} times as large")
    write(plotter, "\n".join(notes), top, 13, color=FAINT)

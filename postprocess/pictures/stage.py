"""A picture of a stage before any run: what it consists of, what holds it, and its named sets."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import imageio.v2 as imageio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.meshes.files.drafts import replacing
from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.moving_stage import moving_stage
from bladewhirl.postprocess.fields.sections import rotor_sections
from bladewhirl.postprocess.pictures.appearance import FAINT, SQUARE
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.offscreen import off_screen_plotter, pixels_of
from bladewhirl.postprocess.pictures.render import WINDOW
from bladewhirl.postprocess.plotting.files import checked_target

if TYPE_CHECKING:
    from bladewhirl.postprocess.pictures.scene import StageScene

SET_COLOURS = ("#ffffff", "#20262e", "#f0e442", "#cc79a7", "#56b4e9", "#009e73")
"""Of the dots that mark the nodes of sets, in turn."""

DOT = 0.011  #: radius of the first set's dots, as a share of the picture's; others are smaller


def stage_at_rest(
    arrays: StageArrays, *, title: str, tip_radius: float, casing_radius: float, clamped: bool
) -> xr.Dataset:
    """A stage at one instant, at which nothing moves."""
    motion = {
        "time": np.zeros(1),
        "rotor_displacement": np.zeros((1, len(arrays.rotor_frequency))),
        "casing_displacement": np.zeros((1, len(arrays.casing_frequency))),
    }
    return moving_stage(arrays, motion).assign_attrs(
        title=title,
        tip_radius=tip_radius,
        casing_radius=casing_radius,
        clamped=int(clamped),
        speed=0.0,
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
        scene.aim()
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
        draw_scale_bar,
        write,
        write_key,
        write_symbols,
        write_title,
    )

    plotter, drawing = scene.plotter, scene.drawing
    write_title(plotter, dataset)
    write(scene.plotter, draw_scale_bar(scene, "clearance"), 0.085, 11, indent=-SQUARE)
    write(plotter, "\n".join(size_words(dataset)), 0.885, 13)
    parts = drawing.colouring.parts or {}
    top = 0.76
    told = [f"{name}, {thickness_words(dataset, name)}" for name in parts]
    thick = " thick" if max(map(len, told)) + len(" thick") <= KEY_LETTERS else ""
    key = {words + thick: colour for words, colour in zip(told, parts.values(), strict=True)}
    write_key(plotter, key, top)
    top -= KEY_STEP * len(key) + 0.03
    sets = [f"set “{name}”, {count(len(nodes), 'node')}" for name, nodes in node_sets.items()]
    if max(map(len, sets), default=0) > KEY_LETTERS:
        sets = [f"set “{name}”: {len(nodes)}" for name, nodes in node_sets.items()]
    dots = dict(zip(sets, SET_COLOURS, strict=False))
    write_key(plotter, dots, top, sign="\N{BLACK CIRCLE}")
    top -= KEY_STEP * len(dots) + 0.03
    symbols = write_symbols(scene, top)
    top -= KEY_STEP * symbols + 0.03 * (symbols > 0)
    notes = [textwrap.fill(each, LINE_LETTERS) for each in holding_words(dataset)]
    if drawing.exaggeration != 1:
        notes.append(f"clearance drawn\n{drawing.exaggeration:g} times as large")
    write(plotter, "\n".join(notes), top, 13, color=FAINT)


def size_words(dataset: xr.Dataset) -> list[str]:
    """Number of blades, radius and clearance, in words."""
    clearance = dataset["clearance"].values[:, None] + dataset["tip_recess"].values
    return [
        f"{dataset.sizes['blade']} blades",
        f"tip radius {handy(float(dataset.attrs['tip_radius']), 'm', 4)}",
        f"clearance {_range(clearance)}",
    ]


def thickness_words(dataset: xr.Dataset, part: str) -> str:
    """Thickness of a part, or the range of it."""
    if part == "casing":
        return _range(dataset["casing_thickness"].values)
    names = dataset["rotor_part"].values.astype(str)
    own = names == ("" if part == "other beams" and part not in names else part)
    return _range(rotor_sections(dataset, "thickness", 1)[own])


def holding_words(dataset: xr.Dataset) -> list[str]:
    """Supports and attachments of both bodies in words; springs and dampers as they are drawn,
    those along the wall beside those across it.
    """
    lines = [*_shaft(dataset), "casing: " + (", ".join(_casing(dataset)) or "free")]
    masses = _numbers(dataset, "point_mass")
    if len(masses):
        lines.append(f"{count(len(masses), 'point mass')}, {masses.sum():.4g} kg")
    for name, what in (("rotor_spring", "spring"), ("rotor_link", "rigid link")):
        number = len(_numbers(dataset, name))
        if number:
            lines.append(f"{count(number, what)} on the bladed disk")
    return lines


def _shaft(dataset: xr.Dataset) -> Iterator[str]:
    """Supports of the centre."""
    if int(dataset.attrs["clamped"]):
        yield "centre held"
        return
    damped = _numbers(dataset, "shaft_damping") > 0
    yield ", ".join(["shaft: 2 springs", *_some(damped, "damper")])
    stiffness = _numbers(dataset, "shaft_stiffness")
    if np.unique(stiffness).size > 1:
        yield "of " + " and ".join(handy(each, "N/m", 3) for each in stiffness) + ","
        static = str(dataset["shaft_frame"].values) == "static"
        yield "standing still" if static else "turning with the disk"


def _casing(dataset: xr.Dataset) -> Iterator[str]:
    """Supports of the casing."""
    if float(dataset["casing_foundation"]) > 0:
        yield "elastic support"
    strut = _numbers(dataset, "support_kind").astype(str) == "strut"
    sprung, damped = (
        np.array([_numbers(dataset, f"support_{way}_{what}") for way in ("radial", "tangential")])
        > 0
        for what in ("stiffness", "damping")
    )
    yield from _some(sprung[:, ~strut], "spring")
    yield from _some(strut, "strut")
    yield from _some(np.append(damped[:, ~strut], damped[:, strut].any(axis=0)), "damper")


def _numbers(dataset: xr.Dataset, name: str) -> NDArray[Any]:
    """Values of a variable; none where a stage has none."""
    return dataset[name].values if name in dataset else np.zeros(0)


def _some(which: NDArray[np.bool_], what: str) -> list[str]:
    number = int(np.count_nonzero(which))
    return [count(number, what)] if number else []


def count(number: int, what: str) -> str:
    """A number of things."""
    plural = "es" if what.endswith("s") else "s"
    return f"{number} {what}{plural if number != 1 else ''}"


def _range(lengths: Array) -> str:
    low, high = float(lengths.min()), float(lengths.max())
    if high - low <= 1e-9 * high:
        return handy(high, "m", 4)
    unit, scale = handy_unit(high, "m")
    return f"{scale * low:.3g} to {scale * high:.3g} {unit}"

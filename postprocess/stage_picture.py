"""A picture of a stage before any run: what it consists of, what holds it, and its named sets."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import imageio.v2 as imageio
import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.stage_arrays import StageArrays
from bladewhirl.postprocess.colouring import length_unit
from bladewhirl.postprocess.drawing import Drawing
from bladewhirl.postprocess.mode_motion import stage_dataset
from bladewhirl.postprocess.off_screen import off_screen_plotter, pixels_of
from bladewhirl.postprocess.picture_file import checked_target, replacing
from bladewhirl.postprocess.render import WINDOW
from bladewhirl.postprocess.stage_look import FAINT
from bladewhirl.solvers.recorder import HISTORY

if TYPE_CHECKING:
    import pyvista

    from bladewhirl.postprocess.scene import StageScene

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
        from bladewhirl.postprocess.scene import StageScene

        scene = StageScene(plotter, drawing, marks=False)
        _mark_sets(scene, dataset, node_sets)
        _describe(plotter, drawing, dataset, node_sets)
        scene.look()
        picture = pixels_of(plotter)
    with replacing(target) as draft:
        imageio.imwrite(draft, picture)
    return target


def _mark_sets(scene: StageScene, dataset: xr.Dataset, node_sets: Mapping[str, IntArray]) -> None:
    """Dots at the nodes of every set; where sets share a node they are rings in each other."""
    for number, (nodes, colour) in enumerate(zip(node_sets.values(), SET_COLOURS, strict=False)):
        size = DOT * (1.0 - number / (len(SET_COLOURS) + 1))
        scene.dots(dataset["rotor_point"].values[nodes], size, colour, layer=8 + 2 * number)


def _describe(
    plotter: pyvista.Plotter,
    drawing: Drawing,
    dataset: xr.Dataset,
    node_sets: Mapping[str, IntArray],
) -> None:
    """Parts and sets with their colours, and what else there is to say."""
    from bladewhirl.postprocess.panel import (
        KEY_STEP,
        write,
        write_key,
        write_title,
    )

    write_title(plotter, dataset)
    write(plotter, "\n".join(_sizes(dataset)), 0.885, 13)
    parts = drawing.colouring.parts or {}
    top = 0.76
    key = {f"{name}, {_thickness(dataset, name)} thick": colour for name, colour in parts.items()}
    write_key(plotter, key, top)
    top -= KEY_STEP * len(key) + 0.03
    dots = {
        f"set “{name}”, {_count(len(nodes), 'node')}": colour
        for (name, nodes), colour in zip(node_sets.items(), SET_COLOURS, strict=False)
    }
    write_key(plotter, dots, top, sign="\N{BLACK CIRCLE}")
    top -= KEY_STEP * len(dots) + 0.03
    notes = [*_hangs(dataset)]
    if drawing.exaggeration != 1:
        notes.append(f"clearance drawn\n{drawing.exaggeration:g} times as large")
    write(plotter, "\n".join(notes), top, 13, color=FAINT)


def _sizes(dataset: xr.Dataset) -> list[str]:
    """Number of blades, radius and clearance, in words."""
    clearance = dataset["clearance"].values
    return [
        f"{dataset.sizes['blade']} blades",
        f"tip radius {_length(float(dataset.attrs['tip_radius']))}",
        f"clearance {_range(clearance)}",
    ]


def _thickness(dataset: xr.Dataset, part: str) -> str:
    """Thickness of a part, or the range of it."""
    if part == "casing":
        return _range(dataset["casing_thickness"].values)
    names = dataset["rotor_part"].values.astype(str)
    own = names == ("" if part == "other beams" and part not in names else part)
    return _range(dataset["rotor_thickness"].values[own])


def _hangs(dataset: xr.Dataset) -> list[str]:
    """What holds the bodies and hangs on them, in words."""
    clamped = int(dataset.attrs["clamped"])
    lines = ["centre held" if clamped else "shaft on two springs"]
    kinds = dataset["support_kind"].values.astype(str)
    held = [
        _count(int(np.sum(kinds == kind)), kind)
        for kind in ("spring", "strut")
        if np.any(kinds == kind)
    ]
    if float(dataset["casing_foundation"]) > 0:
        held.insert(0, "elastic support")
    lines.append("casing: " + (", ".join(held) if held else "free"))
    masses = dataset["point_mass"].values
    if len(masses):
        lines.append(f"{_count(len(masses), 'point mass')}, {masses.sum():.4g} kg")
    for name, what in (("rotor_spring", "spring"), ("rotor_link", "rigid link")):
        if len(dataset[name]):
            lines.append(f"{_count(len(dataset[name]), what)} on the bladed disk")
    return lines


def _count(number: int, what: str) -> str:
    plural = "es" if what.endswith("s") else "s"
    return f"{number} {what}{plural if number != 1 else ''}"


def _range(lengths: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    low, high = float(lengths.min()), float(lengths.max())
    if high - low <= 1e-9 * high:
        return _length(high)
    unit, scale = length_unit(high)
    return f"{scale * low:.3g} to {scale * high:.3g} {unit}"


def _length(length: float) -> str:
    unit, scale = length_unit(length)
    return f"{scale * length:.4g} {unit}"

"""Picture of a stage before any run: parts, supports and named sets."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import imageio.v2 as imageio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.files import replacing
from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.result import stage_dataset
from bladewhirl.postprocess.fields.strains import rotor_sections
from bladewhirl.postprocess.pictures.appearance import FAINT, SQUARE
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.offscreen import off_screen_plotter, pixels_of
from bladewhirl.postprocess.pictures.render import WINDOW
from bladewhirl.postprocess.plotting.files import checked_target

if TYPE_CHECKING:
    from bladewhirl.postprocess.pictures.scene import StageScene

SET_COLOURS = ("#ffffff", "#20262e", "#f0e442", "#cc79a7", "#56b4e9", "#009e73")
"""Colours of the dots at the nodes of sets, in turn."""

DOT = 0.011  #: radius of the dots of the first set, relative to the picture; others are smaller


def stage_at_rest(
    arrays: StageArrays, *, title: str, tip_radius: float, casing_radius: float, clamped: bool
) -> xr.Dataset:
    """Return a stage at rest, at one instant."""
    motion = {
        "time": np.zeros(1),
        "rotor_displacement": np.zeros((1, len(arrays.rotor_frequency))),
        "casing_displacement": np.zeros((1, len(arrays.casing_frequency))),
    }
    return stage_dataset(arrays, motion).assign_attrs(
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
    """Draw a stage with its parts, sets and supports as PNG; return the path.

    Args:
        dataset: from `stage_at_rest`, or a result, of which the first record is drawn.
        path: target.
        node_sets: nodes of the rotor by the name of the set.
        exaggeration: factor of the clearance; chosen when None, see `Drawing`.
        size: width and height [pixels].

    Raises:
        ViewError: the name does not end in .png, or the factor is invalid.
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
    """Dots at the nodes of every set, concentric where sets share a node."""
    for number, (nodes, colour) in enumerate(zip(node_sets.values(), SET_COLOURS, strict=False)):
        size = DOT * (1.0 - number / (len(SET_COLOURS) + 1))
        scene.dots(scene.drawing.nodes[nodes], size, colour, layer=8 + 2 * number)


def _describe(scene: StageScene, dataset: xr.Dataset, node_sets: Mapping[str, IntArray]) -> None:
    """Write title, sizes, keys of parts, sets and symbols, and numbers of supports."""
    from bladewhirl.postprocess.pictures.panel import (
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
    write(plotter, draw_scale_bar(scene, "clearance"), 0.085, 11, indent=-SQUARE)
    write(plotter, "\n".join(size_lines(dataset)), 0.885, 13)
    write(plotter, "parts and their thickness", 0.79, 13, color=FAINT)
    parts = drawing.colouring.parts or {}
    key = {f"{name}, {thickness(dataset, name)}": colour for name, colour in parts.items()}
    sets = [f"set “{name}”: {len(nodes)}" for name, nodes in node_sets.items()]
    dots = dict(zip(sets, SET_COLOURS, strict=False))
    top = 0.76
    for entries, sign in ((key, "\N{BLACK SQUARE}"), (dots, "\N{BLACK CIRCLE}")):
        write_key(plotter, entries, top, sign=sign)
        top -= KEY_STEP * len(entries) + 0.03
    symbols = write_symbols(scene, top)
    top -= KEY_STEP * symbols + 0.03 * (symbols > 0)
    notes = [textwrap.fill(line, LINE_LETTERS) for line in support_lines(dataset)]
    if drawing.exaggeration != 1:
        notes.append(f"clearance drawn\n{drawing.exaggeration:g} times as large")
    write(plotter, "\n".join(notes), top, 13, color=FAINT)


def size_lines(dataset: xr.Dataset) -> list[str]:
    """Return number of blades, tip radius and clearance, a line each."""
    clearance = dataset["clearance"].values[:, None] + dataset["tip_recess"].values
    return [
        f"{dataset.sizes['blade']} blades",
        f"tip radius {handy(float(dataset.attrs['tip_radius']), 'm', 4)}",
        f"clearance {_range(clearance)}",
    ]


def thickness(dataset: xr.Dataset, part: str) -> str:
    """Return the thickness of a part, or its range."""
    if part == "casing":
        return _range(dataset["casing_thickness"].values)
    names = dataset["rotor_part"].values.astype(str)
    members = names == ("" if part == "other beams" and part not in names else part)
    return _range(rotor_sections(dataset, "thickness", 1)[members])


def support_lines(dataset: xr.Dataset) -> list[str]:
    """Return the numbers of supports and attachments, a line each; zero is left out."""

    def positive(name: str, which: Any = ...) -> int:
        return int(np.count_nonzero(_values(dataset, name)[which] > 0))

    strut = _values(dataset, "support_kind").astype(str) == "strut"
    radial, tangential = (
        _values(dataset, f"support_{way}_damping") > 0 for way in ("radial", "tangential")
    )
    masses, clamped = _values(dataset, "point_mass"), bool(dataset.attrs["clamped"])
    stiffness = _values(dataset, "shaft_stiffness")
    sides = ("support_radial_stiffness", "support_tangential_stiffness")
    counts = {
        "shaft springs": 0 if clamped else 2,
        "shaft dampers": 0 if clamped else positive("shaft_damping"),
        "casing springs": sum(positive(name, ~strut) for name in sides),
        "casing struts": np.count_nonzero(strut),
        "casing dampers": np.count_nonzero([radial & ~strut, tangential & ~strut])
        + np.count_nonzero((radial | tangential) & strut),
        "springs on the bladed disk": len(_values(dataset, "rotor_spring")),
        "rigid links": len(_values(dataset, "rotor_link")),
        f"point masses ({masses.sum():.4g} kg)": len(masses),
    }
    lines = [f"{name}: {count}" for name, count in counts.items() if count]
    if clamped:
        lines.insert(0, "centre clamped")
    elif np.unique(stiffness).size > 1:
        values = " and ".join(handy(value, "N/m", 3) for value in stiffness)
        lines.insert(1, f"{values}, {dataset['shaft_frame'].values} frame")
    if float(dataset["casing_foundation"]) > 0:
        lines.append("elastic support of the casing")
    elif not (counts["casing springs"] or counts["casing struts"] or counts["casing dampers"]):
        lines.append("casing free")
    return lines


def _values(dataset: xr.Dataset, name: str) -> NDArray[Any]:
    """Values of a variable; empty if a stage has none."""
    return dataset[name].values if name in dataset else np.zeros(0)


def _range(lengths: Array) -> str:
    low, high = float(lengths.min()), float(lengths.max())
    if high - low <= 1e-9 * high:
        return handy(high, "m", 4)
    unit, scale = handy_unit(high, "m")
    return f"{scale * low:.3g} to {scale * high:.3g} {unit}"

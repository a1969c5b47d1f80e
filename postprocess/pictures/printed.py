"""Stills for print: the stage from VTK, with the title, the notes and the scales of a figure."""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from bladewhirl.postprocess.fields.by_blade import blade_starts
from bladewhirl.postprocess.fields.wheels import with_surfaces
from bladewhirl.postprocess.pictures import appearance as look
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.offscreen import Pixels, off_screen_plotter, pixels_of
from bladewhirl.postprocess.plotting.files import checked_target
from bladewhirl.postprocess.plotting.legends import Group, legends_below
from bladewhirl.postprocess.plotting.style import INCH, STYLE, new_figure, save_figure, styled
from bladewhirl.postprocess.plotting.titles import head

NOTES = 0.03  #: height of the title, the notes and the scales [m]
LETTERS = 10.0  #: size of blade numbers in a picture [points of a window that is 960 pixels high]


def print_still(
    dataset: xr.Dataset, path: str | Path, record: int, *, width: float, **view: Any
) -> Path:
    """Draw the stage at a record as PNG for print with a width [m]; return the path.

    `view` is exaggeration, frame, colour and view, see `Drawing`.

    Raises:
        ViewError: the path does not end in .png.
        OffScreenError: the system cannot draw without a display.
    """
    target, dataset = checked_target(path, ".png"), with_surfaces(dataset)
    drawing = Drawing(dataset, np.array([record]), **view)
    (path,) = save_figure(printed(dataset, drawing, width), target)
    return path


@styled
def printed(dataset: xr.Dataset, drawing: Drawing, width: float) -> Figure:
    """Return a figure with a width [m] of the first picture of a drawing."""
    picture, field = drawing.picture(0), drawing.colouring
    pixels, bar = _stage(dataset, drawing, width)
    rows, columns = (np.flatnonzero((pixels < 255).any(axis=(axis, 2))) for axis in (1, 0))
    seen = pixels[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    tall = width * len(seen) / seen.shape[1]
    figure = new_figure(width=width, height=NOTES + min(tall, width))
    axes = figure.add_subplot()
    axes.imshow(seen, interpolation="antialiased")
    axes.set_axis_off()
    if field.parts is None:
        for label, scale in field.scales.items():
            shown = ScalarMappable(Normalize(*scale.limits), scale.colours)
            look_of: dict[str, Any] = {"location": "bottom", "aspect": 40, "shrink": 0.8}
            scales = figure.colorbar(shown, ax=axes, label=f"{field.name}, {label}", **look_of)
            scales.ax.locator_params(nbins=5)
    contact = look.contact_text(picture.blade_forces, drawing.record_step).replace("\n", ", ", 1)
    size = look.enlargement(drawing.exaggeration, normalised=drawing.normalised)
    time = look.time_text(picture.time, drawing.record_step)
    none = [field.name] * (field.parts is None and not field.scales)
    words = [time, f"{drawing.frame} frame", size, *none, *drawing.dots, contact]
    words = [each.replace("\n", " ") for each in words] + [f"bar: {bar}".replace("\n", ", ")]
    head(figure, dataset.assign_attrs(case_title=dataset.attrs["title"]), *words)
    parts = (field.parts or {}).items()
    legends_below(figure, Group([(Patch(color=colour), name) for name, colour in parts]))
    return figure


def _stage(dataset: xr.Dataset, drawing: Drawing, width: float) -> tuple[Pixels, str]:
    """Return the stage without a panel, and the text of its scale bar; blade numbers have the size
    of the letters of a figure."""
    size = round(STYLE["savefig.dpi"] * width / INCH)
    letters = STYLE["xtick.labelsize"] * INCH / 72 / (LETTERS / 960 * width)
    with off_screen_plotter((round(size / look.SQUARE), size)) as plotter:
        from bladewhirl.postprocess.pictures.panel import BladeNumbers, draw_scale_bar
        from bladewhirl.postprocess.pictures.scene import StageScene

        scene = StageScene(plotter, drawing)
        bar = draw_scale_bar(scene, "" if drawing.normalised else "motion and clearance")
        BladeNumbers(scene, blade_starts(dataset), letters).show(drawing.picture(0))
        scene.aim()
        return pixels_of(plotter)[:, :size], bar

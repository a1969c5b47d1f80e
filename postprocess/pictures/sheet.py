"""Sheets: many stills of a run in one file, with one panel for all."""

from __future__ import annotations

from pathlib import Path

import imageio.v2 as imageio
import numpy as np
import xarray as xr
from PIL import Image, ImageDraw, ImageFont

from bladewhirl.meshes.files.drafts import replacing
from bladewhirl.postprocess.fields.kinematics import IntArray
from bladewhirl.postprocess.pictures.appearance import FONT, INK, SQUARE
from bladewhirl.postprocess.pictures.colouring import Field
from bladewhirl.postprocess.pictures.drawing import Drawing, Frame
from bladewhirl.postprocess.pictures.offscreen import Pixels, stage_view
from bladewhirl.postprocess.plotting.files import checked_target

CELL = 480  #: width and height of a picture [pixels]
PANEL_HEIGHT = 960  #: least height of a sheet, so that its panel can be read


def render_sheet(
    dataset: xr.Dataset,
    path: str | Path,
    records: IntArray,
    *,
    exaggeration: float | None = None,
    frame: Frame = "static",
    colour: Field = "displacement",
    columns: int | None = None,
    cell: int = CELL,
) -> Path:
    """A PNG with the stage at each of the records, row by row, beside one panel; returns its path.

    All share one scale of colours, forces and displacements. `columns` is chosen by default, `cell`
    is the width of a picture in pixels. ViewError and OffScreenError as for `render_still`.
    """
    target = checked_target(path, ".png")
    drawing = Drawing(dataset, records, exaggeration=exaggeration, frame=frame, colour=colour)
    wide = columns or int(np.ceil(np.sqrt(len(records))))
    rows = -(-len(records) // wide)
    size = (round(cell / SQUARE), cell)
    sheet = np.full((rows * cell, wide * cell, 3), 255, dtype=np.uint8)
    with stage_view(dataset, drawing, size, sheet=True) as picture:
        for index in range(len(records)):
            row, column = divmod(index, wide)
            place = (slice(row * cell, (row + 1) * cell), slice(column * cell, (column + 1) * cell))
            sheet[place] = _labelled(picture(index)[:, :cell], float(drawing.times[index]))
    height = max(len(sheet), PANEL_HEIGHT)
    with stage_view(dataset, drawing, (round(height / SQUARE), height), sheet=True) as picture:
        picture(0)
        beside = picture(None)[:, height:]
    image = np.full((height, sheet.shape[1] + beside.shape[1], 3), 255, dtype=np.uint8)
    image[: len(sheet), : sheet.shape[1]] = sheet
    image[:, sheet.shape[1] :] = beside
    with replacing(target) as draft:
        imageio.imwrite(draft, image)
    return target


def _labelled(pixels: Pixels, time: float) -> Pixels:
    """A picture with its time [s] in the upper left corner."""
    image = Image.fromarray(pixels)
    font = ImageFont.truetype(FONT, round(0.045 * image.height))
    inset = round(0.015 * image.height)
    ImageDraw.Draw(image).text((inset, inset), f"{1e3 * time:.4g} ms", fill=INK, font=font)
    return np.asarray(image)

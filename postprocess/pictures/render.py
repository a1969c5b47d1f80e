"""Stills, sheets of stills and animations of a run, drawn off-screen.

pyvista is imported by `offscreen` where it is used, because importing VTK takes long, and must not
happen before the check that VTK can draw.
"""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from PIL import Image, ImageDraw, ImageFont

from bladewhirl.files import replacing
from bladewhirl.postprocess.fields import kinematics, rotation
from bladewhirl.postprocess.fields.by_blade import of_blades
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.wheels import with_surfaces
from bladewhirl.postprocess.pictures import films
from bladewhirl.postprocess.pictures.appearance import FONT, INK, SQUARE
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.offscreen import Pixels, stage_view, tiled
from bladewhirl.postprocess.plotting.files import checked_target

WINDOW = (1280, 960)  #: [pixels]; multiples of 16, for video codecs
GIF_WINDOW = (960, 720)  #: [pixels]; smaller than `WINDOW`, because a GIF file is large
CELL = 480  #: width and height of a picture of a sheet [pixels]
PANEL_HEIGHT = 960  #: smallest height of a sheet, for a legible panel [pixels]
FRAMES = 120  #: number of pictures of an animation by default
MOST_FRAMES = 600  #: largest number of pictures chosen for a given time window
MOST_STILLS = 200  #: largest number of pictures of a sheet
FRAMES_PER_BLADE = 3  #: with fewer pictures per blade passage, the rotor seems to turn backward


def animation_records(
    dataset: xr.Dataset,
    *,
    frames: int | None = None,
    start: float | None = None,
    end: float | None = None,
) -> IntArray:
    """Return the records of an animation in which the rotation is smooth.

    Pictures are a whole number of records apart, with at least 24 pictures in a revolution and
    three in a blade passage. Without a time window the animation has `frames` pictures (120 by
    default) around the strongest contact, or at the end of a run without contact. If only `start`
    or only `end` is given, the pictures start or end at this time. If both are given, the pictures
    cover the window: at most 600 pictures, or `frames` pictures, which can be too few for a smooth
    rotation (see `sampling_hint`).

    Raises:
        ViewError: the time window does not begin inside the run, or `frames` is not positive.
    """
    window = kinematics.frame_records(dataset, dataset.sizes["time"], start, end)
    if start is not None and end is not None:
        chosen = window[:: _stride(dataset)]
        count = min(len(chosen), MOST_FRAMES) if frames is None else frames
        return (
            chosen if count == len(chosen) else kinematics.frame_records(dataset, count, start, end)
        )
    pictures, stride = FRAMES if frames is None else frames, _stride(dataset)
    kinematics.check_frames(pictures)
    span = stride * (pictures - 1) + 1
    if span >= len(window):
        return window[::stride]
    if start is not None:
        return window[:span:stride]
    first = len(window) - span if end is not None else _busiest(dataset, span)
    return window[first : first + span : stride]


def sheet_records(
    dataset: xr.Dataset, frames: int, *, start: float | None = None, end: float | None = None
) -> IntArray:
    """Return equidistant records for a sheet.

    Without a time window the records cover the revolution with the strongest contact, in a run
    without contact the last revolution, and at zero speed the complete run.

    Raises:
        ViewError: the time window does not begin inside the run, or `frames` is not positive.
    """
    kinematics.check_frames(frames, MOST_STILLS)
    speed, step = abs(float(dataset.attrs["speed"])), float(dataset.attrs["record_step"])
    span = 1 + round(2 * np.pi / speed / step) if speed else dataset.sizes["time"]
    if start is not None or end is not None or not frames <= span < dataset.sizes["time"]:
        return kinematics.frame_records(dataset, frames, start, end)
    return _busiest(dataset, span) + np.linspace(0, span - 1, frames).round().astype(np.int64)


def strongest_contact(dataset: xr.Dataset) -> int:
    """Return the record of the largest contact impulse on a blade; the last record of a run without
    contact."""
    largest = of_blades(dataset, _contact_impulse(dataset)).max(axis=1, initial=0.0)
    return int(np.argmax(largest)) if largest.any() else len(largest) - 1


def render_still(
    dataset: xr.Dataset,
    path: str | Path,
    record: int,
    *,
    orbit: bool = False,
    size: tuple[int, int] = WINDOW,
    **view: Any,
) -> Path:
    """Draw the stage at a record as PNG; return the path.

    `view` is exaggeration, frame, colour and view, see `Drawing`. With `orbit` an inset shows the
    orbit of the shaft in the previous revolution.

    Raises:
        ViewError: the path does not end in .png.
        OffScreenError: the system cannot draw without a display.
    """
    target = checked_target(path, ".png")
    dataset = with_surfaces(dataset)
    drawing = Drawing(dataset, np.array([record]), **view)
    trail = _revolution_before(dataset, record) if orbit else None
    with stage_view(dataset, drawing, size, trail=trail) as picture:
        return films.write_pictures(target, picture, 1)


def render_animation(
    dataset: xr.Dataset,
    path: str | Path,
    records: IntArray,
    *,
    orbit: bool = False,
    size: tuple[int, int] | None = None,
    progress: films.Progress | None = None,
    **view: Any,
) -> Path:
    """Draw records (see `animation_records`) as a GIF or MP4 with 25 pictures per second; return
    the path.

    `view` is exaggeration, frame, colour and view, see `Drawing`; all pictures have the same scales
    of colours and arrows. With `orbit` an inset shows the orbit of the shaft. The default size is
    960 x 720 pixels for a GIF and 1280 x 960 pixels for an MP4. See `Progress` for `progress`.

    Raises:
        ViewError: the path does not end in .gif or .mp4.
        OffScreenError: the system cannot draw without a display.
    """
    target = checked_target(path, ".gif", ".mp4")
    dataset = with_surfaces(dataset)
    drawing = Drawing(dataset, records, **view)
    seconds = float(np.ptp(dataset["time"].values[records]))
    slower = (len(records) - 1) / films.FRAME_RATE / seconds if seconds else 1.0
    note = f"slowed down {slower:{',.0f' if slower > 999 else '.3g'}} times" if slower > 1 else ""
    trail = np.arange(records.min(), records.max() + 1) if orbit else None
    size = size or (GIF_WINDOW if target.suffix.lower() == ".gif" else WINDOW)
    with stage_view(dataset, drawing, size, note, trail=trail) as picture:
        return films.write_pictures(target, picture, len(records), progress)


def render_sheet(
    dataset: xr.Dataset,
    path: str | Path,
    records: IntArray,
    *,
    columns: int | None = None,
    cell: int = CELL,
    **view: Any,
) -> Path:
    """Draw a sheet with a picture of each record, row by row, and one panel at the side, as PNG;
    return the path.

    All pictures have the same scales of colours, forces and displacements. `columns` is chosen when
    None, `cell` is the width of a picture [pixels], `view` is exaggeration, frame, colour and view,
    see `Drawing`.

    Raises:
        ViewError: the path does not end in .png.
        OffScreenError: the system cannot draw without a display.
    """
    target = checked_target(path, ".png")
    dataset = with_surfaces(dataset)
    drawing = Drawing(dataset, records, **view)
    with stage_view(dataset, drawing, (round(cell / SQUARE), cell), sheet=True) as picture:
        cells = [
            _labelled(picture(index)[:, :cell], float(time))
            for index, time in enumerate(drawing.times)
        ]
    sheet = tiled(cells, columns)
    height = max(len(sheet), PANEL_HEIGHT)
    with stage_view(dataset, drawing, (round(height / SQUARE), height), sheet=True) as picture:
        picture(0)
        beside = picture(None)[:, height:]
    image = np.full((height, sheet.shape[1] + beside.shape[1], 3), 255, dtype=np.uint8)
    image[: len(sheet), : sheet.shape[1]] = sheet
    image[:, sheet.shape[1] :] = beside
    with replacing(target) as draft:
        Image.fromarray(image).save(draft, format="png")
    return target


def _labelled(pixels: Pixels, time: float) -> Pixels:
    """Return a picture with its time [s] in the upper left corner."""
    image = Image.fromarray(pixels)
    font = ImageFont.truetype(FONT, round(0.045 * image.height))
    inset = round(0.015 * image.height)
    ImageDraw.Draw(image).text((inset, inset), f"{1e3 * time:.4g} ms", fill=INK, font=font)
    return np.asarray(image)


def _revolution_before(dataset: xr.Dataset, record: int) -> IntArray:
    """Return the records of the revolution before a record; at zero speed all earlier records."""
    turned = rotation.turns(dataset)
    return np.arange(int(np.searchsorted(turned, turned[record] - 1.0)), record + 1)


def _stride(dataset: xr.Dataset) -> int:
    """Return the number of records from one picture to the next."""
    speed = abs(float(dataset.attrs["speed"]))
    if speed == 0:
        return 1
    rate = max(kinematics.FRAMES_PER_REVOLUTION, FRAMES_PER_BLADE * dataset.sizes["contact_node"])
    step = float(dataset.attrs["record_step"])
    return max(1, int(2 * np.pi / speed / rate / step))


def _busiest(dataset: xr.Dataset, span: int) -> int:
    """Return the first record of the interval of `span` records that has the largest total contact
    impulse; in a run without contact, the first record of the last interval."""
    total = np.concatenate([[0.0], np.cumsum(_contact_impulse(dataset).sum(axis=1))])
    within = total[span:] - total[:-span]
    return int(np.argmax(within)) if total[-1] > 0 else len(within) - 1


def _contact_impulse(dataset: xr.Dataset) -> Array:
    """Return the contact impulse since the previous record (time, contact_node) [N s]; zero for a
    mode."""
    if "contact_impulse" in dataset:
        return np.asarray(dataset["contact_impulse"].values)
    return np.zeros((dataset.sizes["time"], dataset.sizes["contact_node"]))

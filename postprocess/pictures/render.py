"""Stills and animations of a run, drawn off-screen: what the stage did, in a file anyone opens.

pyvista and the scene are imported where they are used (`offscreen`): loading VTK takes longer than
a march needs to start, and it must not happen before it is known that VTK can draw here.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

import imageio.v2 as imageio
import numpy as np
import xarray as xr
from PIL import Image

from bladewhirl.meshes.files.drafts import replacing
from bladewhirl.postprocess.fields.kinematics import (
    FRAMES_PER_REVOLUTION,
    Array,
    IntArray,
    ViewError,
    frame_records,
    nearest_records,
)
from bladewhirl.postprocess.pictures.appearance import scene_colours
from bladewhirl.postprocess.pictures.colouring import Field
from bladewhirl.postprocess.pictures.drawing import Drawing, Frame
from bladewhirl.postprocess.pictures.films import (
    FRAME_RATE,
    Progress,
    shared_palette,
    write_gif,
    write_mp4,
)
from bladewhirl.postprocess.pictures.offscreen import Pixels, stage_view
from bladewhirl.postprocess.plotting.files import checked_target

WINDOW = (1280, 960)  #: pixels; multiples of 16, as video codecs want
GIF_WINDOW = (960, 720)  #: smaller, since a GIF compresses badly
FRAMES = 120
MOST_FRAMES = 600
FRAMES_PER_BLADE = 3  #: fewer pictures per passing blade make the wheel seem to turn backward


def animation_records(
    dataset: xr.Dataset,
    *,
    frames: int | None = None,
    start: float | None = None,
    end: float | None = None,
) -> IntArray:
    """Records of an animation that shows a smooth turn.

    Pictures are a whole number of records apart, so close that a revolution gets at least 24 and
    a blade three on its way to the next one's place. Without a window, `frames` (120) of them are
    put where contact was strongest, at the end of the run if there was none; with one end of the
    window they start or end there. With both, the window is filled, by at most 600 pictures or by
    `frames`, which may be too few for a smooth turn (see `sampling_hint`). ViewError as for
    `frame_records`.
    """
    window = frame_records(dataset, dataset.sizes["time"], start, end)
    if start is not None and end is not None:
        chosen = window[:: _stride(dataset)]
        wanted = min(len(chosen), MOST_FRAMES) if frames is None else frames
        return chosen if wanted == len(chosen) else frame_records(dataset, wanted, start, end)
    if frames is not None and frames < 1:
        raise ViewError(f"number of frames must be at least 1, got {frames}")
    stride = _stride(dataset)
    span = stride * ((frames or FRAMES) - 1) + 1
    if span >= len(window):
        return window[::stride]
    if start is not None:
        return window[:span:stride]
    first = len(window) - span if end is not None else _busiest(dataset, span)
    return window[first : first + span : stride]


def sheet_records(
    dataset: xr.Dataset, frames: int, *, start: float | None = None, end: float | None = None
) -> IntArray:
    """Records of a sheet, evenly spread over its window.

    Without a window that is the revolution in which contact was strongest, the last one if there
    was none; all of the run where nothing turns. ViewError as for `frame_records`.
    """
    speed, step = abs(float(dataset.attrs["speed"])), float(dataset.attrs["record_step"])
    span = 1 + round(2 * np.pi / speed / step) if speed else dataset.sizes["time"]
    if start is not None or end is not None or not frames <= span < dataset.sizes["time"]:
        return frame_records(dataset, frames, start, end)
    return _busiest(dataset, span) + np.linspace(0, span - 1, frames).round().astype(np.int64)


def strongest_contact(dataset: xr.Dataset) -> int:
    """Record with the largest contact impulse on one blade, the last one if none was touched."""
    largest = _contact_impulse(dataset).max(axis=1)
    return int(np.argmax(largest)) if largest.any() else len(largest) - 1


def render_still(
    dataset: xr.Dataset,
    path: str | Path,
    *,
    time: float | None = None,
    exaggeration: float | None = None,
    frame: Frame = "static",
    colour: Field = "displacement",
    orbit: bool = False,
    size: tuple[int, int] = WINDOW,
) -> Path:
    """A PNG of the stage at the record nearest to `time` [s]; returns its path.

    Without a time, the record of the strongest contact is shown. Exaggeration, frame and colour
    are those of `Drawing`; with `orbit` an inset shows the way of the shaft since the revolution
    before. ViewError for a time outside the run or another kind of file, OffScreenError
    where the system can't draw.
    """
    target = checked_target(path, ".png")
    if time is None:
        records = np.array([strongest_contact(dataset)])
    else:
        check_inside(dataset, time)
        records = nearest_records(dataset, np.array([time]))
    drawing = Drawing(dataset, records, exaggeration=exaggeration, frame=frame, colour=colour)
    trail = _revolution_before(dataset, int(records[0])) if orbit else None
    with stage_view(dataset, drawing, size, trail=trail) as picture, replacing(target) as draft:
        imageio.imwrite(draft, picture(0))
    return target


def render_animation(
    dataset: xr.Dataset,
    path: str | Path,
    records: IntArray,
    *,
    exaggeration: float | None = None,
    frame: Frame = "static",
    colour: Field = "displacement",
    orbit: bool = False,
    size: tuple[int, int] | None = None,
    progress: Progress | None = None,
) -> Path:
    """A GIF or MP4 of the given records (see `animation_records`), 25 a second; returns its path.

    Exaggeration, frame and colour are those of `Drawing`; colours and arrows keep one scale
    throughout. With `orbit` an inset shows the way of the shaft.
    `size` in pixels is 960 x 720 for a GIF and 1280 x 960 for an MP4 by default. `progress` is
    told pictures done and pictures in all. ViewError for another kind of file,
    OffScreenError where the system can't draw.
    """
    target = checked_target(path, ".gif", ".mp4")
    gif = target.suffix.lower() == ".gif"
    drawing = Drawing(dataset, records, exaggeration=exaggeration, frame=frame, colour=colour)
    seconds = float(np.ptp(dataset["time"].values[records]))
    slower = (len(records) - 1) / FRAME_RATE / seconds if seconds else 1.0
    note = f"slowed down {slower:.3g} times" if slower > 1 else ""
    trail = np.arange(records.min(), records.max() + 1) if orbit else None
    size = size or (GIF_WINDOW if gif else WINDOW)
    with (
        stage_view(dataset, drawing, size, note, trail=trail) as picture,
        replacing(target) as draft,
    ):

        def pictures(drawn: Mapping[int, Pixels]) -> Iterator[Pixels]:
            for index in range(len(records)):
                yield drawn[index] if index in drawn else picture(index)
                if progress:
                    progress(index + 1, len(records))

        if gif:
            samples = {i: picture(i) for i in range(0, len(records), -(-len(records) // 6))}
            write_gif(draft, pictures(samples), _palette(drawing, [*samples.values()]))
        else:
            write_mp4(draft, pictures({}))
    return target


def _palette(drawing: Drawing, samples: list[Pixels]) -> Image.Image:
    """The 256 colours of a GIF: those of the scene, and what lies between them in samples."""
    seen = np.vstack(samples).reshape(1, -1, 3)
    drawn = seen[:, np.any(seen[0] < 240, axis=1)]  # a near-white would be taken for white
    return shared_palette(scene_colours(drawing.colouring, 90), drawn)


def _revolution_before(dataset: xr.Dataset, record: int) -> IntArray:
    """Records of the last revolution up to one; of all the time before it where nothing turns."""
    speed = abs(float(dataset.attrs["speed"]))
    time = dataset["time"].values
    begin = time[record] - 2 * np.pi / speed if speed else time[0]
    return np.arange(int(np.searchsorted(time, begin)), record + 1)


def check_inside(dataset: xr.Dataset, time: float) -> None:
    """See that a time [s] lies in the run; else ViewError."""
    first, last = dataset["time"].values[[0, -1]]
    step = float(dataset.attrs["record_step"])  # the last record may fall short of the end
    if not first - step <= time <= last + step:
        raise ViewError(f"time {time:g} s lies outside the run, [{first:g}, {last:g}] s")


def _stride(dataset: xr.Dataset) -> int:
    """Records from one picture to the next."""
    speed = abs(float(dataset.attrs["speed"]))
    if speed == 0:
        return 1
    rate = max(FRAMES_PER_REVOLUTION, FRAMES_PER_BLADE * dataset.sizes["blade"])
    step = float(dataset.attrs["record_step"])
    return max(1, int(2 * np.pi / speed / rate / step))


def _busiest(dataset: xr.Dataset, span: int) -> int:
    """First of `span` records with the largest contact impulse in all; the last ones if none."""
    total = np.concatenate([[0.0], np.cumsum(_contact_impulse(dataset).sum(axis=1))])
    within = total[span:] - total[:-span]
    return int(np.argmax(within)) if total[-1] > 0 else len(within) - 1


def _contact_impulse(dataset: xr.Dataset) -> Array:
    """Contact impulse since the record before (time, blade) [N s]; zero of a mode in time."""
    if "contact_impulse" in dataset:
        return np.asarray(dataset["contact_impulse"].values)
    return np.zeros((dataset.sizes["time"], dataset.sizes["blade"]))

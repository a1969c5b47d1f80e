"""Films: GIFs whose pictures share one palette, and MP4s."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
from PIL import Image

from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.pictures.offscreen import Pixels

FRAME_RATE = 25  #: pictures per second; 40 ms is a multiple of the time unit of a GIF, 10 ms

Progress = Callable[[int, int], None]
"""Function that is called with the number of finished pictures and the number of all pictures."""


def write_gif(path: Path, pictures: Iterable[Pixels], palette: Image.Image) -> None:
    """Write a GIF that repeats without end.

    All pictures have the same palette and are not dithered, so that colours do not flicker; the
    file is half as large as with a palette for each picture.
    """
    frames = (
        Image.fromarray(pixels).quantize(palette=palette, dither=Image.Dither.NONE)
        for pixels in pictures
    )
    first = next(frames)
    duration = round(1000 / FRAME_RATE)
    with path.open("wb") as file:
        first.save(file, "GIF", save_all=True, append_images=frames, duration=duration, loop=0)


def shared_palette(exact: Array, sample: Pixels) -> Image.Image:
    """Return the palette of a GIF: the colours `exact` (colour, 3), between 0 and 1, and further
    colours from a sample of the pictures."""
    kept = np.round(255 * exact).astype(np.uint8).ravel().tolist()
    edges = Image.fromarray(sample).quantize(256 - len(exact)).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette((kept + edges)[: 3 * 256])
    return palette


def write_mp4(path: Path, pictures: Iterable[Pixels]) -> None:
    """Write an MP4 film with the H.264 codec, which browsers and presentation programs play."""
    # Any: imageio declares its writers without their methods.
    writer: Any = imageio.get_writer(path, fps=FRAME_RATE, codec="libx264", quality=7)
    with writer as film:
        for pixels in pictures:
            film.append_data(pixels)

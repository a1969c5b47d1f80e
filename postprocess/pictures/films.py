"""Films: GIFs whose pictures share one palette, and MP4s."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
from PIL import Image

from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.pictures.offscreen import Pixels

FRAME_RATE = 25  #: pictures a second; 40 ms are a whole number of a GIF's ticks

Progress = Callable[[int, int], None]
"""Told pictures done and pictures in all."""


def write_gif(path: Path, pictures: Iterable[Pixels], palette: Image.Image) -> None:
    """A GIF that loops. All pictures share one palette and are not dithered: colours don't
    flicker, and the file is half as large as with a palette for each picture.
    """
    frames = (
        Image.fromarray(pixels).quantize(palette=palette, dither=Image.Dither.NONE)
        for pixels in pictures
    )
    first = next(frames)
    duration = round(1000 / FRAME_RATE)
    with path.open("wb") as file:
        first.save(file, "GIF", save_all=True, append_images=frames, duration=duration, loop=0)


def shared_palette(meant: Array, sample: Pixels, colours: int = 256) -> Image.Image:
    """Colours of a GIF: those meant (colour, 3), between 0 and 1, exactly; the rest for the edges
    between them as a sample has them.
    """
    exact = np.round(255 * meant).astype(np.uint8).ravel().tolist()
    edges = Image.fromarray(sample).quantize(colours - len(meant)).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette((exact + edges)[: 3 * colours])
    return palette


def write_mp4(path: Path, pictures: Iterable[Pixels]) -> None:
    """An MP4 (H.264) that browsers and slides play."""
    # Any: imageio declares its writers without their methods.
    writer: Any = imageio.get_writer(path, fps=FRAME_RATE, codec="libx264", quality=7)
    with writer as film:
        for pixels in pictures:
            film.append_data(pixels)

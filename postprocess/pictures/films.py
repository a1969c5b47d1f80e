"""Files of pictures: PNGs, GIFs whose pictures share one palette, and MP4s."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
from PIL import Image, ImageColor

from bladewhirl.files import replacing
from bladewhirl.postprocess.pictures import appearance as look
from bladewhirl.postprocess.pictures.offscreen import Pixels

FRAME_RATE = 25  #: pictures per second, 40 ms each: a multiple of the time unit of a GIF, 10 ms
SAMPLES, STRIDE = 20, 4
"""Pictures from which the colours of a GIF are chosen, and the distance of their pixels."""
FIXED = (look.BACKGROUND, look.INK, look.FAINT, look.FORCE_COLOUR, look.NO_VALUE, look.MASS_COLOUR)
"""Colours that are in each palette."""

Progress = Callable[[int, int], None]
"""Function that is called with the number of finished pictures and the number of all pictures."""


def write_pictures(
    path: Path,
    picture: Callable[[int], Pixels],
    count: int,
    progress: Progress | None = None,
) -> Path:
    """Write pictures into a file and return its path. The file is a film if the path ends in .gif
    or .mp4, otherwise a PNG of the only picture.

    All pictures of a GIF have the same palette and are not dithered, so that colours do not
    flicker; the file is half as large as with a palette for each picture. MP4s have the H.264
    codec, which browsers and presentation programs play.

    Args:
        path: file to write.
        picture: function that draws the picture of a number from 0.
        count: number of pictures.
        progress: called after each picture of a film.
    """

    def pictures(drawn: Mapping[int, Pixels]) -> Iterator[Pixels]:
        for index in range(count):
            yield drawn[index] if index in drawn else picture(index)
            if progress:
                progress(index + 1, count)

    with replacing(path) as draft:
        if path.suffix.lower() == ".gif":
            samples = {i: picture(i) for i in range(0, count, -(-count // SAMPLES))}
            palette = _palette([*samples.values()])
            frames = (
                Image.fromarray(pixels).quantize(palette=palette, dither=Image.Dither.NONE)
                for pixels in pictures(samples)
            )
            wait = round(1000 / FRAME_RATE)
            more: dict[str, Any] = {"append_images": frames, "duration": wait, "loop": 0}
            with draft.open("wb") as file:
                next(frames).save(file, "GIF", save_all=True, **more)
        elif path.suffix.lower() == ".mp4":
            # Any: imageio declares its writers without their methods.
            writer: Any = imageio.get_writer(draft, fps=FRAME_RATE, codec="libx264", quality=7)
            with writer as film:
                for pixels in pictures({}):
                    film.append_data(pixels)
        else:
            Image.fromarray(picture(0)).save(draft, format="png")
    return path


def _palette(samples: list[Pixels]) -> Image.Image:
    """Return the palette of a GIF: fixed colours, and those that differ least from the samples."""
    seen = np.vstack([sample[::STRIDE, ::STRIDE].reshape(-1, 3) for sample in samples])[None]
    drawn = Image.fromarray(seen[:, np.any(seen[0] < 240, axis=1)])  # not colours close to white
    kept = [value for colour in FIXED for value in ImageColor.getrgb(colour)]
    chosen = drawn.quantize(256 - len(FIXED), Image.Quantize.MAXCOVERAGE, kmeans=1).getpalette()
    palette = Image.new("P", (1, 1))
    palette.putpalette((kept + (chosen or []))[: 3 * 256])
    return palette

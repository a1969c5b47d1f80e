"""Files of pictures: PNGs, GIFs whose pictures share one palette, and MP4s."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
from PIL import Image

from bladewhirl.files import replacing
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.pictures.offscreen import Pixels

FRAME_RATE = 25  #: pictures per second, 40 ms each: a multiple of the time unit of a GIF, 10 ms
SAMPLES = 6  #: number of pictures from which the further colours of a GIF are chosen

Progress = Callable[[int, int], None]
"""Function that is called with the number of finished pictures and the number of all pictures."""


def write_pictures(
    path: Path,
    picture: Callable[[int], Pixels],
    count: int,
    colours: Array,
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
        colours: colours in the palette of a GIF (colour, 3), between 0 and 1; further colours, such
            as those of smoothed edges, are chosen from samples of the pictures.
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
            palette = _palette(colours, [*samples.values()])
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


def _palette(colours: Array, samples: list[Pixels]) -> Image.Image:
    """Return the palette of a GIF."""
    seen = np.vstack(samples).reshape(1, -1, 3)
    drawn = seen[:, np.any(seen[0] < 240, axis=1)]  # without colours close to white
    kept = np.round(255 * colours).astype(np.uint8).ravel().tolist()
    others = Image.fromarray(drawn).quantize(256 - len(colours)).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette((kept + others)[: 3 * 256])
    return palette

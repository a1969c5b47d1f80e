"""Draw the pictures of README.md with commands of bladewhirl.

    python docs/pictures.py

The script takes three minutes. It reduces the colours of PNGs to a palette. The films show one
revolution of the rub in imbalance.toml, and half a revolution of that in bladed_disk.toml.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont, ImageSequence

from bladewhirl.postprocess.pictures.appearance import FONT, INK, SQUARE

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
BLADEWHIRL = Path(sys.executable).with_name("bladewhirl")
COLOURS = 256  #: number of colours of a palette
FRAMES, REVOLUTION = 36, ("--from", "0.9 s", "--to", "0.92367 s")  #: pictures, times of the film
HALF = ("--from", "2.6 ms", "--to", "5.9 ms")  #: times of the film of a disk in space
FILM = (560, 420)  #: width and height of a film [pixels]

GALLERY = {
    "curved_blades": "curved blades",
    "tapered_blades": "taper and tip masses",
    "packets": "packets of blades",
    "shrouded_blades": "shrouds",
    "shrouded_fan": "a mesh from Gmsh",
    "ringed_disk": "disk of rings",
    "rim_disk": "rim on a web of springs",
    "rigid_disk": "rigid disk",
    "elliptical_clearance": "elliptical clearance",
    "stiffened_casing": "stiffened casing",
    "casing_on_struts": "casing on struts",
    "spoked_disk": "disk of spokes",
    "mistuned_blades": "mistuned blades",
    "unequal_shaft": "unequal shaft",
    "unequal_bearings": "unequal bearings",
    "damped_supports": "springs and dampers",
}
"""Title above the picture of each example in the gallery."""

CELL, HEAD, ACROSS = 270, 30, 4  #: gallery: width of a cell and height of a title [pixels], columns
PLAIN = 96  #: number of colours of the gallery: few colours make a small file


def bladewhirl(*arguments: str | Path) -> None:
    """Run a command of bladewhirl; raise a CalledProcessError if the command fails."""
    subprocess.run([BLADEWHIRL, *arguments], check=True, stdout=subprocess.DEVNULL)


def keep(
    picture: Path,
    name: str,
    colours: int = COLOURS,
    method: Image.Quantize = Image.Quantize.MEDIANCUT,
    widest: int = 2400,
) -> None:
    """Save a picture, at most `widest` pixels wide, in docs/ with few colours."""
    (DOCS / name).parent.mkdir(exist_ok=True)
    with Image.open(picture) as image:
        image.thumbnail((widest, 2 * widest), Image.Resampling.LANCZOS)
        small = image.convert("RGB").quantize(colours, method=method, dither=Image.Dither.NONE)
    small.save(DOCS / name, optimize=True)


def keep_film(film: Path, name: str, colours: int | None = 64) -> None:
    """Save a GIF in docs/, reduced to the size `FILM` and a number of colours; None keeps the
    palette, which has the shades of lit surfaces."""
    with Image.open(film) as frames:
        wait = frames.info["duration"]
        palette = Image.new("P", (1, 1))
        palette.putpalette(frames.getpalette() or [])
        small = [
            frame.convert("RGB").resize(FILM, Image.Resampling.LANCZOS)
            for frame in ImageSequence.Iterator(frames)
        ]
    if colours is not None:
        samples = Image.fromarray(np.vstack([np.asarray(frame) for frame in small[::9]]))
        palette = samples.quantize(colours, method=Image.Quantize.MAXCOVERAGE)  # arrows stay orange
    first, *rest = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in small)
    first.save(DOCS / name, save_all=True, append_images=rest, duration=wait, loop=0, optimize=True)


def gallery(folder: Path) -> Path:
    """Draw the examples side by side; return the path of the picture."""
    rows = -(-len(GALLERY) // ACROSS)
    sheet = Image.new("RGB", (ACROSS * CELL, rows * (CELL + HEAD)), "white")
    font = ImageFont.truetype(FONT, round(0.55 * HEAD))
    for number, (name, title) in enumerate(GALLERY.items()):
        row, column = divmod(number, ACROSS)
        x, y = column * CELL, row * (CELL + HEAD)
        drawn = folder / f"{name}.png"
        bladewhirl("show", EXAMPLES / f"{name}.toml", "--json", "--png", "-o", drawn)
        with Image.open(drawn) as picture:
            stage = picture.crop((0, 0, round(SQUARE * picture.width), picture.height))
            sheet.paste(stage.resize((CELL, CELL), Image.Resampling.LANCZOS), (x, y + HEAD))
        label = ImageDraw.Draw(sheet)
        label.text((x + CELL / 2, y + HEAD / 2), title, fill=INK, font=font, anchor="mm")
    path = folder / "gallery.png"
    sheet.save(path)
    return path


def main() -> None:
    """Draw all pictures and save them in docs/."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        distortion, imbalance, chart = (folder / n for n in ("distortion", "imbalance", "chart"))
        bladewhirl("run", EXAMPLES / "casing_distortion.toml", "-o", distortion, "--frames", "0")
        rub = (EXAMPLES / "imbalance.toml", "--set", "march.duration=1.0")
        bladewhirl("run", *rub, "-o", imbalance, "--frames", "0")
        bladewhirl("render", imbalance, "--png", "--time", "0.9 s", "-o", folder / "still.png")
        bladewhirl("stability", EXAMPLES / "fan_stage.toml", "-o", chart, "--no-films")
        keep(gallery(folder), "gallery.png", PLAIN, Image.Quantize.FASTOCTREE)  # flat colours
        keep(folder / "still.png", "contact.png")
        film = ("--frames", str(FRAMES), *REVOLUTION, "--orbit", "-o", folder / "film.gif")
        bladewhirl("render", imbalance, "--gif", *film)
        keep_film(folder / "film.gif", "contact.gif")
        bladewhirl("run", EXAMPLES / "bladed_disk.toml", "-o", folder / "disk", "--frames", "0")
        film = ("--frames", str(FRAMES), *HALF, "-o", folder / "disk.gif")
        bladewhirl("render", folder / "disk", "--gif", *film)
        keep_film(folder / "disk.gif", "contact_3d.gif", None)
        keep(distortion / "energy.png", "distortion_energy.png")
        keep(imbalance / "orbit.png", "imbalance_orbit.png")
        keep(chart / "stability.png", "stability.png")


if __name__ == "__main__":
    main()

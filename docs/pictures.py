"""Draw the pictures of README.md with commands of bladewhirl.

    python docs/pictures.py

The script takes three minutes. It reduces the colours of PNGs to a palette. The film shows a
contact of the rub in bladed_disk.toml, without the panel beside the stage.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont, ImageSequence

from bladewhirl.postprocess.pictures.appearance import FONT, INK, SQUARE

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
BLADEWHIRL = Path(sys.executable).with_name("bladewhirl")
COLOURS = 256  #: number of colours of a palette
TOUCH = ("--from", "2.78 ms", "--to", "3.52 ms")  #: times of the film: the disk turns by two blades
FRAMES, WAIT = 24, 60  #: number of pictures of the film, time of each [ms]
FILM = 420  #: width and height of the film [pixels]

GALLERY = {
    "bladed_disk": "a sector of solids, 18 times",
    "twisted_blade": "a blade of solids",
    "shrouded_fan": "a mesh from Gmsh",
    "curved_blades": "curved blades",
    "tapered_blades": "taper and tip masses",
    "packets": "packets of blades",
    "shrouded_blades": "shrouds",
    "ringed_disk": "disk of rings",
    "rim_disk": "rim on a web of springs",
    "stiffened_casing": "stiffened casing",
    "casing_on_struts": "casing on struts",
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


def stage(picture: Image.Image) -> Image.Image:
    """Return the part of a picture that shows the stage, without the panel beside it."""
    return picture.crop((0, 0, round(SQUARE * picture.width), picture.height))


def keep_film(film: Path, name: str) -> None:
    """Save the stage of a GIF in docs/ with the size `FILM` and the colours of the GIF."""
    palette = Image.new("P", (1, 1))
    with Image.open(film) as frames:
        palette.putpalette(frames.getpalette() or [])
        first, *rest = (
            stage(frame.convert("RGB"))
            .resize((FILM, FILM), Image.Resampling.LANCZOS)
            .quantize(palette=palette, dither=Image.Dither.NONE)
            for frame in ImageSequence.Iterator(frames)
        )
    first.save(DOCS / name, save_all=True, append_images=rest, duration=WAIT, loop=0, optimize=True)


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
            cell = stage(picture).resize((CELL, CELL), Image.Resampling.LANCZOS)
            sheet.paste(cell, (x, y + HEAD))
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
        bladewhirl("stability", EXAMPLES / "fan_stage.toml", "-o", chart, "--no-films")
        keep(gallery(folder), "gallery.png", PLAIN, Image.Quantize.FASTOCTREE)  # flat colours
        bladewhirl("run", EXAMPLES / "bladed_disk.toml", "-o", folder / "disk", "--frames", "0")
        film = (
            *TOUCH,
            "--frames",
            str(FRAMES),
            "--view",
            "axial",
            "--colour",
            "stress",
            "--exaggeration",
            "100",
        )
        bladewhirl("render", folder / "disk", "--gif", *film, "-o", folder / "disk.gif")
        keep_film(folder / "disk.gif", "contact.gif")
        keep(distortion / "energy.png", "distortion_energy.png")
        keep(imbalance / "orbit.png", "imbalance_orbit.png")
        keep(chart / "stability.png", "stability.png")


if __name__ == "__main__":
    main()

"""Makes the pictures that README.md shows, with the commands a user would type.

    python docs/pictures.py

needs what `bladewhirl render` needs, and about a minute. PNGs are reduced to a palette.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
BLADEWHIRL = Path(sys.executable).with_name("bladewhirl")
COLOURS = 256  #: of a palette


def bladewhirl(*arguments: str | Path) -> None:
    """Run a command of the program; its failure is this script's."""
    subprocess.run([BLADEWHIRL, *arguments], check=True)


def keep(picture: Path, name: str) -> None:
    """Put a picture beside this script, small."""
    with Image.open(picture) as image:
        small = image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    small.save(DOCS / name, optimize=True)


def main() -> None:
    """Make all pictures."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        distortion, imbalance, chart = (folder / n for n in ("distortion", "imbalance", "chart"))
        bladewhirl("run", EXAMPLES / "casing_distortion.toml", "-o", distortion, "--frames", "0")
        bladewhirl("render", distortion, "--png", "--time", "30 ms", "-o", folder / "still.png")
        bladewhirl("run", EXAMPLES / "imbalance.toml", "-o", imbalance, "--frames", "0")
        bladewhirl("stability", EXAMPLES / "fan_stage.toml", "-o", chart, "--no-films")
        keep(folder / "still.png", "contact.png")
        keep(imbalance / "orbit.png", "imbalance_orbit.png")
        keep(chart / "stability.png", "stability.png")


if __name__ == "__main__":
    main()

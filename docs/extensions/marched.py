"""Marches an example for a short while; leaves its film, orbit and summary in a folder.

python marched.py EXAMPLE FOLDER
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

import bladewhirl as bw
from bladewhirl.studies.commands.cli import app

LONGEST, FRAMES = 0.2, 30  #: march under a load [s], pictures of the film


def march(example: Path, folder: Path) -> None:
    """Write NAME.gif, NAME-orbit.png and NAME-summary.json, unless nothing sets it off."""
    case = bw.read_case(example)
    if case.excitation.type == "none" and not case.initial.model_fields_set:
        return
    if case.excitation.type != "none":  # what grows by itself takes its time
        case = bw.with_values(case, {"march.duration": min(case.march.duration, LONGEST)})
    with tempfile.TemporaryDirectory() as scratch:
        run = bw.run(case, Path(scratch) / "run", frames=0)
        bw.render(run, folder / f"{example.stem}.gif", frames=FRAMES)
        for kept, name in (("orbit.png", "-orbit.png"), ("summary.json", "-summary.json")):
            shutil.copyfile(run.directory / kept, folder / f"{example.stem}{name}")


if __name__ == "__main__":
    example, folder = Path(sys.argv[1]), Path(sys.argv[2])
    march(example, folder)
    drawing = folder / f"{example.stem}.png"
    drawing.unlink(missing_ok=True)
    app(["show", str(example), "--json", "--png", "-o", str(drawing)])

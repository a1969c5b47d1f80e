"""Marches an example for a short while; leaves its film, orbit and summary in a folder.

python marched.py EXAMPLE FOLDER
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

import bladewhirl as bw

LONGEST, FRAMES = 0.3, 40  #: march under a load [s], pictures of the film


def march(example: Path, folder: Path) -> None:
    """Write NAME.gif, NAME-orbit.png and NAME-summary.json, unless nothing moves."""
    case = bw.read_case(example)
    if case.excitation.type != "none":  # what grows by itself takes its time
        case = bw.with_values(case, {"march.duration": min(case.march.duration, LONGEST)})
    with tempfile.TemporaryDirectory() as scratch:
        run = bw.run(case, Path(scratch) / "run", frames=0)
        if run.summary.tip_displacement_max == 0:
            return
        bw.render(run, folder / f"{example.stem}.gif", frames=FRAMES)
        for kept, name in (("orbit.png", "-orbit.png"), ("summary.json", "-summary.json")):
            shutil.copyfile(run.directory / kept, folder / f"{example.stem}{name}")


if __name__ == "__main__":
    march(Path(sys.argv[1]), Path(sys.argv[2]))

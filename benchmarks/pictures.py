"""Time of series and films: `python benchmarks/pictures.py`.

The casing distortion is marched for 50 ms; 300 frames of it are written for ParaView as lines and
as surfaces, and 100 pictures are drawn as GIF and as HTML page. Printed are the time that passed
and that of the processor, which on a machine with other work tells more.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import bladewhirl as bw
from bladewhirl.models.case.file import read_case
from bladewhirl.postprocess.paraview.series import export_vtk
from bladewhirl.postprocess.pictures.render import render_animation
from bladewhirl.postprocess.pictures.web_page import render_page

CASE = Path(__file__).resolve().parent.parent / "examples" / "casing_distortion.toml"
FRAMES, PICTURES = 300, 100


def cost(work: Callable[[], object]) -> tuple[float, float]:
    """Time that passes and processor time [s]."""
    wall, processor = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - wall, time.process_time() - processor


def main() -> None:
    """March, write, draw, print."""
    table = Table("", "wall [s]", "processor [s]", "goal [s]", box=None)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        run = bw.run(read_case(CASE, ["march.duration=0.05"]), folder / "run", frames=0)
        with run.open() as result:
            records = np.arange(result.sizes["time"] - PICTURES, result.sizes["time"])
            works: dict[str, tuple[Callable[[], object], str]] = {
                f"{FRAMES} frames of VTK": (
                    lambda: export_vtk(result, folder / "lines", frames=FRAMES),
                    "5",
                ),
                f"{FRAMES} frames of VTK, surfaces": (
                    lambda: export_vtk(result, folder / "boxes", frames=FRAMES, surface=True),
                    "",
                ),
                f"GIF of {PICTURES} pictures": (
                    lambda: render_animation(result, folder / "film.gif", records),
                    "60",
                ),
                f"page of {PICTURES} pictures": (
                    lambda: render_page(result, folder / "page.html", records),
                    "",
                ),
            }
            for name, (work, goal) in works.items():
                wall, processor = cost(work)
                table.add_row(name, f"{wall:.2f}", f"{processor:.2f}", goal)
    Console().print(table)


if __name__ == "__main__":
    main()

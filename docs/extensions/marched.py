"""An example shown, and marched for a short while: drawing, film, orbit and summary in a folder."""

from __future__ import annotations

import io
import shutil
import tempfile
from contextlib import redirect_stdout
from pathlib import Path

import bladewhirl as bw
from bladewhirl.studies.commands.cli import app

LONGEST, FRAMES = 0.6, 20  #: march under a load [s], pictures of the film


def shown(example: Path, folder: Path) -> str:
    """The document of `bladewhirl show --json`; NAME.png, film and diagrams go to the folder."""
    case, name = bw.read_case(example), example.stem
    if case.excitation.type != "none":
        march(
            bw.with_values(case, {"march.duration": min(case.march.duration, LONGEST)}),
            folder / name,
        )
    elif case.initial.model_fields_set:  # what grows by itself takes its time
        march(case, folder / name)
    if case.rotation.effects != "none":
        _command("campbell", example, "-o", folder / f"{name}-campbell")
    drawing = folder / f"{name}.png"
    drawing.unlink(missing_ok=True)
    return _command("show", example, "--json", "--png", "-o", drawing)


def march(case: bw.Case, place: Path) -> None:
    """Write PLACE.gif, PLACE-orbit.png and PLACE-summary.json."""
    with tempfile.TemporaryDirectory() as scratch:
        run = bw.run(case, Path(scratch) / "run", frames=0)
        bw.render(run, place.with_suffix(".gif"), frames=FRAMES)
        for name in ("orbit.png", "summary.json"):
            shutil.copyfile(run.directory / name, f"{place}-{name}")


def _command(*words: str | Path) -> str:
    printed = io.StringIO()
    with redirect_stdout(printed):
        app([str(word) for word in words], standalone_mode=False)
    return printed.getvalue()

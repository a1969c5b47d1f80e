"""Fixtures that several test modules share."""

import os
from pathlib import Path

# As the command line does; read when NumPy is first loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings

# The same examples everywhere, and none judged by the clock.
settings.register_profile("house", deadline=None, derandomize=True, database=None)
settings.load_profile("house")


@pytest.fixture
def can_draw() -> None:
    """Skips where the system has no OpenGL for VTK to draw with."""
    from bladewhirl.postprocess.pictures.offscreen import OffScreenError, require_off_screen

    try:
        require_off_screen()
    except OffScreenError as error:
        pytest.skip(str(error))


@pytest.fixture
def pictures_unsaved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of runs and sweeps are made and not rendered: their files are there, empty."""

    def touch(figure: object, path: Path, data: object) -> None:
        for suffix in (".png", ".pdf", ".nc"):
            path.with_suffix(suffix).touch()

    for module in ("plotting.style", "sweep.figures"):
        monkeypatch.setattr(f"bladewhirl.postprocess.{module}.save_figure", touch)

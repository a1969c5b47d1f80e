"""Fixtures that several test modules share."""

import gc
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

# As the command line does; read when NumPy is first loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
import typer.testing
from hypothesis import settings

# The same examples everywhere, and none judged by the clock.
settings.register_profile("house", deadline=None, derandomize=True, database=None)
settings.load_profile("house")

# Commands are built once, not for each call.
vars(typer.testing)["_get_command"] = cache(vars(typer.testing)["_get_command"])


def pytest_collection_finish() -> None:
    """Let the garbage collector leave modules and tests alone: a pass over them takes 0.2 s."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def can_draw() -> None:
    """Skip where the system has no OpenGL for VTK to draw with."""
    from bladewhirl.postprocess.pictures.offscreen import OffScreenError, require_off_screen

    try:
        require_off_screen()
    except OffScreenError as error:
        pytest.skip(str(error))


@pytest.fixture(autouse=True, scope="module")
def pictures_unsaved(request: pytest.FixtureRequest) -> Iterator[None]:
    """Make figures without laying them out and drawing them, which takes most of their time: .png
    and .pdf are empty files, except in modules with the mark `pictures`, and in runs that are not
    only of the default tests."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    def savefig(_: Figure, target: Any, **options: Any) -> None:
        if isinstance(target, str | Path):
            Path(target).touch()

    with pytest.MonkeyPatch.context() as patch:
        by_default = request.config.option.markexpr == "not slow"
        if by_default and not request.node.get_closest_marker("pictures"):
            patch.setattr(Figure, "savefig", savefig)
            patch.setattr(ConstrainedLayoutEngine, "execute", lambda *_: None)
        yield

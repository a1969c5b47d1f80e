"""Fixtures that several test modules share."""

import os
from pathlib import Path
from typing import Any

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
    """Figures are made and laid out, and not rendered: .png and .pdf are empty files."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_pdf import FigureCanvasPdf

    for canvas, name in ((FigureCanvasAgg, "print_png"), (FigureCanvasPdf, "print_pdf")):
        render = getattr(canvas, name)

        def touch(own: object, target: Any, *more: Any, render: Any = render, **named: Any) -> None:
            if isinstance(target, str | Path):
                Path(target).touch()
            else:  # a layout asks for a renderer
                render(own, target, *more, **named)

        monkeypatch.setattr(canvas, name, touch)

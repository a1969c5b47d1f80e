"""Fixtures that several test modules share."""

import os
from collections.abc import Iterator
from pathlib import Path

# As the command line does; read when NumPy is first loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings

# The same examples everywhere, and none judged by the clock.
settings.register_profile("house", deadline=None, derandomize=True, database=None)
settings.load_profile("house")

PROCESSOR_BUDGET = 2.0
"""Processor time that a test may take unless it is marked slow, children included [s]."""


def processor_seconds() -> float:
    """Return the processor time of this process and its ended children."""
    return sum(os.times()[:4])


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Fail a test that takes more processor time than a default test may."""
    before = processor_seconds()
    yield
    used = processor_seconds() - before
    # Beside other processes on the same core a test needs up to twice the processor time.
    load = os.getloadavg()[0] / (os.cpu_count() or 1)
    share = min(max(load, 1.5 if "PYTEST_XDIST_WORKER" in os.environ else 1.0), 2.0)
    if used > share * PROCESSOR_BUDGET and item.get_closest_marker("slow") is None:
        pytest.fail(
            f"took {used:.1f} s of processor time, expected at most {PROCESSOR_BUDGET:g} s;"
            " make its stage smaller or its march shorter, or mark it slow"
        )


@pytest.fixture
def can_draw() -> None:
    """Skip where the system has no OpenGL for VTK to draw with."""
    from bladewhirl.postprocess.pictures.offscreen import OffScreenError, require_off_screen

    try:
        require_off_screen()
    except OffScreenError as error:
        pytest.skip(str(error))


@pytest.fixture
def pictures_unsaved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make figures without laying them out and drawing them: .png and .pdf are empty files."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    monkeypatch.setattr(Figure, "savefig", lambda _, target, **options: Path(target).touch())
    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", lambda *_: None)

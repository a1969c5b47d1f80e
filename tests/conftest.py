"""Fixtures that several test modules share."""

import gc
import os
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from statistics import median

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

PROCESSOR_BUDGET = 2.0
"""Processor time that a test may take unless it is marked slow, children included, on a machine
that takes `PACE` for a reference loop [s]."""

PACE = 0.002
"""Processor time of the reference loop on the machine for which the budget is given [s]."""


def processor_seconds() -> float:
    """Return the processor time of this process and its ended children."""
    return sum(os.times()[:4])


def slowness() -> float:
    """Return how much longer than `PACE` the reference loop takes now, at least 1.5, and 30 % more
    because other processes slow memory more than they slow the loop."""

    def seconds() -> float:
        start = time.process_time()
        sum(i * i % 7 for i in range(60_000))
        return time.process_time() - start

    return 1.3 * max(1.5, median(seconds() for _ in range(5)) / PACE)


def pytest_collection_finish() -> None:
    """Let the garbage collector leave modules and tests alone: a pass over them takes 0.2 s."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Fail a test that takes more processor time than a default test may."""
    before = processor_seconds()
    yield
    used = processor_seconds() - before
    if used <= PROCESSOR_BUDGET or item.get_closest_marker("slow") is not None:
        return
    budget = PROCESSOR_BUDGET * slowness()
    if used > budget:
        pytest.fail(
            f"took {used:.1f} s of processor time, expected at most {budget:.1f} s on this machine;"
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

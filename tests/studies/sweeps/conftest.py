"""A small sweep that the tests of this folder share, and marches in this process."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from sweep_work import CASE, OVER, InProcess, in_process

from bladewhirl.studies.sweeps.sweep import run_sweep


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sweep of six points, marched in this process."""
    folder = tmp_path_factory.mktemp("sweep") / "swept"
    with in_process(figures=True):
        done = run_sweep(CASE, OVER, folder)
    assert (done.points, done.done, done.failed) == (6, 6, 0)
    return folder


@pytest.fixture
def process() -> Iterator[InProcess]:
    """Make sweeps march in this process."""
    with in_process() as made:
        yield made

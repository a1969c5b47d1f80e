"""A small sweep that the tests of this folder share."""

from pathlib import Path

import pytest
from sweep_work import CASE, OVER, march_in_process

from bladewhirl.studies.sweeps import sweep
from bladewhirl.studies.sweeps.sweep import run_sweep


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sweep of six points, marched in this process."""
    folder = tmp_path_factory.mktemp("sweep") / "swept"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sweep, "march_points", march_in_process)
        done = run_sweep(CASE, OVER, folder)
    assert (done.points, done.done, done.failed) == (6, 6, 0)
    return folder


@pytest.fixture
def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make sweeps march in this process."""
    monkeypatch.setattr(sweep, "march_points", march_in_process)

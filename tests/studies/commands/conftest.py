"""Fixtures that tests of several commands share."""

from pathlib import Path

import pytest
import synthetic_result as synthetic
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.studies.modal import coupled_mode_figures
from bladewhirl.studies.runs import figures_folder

Figures = dict[str, tuple[Figure, xr.Dataset]]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that was made up, with its result alone."""
    directory = tmp_path_factory.mktemp("run")
    synthetic.synthetic_result(elements=1).to_netcdf(directory / "result.nc", engine="h5netcdf")
    return directory


@pytest.fixture
def saved(monkeypatch: pytest.MonkeyPatch) -> Figures:
    """Collect figures of modal studies with their data instead of saving them."""
    figures: Figures = {}
    for module in (coupled_mode_figures, figures_folder):
        monkeypatch.setattr(
            module, "save_figures", lambda folder, drawn, **options: figures.update(drawn)
        )
    return figures

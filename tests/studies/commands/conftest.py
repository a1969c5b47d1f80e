"""Fixtures that tests of several commands share."""

from pathlib import Path

import pytest
import synthetic_result as synthetic


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that was made up, with its result alone."""
    directory = tmp_path_factory.mktemp("run")
    synthetic.synthetic_result(elements=1).to_netcdf(directory / "result.nc", engine="h5netcdf")
    return directory

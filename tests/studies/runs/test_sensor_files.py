"""Files of sensors in the folder of a run."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from faults import fault
from small_run import small

import bladewhirl as bw
from bladewhirl.files import listed
from bladewhirl.studies.runs.sensor_files import write_sensors

SENSORS = [
    {"type": "strain", "span": 0.1, "noise": 1e-7},
    {"type": "tip-timing", "probes": [0.0, "180 deg"], "name": "btt"},
    {"type": "wall", "angle": 0.3, "quantity": "acceleration", "name": "a1"},
]


@pytest.mark.slow
def test_a_run_writes_its_sensors_and_replaces_them(tmp_path: Path) -> None:
    case = small(**{"sensor": SENSORS, "march.duration": 0.05, "march.time_step": 4e-6})
    run = bw.run(case, tmp_path / "run", frames=0)
    files = {"sensors.nc", "strain-0.1.csv", "btt.csv", "a1.csv"}
    assert files <= listed(run.directory)
    with run.open() as result, xr.open_dataset(run.directory / "sensors.nc") as stored:
        signals = bw.sensors(result)
        xr.testing.assert_equal(stored, signals)
        assert stored["a1"].attrs["units"] == "m/s2"
    columns = np.genfromtxt(run.directory / "strain-0.1.csv", delimiter=",", names=True)
    assert columns.dtype.names is not None
    assert columns.dtype.names[4] == "strain01_blade_3_umm"
    np.testing.assert_allclose(columns["time_s"], signals["time"], rtol=1e-11)
    strain = 1e6 * signals["strain-0.1"].sel(blade=3)
    np.testing.assert_allclose(columns["strain01_blade_3_umm"], strain, rtol=1e-7)
    head, *rows = (run.directory / "btt.csv").read_text(encoding="utf-8").splitlines()
    assert head == "arrival [s],probe [deg],blade,revolution,deflection [mm]"
    table = np.loadtxt(rows, delimiter=",")
    assert len(table) == np.isfinite(signals["btt"]).sum() > 12
    assert (np.diff(table[:, 0]) >= 0.0).all()
    probe, blade, turn = table[3, 1:4].astype(int)
    moved = signals["btt"].values[probe // 180, blade, turn]
    assert table[3, 4] == pytest.approx(1e3 * moved, rel=1e-6)
    other = bw.with_values(case, {"sensor": SENSORS[2:], "march.duration": 2e-3})
    bw.run(other, tmp_path / "run", frames=0, overwrite=True)
    assert files & {path.name for path in run.directory.iterdir()} == {"sensors.nc", "a1.csv"}


def test_a_gauge_beside_the_mesh_is_refused_before_the_march(tmp_path: Path) -> None:
    case = small(sensor=[{"type": "strain", "element": 2}])
    line = fault(bw.run, case, tmp_path / "run")
    assert line == "sensor[0].element = 2: expected an element from 0 to 1 of blade 0"
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
def test_signals_that_cannot_be_computed_leave_a_hint(tmp_path: Path) -> None:
    case = small(**{"sensor": SENSORS[2:], "march.duration": 1e-3})
    with bw.run(case, tmp_path / "run", frames=0).open() as result:
        [hint] = write_sensors(result.isel(time=[0]), tmp_path)
    assert hint == "no signals of sensors: sensors: expected at least two records"
    assert not (tmp_path / "sensors.nc").exists()

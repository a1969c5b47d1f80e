"""Datasets of `stability`: one point and a chart of a case."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from places import EXAMPLES

import bladewhirl as bw
from bladewhirl.models.modal.full_stage import ModalStage, modal_stage

SPEEDS, KAPPAS = np.linspace(0.9, 1.4, 5), np.linspace(0.0, 1000.0, 3)


@cache
def fan_stage() -> ModalStage:
    return modal_stage(bw.read_case(EXAMPLES / "fan_stage.toml"))


def test_a_point_holds_growth_eigenvalues_mode_and_scenario(tmp_path: Path) -> None:
    point = bw.stability(fan_stage(), speed=1.17, kappa=500.0)
    assert float(point["growth_rate"]) == pytest.approx(7.503, abs=1e-3)
    assert float(point["growth_rate_floquet"]) == pytest.approx(float(point["growth_rate"]))
    assert bool(point["unstable"])
    assert point["real"].values.max() == point["growth_rate"]
    assert point["mode"]["entry"].values.tolist() == ["casing k=1", "1F k=1", "suspension"]
    assert point["mode"].idxmax() == "casing k=1"
    assert point["rotor_wave_speed"] < 0.0 < point["casing_wave_speed"]
    assert point["scenario"] == "inverted"
    for name, variable in point.data_vars.items():
        assert variable.attrs.keys() & {"units", "long_name"} or name == "unstable", name
    point.to_netcdf(tmp_path / "point.nc", engine="h5netcdf")


def test_a_chart_agrees_with_its_points(tmp_path: Path) -> None:
    chart = bw.stability(fan_stage(), speed=SPEEDS, kappa=KAPPAS, modes="all")
    assert chart["growth"].dims == ("kappa", "speed")
    assert {"1F k=1", "suspension"} <= set(chart.attrs["modes"])
    here = chart["growth"].sel(speed=SPEEDS[2], kappa=KAPPAS[1])
    point = bw.stability(fan_stage(), speed=SPEEDS[2], kappa=KAPPAS[1], modes="all")
    assert float(here) == pytest.approx(float(point["growth_rate"]), rel=1e-9)
    assert "1F k=2" in chart["coincidence_rotor"].values
    chart.to_netcdf(tmp_path / "chart.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "chart.nc", engine="h5netcdf") as saved:
        assert saved["growth"].attrs["units"] == "1/s"


def test_unlike_blades_have_a_chart_without_zones() -> None:
    changes = {"bladed_disk.mistuning": {"stiffness": [1.0, 1.1, 0.95, 1.0, 1.2, 0.9]}}
    small = {"bladed_disk.blades": 6, "bladed_disk.elements_per_blade": 3, "casing.elements": 16}
    case = bw.with_values(bw.Case(), small | changes)
    chart = bw.stability(case, speed=[1.0, 1.9], kappa=[0.0, 3e5], physical=True)
    assert "zone" not in chart.dims
    unstable = chart["growth"] > 0.1
    assert unstable.values.tolist() == [[False, False], [False, True]]


def test_a_chart_of_a_periodic_system_is_refused() -> None:
    case = bw.read_case(EXAMPLES / "unequal_bearings.toml")
    with pytest.raises(bw.UserError, match="the stationary shaft springs are unequal"):
        bw.stability(case)

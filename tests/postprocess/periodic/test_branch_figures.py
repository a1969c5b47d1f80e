"""Figures of branches: points of sweeps over them, backbone, and branches in maps of sweeps."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from command_line import answer, refusal
from periodic_cases import case
from synthetic_sweep import synthetic_sweep

import bladewhirl as bw
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.periodic.backbone import backbone, plot_backbone
from bladewhirl.postprocess.periodic.branch import jumps, plot_branch, with_marches
from bladewhirl.postprocess.sweep.figures import SweepFigures
from bladewhirl.studies.periodic.branch_file import dataset

RPM = np.pi / 30.0
SPEEDS = (6000.0, 7000.0, 7500.0, 7300.0, 7600.0)  #: the branch turns back twice [rpm]
COORDINATES = {
    "direction": ["radial", "tangential", "axial"],
    **{name: np.zeros(1) for name in ("node", "order", "multiplier")},
    "instant": [0.0, 0.5],
}
KEYS = {"march.speed": (6000.0 * RPM, 7000.0 * RPM), "casing.clearance": (1e-4, 2e-4)}
UNITS = {"march.speed": "rad/s", "casing.clearance": "m"}


def row(speed: float, radial: float, multiplier: float) -> dict[str, Any]:
    """A point with a radial displacement from 0 to `radial` [m]."""
    moved = np.zeros((2, 1, 3))
    moved[1, 0, 0] = radial
    still = {"residual": 0.0, "kind": 0, "shift": 0.0, "heading": 1.0}
    return still | {
        "parameter": speed,
        "speed_rad_s": speed * RPM,
        "impulse_per_revolution": 1e3 * radial,
        "multiplier_real": np.array([multiplier]),
        "multiplier_imaginary": np.zeros(1),
        "normal_force": np.zeros((2, 1)),
        "slip_direction": np.zeros((2, 1)),
        "contact_displacement": moved,
        "amplitude": np.zeros((1, 1, 3)),
        "tangent_force": np.zeros((2, 1)),
        "tangent_direction": np.zeros((2, 1)),
        "next_step": 0.1,
    }


def stored(folder: Path, clearance: str = "0.4 mm", size: float = 1.0) -> Path:
    """The folder of a branch at a clearance with an amplitude of 2 mm times `size` at 7500 rpm."""
    radial = size * np.array([1e-3, 2e-3, 4e-3, 2.5e-3, 1e-3])
    rows = map(row, SPEEDS, radial, [0.9, 0.9, 0.9, 1.1, 0.9])
    attributes: dict[str, Any] = {
        "key": "march.speed",
        "unit": "rpm",
        "key_units": "rpm",
        "case": "a blade",
    }
    attributes |= {"title": "a branch", "start": 6000.0, "stop": 7600.0}
    folder.mkdir()
    dataset(rows, COORDINATES, attributes).to_netcdf(folder / "branch.nc", engine="h5netcdf")
    (folder / "case.toml").write_text(bw.dumps_case(case(**{"casing.clearance": clearance})))
    return folder


@pytest.mark.slow
def test_points_of_a_sweep_have_the_unit_of_the_branch(tmp_path: Path) -> None:
    branch = bw.open_branch(stored(tmp_path / "branch"))
    motions: Any = [{}, None]
    speeds = {"march.speed": KEYS["march.speed"]}
    folder = synthetic_sweep(tmp_path / "sweep", speeds, motions, units="rad/s")
    with bw.open_sweep(folder) as sweep:
        impulse = float(sweep["impulse_per_revolution"][0])
        data = with_marches(branch, [sweep])
    assert data["march_parameter"].values == pytest.approx([6000.0, 7000.0])
    assert data["march_impulse"].values == pytest.approx([impulse, np.nan], nan_ok=True)
    drawn = plot_branch(data).axes[0]
    stable, unstable, marches = (line.get_ydata() for line in drawn.lines)
    assert np.isnan(stable).tolist() == [False, False, False, True, False]
    assert np.isnan(unstable).tolist() == [True, True, False, False, False]
    assert np.asarray(marches)[0] == pytest.approx(impulse)


@pytest.mark.slow
def test_a_backbone_goes_through_the_peaks(tmp_path: Path) -> None:
    narrow = stored(tmp_path / "one")
    wide = stored(tmp_path / "two", "0.5 mm", 0.5)
    data = backbone(bw.open_branch(narrow), [bw.open_branch(wide)])
    assert data["label"].values.tolist() == [
        "casing clearance = 0.5 mm",
        "casing clearance = 0.4 mm",
    ]
    assert data["peak"].values == pytest.approx([7500.0, 7500.0])
    assert data["peak_amplitude"].values == pytest.approx([1e-3, 2e-3])
    peaks = plot_backbone(data).axes[0].lines[-1]
    assert np.asarray(peaks.get_ydata()) == pytest.approx([1.0, 2.0])  # mm


@pytest.mark.slow
def test_maps_show_branches_at_the_value_of_their_case(tmp_path: Path) -> None:
    folder = synthetic_sweep(tmp_path / "map", KEYS, [{}] * 4, units=UNITS)
    branch = bw.open_branch(stored(tmp_path / "b"))
    with bw.open_sweep(folder) as sweep:
        figure, data = SweepFigures(sweep, [branch]).draw("maps")
    assert data["branch_along"].values[0] == pytest.approx(np.multiply(SPEEDS, RPM))
    assert data["branch_across"].values[0] == pytest.approx(4e-4)
    line = figure.axes[0].lines[-2]
    assert np.nanmax(np.asarray(line.get_ydata())) == pytest.approx(0.4)  # mm


@pytest.mark.slow
def test_commands_lay_folders_over_figures(tmp_path: Path) -> None:
    branch, folder = stored(tmp_path / "branch"), tmp_path / "map"
    synthetic_sweep(folder, KEYS, [{}] * 4, units=UNITS)
    look = ("--format", "png")
    answer("plot", branch, "backbone", "--with", branch, *look)
    with xr.open_dataset(branch / "plots" / "backbone.nc", engine="h5netcdf") as data:
        assert data.sizes["branch"] == 2
    assert "not also over casing_clearance" in refusal("plot", branch, "branch", "--with", folder)
    assert "expected a branch to lay over" in refusal("plot", folder, "maps", "--with", folder)
    assert "a branch has no time window" in refusal("plot", branch, "branch", "--from", 0)
    assert "a branch has the figures branch, backbone" in refusal("plot", branch, "maps")


def test_other_keys_and_files_are_refused(tmp_path: Path) -> None:
    branch = bw.open_branch(stored(tmp_path / "branch"))
    with pytest.raises(UserError, match=r"expected branches over march\.speed in the same unit"):
        backbone(branch, [branch.assign_attrs(unit="Hz")])
    with pytest.raises(UserError, match="expected the file of a branch"):
        bw.open_branch(tmp_path / "none")


def test_a_slow_change_jumps_at_folds_to_the_other_stable_part() -> None:
    """An S with folds at 2 and 1: from 1.9 up to 4, and from 3.1 down to 0.8, by hand."""
    parameter = np.array([0.0, 0.9, 1.9, 2.0, 1.9, 1.1, 1.0, 1.5, 2.5, 3.0])
    value = np.array([0.0, 0.7, 1.7, 1.9, 2.0, 2.9, 3.1, 3.5, 4.5, 5.0])
    stable = np.array([True] * 4 + [False] * 2 + [True] * 4)
    kind = np.where(np.isin(np.arange(10), [3, 6]), 1, 0)
    names = {"parameter": parameter, "stable": stable, "kind": kind}
    up, down = jumps(xr.Dataset({name: ("point", each) for name, each in names.items()}), value)
    assert up == pytest.approx((2.0, 1.9, 4.0))
    assert down == pytest.approx((1.0, 3.1, 0.8))

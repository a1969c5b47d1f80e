"""Points of a sweep from a table: CSV files, columns, what is refused, and the dataset."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr
from report_pages import reported
from small_run import small
from sweep_work import in_process

import bladewhirl as bw
from bladewhirl.postprocess.sweep.figures import SweepFigures
from bladewhirl.postprocess.sweep.quantities import shaft_radius
from bladewhirl.studies.sweeps.axes import make_grid
from bladewhirl.studies.sweeps.draws import parse_draws
from bladewhirl.studies.sweeps.plan import plan_sweep, read_plan, write_plan
from bladewhirl.studies.sweeps.table import point_table

CASE = small(**{"march.duration": 2e-3})
CSV = "march.speed,casing.clearance [mm]\n1.1,0.5\n\n0.9, 0.7\n"
COLUMNS: dict[str, list[Any]] = {
    "march.speed": [1.1, 0.9],
    "casing.clearance": ["0.5 mm", "0.7 mm"],
}


def test_a_file_columns_and_a_frame_say_the_same(tmp_path: Path) -> None:
    (tmp_path / "points.csv").write_text(CSV)
    file = point_table(tmp_path / "points.csv")
    assert file.values == {k: tuple(values) for k, values in COLUMNS.items()}
    assert file.rows[1] == f"{tmp_path / 'points.csv'}, line 4,"
    columns = {"march.speed": ("x", [1.1, 0.9]), "casing.clearance [mm]": ("x", [0.5, 0.7])}
    frame = xr.Dataset(columns).to_dataframe()
    for table in (COLUMNS, frame, dict(frame)):
        assert point_table(table).values == file.values


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "points.csv: expected a first line of keys"),
        ("march.speed\n", "points.csv, line 1, expected at least one key and one point"),
        ("march.speed\n1,2\n", "points.csv, line 2: expected 1 values, one for each key"),
        (
            "march.speed,march.speed\n1,2\n",
            'line 1, column "march.speed": expected each key at most once',
        ),
        (
            "march speed\n1\n",
            'line 1, column "march speed": expected a key of the case, with its unit',
        ),
        ("march.speed\n1\nfast\n", 'line 3, march.speed = "fast": expected a number'),
        ("casing.clearance [mm]\n1 m\n", '= "1 m": expected a number in mm, as line 1 says'),
        ("casing.clearance\n1 m\n1 mm\n", "casing.clearance: expected one unit, not"),
    ],
)
def test_files_that_are_no_table(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "points.csv").write_text(text)
    with pytest.raises(bw.UserError, match=r"points\.csv") as caught:
        point_table(tmp_path / "points.csv")
    [line] = caught.value.lines
    assert expected in line


@pytest.mark.slow
def test_draws_change_the_values_of_each_row(tmp_path: Path) -> None:
    draws = parse_draws(2, ["march.speed = 1e-3", "contact.friction = 0.1"], 0)
    grid = make_grid(CASE, {}, large=False, draws=draws, table=point_table(COLUMNS))
    values = [grid.values(point) for point in range(grid.size)]
    assert [round(float(each["march.speed"]), 1) for each in values] == [1.1, 1.1, 0.9, 0.9]
    assert len({each["march.speed"] for each in values}) == 4
    assert [each["casing.clearance"] for each in values] == ["0.5 mm"] * 2 + ["0.7 mm"] * 2
    plan = plan_sweep(CASE, grid)
    np.testing.assert_allclose(plan.coordinates["march.speed"][0], [1.1, 0.9])
    write_plan(plan, tmp_path)
    again = read_plan(tmp_path)
    assert (again.grid, again.digest) == (grid, plan.digest)


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sweep over a table of two points."""
    folder = tmp_path_factory.mktemp("table") / "sweep"
    with in_process():
        bw.run_sweep(CASE, table=COLUMNS, directory=folder)
        assert bw.resume_sweep(folder).marched == 0
    return folder


def test_the_dataset_has_the_keys_along_the_points(swept: Path) -> None:
    with bw.open_sweep(swept) as data:
        assert data["regime"].dims == ("point",)
        assert data["march_speed"].values.tolist() == [1.1, 0.9]
        np.testing.assert_allclose(data["casing_clearance"], [5e-4, 7e-4])
        assert data["casing_clearance"].attrs["units"] == "m"
        np.testing.assert_allclose(data["speed_ratio"], [1.1, 0.9])
        radius = shaft_radius(data, "point")
        assert radius["march_speed"].dims == ("point",)
        figures = SweepFigures(data)
        figure, _ = figures.draw("shaft-radius")
        assert figure.axes[0].lines[0].get_linestyle() == "None"
        for name in ("frequency-map", "maps"):
            with pytest.raises(bw.ViewError, match="expected a sweep over a grid of values"):
                figures.draw(name)


def test_changed_values_of_a_table_are_noticed(swept: Path, tmp_path: Path) -> None:
    for name, change in (("march_speed", 1.2), ("table", "[1]"), ("table", "{")):
        copy = tmp_path / "sweep.nc"
        copy.write_bytes((swept / "sweep.nc").read_bytes())
        with h5py.File(copy, "r+") as file:
            if name == "table":
                file.attrs["table"] = change
            else:
                file[name][0] = change
        with pytest.raises(bw.ResultError, match=r"was changed after|as JSON"):
            bw.open_sweep(copy)


@pytest.mark.slow
def test_the_report_lists_the_values_of_the_keys(swept: Path) -> None:
    words = reported(swept).words
    assert "Swept: march.speed, casing.clearance." in words
    assert "casing.clearance [mm]" in words
    assert "casing clearance = 0.7 mm" in (swept / "report.html").read_text(encoding="utf-8")

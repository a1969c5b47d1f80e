"""`bladewhirl campbell`: coincidence speeds of the fan stage, as JSON, table and diagrams."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner, Result

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.studies.commands.cli import app


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "fan.toml"
    path.write_text(dumps_case(Case()), encoding="utf-8")
    return path


def run(command: str, *arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [command, *map(str, arguments)])


def document(command: str, *arguments: str | Path) -> dict[str, Any]:
    result = run(command, *arguments, "--json")
    assert result.exit_code == 0, result.stderr
    found = json.loads(result.stdout)
    assert isinstance(found, dict)
    return found


def test_every_nodal_diameter_and_family_has_its_speed(case: Path) -> None:
    """Held against Eq. (14) worked out from the frequencies of `bladewhirl modes`."""
    found = document("campbell", case)
    modes = document("modes", case, "--count", "400")

    def frequencies(body: str, families: set[str]) -> dict[tuple[int, str], float]:
        return {
            (mode["nodal_diameter"], mode["family"]): mode["frequency_hz"]
            for mode in modes[body]
            if mode["family"] in families
        }

    rotor = frequencies("bladed_disk", {"suspension", *(f"{n}F" for n in range(1, 6))})
    casing = frequencies("casing", {"rigid", "1F", "2F"})
    expected = {
        (k, family, wall): (frequency + wall_frequency) / k
        for ((k, family), frequency), ((wall_k, wall), wall_frequency) in product(
            rotor.items(), casing.items()
        )
        if k == wall_k and k > 0
    }
    rows = found["coincidences"]
    speeds = {
        (row["nodal_diameter"], row["rotor_family"], row["casing_family"]): row["speed_rpm"] / 60.0
        for row in rows
    }
    assert len(speeds) == len(rows)
    assert speeds == pytest.approx(expected, rel=1e-9)
    assert {row["nodal_diameter"] for row in rows} == set(range(1, 12))
    assert [row["speed"] for row in rows] == sorted(row["speed"] for row in rows)
    reference = found["reference_frequency_hz"]
    for row in rows:
        assert row["speed"] * reference == pytest.approx(row["speed_rpm"] / 60.0)
        assert row["in_operating_range"] == (0.6 <= row["speed"] <= 2.0)


def test_a_clamped_centre_has_no_suspension_and_the_free_reference(case: Path) -> None:
    free, clamped = (
        document("campbell", case),
        document("campbell", case, "--set", "shaft.clamped=true"),
    )
    assert clamped["reference_frequency_hz"] == free["reference_frequency_hz"]
    assert {row["rotor_family"] for row in clamped["coincidences"]} == {
        f"{n}F" for n in range(1, 6)
    }


def test_diagrams_and_table(case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = run("campbell", case, "--speeds", "0.5:2.7", "--operating", "1:1.2")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.splitlines()[-1] == "Wrote fan-campbell."
    assert result.stdout.count("inside") == 2  # k = 1 at 1.055 and k = 4 at 1.116
    assert "suspension" in result.stdout
    assert "2.8077" not in result.stdout  # beyond the last speed
    for frame, suffix in product(("rotating", "static"), ("png", "pdf", "nc")):
        assert (tmp_path / "fan-campbell" / f"campbell-{frame}.{suffix}").stat().st_size > 1000
    with xr.open_dataset(tmp_path / "fan-campbell" / "campbell-rotating.nc") as data:
        on_rotor = data["mode_body"].values == "bladed-disk"
        assert set(data["mode_family"].values[on_rotor]) == {"1F", "2F", "suspension"}
        diameters = data["mode_nodal_diameter"].values[~on_rotor]
        np.testing.assert_array_equal(np.sort(diameters), np.arange(1, 12))
        np.testing.assert_allclose(data.attrs["operating_range"], (1.0, 1.2))
    again = run("campbell", case)
    assert (again.exit_code, again.stderr) == (
        2,
        "fan-campbell: already exists; --overwrite writes into it\n",
    )


def test_json_writes_nothing_unless_asked(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    document("campbell", case)
    assert [path.name for path in tmp_path.iterdir()] == [case.name]


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--speeds", "3:1"], "--speeds 3:1: expected a STOP above the START of 3"),
        (["--speeds", "2:2"], "--speeds 2:2: expected a STOP above the START of 2"),
        (["--speeds", ""], "--speeds : expected START:STOP, two numbers"),
        (["--speeds", "1"], "--speeds 1: expected START:STOP, two numbers"),
        (["--speeds", "0:1:5"], "--speeds 0:1:5: expected START:STOP, two numbers"),
        (["--speeds", "0:inf"], "--speeds 0:inf: expected START:STOP with finite numbers"),
        (["--speeds", "-1:2"], "--speeds -1:2: expected a START of zero or more"),
        (["--operating", "2:0.6"], "--operating 2:0.6: expected a STOP above the START of 2"),
        (["--families", "0"], "--families 0: expected a whole number of one or more"),
    ],
)
def test_bad_input_is_one_line(
    case: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    line: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run("campbell", case, *arguments)
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", f"{line}\n")
    assert [path.name for path in tmp_path.iterdir()] == [case.name]

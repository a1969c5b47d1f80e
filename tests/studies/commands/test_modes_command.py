"""`bladewhirl modes`: lists against an independent program, pictures and films, bad input."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageSequence
from stages import oracle
from typer.testing import CliRunner, Result

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.studies.commands.cli import app

LITERATURE = ("--set", "bladed_disk.disk.thickness=0.01")
SMALL = ("--set", "bladed_disk.blades=5", "--set", "bladed_disk.elements_per_blade=2")


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "fan.toml"
    path.write_text(dumps_case(Case()), encoding="utf-8")
    return path


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["modes", *map(str, arguments)])


def lists(*arguments: str | Path) -> dict[str, list[dict[str, Any]]]:
    result = run(*arguments, "--json")
    assert result.exit_code == 0, result.stderr
    found = json.loads(result.stdout)
    assert isinstance(found, dict)
    return found


def test_lists_of_the_literature_stage_are_those_of_an_independent_program(case: Path) -> None:
    found = lists(case, *LITERATURE, "--count", "92")
    assert list(found) == ["bladed_disk", "bladed_disk_free", "bladed_disk_clamped", "casing"]
    assert found["bladed_disk"] == found["bladed_disk_free"]
    for name in ("free", "clamped"):
        expected = oracle("disk_modes")[name]
        modes = found[f"bladed_disk_{name}"]
        assert len(modes) == 92
        assert all(
            set(mode) == {"frequency_hz", "normalised", "nodal_diameter", "family", "purity"}
            for mode in modes
        )
        frequency = [mode["frequency_hz"] for mode in modes]
        np.testing.assert_allclose(frequency, expected["frequency_hz"], rtol=1e-8)
        assert [mode["nodal_diameter"] for mode in modes] == expected["nodal_diameter"]
        assert [mode["family"] for mode in modes] == expected["family"]
        lowest = oracle("disk_modes")["free"]["frequency_hz"][0]
        np.testing.assert_allclose(
            [mode["normalised"] for mode in modes], np.array(frequency) / lowest, rtol=1e-8
        )
        assert {mode["purity"] for mode in modes} == {1.0}
    casing = [mode["frequency_hz"] for mode in found["casing"]]
    assert len(casing) == 92
    assert casing == sorted(casing)
    assert [mode["family"] for mode in found["casing"][:3]] == ["rigid", "rigid", "1F"]


def test_a_clamped_case_lists_its_own_modes_first_and_stays_normalised(case: Path) -> None:
    free, clamped = lists(case), lists(case, "--set", "shaft.clamped=true")
    assert clamped["bladed_disk"] == free["bladed_disk_clamped"]
    assert clamped["bladed_disk_free"] == free["bladed_disk"]
    assert len(free["bladed_disk"]) == 60
    assert all(mode["family"] != "suspension" for mode in clamped["bladed_disk"])


def test_fewer_modes_have_the_same_labels(case: Path) -> None:
    few, many = lists(case, "--count", "5"), lists(case)
    for name, modes in few.items():
        assert modes == many[name][:5]


def test_the_table_is_for_people(case: Path) -> None:
    result = run(case, "--count", "24")
    assert result.exit_code == 0
    assert "suspension" in result.stdout
    assert "2.52666" in result.stdout
    assert "Casing" in result.stdout


def test_pictures_and_films(case: Path, tmp_path: Path) -> None:
    folder = tmp_path / "pictures"
    result = run(
        case, *SMALL, "-o", folder, "--shapes", "1F:0,1F:1,casing:rigid", "--animate", "1F:1"
    )
    assert result.exit_code == 0, result.stderr
    assert {path.name for path in folder.iterdir()} == {
        *(f"bladed-disk-shapes.{suffix}" for suffix in ("png", "pdf", "nc")),
        *(f"casing-shapes.{suffix}" for suffix in ("png", "pdf", "nc")),
        *(f"standard-scenario.{suffix}" for suffix in ("png", "pdf", "nc")),
        *(f"inverted-scenario.{suffix}" for suffix in ("png", "pdf", "nc")),
        "1F-1.gif",
        "1F-1-vtk",
    }
    assert (folder / "1F-1-vtk" / "series.pvd").is_file()
    with Image.open(folder / "1F-1.gif") as film:
        assert sum(1 for _ in ImageSequence.Iterator(film)) == 48
        assert film.info["loop"] == 0
    refused = run(case, *SMALL, "-o", folder)
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert refused.stderr == f"{folder}: already exists; --overwrite writes into it\n"


def test_a_clamped_centre_has_neither_suspension_nor_contact_scenario(
    case: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "clamped"
    folder.mkdir()
    clamped = (*SMALL, "--set", "shaft.clamped=true")
    result = run(case, *clamped, "-o", folder, "--overwrite", "--no-films", "--json")
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["bladed_disk"]
    assert not list(folder.glob("*scenario*"))
    assert (folder / "bladed-disk-shapes.png").is_file()


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--count", "0"], "--count 0: expected a whole number of one or more"),
        (["--count", "-3"], "--count -3: expected a whole number of one or more"),
        (["--animate", "1F:1"], "--animate: for pictures; expected a folder for them, -o DIR"),
        (
            ["-o", "new", "--animate", "1G:1"],
            "--animate 1G:1: expected a family of the bladed disk, 1F to 9F, suspension",
        ),
        (
            ["-o", "new", "--animate", "suspensoin"],
            "--animate suspensoin: expected a family of the bladed disk, 1F to 9F, suspension"
            " (did you mean suspension?)",
        ),
        (
            ["-o", "new", "--animate", "1F:3"],
            "--animate 1F:3: expected a nodal diameter of 1F: 0, 1, 2",
        ),
        (
            ["-o", "new", "--shapes", "1F,"],
            '--shapes "": expected a family of the bladed disk, 1F to 9F, suspension',
        ),
        (
            ["-o", "new", "--shapes", "casing:suspension"],
            "--shapes casing:suspension: expected a family of the casing, 1F to 4F, rigid",
        ),
        (
            ["-o", "new", "--wave", "sideways"],
            "--wave sideways: expected one of standing, forward, backward",
        ),
        (
            ["-o", "new", "--animate", "1F:0", "--wave", "forward"],
            "--wave forward: expected standing; 1F:0 is no pair, it stands",
        ),
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
    result = run(case, *SMALL, *arguments)
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", f"{line}\n")
    assert [path.name for path in tmp_path.iterdir()] == [case.name]


def test_a_folder_that_cannot_be_made(case: Path, tmp_path: Path) -> None:
    result = run(case, *SMALL, "-o", case)
    assert (result.exit_code, result.stderr) == (2, f"{case}: expected a folder, found a file\n")
    below = run(case, *SMALL, "-o", case / "below", "--no-films")
    assert below.exit_code == 2
    assert "cannot be written" in below.stderr
    assert len(below.stderr.splitlines()) == 1


def test_numbers_beyond_double_precision_are_a_fault_of_the_case(case: Path) -> None:
    result = run(case, "--set", "bladed_disk.disk.thickness=1e-150")
    assert result.exit_code == 2
    assert "within reach of double precision" in result.stderr
    assert len(result.stderr.splitlines()) == 1

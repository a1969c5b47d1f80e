"""`bladewhirl modes`, `campbell` and `veering`: lists, tables, figures and films, bad input."""

import json
import re
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from command_line import answer
from matplotlib.figure import Figure
from matplotlib.text import Text
from places import EXAMPLES
from report_pages import Parsed

import bladewhirl as bw
from bladewhirl.files import MANIFEST_NAME, listed
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.postprocess.modal import motion
from bladewhirl.studies.commands.cli import app
from bladewhirl.studies.modal import mode_pictures
from bladewhirl.studies.modal.study import Study

SMALL = ("--set", "bladed_disk.blades=5", "--set", "bladed_disk.elements_per_blade=2")


@pytest.fixture
def case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The case of the fan stage in an empty folder, in which commands run."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "fan.toml"
    path.write_text(dumps_case(Case()), encoding="utf-8")
    return path


@cache
def document(command: str, *arguments: str) -> dict[str, Any]:
    """Return the JSON document of a command for the fan stage, computed once."""
    result = answer(command, EXAMPLES / "fan_stage.toml", *arguments, "--json")
    content = json.loads(result.stdout)
    assert isinstance(content, dict)
    return content


def test_tables_are_printed_before_figures_are_drawn(
    case: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    printed: list[str] = []
    drawing = Study.draw

    def draw(study: Study, folder: Path, *, overwrite: bool = False) -> None:
        printed.append(capsys.readouterr().out)
        drawing(study, folder, overwrite=overwrite)

    monkeypatch.setattr(Study, "draw", draw)
    with pytest.raises(SystemExit):
        app(["campbell", str(case), *SMALL, "--families", "1"])
    assert "Coincidence speeds" in printed[0]
    assert "Wrote fan-campbell." in capsys.readouterr().out


@pytest.mark.slow
def test_a_clamped_case_lists_its_own_modes_first_and_stays_normalised() -> None:
    free, clamped = document("modes"), document("modes", "--set", "shaft.clamped=true")
    assert clamped["bladed_disk"] == free["bladed_disk_clamped"]
    assert clamped["bladed_disk_free"] == free["bladed_disk"]
    listed = {(mode["family"], mode["nodal_diameter"]) for mode in free["bladed_disk"]}
    assert len(listed) == 60
    assert all(mode["family"] != "suspension" for mode in clamped["bladed_disk"])


@pytest.mark.slow
def test_pictures_and_films(case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(motion, "PICTURES", 4)
    monkeypatch.setattr(
        mode_pictures,
        "render_animation",
        lambda motion, path, records, **view: path.write_text(str(records)),
    )
    folder = tmp_path / "pictures"
    chosen = ("--shapes", "1F:0,1F:1,casing:rigid", "--animate", "1F:1")
    answer("modes", case, *SMALL, "-o", folder, *chosen)
    figures = ("bladed-disk-shapes", "casing-shapes", "standard-scenario", "inverted-scenario")
    assert {path.name for path in folder.iterdir()} == {
        *(f"{name}.{end}" for name in (*figures, "1F-1-wave") for end in ("png", "nc")),
        "1F-1.gif",
        "1F-1-vtk",
        MANIFEST_NAME,
    }
    assert {path.name for path in folder.iterdir() if path.is_file()} == listed(folder)
    assert (folder / "1F-1-vtk" / "series.pvd").is_file()
    assert (folder / "1F-1.gif").read_text() == "[0 1 2 3]"


@pytest.mark.slow
def test_waves_at_speed_are_pictured_as_they_travel(case: Path, tmp_path: Path) -> None:
    effects = (*SMALL, "--set", "rotation.effects=full", "-o", tmp_path / "new", "--no-films")
    answer("modes", case, *effects, "--shapes", "1F:0,1F:1")
    with xr.open_dataset(tmp_path / "new" / "bladed-disk-shapes.nc") as data:
        assert data["rotor_direction"].values.tolist() == ["standing", "forward", "backward"]


def test_every_nodal_diameter_and_family_has_its_speed() -> None:
    """Compare with Eq. (14) for the frequencies of both modes."""
    content = document("campbell")
    rows, reference = content["coincidences"], content["reference_frequency_hz"]
    kinds = {(row["nodal_diameter"], row["rotor_family"], row["casing_family"]) for row in rows}
    assert len(kinds) == len(rows)
    flexible = product(range(2, 12), [f"{n}F" for n in range(1, 6)], ["1F", "2F"])
    assert {*flexible, (1, "1F", "rigid"), (1, "suspension", "rigid")} <= kinds
    assert [row["speed"] for row in rows] == sorted(row["speed"] for row in rows)
    for row in rows:
        hertz = (row["rotor_frequency_hz"] + row["casing_frequency_hz"]) / row["nodal_diameter"]
        assert row["speed_rpm"] == pytest.approx(60.0 * hertz, rel=1e-9)
        assert row["speed"] * reference == pytest.approx(hertz)
        assert "in_operating_range" not in row  # the user gave no range
    assert content["operating_range"] is None


@pytest.mark.parametrize("speeds", [[], [1.0], (0.0, 1.0, 2.0), (2.0, 1.0)])
def test_a_diagram_has_two_ends(speeds: Any) -> None:
    with pytest.raises(bw.UserError, match="expected two speeds of zero or more, the second above"):
        bw.campbell(bw.Case(), speeds=speeds)


Figures = dict[str, tuple[Figure, xr.Dataset]]


@pytest.mark.slow
def test_campbell_diagrams_and_table(case: Path, saved: Figures) -> None:
    result = answer("campbell", case, "--speeds", "0.5:2.7", "--operating", "1:1.2")
    assert result.stdout.splitlines()[-1] == "Wrote fan-campbell."
    assert result.stdout.count("yes") == 2  # k = 1 at 1.055 and k = 4 at 1.116
    assert "suspension" in result.stdout
    assert "2.8077" not in result.stdout  # beyond the last speed
    assert set(saved) == {"campbell-rotating", "campbell-static"}
    _, data = saved["campbell-rotating"]
    on_rotor = data["mode_body"].values == "bladed-disk"
    assert set(data["mode_family"].values[on_rotor]) == {"1F", "suspension"}
    diameters = data["mode_nodal_diameter"].values[~on_rotor]
    np.testing.assert_array_equal(np.sort(diameters), np.arange(1, 12))
    np.testing.assert_allclose(data.attrs["operating_range"], (1.0, 1.2))


@pytest.mark.slow
def test_an_operating_range_is_named_only_if_it_is_given(case: Path, saved: Figures) -> None:
    printed = answer(
        "campbell", case, *SMALL, "--html", case.parent / "page.html", "-o", "fan"
    ).stdout
    page = (case.parent / "page.html").read_text(encoding="utf-8")
    assert "Coincidences in the speed range" in page
    figure, _ = saved["campbell-rotating"]
    labels = {text.get_text() for text in figure.findobj(Text)}
    for words in (printed, page, " ".join(labels)):
        assert not re.search(r"\boperating\b", words)
    ranged = ["--operating", "1:1.2", "--html", case.parent / "ranged.html"]
    assert "operating" in answer("campbell", case, *SMALL, *ranged).stdout
    assert "Coincidences in the operating range" in (case.parent / "ranged.html").read_text("utf-8")


@pytest.mark.slow
def test_the_page_has_both_diagrams_with_values(case: Path, tmp_path: Path) -> None:
    effects = ("--set", "rotation.effects=full")
    page = tmp_path / "fan.html"
    result = answer("campbell", case, *SMALL, *effects, "--html", page)
    assert result.stdout.splitlines()[-1] == f"Wrote {page}."
    assert {path.name for path in tmp_path.iterdir()} == {case.name, page.name}
    parsed = Parsed(page.read_text(encoding="utf-8"))
    assert not parsed.outside()
    assert set(parsed.pictures) == {"rotating-frame", "static-frame"}
    for name in ("rotating", "static"):
        (panel,) = parsed.values[f"{name}-frame"]
        assert f"{name} frame" in panel["y"]["label"]
        names = {curve["name"] for curve in panel["curves"]}
        assert {f"bladed disk, 1F, k = 1, {way}" for way in ("backward", "forward")} <= names


@pytest.mark.slow
def test_veering_diagrams(case: Path, saved: Figures) -> None:
    result = answer("veering", case, *SMALL, "--families", "3", "--stiffnesses", "1e6:1e9")
    assert "suspension, rotating frame" in result.stdout
    assert set(saved) == {"families", "first-families", "shaft"}
    np.testing.assert_allclose(saved["shaft"][1]["stiffness"][[0, -1]], [1e6, 1e9])


def test_veering_as_one_document() -> None:
    content = document("veering")
    assert len(content["modes"]) == 2 * 12 * 12 + 1
    assert content["modes"][0] == {
        "centre": "free",
        "family": "1F",
        "nodal_diameter": 1,
        "frequency_hz": pytest.approx(content["reference_frequency_hz"]),
        "normalised": 1.0,
    }


def test_modes_at_a_speed_say_which(case: Path) -> None:
    at_speed = answer("modes", case, "--set", "rotation.effects=centrifugal").stdout
    speed = bw.build_stage(bw.read_case(case)).speed * 30.0 / np.pi
    assert f"centre, at {speed:.6g} rpm" in at_speed
    assert "rpm" not in answer("modes", case).stdout


def test_a_campbell_diagram_without_resonances_says_so(case: Path) -> None:
    rigid = ("--set", "casing.type=rigid", "--set", "excitation.type=none")
    printed = answer("campbell", case, "--json", *rigid)
    assert not json.loads(printed.stdout)["coincidences"]
    printed = answer("campbell", case, "-o", case.parent / "diagrams", *rigid)
    assert "--orders adds orders" in printed.stdout

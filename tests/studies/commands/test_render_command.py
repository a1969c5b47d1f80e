"""`bladewhirl render` and `export`: which files they write, and what they say."""

from pathlib import Path
from typing import Any

import pytest
import pyvista
from command_line import answer, refusal
from PIL import Image


@pytest.mark.usefixtures("can_draw")
@pytest.mark.slow
def test_each_kind_goes_to_the_folder_of_the_run(run: Path) -> None:
    done = answer("render", run, "--gif", "--frames", "2")
    with Image.open(run / "animation.gif") as film:
        assert getattr(film, "n_frames", 1) == 2
    assert "2 pictures from" in done.stdout
    answer("render", run / "result.nc", "--png")
    assert (run / "still.png").is_file()


@pytest.mark.slow
@pytest.mark.usefixtures("can_draw")
def test_a_named_file_and_a_window_with_units(run: Path, tmp_path: Path) -> None:
    path = tmp_path / "new" / "coarse.gif"
    arguments = ["--from", "50 ms", "--to", "0.4", "--frames", "5", "--frame", "rotating"]
    done = answer("render", run, "-o", path, *arguments)
    assert "5 pictures from 0.05 s to 0.4 s" in done.stdout
    assert "frames per revolution" in done.stderr  # too few for a smooth turn
    with Image.open(path) as film:
        assert getattr(film, "n_frames", 1) == 5


@pytest.mark.usefixtures("can_draw")
@pytest.mark.slow
def test_stills_at_times_and_a_sheet(run: Path, tmp_path: Path) -> None:
    times = ["--time", "50 ms", "--time", "0.1"]
    still = ["render", str(run), "-o", str(tmp_path / "at.png"), "--colour", "gap", "--orbit"]
    answer(*still, *times)
    sheet = ["render", str(run), "--sheet", "-o", str(tmp_path / "many.png")]
    done = answer(*sheet, "--frames", "2", "--from", "0.1", "--to", "0.2")
    assert "2 pictures" in done.stdout
    assert {path.name for path in tmp_path.iterdir()} == {
        *(f"at_{number}.png" for number in (1, 2)),
        "many.png",
    }


def test_a_page_needs_no_display(run: Path, tmp_path: Path) -> None:
    path = tmp_path / "run.html"
    done = answer("render", run, "-o", path, "--frames", "3")
    assert "3 pictures from" in done.stdout
    assert path.is_file()


def test_options_of_the_view(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[dict[str, Any]] = []
    monkeypatch.setattr(
        "bladewhirl.studies.runs.render.render", lambda _, path, **options: calls.append(options)
    )
    options = ["--time", "0.1", "--colour", "gap", "--view", "axial"]
    refusal("render", run, "--png", "--width", "85", "--orbit")
    answer("render", run, "--png", "--width", "85", *options)
    [view] = calls
    assert view.pop("progress")
    look = {"exaggeration": None, "frame": None, "colour": "gap", "view": "axial", "orbit": False}
    assert view == {"time": 0.1, "width": pytest.approx(0.085), **look}


def test_a_window_as_lines(run: Path) -> None:
    arguments = ["--frames", "5", "--from", "100 ms", "--to", "0.2"]
    done = answer("export", run, *arguments)
    assert "5 instants from 0.1 s to 0.2 s" in done.stdout
    assert "frames per revolution" in done.stderr  # too few for a smooth turn
    reader = pyvista.PVDReader(run / "vtk" / "series.pvd")
    assert reader.time_values == pytest.approx([0.1, 0.125, 0.15, 0.175, 0.2])
    rotor, casing, *others = reader.read()
    assert casing.volume > 0  # the wall is always solid
    assert all(part.volume == 0 for part in (rotor, *others))


def test_surfaces_in_a_named_folder(run: Path, tmp_path: Path) -> None:
    target = tmp_path / "deep" / "machine"
    answer("export", run / "result.nc", "--surface", "--frames", "2", "-o", target)
    rotor, casing, contact, _ = pyvista.PVDReader(target / "series.pvd").read()
    assert rotor.volume > 0
    assert casing.volume > 0
    assert contact.n_points == 22

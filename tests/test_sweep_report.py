"""`bladewhirl report` of sweeps: finished ones, ones with failed or missing points, none done."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from report_pages import Parsed
from synthetic_sweep import synthetic_sweep
from typer.testing import CliRunner

from bladewhirl.postprocess.report_words import SWEEP
from bladewhirl.postprocess.sweep_figures import SWEEP_FIGURES
from bladewhirl.postprocess.sweep_result import SWEEP_NAME
from bladewhirl.studies.cli import app
from bladewhirl.studies.reports import write_report

REFERENCE = 75.0  # rad/s
SPEEDS = (1.0, 1.2, 1.4, 1.6)
RADII = (0.4e-3, 1.3e-3, 1.2e-3)  # the clearance is 1 mm


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Free, in contact twice, failed."""
    motions = [
        *(
            {"speed": REFERENCE * speed, "shaft_radius": radius}
            for speed, radius in zip(SPEEDS, RADII, strict=False)
        ),
        None,
    ]
    over = {"march.speed": SPEEDS}
    return synthetic_sweep(tmp_path_factory.mktemp("sweeps") / "one", over, motions)


@pytest.fixture(scope="module")
def page(folder: Path) -> Parsed:
    done = CliRunner().invoke(app, ["report", str(folder)])
    assert (done.exit_code, done.stdout) == (0, f"Wrote {folder / 'report.html'}.\n"), done.stderr
    return Parsed((folder / "report.html").read_text(encoding="utf-8"))


def test_it_stands_alone_with_its_figures(page: Parsed) -> None:
    assert page.references
    assert page.outside() == []
    assert set(SWEEP) == set(SWEEP_FIGURES)
    assert set(page.pictures) == set(SWEEP) - {"maps"}


def test_the_verdict_is_of_its_points(page: Parsed) -> None:
    words = re.sub(r"\s+", " ", page.words)
    assert "Sustained contact at 2 of 3 points" in words
    assert "stays in contact at march.speed 1.2 to 1.4; never touches at march.speed 1." in words
    assert "1 of 4 points failed; the reasons are listed under Points." in words
    assert "march.speed = 1.6 it could not be marched" in words
    assert "unfinished" not in words


def test_points_and_maps_are_those_of_the_sweep(page: Parsed) -> None:
    points, maps = page.plots
    shown = {trace["name"]: trace for trace in points["data"]}
    assert set(shown) == {"no-contact (1)", "sustained (2)"}
    assert shown["sustained (2)"]["text"][0].startswith("<b>sustained</b><br>march.speed = 1.2<br>")
    assert "largest shaft displacement 1.3 mm" in shown["sustained (2)"]["text"][0]
    heat = maps["data"][0]
    told = np.array(
        [[np.nan if cell == "–" else float(cell) for cell in row] for row in heat["customdata"]]
    )
    assert np.isnan(told[:, 3]).all()  # the failed point
    np.testing.assert_allclose(told[:, :3].max(axis=0), [0.4, 1.3, 1.2], rtol=0.2)


def test_two_keys_and_missing_points(tmp_path: Path) -> None:
    import h5py

    over = {"march.speed": (1.0, 2.0), "contact.friction": (0.0, 0.2)}
    motions = [{"speed": REFERENCE, "shaft_radius": radius * 1e-3} for radius in (0.2, 1.2, 0.3, 1)]
    folder = synthetic_sweep(tmp_path / "two", over, motions)
    with h5py.File(folder / SWEEP_NAME, "r+") as file:
        file["state"][1, 0] = 0
    page = Parsed(write_report(folder).read_text(encoding="utf-8"))
    words = re.sub(r"\s+", " ", page.words)
    assert re.search(r"\d of 3 points so far", words)
    assert "unfinished: 1 of 4 points are missing; bladewhirl sweep --resume" in words
    regimes, _, maps = page.plots
    assert regimes["data"][0]["text"][0][1].startswith("<b>missing</b>")
    assert [entry["label"] for entry in maps["layout"]["updatemenus"][0]["buttons"]] == [
        "contact.friction = 0",
        "contact.friction = 0.2",
    ]


def test_a_sweep_without_a_point_done(tmp_path: Path) -> None:
    folder = synthetic_sweep(tmp_path / "none", {"march.speed": (1.0, 2.0)}, [None, None])
    page = Parsed(write_report(folder).read_text(encoding="utf-8"))
    assert "No result" in page.words
    assert "2 of 2 points failed" in page.words
    assert "Not drawn: no point of the sweep is done" in page.words
    assert page.plots == []


def test_a_folder_of_neither_and_a_broken_sweep(tmp_path: Path) -> None:
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / SWEEP_NAME).write_text("broken")
    for name, complaint in (
        (".", "expected the folder of a run or a sweep, with its result.nc or sweep.nc"),
        ("broken", "expected a sweep"),
    ):
        done = CliRunner().invoke(app, ["report", str(tmp_path / name)])
        assert (done.exit_code, done.stdout) == (2, "")
        assert complaint in done.stderr
        assert len(done.stderr.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["broken"]

"""`bladewhirl report`: self-contained pages with the figures and numbers of a run."""

import base64
import json
import re
from pathlib import Path
from typing import Any

import pytest
import synthetic_result as synthetic
import xarray as xr
from matplotlib.figure import Figure
from report_pages import PICTURE, Parsed, reported
from three_runs import KINDS, run_of

import bladewhirl as bw
from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.pictures.render import animation_records
from bladewhirl.postprocess.pictures.web_page import film_page
from bladewhirl.postprocess.plotting.registry import RUN_FIGURES
from bladewhirl.postprocess.reports import page as report_page
from bladewhirl.postprocess.reports.run import _glance
from bladewhirl.postprocess.run.extremes import largest_force, stress_split
from bladewhirl.postprocess.run.histories import contact_force
from bladewhirl.postprocess.run.stresses import stress_history

pytestmark = pytest.mark.pictures

MARCHED = {
    "complementarity_residual": 3.25e-12,
    "unsolved_steps": 0,
    "dt_over_critical": 0.2125,
    "wall_time": 1.75,
    "us_per_step": 4.375,
}


def made(folder: Path, **attributes: Any) -> Path:
    """The folder of a run."""
    folder.mkdir()
    result = synthetic.synthetic_result(shaft_radius=1.2e-3, records=901)
    attributes = {**MARCHED, **attributes}
    known = {name: value for name, value in attributes.items() if value is not None}
    result.assign_attrs(known).to_netcdf(folder / "result.nc", engine="h5netcdf")
    (folder / "provenance.json").write_text(
        json.dumps({"bladewhirl": "0.1.0", "python": "3.11.4", "dependencies": {"numpy": "2.2.9"}})
    )
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(tmp_path_factory.mktemp("reports") / "run", title="<b>a & b</b></script>")


@pytest.fixture(scope="module")
def page(folder: Path) -> Parsed:
    return reported(folder)


@pytest.mark.usefixtures("page")
def test_it_stands_alone(folder: Path) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert "default-src 'none'" in text  # what a browser would refuse to load
    assert (
        "<title>&lt;b&gt;a &amp; b&lt;/b&gt;&lt;/script&gt;: Contact up to the end</title>" in text
    )
    assert not [path.name for path in folder.iterdir() if path.name.startswith(".")]


def test_all_figures_are_inside(page: Parsed) -> None:
    drawn = {name for name, kind in RUN_FIGURES.items() if kind.section not in ("", "wear")}
    drawn -= {"regime"}  # so short a run has no growth rate
    drawn -= {"contact-nodes", "tips", "joints"}  # of superelements
    drawn -= {"line-bearing-forces", "line-orbits"}  # of shaft lines
    drawn -= {"run-up", "critical-orbits", "waterfall", "torques"}  # of a speed that varies
    assert len(drawn) == 20
    assert set(page.pictures) == drawn
    assert set(page.pictures.values()) == {f"data:image/png;base64,{PICTURE}"}
    assert base64.b64decode(report_page._as_png(Figure())).startswith(b"\x89PNG")
    assert "Not drawn: the history is too short for a growth rate, or nothing moves." in page.words


def test_numbers_are_those_of_the_run(page: Parsed) -> None:
    for expected in (
        "1.2 mm",  # the radius of the circle
        "1.2 times the clearance",
        "backward 11.1 Hz",  # 70 rad/s, rotating frame
        "forward 1.59 Hz",  # 80 - 70 rad/s, static frame
        "764 rpm Ω/ω₁ = 1.067",  # 80 over 75 rad/s
        "complementarity residual 3.25e-12",
        "time step / critical 0.212",
        'title = "synthetic"',
        "numpy 2.2.9",
    ):
        assert expected in page.words, expected


def test_it_begins_with_card_and_film(folder: Path, page: Parsed) -> None:
    """The film is that of `render --html` around the strongest contact."""
    assert next(iter(page.pictures)) == "card"
    assert page.words.index("On one page") < page.words.index("The stage in motion")
    with xr.open_dataset(folder / "result.nc", engine="h5netcdf") as result:
        records = animation_records(result, frames=60)
        assert page.film == film_page(result, records, colour="stress")


def test_values_under_the_pointer_are_inside(page: Parsed) -> None:
    assert set(page.values) == set(page.pictures)
    (panel,) = page.values["contact-classes"]
    assert panel["y"]["label"] == "time in contact [%]"
    assert sum(len(curve["points"]) for curve in panel["curves"]) >= 22


def test_a_killed_march_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bladewhirl.postprocess.reports.run.report_figures", lambda *_: [])
    run = made(tmp_path / "run", end_reason="unfinished", steps=0, **dict.fromkeys(MARCHED))
    target = tmp_path / "own.html"
    target.write_text("old")
    assert bw.report(run, target) == target
    page = Parsed(target.read_text(encoding="utf-8"))
    assert "it was killed, or is still running. The last record is at 0.9 s" in page.words
    assert "Contact up to the end so far" in page.words
    assert "complementarity residual" not in page.words
    assert not re.search(r"\bnan\b", page.words)
    assert "900000" in page.words  # steps up to the last record
    assert not (run / "report.html").exists()


def test_reports_begin_with_force_stress_and_wear() -> None:
    """As tiles, with the numbers of the summary, for every kind of stage."""
    for kind in KINDS:
        run = run_of(kind)
        glance = _glance(run, stress_history(run))
        tiles, remarks = ({row[0]: row[column] for row in glance} for column in (1, 2))
        force = largest_force(run)["on_blade"]
        assert tiles["largest force on a blade"] == handy(force, "N", 3)
        over_a_record = handy(float(contact_force(run)["normal"].max()), "N", 3)
        assert remarks["largest force on a blade"].endswith(f"up to {over_a_record}")
        split = stress_split(stress_history(run))
        assert split is not None
        assert tiles["alternating stress"] == handy(split["alternating"], "Pa", 3)
        assert ("deepest wear" in tiles) == (kind != "wheel")

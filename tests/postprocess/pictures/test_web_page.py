"""Pages: complete without a network, and true to the drawing."""

import re
from html import unescape
from pathlib import Path

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from web_pages import page, part

from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.web_page import FULL, NONE, render_page

RECORDS = np.arange(376, 388, 4)  # the first without contact


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return synthetic.synthetic_result(elements=2)


def test_places_are_those_of_the_drawing(result: xr.Dataset, tmp_path: Path) -> None:
    about, places, _ = page(render_page(result, tmp_path / "a.html", RECORDS))
    drawing = Drawing(result, RECORDS)
    drawn = [drawing.picture(index) for index in range(3)]
    size = np.linalg.norm(drawn[0].casing.sides) / np.linalg.norm(part(about, places, "casing")[0])
    for name, expected in (
        ("rotor", [seen.rotor.sides for seen in drawn]),
        ("casing", [seen.casing.sides for seen in drawn]),
        ("springs", [seen.symbols.springs for seen in drawn]),
        ("nodes", [seen.tip_places for seen in drawn]),
        ("shaft", [seen.shaft for seen in drawn]),
    ):
        np.testing.assert_allclose(size * part(about, places, name), expected, atol=2e-5)
    assert np.abs(places).max() < FULL  # nothing is cut off
    touching = [np.any(seen.pushes, axis=1).astype(int).tolist() for seen in drawn]
    assert about["touching"] == touching
    assert any(map(any, touching))
    largest = max(range(len(drawn)), key=lambda i: float(np.linalg.norm(drawn[i].forces)))
    assert about["first"] == largest


def test_shades_are_true_values(result: xr.Dataset, tmp_path: Path) -> None:
    about, _, shades = page(render_page(result, tmp_path / "a.html", RECORDS, colour="stress"))
    drawing = Drawing(result, RECORDS, colour="stress")
    beams = [drawing.picture(index).rotor.values for index in range(3)]
    walls = [drawing.picture(index).casing.values for index in range(3)]
    first, last = about["casingShades"], about["perScale"] - 1
    colouring, split = (
        drawing.colouring,
        (shades[:, :first], shades[:, first : about["surfaceShades"]]),
    )
    for number, (scale, drawn, given) in enumerate(
        zip((colouring.disk, colouring.wall), split, (beams, walls), strict=True)
    ):
        low, high, _ = about["scales"][number]
        share = (drawn - number * about["perScale"]) / last
        true = scale.factor * np.reshape(given, (3, -1))
        np.testing.assert_allclose(
            low + (high - low) * share, true, atol=0.51 * (high - low) / last
        )
    assert len(about["members"]) == result.sizes["rotor_line"]


def test_the_speed_is_that_of_the_instant(result: xr.Dataset, tmp_path: Path) -> None:
    time = result["time"].values
    speed, turned = 50.0 + 900.0 * time, 50.0 * time + 450.0 * time**2
    run_up = result.assign(rotation_speed=("time", speed), rotation_angle=("time", turned))
    about, _, _ = page(render_page(run_up, tmp_path / "a.html", RECORDS))
    shown = [float(text.split()[0]) for text in about["speeds"]]
    assert shown == pytest.approx(speed[RECORDS], rel=1e-4)
    assert np.ptp(shown) > 0.0
    assert about["lost"] == [[], [], []]


def test_missing_values_and_parts(result: xr.Dataset, tmp_path: Path) -> None:
    about, _, shades = page(render_page(result, tmp_path / "a.html", RECORDS, colour="gap"))
    assert np.all(shades[:, : about["nodeShades"]] == NONE)  # only contact nodes have a gap
    assert np.all(shades[:, about["nodeShades"] :] != NONE)
    about, _, shades = page(render_page(result, tmp_path / "b.html", RECORDS, colour="part"))
    text = (tmp_path / "b.html").read_text(encoding="utf-8")
    key = re.findall(r'<div class="key"><i style="background: (#\w+)"></i>(\w+)</div>', text)
    assert [name for _, name in key] == ["spokes", "rim", "blades", "casing"]
    assert [colour for colour, _ in key] == about["colours"]
    assert np.unique(shades).tolist() == [0, 1, 2, 3, NONE]  # contact nodes are no part


TITLES = ["<b>a & b</b></script>", "<!--<script>", "@PLACES@ {{ about }}", "\u2028 ' \" \\"]


@pytest.mark.parametrize("title", TITLES)
def test_it_stands_alone_and_titles_are_text(
    result: xr.Dataset, tmp_path: Path, title: str
) -> None:
    path = render_page(result.assign_attrs(title=title), tmp_path / "a.html", RECORDS)
    text = path.read_text(encoding="utf-8")
    assert "http:" not in text
    assert "https:" not in text
    assert "default-src 'none'" in text
    assert unescape(re.search("<title>(.*)</title>", text)[1]) == title  # type: ignore[index]
    assert unescape(re.search("<h1>(.*)</h1>", text)[1]) == title  # type: ignore[index]
    assert (text.count("<script>"), text.count("</script>"), text.count("<!--")) == (1, 1, 0)
    assert len(page(path)[0]["times"]) == len(RECORDS)

"""Values under the pointer are those that were drawn."""

import json
import re
from pathlib import Path

import matplotlib.style
import numpy as np
import pytest
from long_cases import slow_except
from matplotlib.figure import Figure
from three_runs import KINDS, Kind, run_of

from bladewhirl.postprocess.plotting.axes import draw_map
from bladewhirl.postprocess.plotting.hover import FULL, hover_data
from bladewhirl.postprocess.plotting.style import laid_out, new_figure, save_figure, time_axis
from bladewhirl.postprocess.run.figures import RunFigures

pytestmark = pytest.mark.pictures


def drawn() -> Figure:
    """A curve over time in ms, logarithmic upward; a map with a colour bar."""
    figure = new_figure(width=0.17, height=0.06)
    curve, cells = figure.subplots(1, 2)
    curve.plot([0.0, 0.01, 0.02], [1.0, 100.0, 10.0], label="force")
    curve.set(yscale="log", ylabel="force [N]", ylim=(1.0, 1000.0))
    time_axis(curve)
    draw_map(
        cells, [0.0, 1.0, 2.0, 3.0], [0.0, 10.0, 20.0], np.arange(6.0).reshape(2, 3), label="gap"
    )
    return figure


def test_positions_give_the_values_back() -> None:
    figure = drawn()
    with laid_out(figure):
        figure.canvas.draw()
    curve, cells = hover_data(figure)
    assert (curve["x"]["label"], curve["y"]["label"]) == ("time [ms]", "force [N]")
    (line,) = curve["curves"]
    assert line["name"] == "force"
    left, top, right, bottom = curve["box"]
    x, y = np.array(line["points"], dtype=float).T
    ends = curve["x"]["ends"]
    share = (x - left) / (right - left)
    np.testing.assert_allclose(ends[0] + share * np.diff(ends), [0.0, 10.0, 20.0], atol=0.01)
    assert curve["y"]["log"]
    low, high = curve["y"]["ends"]
    up = (bottom - y) / (bottom - top)
    np.testing.assert_allclose(low * (high / low) ** up, [1.0, 100.0, 10.0], rtol=5e-3)
    (shown,) = cells["maps"]
    assert shown["label"] == "gap"
    assert shown["values"] == [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]
    assert len(shown["x"]) == 4
    assert shown["y"] == sorted(shown["y"], reverse=True)  # from the top of the picture


def test_a_page_of_a_figure_loads_nothing(tmp_path: Path) -> None:
    (path,) = save_figure(drawn(), tmp_path / "figure", formats=["html"])
    text = path.read_text(encoding="utf-8")
    assert "default-src 'none'" in text
    assert re.findall(r'(?:src|href)="(?!data:image/png;base64,)', text) == []
    data = json.loads(re.search(r'id="values">(.*?)</script>', text, re.DOTALL)[1])  # type: ignore[index]
    assert [len(panel["curves"]) + len(panel["maps"]) for panel in data] == [1, 1]


@pytest.mark.parametrize("kind", slow_except(KINDS, "blade"))
def test_figures_of_every_stage_have_values(kind: Kind) -> None:
    for name in ("unrolled", "haigh", "close-up"):
        figure, _ = RunFigures(run_of(kind)).draw(name)
        figure.draw_without_rendering()
        panels = hover_data(figure)
        assert panels
        for panel in panels:
            assert all(0 <= edge <= FULL for edge in panel["box"])
            assert panel["y"]["label"]
            assert json.dumps(panel, allow_nan=False)


def test_the_style_of_the_user_does_not_matter() -> None:
    with matplotlib.style.context("dark_background"):
        assert hover_data(drawn())[0]["curves"]

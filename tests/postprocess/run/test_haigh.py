"""Haigh diagram: points and line are the stored values, for every kind of stage."""

import numpy as np
import pytest
import xarray as xr
from legible import assert_legible
from long_cases import slow_except
from three_runs import KINDS, Kind, run_of

from bladewhirl.postprocess.plotting.style import at_width
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.run.haigh import haigh, plot_haigh
from bladewhirl.postprocess.run.stresses import stress_history

pytestmark = pytest.mark.pictures

LIMITS = {"endurance": 2e8, "strength": 9e8}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("width", slow_except([0.085, 0.17], 0.085))
def test_points_are_the_stored_values(kind: Kind, width: float) -> None:
    with at_width(width):
        figure, data = RunFigures(run_of(kind).assign_attrs(LIMITS)).draw("haigh")
    assert_legible(figure)
    (axes,) = figure.axes
    line, *points = axes.lines
    np.testing.assert_allclose(np.array(line.get_xydata())[-2:], [[0.0, 200.0], [900.0, 0.0]])
    drawn = np.concatenate([np.asarray(one.get_xydata()) for one in points])
    stored = 1e-6 * np.column_stack([data["mean"], data["alternating"]])
    worst = int(data["margin"].values.argmin())
    assert data.attrs["worst"] == worst
    np.testing.assert_array_equal(drawn, np.vstack([np.delete(stored, worst, 0), stored[worst]]))
    used = stored[:, 1] / 200.0 + np.maximum(stored[:, 0], 0.0) / 900.0
    np.testing.assert_allclose(1.0 / used, data["margin"])
    assert axes.get_title() == f"blade {worst}: margin {1.0 / used.max():.3g}"


def test_without_limits_the_figure_says_what_is_missing() -> None:
    given = run_of("wheel").assign_attrs(endurance=2e8)
    figure, data = RunFigures(given).draw("haigh")
    assert "margin" not in data
    assert figure.axes[0].get_title().endswith("no margin, as the case gives no\nmaterial.strength")


def test_lost_blades_are_left_out() -> None:
    run: xr.Dataset = run_of("beams")
    lost = {"case": f"{run.attrs['case']}\n[blade_loss]\nblade = [0, 2]\ntime = 0.01\n"}
    figure, data = RunFigures(run.assign_attrs(lost)).draw("haigh")
    assert np.isnan(data["alternating"].values).tolist() == [n in (0, 2) for n in range(6)]
    assert {text.get_text() for text in figure.axes[0].texts} <= set("1345")
    assert data.attrs["worst"] == 3


def test_blades_at_the_same_place_share_a_label() -> None:
    """Opposite blades of a wheel in a wall of two lobes have equal stresses."""
    data = haigh(stress_history(run_of("beams")))
    mean, alternating = data["mean"].copy(), data["alternating"].copy()
    mean[4:], alternating[4:] = mean[:2].values, alternating[:2].values
    figure = plot_haigh(data.assign(mean=mean, alternating=alternating))
    texts = {text.get_text() for text in figure.axes[0].texts}
    assert texts & {"0, 4", "1, 5"}
    assert not texts & {"0", "1", "4", "5"}

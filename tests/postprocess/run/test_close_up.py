"""Close-up of one pass: path and wall are as far apart as the march says, and are drawn so."""

import numpy as np
import pytest
from legible import assert_legible
from long_cases import slow_except
from three_runs import KINDS, Kind, run_of

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.plotting.style import at_width
from bladewhirl.postprocess.run.close_up import close_up
from bladewhirl.postprocess.run.figures import RunFigures

pytestmark = pytest.mark.pictures

PATH, GAP, FORCE, STROBE = range(4)


@pytest.mark.parametrize("kind", KINDS)
def test_the_gap_is_that_between_path_and_wall(kind: Kind) -> None:
    """To the motion between two records, over which the gap of a record is the smallest."""
    run, data = run_of(kind), close_up(run_of(kind))
    apart = (data["wall"] - data["radius"]).values
    gap = data["gap"].values
    change = np.abs(np.diff(apart))
    np.testing.assert_array_less(np.abs(gap - apart)[1:], change + 0.02 * np.ptp(apart) + 1e-9)
    impulse = run["contact_impulse"].values
    assert float(data["normal"].max()) == pytest.approx(impulse.max() / run.attrs["record_step"])
    at = int(data["normal"].values.argmax())
    assert float(data["time"][at]) == data.attrs["instant"]
    if kind != "wheel":
        pushed = (data["coating"] - data["radius"]).values[data["normal"].values > 0.0]
        assert pushed.min() < 0.0  # into the coating
    _, node = np.unravel_index(impulse.argmax(), impulse.shape)
    angle = run["tip_angle"].values[node] + run.attrs["speed"] * data["time"].values
    turns = (data["angle"].values - angle) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
    here = int(np.abs(data["passed"].values - data.attrs["instant"]).argmin())
    assert float(data["passed"][here]) == pytest.approx(data.attrs["instant"])
    period = 2 * np.pi / run.attrs["speed"]
    np.testing.assert_allclose(np.diff(data["passed"]), period)


@pytest.mark.parametrize("width", slow_except([0.085, 0.17], 0.085))
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_drawn_is_what_is_stored(kind: Kind, width: float) -> None:
    with at_width(width):
        figure, data = RunFigures(run_of(kind)).draw("close-up")
    assert_legible(figure)
    path, gap, force, strobe = figure.axes
    angle = np.degrees(data["angle"].values)
    gaps = data["gap"] if kind == "wheel" else data["gap"] - (data["wall"] - data["coating"])
    for axes, line, stored in (
        (path, 0, data["radius"]),
        (gap, 0, gaps),
        (force, 0, data["normal"]),
        (force, 1, data["friction"]),
    ):
        x, y = np.asarray(axes.lines[line].get_xydata()).T
        np.testing.assert_array_equal(x, angle)
        factor = np.abs(y).max() / np.abs(stored.values).max()
        assert np.log10(factor) == pytest.approx(round(np.log10(factor)))
        np.testing.assert_allclose(y, factor * stored.values, atol=1e-9)
    points = np.concatenate([np.asarray(line.get_xydata()) for line in strobe.lines[:2]])
    assert len(points) == data.sizes["revolution"]


def test_what_cannot_be_shown_is_refused() -> None:
    run = run_of("wheel")
    with pytest.raises(ViewError, match="no blade tip touches"):
        close_up(run.assign(contact_impulse=0.0 * run["contact_impulse"]))
    with pytest.raises(ViewError, match="a rotor that turns"):
        close_up(run.assign_attrs(speed=0.0))

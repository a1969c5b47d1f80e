"""Figures of sweeps as readers see them: all on the canvas, units that read well, lines and marks
that are told apart without colour.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from legible import assert_legible
from matplotlib.collections import PolyQuadMesh
from matplotlib.figure import Figure
from matplotlib.text import Text
from synthetic_sweep import synthetic_sweep

from bladewhirl.postprocess.plotting.style import INCH, at_width, new_figure
from bladewhirl.postprocess.sweep.dataset import open_sweep
from bladewhirl.postprocess.sweep.drawing import in_handy_units, key_axis, lines_of
from bladewhirl.postprocess.sweep.figures import SweepFigures
from bladewhirl.postprocess.sweep.frequency_map import frequency_map, plot_frequency_map
from bladewhirl.postprocess.sweep.maps import DOUBTFUL, plot_sweep_maps, sweep_maps
from bladewhirl.postprocess.sweep.quantities import contact_sides, regimes
from bladewhirl.postprocess.sweep.shaft import plot_contact_sides

pytestmark = pytest.mark.pictures

REFERENCE = 75.0  # rad/s
SPEEDS = (1.0, 1.1, 1.2)


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Iterator[xr.Dataset]:
    """Three speeds and two values of each of three lengths with long names."""
    motions = [
        {"speed": REFERENCE * s, "shaft_radius": 1e-4 * s, "records": 101}
        for s in SPEEDS
        for _ in range(8)
    ]
    over = {
        "march.speed": SPEEDS,
        "casing.clearance_amplitude": (2e-5, 5e-5),
        "blades.suspension_thickness": (1.25e-3, 2.5e-3),
        "shaft.bearing_clearance": (0.4e-3, 0.6e-3),
    }
    folder = tmp_path_factory.mktemp("sweeps") / "four"
    units = {key: "1" if key == "march.speed" else "m" for key in over}
    with open_sweep(synthetic_sweep(folder, over, motions, units=units)) as data:
        yield data


@pytest.mark.parametrize("name", ["frequency-map", "energy-families", "maps", "contact-classes"])
@pytest.mark.slow
def test_figures_of_four_keys_stay_on_their_canvas(sweep: xr.Dataset, name: str) -> None:
    figure, _ = SweepFigures(sweep).draw(name)
    assert_legible(figure)


def test_lines_differ_without_their_colour(sweep: xr.Dataset) -> None:
    lines = list(lines_of(in_handy_units(regimes(sweep, "march_speed"))))
    assert len({str(line.dash) for line in lines}) == len({line.mark for line in lines}) == 8
    assert lines[0].label == "20 µm, 1.25 mm, 0.4 mm"


def keyed(values: np.ndarray) -> xr.Dataset:
    attributes = {"long_name": "casing.support", "units": "1"}
    return xr.Dataset(coords={"key": ("key", values, attributes)}, attrs={"along": "key"})


def test_ticks_are_at_the_swept_values_if_these_are_few() -> None:
    axes = new_figure(height=0.05).subplots()
    few = np.array([1.0, 1.5, 1.6, 3.0])
    key_axis(axes, keyed(few))
    np.testing.assert_allclose(axes.get_xticks(), few)
    np.testing.assert_allclose(axes.get_xlim(), [0.75, 3.7])
    many = np.linspace(0.0, 1.0, 201)
    key_axis(axes, keyed(many))
    assert len(axes.get_xticks()) < 20


def test_points_that_nothing_touches_have_no_side(sweep: xr.Dataset) -> None:
    share = np.zeros(sweep["late_contact_share"].shape)
    share[1, ..., 3] = 0.5
    changed = sweep.assign(late_contact_share=(sweep["late_contact_share"].dims, share))
    actual = contact_sides(changed, "march_speed")
    assert (actual["scenario"].values[:, [0, 2]] == "no-contact").all()
    assert np.isnan(actual["shaft_lead"].values[:, [0, 2]]).all()
    assert np.isfinite(actual["shaft_lead"].values[:, 1]).all()
    assert not (actual["scenario"].values[:, 1] == "no-contact").any()
    figure = plot_contact_sides(actual)
    low, high = figure.axes[1].get_xlim()
    assert low < SPEEDS[0]  # though nothing is drawn there
    assert high > SPEEDS[-1]


def test_growth_that_may_be_none_is_crossed_out(sweep: xr.Dataset) -> None:
    maps = sweep_maps(sweep, "march_speed")
    rate = np.full(maps["growth_rate"].shape, 3.0)
    error = np.ones_like(rate)
    error[0, 0, :2] = 2.0
    maps["growth_rate"][:], maps["growth_error"][:] = rate, error
    figure = plot_sweep_maps(maps)
    crossed = [
        len(collection.get_paths())
        for axes in figure.axes
        for collection in axes.collections
        if isinstance(collection, PolyQuadMesh) and collection.get_hatch()
    ]
    assert crossed == [2, 0, 0, 0]
    assert DOUBTFUL in [text.get_text() for text in figure.legends[0].get_texts()]


@pytest.mark.slow
def test_a_frequency_map_names_only_modes_that_are_seen(sweep: xr.Dataset) -> None:
    maps = frequency_map(sweep, "march_speed")
    names = [text.get_text() for text in plot_frequency_map(maps).legends[0].get_texts()]
    assert names == ["suspension", "1F k = 1", "casing k = 1", "engine orders"]
    maps["mode_line"].loc[{"mode": "casing k=1"}] = 1e4
    names = [text.get_text() for text in plot_frequency_map(maps).legends[0].get_texts()]
    assert names == ["suspension", "1F k = 1", "engine orders"]


@pytest.mark.parametrize("width", [0.085, 0.17])
@pytest.mark.parametrize(
    "name", ["frequency-map", "energy-families", "maps", "regimes", "whirl", "contact-classes"]
)
@pytest.mark.slow
def test_figures_of_two_keys_are_legible_in_a_column(
    narrow: xr.Dataset, name: str, width: float
) -> None:
    with at_width(width):
        figure, _ = SweepFigures(narrow).draw(name)
    assert figure.get_figwidth() * INCH == pytest.approx(width)
    assert_legible(figure)
    assert not [each for each in texts_of(figure) if "^{" in each]  # 5 points high
    for axes in figure.axes:
        labels = [each for each in axes.get_xticklabels() if each.get_text()]
        boxes = [each.get_window_extent() for each in labels]
        assert all(a.x1 < b.x0 for a, b in pairwise(boxes)), name


def test_axes_and_legends_of_lines_name_their_key(narrow: xr.Dataset) -> None:
    with at_width(0.085):
        strips, maps, whirl = (
            SweepFigures(narrow).draw(name)[0] for name in ("regimes", "maps", "whirl")
        )
    assert strips.axes[0].get_ylabel() == "casing clearance"
    labels = [axes.get_ylabel() for axes in maps.axes]
    assert labels.count("casing clearance [mm]") == 2  # one above the other
    assert "casing clearance" in [each.get_title().get_text() for each in whirl.legends]


def texts_of(figure: Figure) -> list[str]:
    figure.draw_without_rendering()
    return [text.get_text() for text in figure.findobj(Text) if isinstance(text, Text)]


@pytest.fixture(scope="module")
def narrow(tmp_path_factory: pytest.TempPathFactory) -> Iterator[xr.Dataset]:
    """Five speeds and four clearances, with displacements over four decades."""
    over = {
        "march.speed": (1.0, 1.05, 1.1, 1.15, 1.2),
        "casing.clearance": (2e-5, 5e-5, 1e-4, 2e-3),
    }
    motions = [
        {"speed": REFERENCE * s, "shaft_radius": 1e-6 * 10 ** (20 * (s - 1)), "records": 101}
        for s in over["march.speed"]
        for _ in over["casing.clearance"]
    ]
    folder = tmp_path_factory.mktemp("sweeps") / "two"
    units = {"march.speed": "1", "casing.clearance": "m"}
    with open_sweep(synthetic_sweep(folder, over, motions, units=units)) as data:
        yield data

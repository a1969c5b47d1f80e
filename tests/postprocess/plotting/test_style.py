"""The common style: sizes, colours, titles, and what is saved with a figure."""

import re
from pathlib import Path

import matplotlib
import numpy as np
import pytest
import xarray as xr
from legible import assert_legible
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.image import imread
from numpy.typing import ArrayLike
from synthetic_result import synthetic_result

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.postprocess.energy.strain import plot_energy, strain_energies
from bladewhirl.postprocess.plotting import style
from bladewhirl.postprocess.plotting.style import new_figure
from bladewhirl.postprocess.plotting.titles import head, speed_label
from bladewhirl.postprocess.shaft.orbits import plot_orbit, shaft_orbit

pytestmark = pytest.mark.pictures


class TestFiguresOfARun:
    @pytest.mark.slow
    @pytest.mark.parametrize("growing", [False, True])
    def test_are_one_column_wide_and_legible(self, growing: bool) -> None:
        result = synthetic_result(records=3001 if growing else 401, growth=0.8 if growing else 0.0)
        for figure in (plot_orbit(shaft_orbit(result)), plot_energy(strain_energies(result))):
            assert figure.get_figwidth() * 0.0254 == pytest.approx(0.085)
            assert_legible(figure, least=7.0)
            for axes in figure.axes:
                assert not axes.title.get_window_extent().overlaps(axes.get_window_extent())

    @pytest.mark.slow
    def test_look_the_same_whatever_the_users_settings(self, tmp_path: Path) -> None:
        energies = strain_energies(synthetic_result(records=50))
        plain, *_ = style.save_figure(plot_energy(energies), tmp_path / "plain", energies)
        with matplotlib.rc_context({"font.size": 20, "axes.facecolor": "red", "savefig.dpi": 50}):
            other, *_ = style.save_figure(plot_energy(energies), tmp_path / "other", energies)
        np.testing.assert_array_equal(imread(plain), imread(other))


#: dichromats' views of linear RGB after Vienot, Brettel and Mollon (1999)
VIEWS = {
    "trichromat": np.eye(3),
    "protanope": np.array([[0.11238, 0.88762, 0], [0.11238, 0.88762, 0], [0.00401, -0.00401, 1]]),
    "deuteranope": np.array([[0.29275, 0.70725, 0], [0.29275, 0.70725, 0], [-0.02234, 0.02234, 1]]),
}


def seen_as(colours: ArrayLike, view: str) -> FloatArray:
    """Return CIELAB coordinates (colour, 3) of RGB colours as a viewer sees them."""
    rgb = np.asarray(colours)[:, :3]
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4) @ VIEWS[view].T
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    share = np.clip(linear, 0.0, 1.0) @ np.transpose(to_xyz) / [0.9505, 1.0, 1.089]
    f = np.where(share > 0.008856, np.cbrt(share), 7.787 * share + 16.0 / 116.0)
    return np.stack(
        [116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1
    )


@pytest.mark.parametrize("view", VIEWS)
class TestColourMaps:
    @pytest.mark.parametrize("name", ["magnitude", "line", "wall", "contact", "gap"])
    def test_larger_is_darker_for_every_viewer(self, name: str, view: str) -> None:
        lab = seen_as(style.COLOUR_MAPS[name](np.linspace(0.0, 1.0, 33)), view)
        assert np.diff(lab[:, 0]).max() < -0.3
        if name not in ("line", "contact"):
            assert lab[0, 0] == pytest.approx(100.0, abs=0.1)  # zero is paper

    def test_signs_differ_for_every_viewer(self, view: str) -> None:
        lab = seen_as(style.COLOUR_MAPS["signed"](np.linspace(0.0, 1.0, 33)), view)
        assert lab[16, 0] > 99.0
        assert np.diff(lab[:17, 0]).min() > 0.3
        assert np.diff(lab[16:, 0]).max() < -0.3
        apart = np.linalg.norm(lab - lab[::-1], axis=1)
        assert apart[[0, 4, 8, 12]].min() > 12.0

    def test_contact_is_distinct_from_gaps_and_wall_from_blades(self, view: str) -> None:
        for one, other in (("contact", "gap"), ("wall", "magnitude")):
            shades = [style.COLOUR_MAPS[name](np.linspace(0.3, 0.7, 5)) for name in (one, other)]
            apart = seen_as(shades[0], view) - seen_as(shades[1], view)
            assert np.linalg.norm(apart, axis=1).min() > 10.0


class TestColours:
    def test_meanings_drawn_together_are_distinct_without_colour_vision(self) -> None:
        together = ("total", "suspension", "k = 0", "k = 1", "other k", "rest")
        for view in VIEWS.values():
            seen = [view @ np.array(to_rgb(style.COLOURS[name])) ** 2.2 for name in together]
            for i, one in enumerate(seen):
                for other in seen[:i]:
                    assert np.linalg.norm(one - other) > 0.1


class TestSaveFigure:
    def figure(self) -> Figure:
        figure = style.new_figure(height=0.05)
        figure.add_subplot().plot([0, 1], [0, 1])
        return figure

    def test_a_png_and_a_pdf_of_the_printed_size(self, tmp_path: Path) -> None:
        only = style.save_figure(self.figure(), tmp_path / "map.png")
        assert [path.name for path in only] == ["map.png"]
        paths = style.save_figure(self.figure(), tmp_path / "map.png", formats=("png", "pdf"))
        assert [path.name for path in paths] == ["map.png", "map.pdf"]
        height, width, _ = imread(paths[0]).shape
        assert (width, height) == (1003, 590)  # 85 x 50 mm at 300 dots an inch
        media = re.search(rb"/MediaBox \[\s*0 0 ([\d.]+) ([\d.]+)", paths[1].read_bytes())
        assert media is not None
        assert float(media[1]) == pytest.approx(72 * 0.085 / 0.0254)

    def test_a_dataset_goes_to_netcdf(self, tmp_path: Path) -> None:
        data = strain_energies(synthetic_result(records=9))
        *_, beside = style.save_figure(self.figure(), tmp_path / "energy.png", data)
        with xr.open_dataset(beside, engine="h5netcdf") as saved:
            xr.testing.assert_identical(saved.load(), data)


def headed(title: str, *words: str) -> tuple[Figure, list[str]]:
    figure = new_figure(height=0.06)
    figure.add_subplot()
    result = synthetic_result(records=2, speed=78.75).assign_attrs(title=title)
    head(figure, shaft_orbit(result), *words)
    return figure, figure.get_suptitle().split("\n")


def test_speed_label() -> None:
    assert speed_label(synthetic_result(records=2, speed=78.75)) == "Ω/ω₁ = 1.05 (752 rpm)"


def test_the_name_comes_first_and_the_speed_next() -> None:
    _, lines = headed("Fan stage", "1 to", "2 s")
    assert lines == ["Fan stage", "Ω/ω₁ = 1.05 (752 rpm), 1 to, 2 s"]
    figure, lines = headed("", "words that are too long for a line with the speed of a figure")
    assert lines[0].startswith("Ω/ω₁ = 1.05 (752 rpm), words")
    assert lines[1].endswith("speed of a figure")
    assert figure.get_figheight() > headed("")[0].get_figheight()


@pytest.mark.parametrize(
    "title", ["long " * 80, "$\\frac{$ _x^ $", "<b>&amp;\n\t@PLACES@", "風扇 \u202e\x07 🌀" * 3]
)
def test_no_name_breaks_a_figure(title: str) -> None:
    assert_legible(headed(title)[0])

"""Titles of figures: the case's name, whatever it is, and the speed."""

import pytest
from legible import assert_legible
from matplotlib.figure import Figure
from synthetic_result import synthetic_result

from bladewhirl.postprocess.plotting.style import new_figure
from bladewhirl.postprocess.plotting.titles import head, speed_label
from bladewhirl.postprocess.shaft.orbits import shaft_orbit


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
    _, (line,) = headed("", "words that are too long for a line with the speed of a figure")
    assert line.startswith("Ω/ω₁ = 1.05 (752 rpm), words")
    assert line.endswith(" …")


@pytest.mark.parametrize(
    "title", ["long " * 80, "$\\frac{$ _x^ $", "<b>&amp;\n\t@PLACES@", "風扇 \u202e\x07 🌀" * 3]
)
def test_no_name_breaks_a_figure(title: str) -> None:
    assert_legible(headed(title)[0])

"""Figures as readers see them."""

from itertools import combinations

from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

EDGE = 1.0  # pixel
PRINTED = 300  # dots an inch, of files


def overlap(one: Bbox, other: Bbox) -> bool:
    """Return whether boxes share more than an edge."""
    common = Bbox.intersection(one, other)
    return common is not None and min(common.width, common.height) > 2 * EDGE


def seen_texts(figure: Figure) -> list[tuple[str, Bbox]]:
    """Return the texts of a drawn figure with their boxes, without labels of ticks outside axes."""
    outside = set()
    every = [each for axes in figure.axes for each in (axes, *axes.child_axes)]
    for axis in (axis for axes in every for axis in axes._axis_map.values()):
        low, high = sorted(axis.get_view_interval())
        slack = 1e-9 * (high - low)
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            if not low - slack <= tick.get_loc() <= high + slack or not axis.axes.axison:
                outside |= {id(tick.label1), id(tick.label2)}
    found = []
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        box = Text.get_window_extent(text)  # without the leader of a label
        shown = text.get_visible() and text.get_text().strip() and id(text) not in outside
        if shown and min(box.width, box.height) > EDGE:
            found.append((text.get_text(), box))
    return found


def faults_of_texts(figure: Figure) -> list[str]:
    """Return texts of a drawn figure that leave the canvas or lie on one another, and legends
    without lines and patches."""
    texts, (width, height) = seen_texts(figure), figure.bbox.size
    faults = [
        f"cut: {text!r}"
        for text, box in texts
        if min(box.x0, box.y0) < -EDGE or box.x1 > width + EDGE or box.y1 > height + EDGE
    ]
    for (text, box), (other, beside) in combinations(texts, 2):
        if overlap(box, beside):
            faults.append(f"on one another: {text!r} and {other!r}")
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes)]
    return faults + ["empty legend" for one in legends if one and not one.legend_handles]


def assert_legible(figure: Figure, *, least: float = 6.5) -> None:
    """Assert that all parts of a figure are on its canvas, that legends and panels with their
    labels lie apart, and that no letters are smaller than `least` [pt]."""
    figure.set_dpi(PRINTED)
    figure.draw_without_rendering()
    faults = faults_of_texts(figure)
    assert not faults, faults
    texts = [text for text in figure.findobj(Text) if isinstance(text, Text) and text.get_text()]
    assert min(float(text.get_fontsize()) for text in texts if text.get_visible()) >= least
    parts = {f"legend {n}": part.get_window_extent() for n, part in enumerate(figure.legends)}
    for number, axes in enumerate(figure.axes):
        box = axes.get_tightbbox()
        assert isinstance(box, Bbox)
        parts[f"panel {number}"] = box
    together = {
        (a, b) for (a, one), (b, other) in combinations(parts.items(), 2) if overlap(one, other)
    }
    assert not together, together
    parts |= {text.get_text(): text.get_window_extent() for text in figure.texts}
    width, height = figure.bbox.size
    strays = [
        part
        for part, box in parts.items()
        if min(box.x0, box.y0) < -EDGE or box.x1 > width + EDGE or box.y1 > height + EDGE
    ]
    assert not strays, strays

"""Figures as readers see them."""

from itertools import combinations

from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

EDGE = 1.0  # pixel


def overlap(one: Bbox, other: Bbox) -> bool:
    """Return whether boxes share more than an edge."""
    common = Bbox.intersection(one, other)
    return common is not None and min(common.width, common.height) > 2 * EDGE


def assert_legible(figure: Figure, *, least: float = 6.5) -> None:
    """Assert that all parts of a figure are on its canvas, that legends and panels with their
    labels lie apart, and that no letters are smaller than `least` [pt]."""
    figure.draw_without_rendering()
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
    assert together == set()
    parts |= {text.get_text(): text.get_window_extent() for text in figure.texts}
    width, height = figure.bbox.size
    strays = [
        part
        for part, box in parts.items()
        if min(box.x0, box.y0) < -EDGE or box.x1 > width + EDGE or box.y1 > height + EDGE
    ]
    assert strays == []

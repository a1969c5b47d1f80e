"""Axes of speed and frequency, the same in all figures, and names beside what is drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray, IntArray

SPEED = "speed Ω / ω₁ [–]"
FREQUENCY = "frequency / ω₁ [–]"

LETTER, LINE = 3.8, 9.0
"""Room of a name's letter and of its line [points]."""

POINT = 4.0
"""Half the room that is kept free about a point [points]."""

NUMBER = 3
"""Letters up to which a name beside a point hides nothing behind it."""

SHARE, LABELS = 0.8, 1.1
"""Share of a figure's height that axes have, and what their labels take of its width [inch], at
about."""


def speed_axis(axes: Axes, reference_hz: float) -> None:
    """Label an x axis of normalised speeds, with a second one in rpm on top.

    Args:
        axes: whose x values are multiples of the reference frequency.
        reference_hz: that frequency [Hz].
    """
    axes.set_xlabel(SPEED)
    rpm_axis(axes, reference_hz)


def rpm_axis(axes: Axes, reference_hz: float) -> None:
    """Put an axis in rpm on top of one of normalised speeds; see `speed_axis`."""
    second = axes.secondary_xaxis("top", functions=_multiples(60.0 * reference_hz))
    second.set_xlabel("speed [rpm]")


def frequency_axis(axes: Axes, reference_hz: float, label: str = FREQUENCY) -> None:
    """Label a y axis of normalised frequencies, with a second one in Hz on the right.

    Args:
        axes: whose y values are multiples of the reference frequency.
        reference_hz: that frequency [Hz].
        label: of the first.
    """
    axes.set_ylabel(label)
    second = axes.secondary_yaxis("right", functions=_multiples(reference_hz))
    second.set_ylabel("frequency [Hz]")


Scaling = Callable[[ArrayLike], FloatArray]


def _multiples(unit: float) -> tuple[Scaling, Scaling]:
    """From multiples to an amount, and back."""
    return lambda x: np.asarray(x) * unit, lambda x: np.asarray(x) / unit


INSET = 0.012
"""Least distance of a name on a line from the frame, as a share of the axes."""


CLOSE = 0.005
"""Between points of a line that no name may cover, as a share of the axes."""


class Names:
    """Names beside lines and points of axes, where no other name stands."""

    def __init__(self, axes: Axes) -> None:
        """Prepare for axes whose limits and scales are set."""
        box = axes.figure.bbox
        width, height = box.width / axes.figure.dpi, box.height / axes.figure.dpi
        spec = axes.get_subplotspec()
        rows, columns = (1, 1) if spec is None else spec.get_gridspec().get_geometry()
        self._axes = axes
        self._points = 72.0 * np.array([width / columns - LABELS, SHARE * height / rows])
        self._taken: list[tuple[FloatArray, FloatArray]] = []
        self._kept: list[FloatArray] = []

    def keep_free(self, x: FloatArray, y: FloatArray) -> None:
        """Let no name cover these points."""
        room = np.full(2, 2.0 * POINT) / self._points
        self._kept += [*self._shares(x, y)]
        self._taken += [(place - room / 2.0, room) for place in self._shares(x, y)]

    def along(
        self, x: FloatArray, y: FloatArray, text: str, colour: str, *, aside: float = 0.0
    ) -> bool:
        """Name a line where it has room, rather at its end; False where it has none.

        Args:
            x: of its points, with `y`.
            y: of its points.
            text: the name.
            colour: of the name.
            aside: how far to the right of the line, in halves of the name's width; 0 is on it.
        """
        places = self._shares(x, y)
        places = places[np.all((places > 0.0) & (places < 1.0), axis=1)][::-1]
        size = self._size(text)
        for place in places[:: max(1, len(places) // 60)]:
            middle = place + np.array([0.5 * aside * size[0], 0.0])
            corner = np.clip(middle - size / 2.0, INSET, 1.0 - INSET - size)
            if aside and abs(corner[0] + size[0] / 2.0 - middle[0]) > 0.1 * size[0]:
                continue  # the frame would push it over the line
            near = np.abs(places - corner - size / 2.0) < size * np.array([0.5 + abs(aside), 0.5])
            if np.all(near, axis=1).any() and self._take(corner, size):
                self._write(corner + size / 2.0, text, colour, ground=True)
                return True
        return False

    def over(self, x: FloatArray, y: FloatArray, text: str, colour: str) -> bool:
        """Name a line over or under it, where no line is covered; else as `along`, on it.

        All lines of the axes must have been drawn.

        Args:
            x: of its points, with `y`.
            y: of its points.
            text: the name.
            colour: of the name.
        """
        places = self._shares(x, y)
        places = places[np.all((places > 0.0) & (places < 1.0), axis=1)][::-1]
        drawn, size = self._drawn(), self._size(text)
        away = 0.4 * POINT / self._points[1]
        for place in places[:: max(1, len(places) // 60)]:
            left = np.clip(place[0] - size[0] / 2.0, INSET, 1.0 - INSET - size[0])
            near = places[np.abs(places[:, 0] - left - size[0] / 2.0) < size[0] / 2.0 + INSET, 1]
            for bottom in (near.max() + away, near.min() - away - size[1]):
                corner = np.array([left, bottom])
                covered = np.all((drawn > corner) & (drawn < corner + size), axis=1).any()
                inside = 0.0 <= bottom <= 1.0 - size[1]
                if inside and not covered and self._take(corner, size):
                    self._write(corner + size / 2.0, text, colour, ground=False)
                    return True
        return self.along(x, y, text, colour)

    def _drawn(self) -> FloatArray:
        """Points along all lines of the axes, closely, as shares of these."""
        to_shares = self._axes.transAxes.inverted().transform
        found = []
        for each in self._axes.get_children():
            if isinstance(each, Line2D) and each.get_linestyle() != "None":
                paths = [np.asarray(each.get_xydata())]
            elif isinstance(each, LineCollection):
                paths = each.get_segments()
            else:
                continue
            ends = [path[:-1] for path in paths], [path[1:] for path in paths]
            first, last = (
                np.clip(to_shares(each.get_transform().transform(np.concatenate(end))), -1.0, 2.0)
                for end in ends
            )
            between = np.linspace(
                0.0, 1.0, 2 + int(np.nan_to_num(np.abs(last - first)).max(initial=0.0) / CLOSE)
            )
            found.append((first + between[:, None, None] * (last - first)).reshape(-1, 2))
        return np.concatenate([np.empty((0, 2)), *found])

    def beside(self, x: float, y: float, text: str, colour: str) -> bool:
        """Name a point above, below, or to a side of it; False where there is no room.

        Places that are nearer to another point that `keep_free` knows come last, and before them
        those that cover a line.
        """
        (place,) = self._shares(np.array([x]), np.array([y]))
        size = self._size(text)
        corners = [*self._corners(place, size)]
        if len(text) > NUMBER:  # above a point a word reads better than before it
            corners[:2] = corners[1::-1]
        drawn = self._drawn()

        def faults(corner: FloatArray) -> tuple[bool, bool]:
            covers = np.all((drawn > corner) & (drawn < corner + size), axis=1).any()
            return self._nearer_to_another(corner + size / 2.0, place), bool(covers)

        corners.sort(key=faults)
        for corner in corners:
            inside = np.all((corner >= 0.0) & (corner + size <= 1.0))
            if inside and self._take(corner, size):
                self._write(corner + size / 2.0, text, colour, ground=len(text) > NUMBER)
                return True
        return False

    def one_place(self, x: FloatArray, y: FloatArray) -> Iterator[IntArray]:
        """Points whose marks cover each other, by number: they are named at once."""
        places = self._shares(x, y) * self._points
        left = np.arange(len(places))
        while len(left):
            near = np.hypot(*(places[left] - places[left[0]]).T) < 0.7 * POINT
            yield left[near]
            left = left[~near]

    def behind(self, x: float, y: float, text: str, colour: str, *, left: bool = False) -> None:
        """Name the end of a line on its right or left, above the names that stand there.

        A thin line leads to a name that had to give way.
        """
        (place,) = self._shares(np.array([x]), np.array([y]))
        size = self._size(text) * np.array([1.0, 0.75 if text.isupper() else 0.9])
        away = np.array([POINT / self._points[0], 0.0]) * (-1.0 if left else 1.0)
        inner = np.array([size[0] if left else 0.0, 0.5 * size[1]])  # of the name, beside the line
        start = corner = place + 2.0 * away - inner
        while not self._take(corner, size):
            corner = corner + np.array([0.0, 0.1 * size[1]])
        if corner[1] > start[1] + 0.2 * size[1]:
            ends = np.stack([place + 0.7 * away, corner + inner])
            self._axes.plot(*ends.T, color=colour, linewidth=0.4, transform=self._axes.transAxes)
        self._write(corner + size / 2.0, text, colour, ground=True)

    def _nearer_to_another(self, middle: FloatArray, place: FloatArray) -> bool:
        """Whether a name would be taken for that of another point."""
        own = np.hypot(*((middle - place) * self._points))
        others = np.array(self._kept).reshape(-1, 2)
        return bool((np.hypot(*((middle - others) * self._points).T) < 0.95 * own).any())

    def _corners(self, place: FloatArray, size: FloatArray) -> Iterator[FloatArray]:
        """Lower left corners of a name about a point: above, below, to its sides."""
        away = POINT / self._points
        low, middle, high = place - size - away, place - size / 2.0, place + away
        for x, y in (
            (low[0], high[1]),
            (middle[0], high[1]),
            (high[0], low[1]),
            (middle[0], low[1]),
            (high[0], high[1]),
            (low[0], low[1]),
            (high[0], middle[1]),
            (low[0], middle[1]),
        ):
            yield np.array([x, y])

    def _shares(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Points as shares of the axes, (points, 2)."""
        with np.errstate(invalid="ignore"):
            shown = self._axes.transData.transform(np.column_stack([x, y]))
        return np.asarray(self._axes.transAxes.inverted().transform(shown))

    def _size(self, text: str) -> FloatArray:
        bare = text.replace("$", "").replace("_", "")
        return np.array([LETTER * len(bare) + 2.0, LINE]) / self._points

    def _take(self, corner: FloatArray, size: FloatArray) -> bool:
        """Whether a box is free, which then is taken."""
        free = not any(
            np.all((corner < other + extent) & (other < corner + size))
            for other, extent in self._taken
        )
        if free:
            self._taken.append((corner, size))
        return free

    def _write(self, middle: FloatArray, text: str, colour: str, *, ground: bool) -> None:
        box = {"boxstyle": "square,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.9}
        self._axes.text(
            float(middle[0]),
            float(middle[1]),
            text,
            transform=self._axes.transAxes,
            ha="center",
            va="center",
            color=colour,
            fontsize=6.5,
            zorder=7,
            bbox=box if ground else None,
        )

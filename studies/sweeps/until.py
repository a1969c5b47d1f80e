"""Random draws of a sweep that stop, point by point, when no more of them are needed.

A rule looks at the draws of a point in their order, whatever the order in which they were marched:
a draw is needed if the draws before it do not settle the outcome of the point. The dataset
therefore does not depend on the number of workers.
"""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from bladewhirl.postprocess.sweep.dataset import DONE
from bladewhirl.postprocess.sweep.shares import settled, wilson
from bladewhirl.solvers.march.schema import BEAMS
from bladewhirl.studies.sweeps.points import Failure, Outcome

UNKNOWN, FAILED = -1, -2  #: codes of random draws without a regime

REGIMES = np.arange(1, len(BEAMS.sweep["regime"].labels))
"""Codes of the regimes; zero means that there is no regime yet."""


Rule = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.bool_]]
"""Function that returns true for each n for which the first n draws of a point are enough,
(draws,). Its arguments are the number of draws of each regime among the first n draws, (draws,
regimes), and n, (draws,). Failed draws have no regime."""


def narrower(width: float) -> Rule:
    """Return the rule of `--until`, see `shares.settled`."""
    return lambda hits, drawn: settled(*wilson(hits, hits.sum(axis=-1, keepdims=True)), width)


def never(hits: NDArray[np.float64], drawn: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return false for each number of draws."""
    return np.zeros(drawn.shape, dtype=np.bool_)


def differing(hits: NDArray[np.float64], drawn: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return true for each number of draws among which two differ or one failed."""
    return np.asarray(hits.max(axis=1) < drawn)


class Judge:
    """Decision which random draws of each point are needed.

    Args:
        count: number of draws of each point, if all are needed.
        enough: rule by which the outcome of a point is known; its other draws are left out.
        state: state of every draw as written, (points * count,).
        regime: code of the regime of every draw as written, (points * count,).
        halt: rule by which a point is put off: its other draws are neither marched nor left out.
        chosen: true for each point whose draws are marched, (points,); all points when None.
    """

    def __init__(
        self,
        count: int,
        enough: Rule,
        state: NDArray[np.int8],
        regime: NDArray[np.int8],
        halt: Rule = never,
        chosen: NDArray[np.bool_] | None = None,
    ) -> None:
        self._count, self._enough, self._halt = count, enough, halt
        self._regime = np.where(state == DONE, regime, UNKNOWN).reshape(-1, count)
        all_points = np.ones(len(self._regime), dtype=np.bool_)
        self._points = np.flatnonzero(all_points if chosen is None else chosen).tolist()
        self._arrived: dict[int, Outcome] = {}  # outcomes that are not written yet

    def next_draws(self) -> Iterator[int]:
        """Yield the numbers of draws to march: the first draw of every point, then the second draw
        of every point, and so on. Whether a draw is needed is decided when it is requested, from
        the outcomes that have arrived."""
        for draw in range(self._count):
            for point in self._points:
                row = self._regime[point]
                if row[draw] == UNKNOWN and draw < self._needed(row)[1]:
                    yield point * self._count + draw

    def take(self, number: int, outcome: Outcome) -> Iterator[tuple[int, Outcome | None]]:
        """Take the outcome of a draw; yield the outcomes of its point that can be written, with
        their numbers. An outcome can be written as soon as the outcomes of all draws before it are
        known. None means that a draw is left out."""
        point, draw = divmod(number, self._count)
        code = FAILED if isinstance(outcome, Failure) else int(outcome["regime"])
        self._regime[point, draw] = code
        self._arrived[number] = outcome
        yield from self._decided(point)

    def all_decided(self) -> Iterator[tuple[int, Outcome | None]]:
        """Yield the outcomes of all points that can be written, see `take`."""
        for point in self._points:
            yield from self._decided(point)

    def _decided(self, point: int) -> Iterator[tuple[int, Outcome | None]]:
        """Yield number and outcome of every draw of a point whose outcome can be written; None if
        the draw is left out. See `take`."""
        first, row = point * self._count, self._regime[point]
        known, needed, put_off = self._needed(row)
        for draw in range(min(known, needed)):
            if first + draw in self._arrived:
                yield first + draw, self._arrived.pop(first + draw)
        for draw in range(needed, self._count) if needed <= known and not put_off else ():
            if row[draw] == UNKNOWN or self._arrived.pop(first + draw, None) is not None:
                yield first + draw, None

    def _needed(self, row: NDArray[np.int8]) -> tuple[int, int, bool]:
        """Return the number of draws before the first one without an outcome, the number of draws
        that are needed according to these draws, and whether the point is put off."""
        unknown = np.flatnonzero(row == UNKNOWN)
        known = int(unknown[0]) if unknown.size else len(row)
        hits = np.cumsum(row[:known, None] == REGIMES, axis=0).astype(np.float64)
        drawn = np.arange(1.0, known + 1.0)
        ends = [
            int(np.argmax(rule)) if (rule := each(hits, drawn)).any() else len(row)
            for each in (self._halt, self._enough)
        ]
        return known, min(*ends, len(row) - 1) + 1, ends[0] <= min(ends[1], len(row) - 1)

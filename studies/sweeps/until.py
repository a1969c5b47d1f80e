"""Draws of a sweep that stop, point by point, when the shares of the regimes are known.

The rule looks at the draws of a point in their order, whatever the order in which they were
marched: a draw is needed if the draws before it do not settle the outcome, see `shares.settled`.
The dataset therefore does not depend on the number of workers.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from bladewhirl.postprocess.sweep.dataset import DONE
from bladewhirl.postprocess.sweep.shares import settled, wilson
from bladewhirl.solvers.march.schema import SWEEP
from bladewhirl.studies.sweeps.points import Failure, Outcome

UNKNOWN, FAILED = -1, -2  #: codes of draws without a regime

REGIMES = np.arange(1, len(SWEEP["regime"].labels))
"""Codes of the regimes; zero means that there is no regime yet."""


class Judge:
    """Decision which draws of each point are needed.

    Args:
        count: number of draws of each point, if all are needed.
        until: width of the intervals, see `shares.settled`.
        state: state of every draw as written, (points * count,).
        regime: code of the regime of every draw as written, (points * count,).
    """

    def __init__(
        self, count: int, until: float, state: NDArray[np.int8], regime: NDArray[np.int8]
    ) -> None:
        self._count, self._until = count, until
        self._regime = np.where(state == DONE, regime, UNKNOWN).reshape(-1, count)
        self._arrived: dict[int, Outcome] = {}  # outcomes that are not written yet

    def wanted(self) -> Iterator[int]:
        """Yield the numbers of draws to march: the first draw of every point, then the second draw
        of every point, and so on. Whether a draw is needed is decided when it is requested, from
        the outcomes that have arrived."""
        for draw in range(self._count):
            for point, row in enumerate(self._regime):
                if row[draw] == UNKNOWN and draw < self._needed(row)[1]:
                    yield point * self._count + draw

    def take(self, number: int, outcome: Outcome) -> Iterator[tuple[int, Outcome | None]]:
        """Take the outcome of a draw; yield the outcomes of its point that can be written, with
        their numbers. An outcome can be written as soon as the outcomes of all draws before it are
        known. None means that a draw is not needed."""
        point, draw = divmod(number, self._count)
        code = FAILED if isinstance(outcome, Failure) else int(outcome["regime"])
        self._regime[point, draw] = code
        self._arrived[number] = outcome
        yield from self.decided(point)

    def decided(self, point: int) -> Iterator[tuple[int, Outcome | None]]:
        """Yield the outcomes of a point that can be written, see `take`."""
        first, row = point * self._count, self._regime[point]
        known, needed = self._needed(row)
        for draw in range(min(known, needed)):
            if first + draw in self._arrived:
                yield first + draw, self._arrived.pop(first + draw)
        for draw in range(needed, self._count) if needed <= known else ():
            if row[draw] == UNKNOWN or self._arrived.pop(first + draw, None) is not None:
                yield first + draw, None

    def _needed(self, row: NDArray[np.int8]) -> tuple[int, int]:
        """Return the number of draws before the first one without an outcome, and the number of
        draws that are needed according to these draws."""
        unknown = np.flatnonzero(row == UNKNOWN)
        known = int(unknown[0]) if unknown.size else len(row)
        hits = np.cumsum(row[:known, None] == REGIMES, axis=0).astype(np.float64)
        enough = settled(*wilson(hits, hits.sum(axis=1, keepdims=True)), self._until)
        return known, int(np.argmax(enough)) + 1 if enough.any() else len(row)

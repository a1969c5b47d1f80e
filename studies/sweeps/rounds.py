"""Order in which the points of a sweep are marched, and random draws that need not be marched.

Screening marches are first. Random draws stop, point by point, when no more of them are needed. A
rule looks at the draws of a point in their order, whatever the order in which they were marched: a
draw is needed if the draws before it do not settle the outcome of the point. The dataset therefore
does not depend on the number of workers.
"""

from collections.abc import Callable, Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from bladewhirl.postprocess.sweep.dataset import DONE, MISSING, NOT_NEEDED
from bladewhirl.postprocess.sweep.shares import settled, wilson
from bladewhirl.solvers.march.schema import SWEEP
from bladewhirl.studies.sweeps.carried import Carry, Chains
from bladewhirl.studies.sweeps.plan import SweepPlan
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point
from bladewhirl.studies.sweeps.starts import SPEED
from bladewhirl.studies.sweeps.store import Store

March = Callable[[Iterable[Point | None]], Iterator[tuple[int, Outcome]]]
"""Function that marches points and yields number and outcome of each."""

Mask = NDArray[np.bool_]

UNKNOWN, FAILED = -1, -2  #: codes of random draws without a regime

REGIMES = np.arange(1, len(SWEEP["regime"].labels))
"""Codes of the regimes; zero means that there is no regime yet."""

Rule = Callable[[NDArray[np.float64], NDArray[np.float64]], Mask]
"""Function that returns true for each n for which the first n draws of a point are enough,
(draws,). Its arguments are the number of draws of each regime among the first n draws, (draws,
regimes), and n, (draws,). Failed draws have no regime."""


def narrower(width: float) -> Rule:
    """Return the rule of `--until`, see `shares.settled`."""
    return lambda hits, drawn: settled(*wilson(hits, hits.sum(axis=-1, keepdims=True)), width)


def never(hits: NDArray[np.float64], drawn: NDArray[np.float64]) -> Mask:
    """Return false for each number of draws."""
    return np.zeros(drawn.shape, dtype=np.bool_)


def differing(hits: NDArray[np.float64], drawn: NDArray[np.float64]) -> Mask:
    """Return true for each number of draws among which two differ or one failed."""
    return np.asarray(hits.max(axis=1) < drawn)


class Judge:
    """Decides which random draws of each point are needed.

    Args:
        count: number of draws of each point, if all are needed.
        enough: rule for the number of draws from which the outcome of a point is known; the other
            draws of the point are left out.
        known: true for every draw whose regime is known, (points * count,).
        regime: code of the regime of every draw as written, (points * count,).
        halt: rule for the number of draws after which a point is put off; the other draws of the
            point are neither marched nor left out.
        chosen: true for each point whose draws are marched, (points,); all points when None.
    """

    def __init__(
        self,
        count: int,
        enough: Rule,
        known: Mask,
        regime: NDArray[np.int8],
        halt: Rule = never,
        chosen: Mask | None = None,
    ) -> None:
        self._count, self._enough, self._halt = count, enough, halt
        self._regime = np.where(known, regime, UNKNOWN).reshape(-1, count)
        every = np.arange(len(self._regime))
        self._points = (every if chosen is None else np.flatnonzero(chosen)).tolist()
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


class Rounds:
    """The unfinished points of a sweep, marched in one round, or in two if points are screened.

    What is marched depends only on the dataset as written, so that an interrupted sweep continues
    where it stopped.

    Args:
        plan: plan of the sweep.
        store: dataset of the sweep.
        march: function that marches points.
    """

    def __init__(self, plan: SweepPlan, store: Store, march: March) -> None:
        self._plan, self._store, self._march = plan, store, march
        draws = plan.grid.draws
        judged = draws is not None and (plan.screen or draws.until is not None)
        #: number of draws of a point that are judged together; 1 if all draws are needed
        self._draws = draws.count if draws is not None and judged else 1
        self.screening = False  #: whether the current round consists of screening marches
        self.waiting = 0  #: number of finished screening marches that are still to be repeated

    def outcomes(self) -> Iterator[tuple[int, Outcome | None]]:
        """March the unfinished points; yield number and outcome of each, None for a draw that is
        left out."""
        if self._plan.carry is not None:
            yield from self._chained(self._plan.carry)
            return
        # Both rounds are in one call of `march`, so that workers are started once.
        rounds, flying = self._rounds(), 0
        judge = next(rounds)
        yield from self._counted(judge.all_decided())

        def points() -> Iterator[Point | None]:
            nonlocal judge, flying
            following: Judge | None = judge
            while following is not None:
                judge = following
                for number in judge.next_draws():
                    flying += 1
                    yield self._plan.point(number, screen=self.screening)
                while flying and self.screening:
                    yield None  # the next round depends on the outcomes of all draws
                following = next(rounds, None)

        for number, outcome in self._march(points()):
            flying -= 1
            yield from self._counted(judge.take(number, outcome))
        yield from self._counted(judge.all_decided())

    def _rounds(self) -> Iterator[Judge]:
        """Yield the judge of each round; the next one must be requested when all outcomes of the
        one before are written."""
        store, draws = self._store, self._plan.grid.draws
        rule = never if draws is None or draws.until is None else narrower(draws.until)
        self.screening = self._plan.screen
        done = store.state == DONE
        if not self.screening:
            yield Judge(self._draws, rule, done, store.regime)
            return
        yield Judge(self._draws, rule, done, store.regime, differing, ~self._repeated())
        self.screening, again, done = False, self._uncertain(), store.state == DONE
        known = done & ~(store.screened & np.repeat(again, self._draws))
        self.waiting = int(np.count_nonzero(done & ~known))
        yield Judge(self._draws, rule, known, store.regime, chosen=again)

    def _chained(self, carry: Carry) -> Iterator[tuple[int, Outcome]]:
        """March points one after the other along the speed; yield number and outcome of each."""
        plan, grid = self._plan, self._plan.grid
        chains = Chains(
            grid.shape,
            [axis.key for axis in grid.axes].index(SPEED),
            plan.coordinates[SPEED][0],
            carry,
            self._store.state,
            self._store.end_reason,
        )
        points = (
            each and plan.point(each[0], before=each[1])  # None if no point can be marched yet
            for each in chains.next_points()
        )
        for number, outcome in self._march(points):
            end = None if isinstance(outcome, Failure) else int(outcome["end_reason"])
            chains.take(number, end)
            yield number, outcome

    def _counted(
        self, outcomes: Iterable[tuple[int, Outcome | None]]
    ) -> Iterator[tuple[int, Outcome | None]]:
        """Yield outcomes, and update the number `waiting`."""
        for number, outcome in outcomes:
            self.waiting -= int(self.waiting > 0 and self._store.state[number] == DONE)
            yield number, outcome

    def _repeated(self) -> Mask:
        """Return true for each point with a draw that was marched without scaled masses, (points,);
        the draws of such a point were uncertain."""
        finished = ~np.isin(self._store.state, (MISSING, NOT_NEEDED))
        return np.asarray((finished & ~self._store.screened).reshape(-1, self._draws).any(axis=1))

    def _uncertain(self) -> Mask:
        """Return true for each point that must be marched with the time step of the case: a draw
        failed, draws differ, or the interval of a share includes one half, (points,)."""
        shape = (-1, self._draws)
        done = (self._store.state == DONE).reshape(shape)
        needed = (self._store.state != NOT_NEEDED).reshape(shape)
        of_regime = (self._store.regime.reshape(shape)[..., None] == REGIMES) & done[..., None]
        hits, total = of_regime.sum(axis=1), done.sum(axis=1)
        known = settled(*wilson(hits.astype(np.float64), total[:, None].astype(np.float64)))
        agree = (hits == total[:, None]).any(axis=1)
        whole = (done | ~needed).all(axis=1)
        return np.asarray(self._repeated() | ~(whole & agree & known))

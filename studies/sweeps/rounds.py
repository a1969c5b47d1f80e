"""Order in which the points of a sweep are marched: screening marches first, then the others."""

from collections.abc import Callable, Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from bladewhirl.postprocess.sweep.dataset import DONE, MISSING, NOT_NEEDED
from bladewhirl.postprocess.sweep.shares import settled, wilson
from bladewhirl.studies.sweeps.carried import SPEED, Carry, Chains
from bladewhirl.studies.sweeps.plan import Plan
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point
from bladewhirl.studies.sweeps.store import Store
from bladewhirl.studies.sweeps.until import (
    REGIMES,
    Judge,
    Rule,
    differing,
    narrower,
    never,
)

March = Callable[[Iterable[Point | None]], Iterator[tuple[int, Outcome]]]
"""Function that marches points and yields number and outcome of each."""

Mask = NDArray[np.bool_]


class Rounds:
    """The unfinished points of a sweep, marched in one round, or in two if points are screened.

    What is marched depends only on the dataset as written, so that an interrupted sweep continues
    where it stopped.

    Args:
        plan: plan of the sweep.
        store: dataset of the sweep.
        march: function that marches points.
    """

    def __init__(self, plan: Plan, store: Store, march: March) -> None:
        self._plan, self._store, self._march = plan, store, march
        self._draws = 1 if plan.grid.draws is None else plan.grid.draws.count
        self.screening = False  #: whether the current round consists of screening marches
        self.waiting = 0  #: number of finished screening marches that are still to be repeated

    def outcomes(self) -> Iterator[tuple[int, Outcome | None]]:
        """March the unfinished points; yield number and outcome of each, None for a draw that is
        left out."""
        plan, draws = self._plan, self._plan.grid.draws
        if plan.carry is not None:
            yield from self._chained(plan.carry)
        elif plan.screen or (draws is not None and draws.until is not None):
            yield from self._judged()
        else:
            yield from self._march(plan.point(n) for n in self._unfinished())

    def _judged(self) -> Iterator[tuple[int, Outcome | None]]:
        """March the draws that are needed, in one or two rounds; yield number and outcome of each.

        Both rounds are in one call of `march`, so that workers are started once.
        """
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
            yield self._judge(done, np.ones(self._points, dtype=np.bool_), rule)
            return
        yield self._judge(done, ~self._repeated(), rule, differing)
        self.screening, again, done = False, self._uncertain(), store.state == DONE
        known = done & ~(store.screened & np.repeat(again, self._draws))
        self.waiting = int(np.count_nonzero(done & ~known))
        yield self._judge(known, again, rule)

    def _judge(self, known: Mask, chosen: Mask, enough: Rule, halt: Rule = never) -> Judge:
        """Return the judge of the chosen points (points,) with the known draws (draws,)."""
        state = np.where(known, DONE, MISSING).astype(np.int8)
        return Judge(self._draws, enough, state, self._store.regime, halt, chosen)

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
        """Yield outcomes, and keep account of `waiting`."""
        for number, outcome in outcomes:
            self.waiting -= int(self.waiting > 0 and self._store.state[number] == DONE)
            yield number, outcome

    @property
    def _points(self) -> int:
        return int(self._store.state.size) // self._draws

    def _unfinished(self) -> Iterator[int]:
        return map(int, np.flatnonzero(self._store.state != DONE))

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

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
    unalterable,
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
        if self._plan.carry is not None:
            yield from self._chained(self._plan.carry)
            return
        done, draws = self._store.state == DONE, self._plan.grid.draws
        rule = never if draws is None or draws.until is None else narrower(draws.until)
        if not self._plan.screen:
            yield from self._round(done, np.ones(self._points, dtype=np.bool_), rule)
            return
        self.screening = True
        yield from self._round(done, ~self._repeated(), rule, differing)
        self.screening = False
        again = self._uncertain()
        known = (self._store.state == DONE) & ~(self._store.screened & self._of_draws(again))
        self.waiting = int(np.count_nonzero((self._store.state == DONE) & ~known))
        yield from self._round(known, again, unalterable(self._draws) if rule is never else rule)

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
            for each in chains.wanted()
        )
        for number, outcome in self._march(points):
            end = None if isinstance(outcome, Failure) else int(outcome["end_reason"])
            chains.take(number, end)
            yield number, outcome

    def _round(
        self, known: Mask, chosen: Mask, enough: Rule, halt: Rule = never
    ) -> Iterator[tuple[int, Outcome | None]]:
        """March the draws that are not known (draws,) of the chosen points (points,), as far as
        the rules require."""
        if enough is halt is never:
            yield from self._counted(self._marched(np.flatnonzero(~known & self._of_draws(chosen))))
            return
        state = np.where(known, DONE, MISSING).astype(np.int8)
        judge = Judge(self._draws, enough, state, self._store.regime, halt)
        for point in np.flatnonzero(chosen):
            yield from self._counted(judge.decided(int(point)))
        wanted = (number for number in judge.wanted() if chosen[number // self._draws])
        for number, outcome in self._marched(wanted):
            yield from self._counted(judge.take(number, outcome))

    def _marched(self, numbers: Iterable[int]) -> Iterator[tuple[int, Outcome]]:
        plan, screen = self._plan, self.screening
        yield from self._march(plan.point(int(number), screen=screen) for number in numbers)

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

    def _of_draws(self, points: Mask) -> Mask:
        return np.repeat(points, self._draws)

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

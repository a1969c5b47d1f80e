"""A small sweep, and stand-ins for its work in a module that workers can import."""

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from bladewhirl.models.case.file import loads
from bladewhirl.models.stage.stage import Stage
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.sweeps import sweep
from bladewhirl.studies.sweeps.carried import continued, late_state
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point, Work, march_point
from bladewhirl.studies.sweeps.workers import ready

CASE = loads("""
bladed_disk = { blades = 8, elements_per_blade = 2 }
casing.elements = 16
reduction.fixed_interface_modes = 16
excitation = { type = "imbalance", ramp = 1e-3 }
march = { duration = 6e-3, record_step = 5e-5 }
""")
OVER = {"march.speed": [0.95, 1.05, 1.15], "contact.friction": [0.05, 0.1]}


class Killed(Exception):
    """End of a process."""


class InProcess:
    """Stand-in for workers: points are marched in this process, in lots and in reverse order, until
    no march is `left`; then the process dies."""

    def __init__(self) -> None:
        self.left, self.calls, self.marched = 10**9, 0, list[Point]()
        self.outcome: Callable[[Work, Point], Outcome] = march_point
        self._first: Outcome | None = None

    def march(
        self, work: Work, points: Iterable[Point | None], *, workers: int | None, **_: object
    ) -> Iterator[tuple[int, Outcome]]:
        waiting, self.calls = iter(points), self.calls + 1
        while lot := ready(waiting, workers or 1):
            for point in reversed(lot):
                if not self.left:
                    raise Killed
                self.left -= 1
                self.marched.append(point)
                yield point.number, self.outcome(work, point)

    def like_the_first(self, work: Work, point: Point, **values: int) -> Outcome:
        """Return the outcome of the first point, which alone is marched, with other values."""
        self._first = self._first or march_point(work, point)
        assert not isinstance(self._first, Failure)
        return {**self._first, **{name: np.array(value) for name, value in values.items()}}


@contextmanager
def in_process(*, figures: bool = False) -> Iterator[InProcess]:
    """Let sweeps be marched in this process, by default without leaving figures."""
    made = InProcess()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sweep, "march_points", lambda *given, **more: made.march(*given, **more))
        if not figures:
            patch.setattr("bladewhirl.postprocess.sweep.figures.leave_figures", lambda _: {})
        yield made


def assert_carried_on(stage: Stage, *names: str) -> None:
    """Assert that a march carried on from another moves as the other did after two revolutions, in
    which the loads repeat themselves."""
    first, _ = march_in_memory(prepare(stage))
    state = late_state(stage, first)
    second, _ = march_in_memory(
        prepare(stage, lambda problem, timing: (continued(stage, problem, state), timing))
    )
    record = int(np.abs(first["time"].values - 4.0 * np.pi / stage.speed).argmin())
    for name in names:
        expected, actual = first[name].values[record:], second[name].values
        scale = np.abs(expected).max()
        np.testing.assert_allclose(actual[: len(expected)], expected, rtol=0.0, atol=1e-2 * scale)
        assert np.abs(first[name].values[: len(expected)] - expected).max() > 0.1 * scale


def same_bits(one: Path, other: Path) -> bool:
    """Return whether two folders hold the same dataset, byte by byte."""
    return (one / "sweep.nc").read_bytes() == (other / "sweep.nc").read_bytes()


DEADLY = 2
"""The point that kills whoever marches it."""


def deadly(work: Work, point: Point) -> Outcome:
    """Die at one point."""
    if point.number == DEADLY:
        os._exit(1)
    return {"number": np.array(point.number)}


def of_another_version(work: Work, point: Point) -> Outcome:
    """Fail as a worker does that lacks the code of a point."""
    raise ModuleNotFoundError("No module named 'old'")

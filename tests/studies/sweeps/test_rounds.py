"""Draws that are repeated or not needed: the rules, order and interruptions, more draws later."""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray
from small_run import small
from sweep_work import InProcess, Killed, same_bits

import bladewhirl as bw
from bladewhirl.models.case.template import dumps_case
from bladewhirl.postprocess.sweep.dataset import flag, open_sweep
from bladewhirl.postprocess.sweep.shares import settled, wilson
from bladewhirl.solvers.march.schema import SCREENING, SWEEP
from bladewhirl.studies.sweeps.layout import make_layout, march_extent
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point, Work, march_point
from bladewhirl.studies.sweeps.rounds import Judge, narrower
from bladewhirl.studies.sweeps.stages import stage_at
from bladewhirl.studies.sweeps.sweep import resume_sweep, run_sweep

DIVERGENT, SUSTAINED = flag("regime", "divergent"), flag("regime", "sustained")
CASE = small(**{"contact.friction": 0.2, "march.duration": 2e-3})
OVER = {"march.speed": [1.0, 1.2, 1.5]}
PERTURB = ["contact.friction = 1e-3"]
LAYOUT = make_layout(march_extent([CASE]), stage_at(CASE))
UNSURE = 1.2
"""The speed at which a screened draw differs; marched again, all agree with those at 1.5."""
TWO = {"march.speed": [UNSURE, 1.5]}


class Toy:
    """Outcomes of points: one screened draw of each `draws` differs at one speed.

    Args:
        process: that marches the points.
    """

    def __init__(self, process: InProcess) -> None:
        self.process, self.differs, self.draws = process, 1, 6
        process.outcome = self.outcome

    def outcome(self, work: Work, point: Point) -> Outcome:
        speed = float(point.values["march.speed"])
        differs = point.screen and point.number % self.draws == self.differs
        grows = speed == 1.0 or (speed == UNSURE and differs)
        return self.process.like_the_first(
            work,
            point,
            regime=DIVERGENT if grows else SUSTAINED,
            steps=1 if point.screen else 2,
        )

    @property
    def screened(self) -> list[bool]:
        return [point.screen for point in self.process.marched]


@pytest.fixture
def toy(process: InProcess) -> Toy:
    return Toy(process)


@pytest.mark.parametrize("differs", [1, 5])
@pytest.mark.slow
def test_points_whose_draws_differ_are_repeated(toy: Toy, tmp_path: Path, differs: int) -> None:
    toy.differs = differs
    done = run_sweep(CASE, OVER, tmp_path, draws=6, perturb=PERTURB, screen=True)
    assert (done.done, done.screened, done.marched) == (18, 12, 19 + differs)
    assert toy.screened == [True] * (13 + differs) + [False] * 6
    assert toy.process.calls == 1  # workers are started once
    with open_sweep(tmp_path) as sweep:
        assert (sweep["screened"] == "yes").values.tolist() == [[True] * 6, [False] * 6, [True] * 6]
        assert sweep["steps"].values.tolist() == [[1] * 6, [2] * 6, [1] * 6]
        assert (sweep["regime"].sel(march_speed=UNSURE) == "sustained").all()
        assert "are repeated with the time step of the case" in sweep.attrs["screen_rule"]
    assert resume_sweep(tmp_path).marched == 0


@pytest.mark.parametrize("until", [pytest.param(None, marks=pytest.mark.slow), 0.2])
@pytest.mark.slow
def test_neither_workers_nor_kills_change_the_file(
    toy: Toy, tmp_path: Path, until: float | None
) -> None:
    toy.draws, toy.differs = 10, 2
    run_sweep(CASE, TWO, tmp_path / "one", draws=10, perturb=PERTURB, screen=True, until=until)
    whole = len(toy.screened)
    for left in (whole // 3, whole - 1):  # in either round
        folder, toy.process.left = tmp_path / f"killed-{left}", left
        with pytest.raises(Killed):
            run_sweep(
                CASE, TWO, folder, draws=10, perturb=PERTURB, screen=True, until=until, workers=2
            )
        assert toy.screened[-1] == (left < whole // 2)
        toy.process.left = 10**9
        resume_sweep(folder, workers=3)
        assert same_bits(tmp_path / "one", folder)


@pytest.mark.parametrize("differs", [1, pytest.param(9, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_draws_added_later_are_those_of_a_longer_sweep(
    toy: Toy, tmp_path: Path, differs: int
) -> None:
    toy.differs, toy.draws = differs, 10
    run_sweep(CASE, TWO, tmp_path / "all", draws=10, perturb=PERTURB, screen=True)
    toy.draws = 5
    run_sweep(CASE, TWO, tmp_path / "few", draws=5, perturb=PERTURB, screen=True)
    toy.draws = 10
    resume_sweep(tmp_path / "few", draws=10, workers=3)
    assert same_bits(tmp_path / "all", tmp_path / "few")


def test_a_screened_march_has_the_longer_step() -> None:
    work = Work(case=dumps_case(CASE), layout=LAYOUT, histories="")
    screened, whole = (
        march_point(work, Point(number=0, values={}, screen=screen)) for screen in (True, False)
    )
    assert not isinstance(screened, Failure)
    assert not isinstance(whole, Failure)
    assert screened["dt_over_critical"] < 0.5
    assert 2 * screened["steps"] < whole["steps"]
    assert screened["end_time"] == pytest.approx(whole["end_time"])


@pytest.mark.slow
@pytest.mark.usefixtures("toy")
def test_options_that_are_not_used_leave_no_trace(tmp_path: Path) -> None:
    run_sweep(CASE, OVER, tmp_path, draws=2, perturb=PERTURB)
    with h5py.File(tmp_path / "sweep.nc") as file:
        assert {name for name in SWEEP if SWEEP[name].part not in ("nodes", "start")} <= set(file)
        assert not {*SCREENING, "start", "start_impulse"} & set(file)
        assert not {"screen_rule", "carry", "carry_rule", "start_rule"} & set(file.attrs)
        assert "not-needed" not in file["state"].attrs["flag_meanings"]
    plan = json.loads((tmp_path / "sweep.json").read_text(encoding="utf-8"))
    assert list(plan) == [
        *("bladewhirl", "format", "digest", "case", "over", "histories", "stop_when", "draws")
    ]


COUNT = 30


@pytest.fixture
def even(process: InProcess) -> None:
    """Give the points outcomes of equal probability."""

    def outcome(work: Work, point: Point) -> Outcome:
        grows = float(point.values["contact.friction"]) > 0.2
        return process.like_the_first(work, point, regime=DIVERGENT if grows else SUSTAINED)

    process.outcome = outcome


def outcome(regime: int) -> Outcome:
    return {"regime": np.array(regime)} if regime >= 0 else Failure(reason="toy")


def carried_out(regimes: NDArray[np.int64], workers: int, seed: int) -> list[dict[int, bool]]:
    """March toy draws that arrive in random order; return for each point its draws that were
    written, true if needed."""
    written: list[dict[int, bool]] = [{} for _ in regimes]
    known = np.zeros(regimes.size, dtype=np.bool_)
    judge = Judge(COUNT, narrower(0.2), known, known.astype(np.int8))
    random, numbers, flying = np.random.default_rng(seed), judge.next_draws(), list[int]()
    while True:
        while len(flying) < 2 * workers and (number := next(numbers, None)) is not None:
            flying.append(number)
        if not flying:
            return written
        number = flying.pop(int(random.integers(len(flying))))
        for each, result in judge.take(number, outcome(int(regimes.flat[number]))):
            point, draw = divmod(each, COUNT)
            written[point][draw] = result is not None


def test_the_order_of_arrival_does_not_matter() -> None:
    random = np.random.default_rng(0)
    shares = np.array([0.0, 0.1, 0.5, 0.9, 1.0])[:, None]
    regimes = np.where(random.random((5, COUNT)) < shares, DIVERGENT, SUSTAINED)
    regimes[0, 1] = -1  # a failed draw
    alone = carried_out(regimes, 1, 0)
    for workers, seed in ((1, 1), (2, 2), (8, 3), (8, 4)):
        assert carried_out(regimes, workers, seed) == alone
    needed = [sum(draws.values()) for draws in alone]
    assert needed[0] == 5  # four equal draws and the failed one: 4 / (4 + 1.96**2) > 1/2
    assert needed[4] == 4
    assert needed[2] > needed[4]
    assert [len(draws) for draws in alone] == [COUNT] * 5


def test_wide_intervals_settle_when_they_exclude_one_half() -> None:
    low, high = wilson(
        np.array([[3.0, 0.0], [4.0, 0.0], [50.0, 50.0]]), np.array([[3], [4], [100]])
    )
    assert settled(low, high).tolist() == [False, True, False]
    assert settled(low, high, 0.2).tolist() == [False, True, True]  # 0.404 to 0.596


@pytest.mark.parametrize(("share", "covered"), [(0.2, 0.98), (0.4, 0.94), (0.5, 0.65)])
def test_how_often_the_interval_of_a_stopped_point_holds_the_share(
    share: float, covered: float
) -> None:
    """The figures of the tutorial, for up to 100 draws of a regime of known probability."""
    points, most = 2000, np.arange(1.0, 101.0)
    hits = np.cumsum(np.random.default_rng(1).random((points, 100)) < share, axis=1)
    low, high = wilson(np.stack([hits, most - hits], axis=-1), most[:, None])
    enough = settled(low, high, 0.2)
    at = np.arange(points), np.where(enough.any(axis=1), enough.argmax(axis=1), 99), 0
    assert np.mean((low[at] <= share) & (share <= high[at])) == pytest.approx(covered, abs=0.025)


@pytest.mark.usefixtures("even")
@pytest.mark.slow
def test_the_file_does_not_depend_on_the_number_of_workers(tmp_path: Path) -> None:
    for workers, folder in ((1, "one"), (5, "five")):
        done = run_sweep(
            CASE, TWO, tmp_path / folder, draws=8, perturb=PERTURB, until=0.2, workers=workers
        )
        assert (done.done, done.not_needed) == (12, 4)  # the draws of one point agree
    assert same_bits(tmp_path / "one", tmp_path / "five")
    assert resume_sweep(tmp_path / "one").marched == 0
    with open_sweep(tmp_path / "one") as sweep:
        counts = (sweep["state"] == "done").sum("draw").values.tolist()
        shares = bw.probability(sweep)
    assert shares["draws"].values.tolist() == [counts]
    assert shares["uncertain"].values.tolist() == [[count == 8 for count in counts]]


@pytest.mark.slow
@pytest.mark.usefixtures("even")
def test_draws_and_widths_added_later_are_those_of_a_longer_sweep(tmp_path: Path) -> None:
    run_sweep(CASE, TWO, tmp_path / "all", draws=8, perturb=PERTURB, until=0.2)
    run_sweep(CASE, TWO, tmp_path / "few", draws=3, perturb=PERTURB, until=0.2)
    resume_sweep(tmp_path / "few", draws=8, workers=3)
    assert same_bits(tmp_path / "all", tmp_path / "few")
    run_sweep(CASE, TWO, tmp_path / "wide", draws=8, perturb=PERTURB, until=0.9)
    resume_sweep(tmp_path / "wide", until=0.2)
    assert same_bits(tmp_path / "all", tmp_path / "wide")
    with pytest.raises(bw.UserError, match=r"--until 0.3: expected less than the 0.2 of the sweep"):
        resume_sweep(tmp_path / "wide", until=0.3)
    with pytest.raises(bw.UserError, match=r"--draws 5: expected more than the 8 draws of the"):
        resume_sweep(tmp_path / "few", draws=5)


@pytest.mark.usefixtures("even")
@pytest.mark.slow
def test_a_killed_addition_of_draws_is_completed(tmp_path: Path) -> None:
    run_sweep(CASE, TWO, tmp_path / "few", draws=2, perturb=PERTURB)
    plan = (tmp_path / "few" / "sweep.json").read_bytes()
    resume_sweep(tmp_path / "few", draws=3)
    bits = (tmp_path / "few" / "sweep.nc").read_bytes()
    (tmp_path / "few" / "sweep.json").write_bytes(plan)  # as after a kill before the plan
    assert resume_sweep(tmp_path / "few", draws=3).marched == 0
    assert (tmp_path / "few" / "sweep.nc").read_bytes() == bits


def test_a_resumed_point_needs_the_first_missing_draw() -> None:
    known = np.array([True, False, True])
    judge = Judge(3, narrower(0.2), known, np.full(3, SUSTAINED, dtype=np.int8))
    assert list(judge.next_draws()) == [1]
    assert [number for number, _ in judge.take(1, outcome(SUSTAINED))] == [1]

"""Screened sweeps: which draws are repeated, and that order and interruptions do not matter."""

import json
from pathlib import Path

import h5py
import pytest
from small_run import small
from sweep_work import InProcess, Killed, same_bits

from bladewhirl.models.case.template import dumps_case
from bladewhirl.postprocess.sweep.dataset import flag, open_sweep
from bladewhirl.solvers.march.schema import SCREENING, SWEEP
from bladewhirl.studies.sweeps.layout import make_layout, march_extent
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point, Work, march_point, stage_at
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


@pytest.mark.parametrize("until", [None, 0.2])
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


@pytest.mark.parametrize("differs", [1, 9])
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


@pytest.mark.usefixtures("toy")
def test_options_that_are_not_used_leave_no_trace(tmp_path: Path) -> None:
    run_sweep(CASE, OVER, tmp_path, draws=2, perturb=PERTURB)
    with h5py.File(tmp_path / "sweep.nc") as file:
        assert set(SWEEP) <= set(file)
        assert not set(SCREENING) & set(file)
        assert not {"screen_rule", "carry", "carry_rule"} & set(file.attrs)
        assert "not-needed" not in file["state"].attrs["flag_meanings"]
    plan = json.loads((tmp_path / "sweep.json").read_text(encoding="utf-8"))
    assert list(plan) == [
        *("bladewhirl", "format", "digest", "case", "over", "histories", "stop_when", "draws")
    ]

"""Steps and duration of a march in revolutions."""

from pathlib import Path

import numpy as np
import pytest
from small_run import assert_same_bits, small
from sweep_work import in_process

import bladewhirl as bw

TURN = 2.0 * np.pi / 400.0


def turning(**values: object) -> bw.Case:
    given = {"march.speed": "400 rad/s", "march.steps_per_revolution": 4000, **values}
    return small(**{"march.revolutions": 0.5, "march.record_step": "0.1 ms", **given})


@pytest.mark.slow
def test_they_are_those_of_seconds_to_the_last_bit(tmp_path: Path) -> None:
    case = turning()
    step = TURN / 4000
    every = round(1e-4 / step)
    seconds = {"time_step": step, "record_step": every * step, "duration": 0.5 * TURN}
    plain = small(**{f"march.{key}": value for key, value in seconds.items()})
    plain = bw.with_values(plain, {"march.speed": "400 rad/s"})
    one, other = (bw.run(c, tmp_path / n, frames=0) for c, n in ((case, "one"), (plain, "other")))
    assert_same_bits(one.directory, other.directory)
    assert one.summary.steps == 2000
    text = (one.directory / "case.toml").read_text(encoding="utf-8")
    assert "revolutions = 0.5" in text
    assert "time_step" not in text
    read = bw.read_case(one.directory / "case.toml").march
    assert read.in_seconds(400.0) == case.march.in_seconds(400.0)


@pytest.mark.slow
def test_in_a_sweep_the_step_follows_the_speed(tmp_path: Path) -> None:
    with in_process():
        bw.run_sweep(turning(), {"march.speed": [0.8, 1.2]}, tmp_path / "sweep")
    with bw.open_sweep(tmp_path / "sweep") as swept:
        assert swept["steps"].values.tolist() == [2000, 2000]
        turns = swept["end_time"] * swept["rotation_speed"] / (2.0 * np.pi)
        assert turns.values == pytest.approx(0.5, rel=1e-12)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"march.speed": 0.0}, "march.speed = 0.0: expected a speed other than 0"),
        ({"march.revolutions": 1e12}, "march.revolutions = 1e12: expected at most"),
        ({"march.revolutions": 0.0}, "march.revolutions = 0.0: expected"),
    ],
)
def test_contradictions_are_refused(values: dict[str, object], expected: str) -> None:
    with pytest.raises(bw.UserError) as caught:
        bw.case_from({"march": {k.partition(".")[2]: v for k, v in _given(values).items()}})
    assert expected in str(caught.value)


def _given(values: dict[str, object]) -> dict[str, object]:
    march = {"speed": "400 rad/s", "steps_per_revolution": 4000, "revolutions": 0.5}
    return {f"march.{key}": value for key, value in march.items()} | values


def test_too_few_steps_are_refused_by_their_key(tmp_path: Path) -> None:
    with pytest.raises(bw.UserError, match=r"_per_revolution = 8: expected more, for a time"):
        bw.run(turning(**{"march.steps_per_revolution": 8}), tmp_path / "run", frames=0)

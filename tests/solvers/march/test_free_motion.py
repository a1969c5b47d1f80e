"""Marches that end early: nothing that they leave out would have touched."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rod_blade
from contact_cases import run, stage_problem, thrown
from numpy.testing import assert_array_equal
from sweep_work import in_process

import bladewhirl as bw
from bladewhirl.models.case.case import Case
from bladewhirl.postprocess.energy.regimes import classify
from bladewhirl.postprocess.energy.strain import strain_energies
from bladewhirl.postprocess.sweep.dataset import open_sweep
from bladewhirl.solvers.march.free_motion import RULE, FreeMotion
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.sweeps.plan import read_plan
from bladewhirl.studies.sweeps.sweep import run_sweep

STEP = 1e-6


def pulse(force: float, **more: object) -> Case:
    """A casing that is distorted for 3 ms, and then left to itself."""
    excitation = {"type": "casing-distortion", "modal_force": force, "duration": "3 ms"}
    march = {"speed": 1.05, "time_step": STEP, "duration": 0.5, "record_step": 1e-4}
    stiff = {"casing": {"support": 7.975e6}, "damping": {"ratio": 0.05}}
    return bw.case_from({**stiff, "excitation": excitation, "march": march, **more})


@pytest.mark.slow
@pytest.mark.parametrize(("force", "regime"), [(1e3, "no-contact"), (3e4, "damped")])
def test_a_stopped_march_begins_as_the_whole_one_and_nothing_touches_later(
    force: float, regime: str
) -> None:
    whole = prepare(pulse(force))
    stop = FreeMotion.of(whole.problem, STEP)
    long, _ = march_in_memory(whole)
    short, report = march_in_memory(replace(whole, stop=stop))
    assert short.attrs["end_reason"] == "damped"
    assert report["steps"] == short.attrs["steps"] < 400_000
    for name in ("rotor_displacement", "casing_displacement", "energy", "contact_steps"):
        assert_array_equal(short[name], long[name][: short.sizes["time"]])
    assert not long["contact_steps"][short.sizes["time"] // 2 :].any()
    for actual in (short, long):
        assert classify(actual, strain_energies(actual)["total"].values).name == regime


def separate_blades(folder: Path, **further: object) -> Case:
    """Two of three separate blades touch once, and one is lost later."""
    bw.write_superelement(folder / "rods.npz", rod_blade.blade())
    given = rod_blade.tables(folder / "rods.npz", damping={"ratio": 0.05})
    given["reduction"] = {"boundary": "consistent"}
    given["casing"] = {"type": "rigid", "clearance": 3e-5}
    given["initial"] = {"tip_velocity": [[3.0, 1.0], [3.0, 1.0], [0.0, 0.0]]}
    given["march"] |= {"duration": 0.5, "speed": "60000 rpm"}
    return bw.case_from(given | further)


@pytest.mark.slow
def test_a_march_does_not_end_before_a_blade_is_lost(tmp_path: Path) -> None:
    ends = {}
    for time in (None, 0.05, 0.3):
        loss = {} if time is None else {"blade_loss": {"blade": 1, "time": time}}
        whole = prepare(separate_blades(tmp_path, **loss))
        stop = FreeMotion.of(whole.problem, whole.timing.time_step)
        short, _ = march_in_memory(replace(whole, stop=stop))
        assert short.attrs["end_reason"] == "damped"
        assert short["contact_steps"].any()
        ends[time] = float(short["time"][-1])
    assert ends[None] == ends[0.05] < 0.3 < ends[0.3]


def test_no_state_with_so_little_energy_closes_the_gap() -> None:
    """The worst of states of that energy, of every tip and wall node, closes just the share."""
    problem: Any = prepare(pulse(3e4)).problem
    stop = FreeMotion.of(problem, STEP)
    ways = [
        [row / frequency for row in rows]
        for rows, frequency in (
            (problem.rotor.tip_radial, problem.rotor.frequency),
            (problem.casing.nodal[:, 0], problem.casing.frequency),
        )
    ]
    rotor, casing = (max(np.linalg.norm(way) for way in body) for body in ways)
    closed = np.sqrt(2.0 * stop.enough) * np.hypot(rotor, casing)
    assert 0.95 < closed / (0.8 * problem.casing.clearance[:, 0].min()) <= 1.0


def test_a_long_blade_a_large_step_and_slow_rotation_count() -> None:
    problem: Any = prepare(pulse(3e4)).problem
    stop = FreeMotion.of(problem, STEP)
    assert stop.free_time == pytest.approx(10 * 2 * np.pi / problem.speed)
    assert stop.since == 3e-3
    half = -0.5 * float(problem.casing.clearance[:, 0].min())
    recess = np.where(np.arange(22) == 7, half, 0.0)
    long = replace(problem, rotor=replace(problem.rotor, tip_recess=recess))
    assert FreeMotion.of(long, STEP).enough == pytest.approx(0.25 * stop.enough)
    assert np.isinf(FreeMotion.of(replace(problem, speed=0.0), STEP).free_time)
    whole, halved = (FreeMotion.of(problem, f * problem.critical_time_step) for f in (1e-6, 0.5))
    assert halved.enough == pytest.approx(0.75 * whole.enough)


def test_what_is_waited_for() -> None:
    """Ten turns and half of the time without contact, and little energy at the end of both."""
    _, chunk, _ = run(thrown(stage_problem(), 0.0), 1e-6, 1)
    blank = replace(chunk, contact_steps=np.zeros_like(chunk.contact_steps))

    def over(stop: FreeMotion, end: float, *, energy: float = 0.5, touched: bool = False) -> bool:
        times, energies = np.array([end - 0.04, end]), np.array([2.0 - energy, energy])
        contact = blank.contact_steps.copy()
        contact[0, 3] = touched
        return stop.is_over(replace(blank, time=times, energy=energies, contact_steps=contact))

    stop = FreeMotion(enough=1.0, free_time=0.3, since=0.1)
    assert not over(stop, 0.39)
    assert over(stop, 0.41)
    assert not over(stop, 0.41, energy=1.5)
    assert not over(stop, 0.44, touched=True)  # at 0.4
    assert stop.since == pytest.approx(0.4)
    assert not over(stop, 0.79)
    assert over(stop, 0.81)


@pytest.mark.slow
def test_a_sweep_records_where_and_why_points_stopped(tmp_path: Path) -> None:
    speeds = {"march.speed": [1.0, 1.1]}
    with in_process():
        run_sweep(pulse(1e3), speeds, tmp_path / "early", stop_when="damped")
        run_sweep(pulse(1e3), speeds, tmp_path / "whole")
    with open_sweep(tmp_path / "early") as early, open_sweep(tmp_path / "whole") as whole:
        assert early.attrs["stop_rule"] == RULE
        assert "stop_rule" not in whole.attrs
        assert (early["end_reason"] == "damped").all()
        assert (early["end_time"] < 0.6 * whole["end_time"]).all()
        assert_array_equal(early["regime"], whole["regime"])
    assert read_plan(tmp_path / "early").stop_when == "damped"

"""Mass scaling of the casing: what it keeps, what it changes, and the step it permits."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exported_stages import beams, exported
from stages import stage

from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.mass_scaling import (
    MASS_CHANGE,
    screening_cut,
    screening_problem,
    with_scaled_casing,
)
from bladewhirl.solvers.march.sudden_changes import make_scheme
from bladewhirl.studies.runs.prepare import prepare


def test_displacements_of_the_start_stay() -> None:
    problem = contact_problem(stage())
    values = np.linspace(1.0, 2.0, len(problem.casing.frequency))
    start = replace(problem.start, casing=values, casing_velocity=-values)
    scaled = with_scaled_casing(replace(problem, start=start), 2e4)
    for name in ("casing", "casing_velocity"):
        moved = problem.casing.nodal @ getattr(start, name)
        same = scaled.casing.nodal @ getattr(scaled.start, name)
        np.testing.assert_allclose(same, moved, rtol=1e-12, atol=1e-12 * np.abs(moved).max())


def test_cut_and_step_of_the_papers_stage() -> None:
    """A cut of 15 kHz with a critical step of 21 us, marched at 10 us, was found by trial."""
    problem, timing = contact_problem(stage()), stage().case.march.timing
    assert screening_cut(problem) / (2.0 * np.pi) == pytest.approx(15e3, rel=1e-2)
    scaled, longer = screening_problem(problem, timing)
    assert scaled.critical_time_step == pytest.approx(21e-6, rel=1e-2)
    assert longer.time_step == pytest.approx(10e-6, rel=1e-12)
    assert longer.record_every * longer.time_step == pytest.approx(timing.record_step, rel=1e-12)
    inverse = [  # at the nodes, where it changes least
        (each.casing.nodal[:, 0] ** 2).sum(axis=1) for each in (problem, scaled)
    ]
    assert (1.0 - inverse[1] / inverse[0]).max() < MASS_CHANGE


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("march.time_step=1e-6", None),
        ("march.record_step=4e-6", "march.time_step below 4e-06 s"),
        ("march.speed=100", r"a speed below 1\.571e\+04 rad/s"),  # 9 degrees in 10 us
    ],
)
def test_what_cannot_be_screened(change: str, expected: str | None) -> None:
    built = stage("march.time_step=4e-6" if "record" in change else "march.time_step=1e-6", change)
    problem, timing = contact_problem(built), built.case.march.timing
    if expected is None:
        assert screening_problem(problem, timing)[1].time_step == pytest.approx(1e-5)
        return
    with pytest.raises(ValueError, match=expected):
        screening_problem(problem, timing)


def test_springs_on_scaled_modes_are_refused() -> None:
    built = stage("coupling.stiffness=1e3")
    problem, timing = contact_problem(built), built.case.march.timing
    assert problem.springs is not None
    assert screening_problem(problem, timing)[1].time_step == pytest.approx(1e-5)
    last = np.zeros_like(problem.springs.casing)
    last[..., -1] = 1.0
    moved = replace(problem, springs=replace(problem.springs, casing=last))
    with pytest.raises(ValueError, match="that act on no casing mode above"):
        screening_problem(moved, timing)


@pytest.mark.slow
def test_a_wheel_is_screened_as_its_beams(tmp_path: Path) -> None:
    tables: dict[str, Any] = {
        "casing": {"elements": 40, "support": 7.975e6},
        "excitation": {"type": "casing-distortion"},
        "march": {"speed": "600 rpm", "time_step": 1e-6, "duration": 0.01, "record_step": 1e-4},
    }
    own, timing = beams(**tables), beams(**tables).march.timing
    same = {"boundary": "consistent", "fixed_interface_modes": 10}
    excitation = {"excitation": tables["excitation"]}
    wheel = exported(own, "wheel", tmp_path, reduction=same, **excitation)
    problems = [prepare(case).problem for case in (own, wheel)]
    first, second = (screening_problem(problem, timing) for problem in problems)
    assert second[1] == first[1]
    assert second[1].time_step > 4e-6
    for name in ("frequency", "nodal"):
        expected = getattr(first[0].casing, name)
        assert getattr(second[0].casing, name) == pytest.approx(expected, rel=1e-9, abs=1e-12)
    massless = exported(own, "wheel", tmp_path, **excitation)
    with pytest.raises(ValueError, match="massless nodes with a flexible casing loses energy"):
        screening_problem(prepare(massless).problem, timing)


def test_a_stage_that_loses_a_blade_is_screened() -> None:
    """The largest displacement of the shaft is that with the casing's own masses."""
    changes = (
        "march.time_step=1e-6",
        "march.duration=0.02",
        "march.record_step=1e-4",
        "blade_loss={blade=3,time=0.005}",
        "excitation={type='none'}",
        "casing.clearance=0.2e-3",
    )
    built = stage(*changes)
    problem, timing = contact_problem(built), built.case.march.timing
    scaled, longer = screening_problem(problem, timing)
    assert longer.time_step > 5.0 * timing.time_step
    largest = []
    for given, steps in ((problem, timing), (scaled, longer)):
        scheme = make_scheme(given, steps.time_step, steps.record_every)
        chunk = scheme.advance(scheme.init(), steps.steps)[1]
        assert chunk.contact_impulse.any()
        largest.append(np.linalg.norm(chunk.rotor_displacement @ given.rotor.centre.T, axis=1))
    assert largest[0].max() > 1e-4
    np.testing.assert_allclose(largest[1].max(), largest[0].max(), rtol=0.05)

"""Contact that is constant in rotating axes against marches."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer, refusal
from periodic_cases import case
from places import ROOT

import bladewhirl as bw
from bladewhirl.models.stage.marched import marched_stage
from bladewhirl.solvers.periodic.corotating import corotating_contact, obstacles

IMBALANCE = ROOT / "examples" / "imbalance.toml"


def imbalance(**changes: Any) -> bw.Case:
    return bw.with_values(bw.read_case(IMBALANCE), changes)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_forces_on_the_tips_are_those_of_a_long_march(tmp_path: Path, friction: float) -> None:
    own = imbalance(
        **{
            "contact.friction": friction,
            "damping.ratio": 0.05,
            "march.duration": 0.8,
            "march.record_step": "1 ms",
            "march.time_step": "2 us",
        }
    )
    found = corotating_contact(marched_stage(own).contact_problem())
    bw.run(own, tmp_path / "run", frames=0)
    with bw.open_result(tmp_path / "run") as result:
        force = result["contact_impulse"].values[-50:].mean(axis=0) / 1e-3
    assert found.normal == pytest.approx(force, abs=5e-3 * force.max())


def test_complementarity() -> None:
    found = corotating_contact(marched_stage(imbalance()).contact_problem())
    touching = found.normal > 0.0
    assert 0 < np.count_nonzero(touching) < len(touching)
    assert np.abs(found.gap[touching]).max() < 1e-12
    assert found.gap[~touching].min() > 0.0
    assert (found.normal >= 0.0).all()


def test_the_command_prints_the_radius_of_the_shaft(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(imbalance(**{"contact.friction": 0.0})))
    document = json.loads(answer("periodic", file, "--speeds", "1.05,1.06", "--json").stdout)
    first, second = document["solutions"]
    assert first["radius"] == pytest.approx(1.1984e-3, rel=1e-4)
    assert first["stable"] is None
    assert second["impulse_per_revolution"] != first["impulse_per_revolution"]
    assert "no contact at 0.5" in refusal("periodic", file, "--speeds", "0.5")


@pytest.mark.slow
def test_the_command_draws_the_forces(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(imbalance(**{"contact.friction": 0.0})))
    assert "1.198" in answer("periodic", file, "-o", tmp_path / "out").stdout
    assert (tmp_path / "out" / "periodic.png").exists()


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"casing.profile": {"harmonics": [{"lobes": 2, "amplitude": "0.1 mm"}]}}, "round"),
        ({"coupling.stiffness": 1e5}, "static frame"),
    ],
)
def test_what_is_not_constant_in_rotating_axes(changes: Any, reason: str) -> None:
    problem = marched_stage(imbalance(**changes)).contact_problem()
    assert any(reason in each for each in obstacles(problem))
    with pytest.raises(ValueError, match=reason):
        corotating_contact(problem)


def test_a_blade_without_load_has_other_obstacles() -> None:
    assert list(obstacles(marched_stage(case()).contact_problem())) == [
        "the clearance is not round"
    ]

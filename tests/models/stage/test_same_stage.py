"""Stages of beams and the same stages as superelements: the same loads, springs, dampers and
rotation effects give the same march."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from long_cases import slow_except

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.build import contact_problem, steady_problem
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.solvers.march.sudden_changes import make_scheme

COMMON: dict[str, Any] = {
    "casing": {"elements": 12, "support": 8e6, "clearance": 5e-4},
    "contact": {"friction": 0.05},
    "damping": {"ratio": 0.0, "boundary_ratio": 0.0},
    "excitation": {"type": "none"},
    "march": {
        "speed": "1200 rpm",
        "time_step": 2e-6,
        "duration": 0.01,
        "displacement_limit": 0.45,
    },
}
PINCHED = {"closure": {"amount": 6e-4, "time_constant": 1e-3}}


def pair(
    folder: Path, kind: Any = "wheel", *, own: Any = None, **tables: Any
) -> tuple[ContactProblem, ContactProblem]:
    """Contact problems of a stage of six beams, and of the same stage as a superelement; `own` is
    an excitation of the superelement alone."""
    common = COMMON | {
        key: COMMON.get(key, {}) | value if key != "excitation" else value
        for key, value in tables.items()
    }
    shaft = {"clamped": kind != "wheel"} | tables.get("shaft", {})
    beams: dict[str, Any] = {"blades": 6, "elements_per_blade": 2}
    if kind == "blade":
        beams["disk_kind"] = "rigid"
    reduction = {"fixed_interface_modes": 6}
    given = common | {"bladed_disk": beams, "shaft": shaft, "reduction": reduction}
    stage = bw.build_stage(bw.case_from(given))
    file = folder / "part.npz"
    bw.write_superelement(file, stage.to_superelement(kind))
    table = {"file": str(file), "kind": kind, "copies": 6}
    kept = {"boundary": "consistent", "fixed_interface_modes": 1 if kind == "blade" else 6}
    same = common | {"bladed_disk": {"superelement": table}, "shaft": shaft, "reduction": kept}
    same |= {} if own is None else {"excitation": own}
    speed = stage.speed
    return contact_problem(stage), steady_problem(build_matrices(bw.case_from(same)).at(speed))


def marched(problem: ContactProblem) -> tuple[Chunk, FloatArray]:
    """Records of a march, and the radial displacements of the tips."""
    made = make_scheme(problem, 2e-6, 50)
    _, chunk, _ = made.advance(made.init(), 5001)
    rotor = problem.rotor
    return chunk, np.array([rotor.at_tips(rotor.tip_radial, x) for x in chunk.rotor_displacement])


BEARINGS = {"stiffness": 3e7, "stiffness_y": 1e7, "frame": "static", "damping": 2e3}
CASES: dict[str, Any] = {
    "unequal bearings and dampers": {
        "shaft": BEARINGS,
        "excitation": {"type": "imbalance", "clearance_speed": "1500 rpm", "ramp": "1 ms"},
    },
    "Coriolis forces, dampers in the static frame": {
        "rotation": {"effects": "full"},
        "shaft": {"damping": 2e3, "damping_frame": "static"},
        "excitation": {"type": "imbalance", "unbalance": 2.0, "ramp": "1 ms"},
    },
}


@pytest.mark.parametrize("case", CASES)
def test_a_wheel_on_bearings_is_the_bladed_disk_it_was_made_of(case: str, tmp_path: Path) -> None:
    beams, nodes = (marched(each) for each in pair(tmp_path, **CASES[case]))
    assert np.abs(beams[1]).max() > 2e-5
    assert nodes[1] == pytest.approx(beams[1], abs=1e-9 * np.abs(beams[1]).max())
    for name in ("energy", "external_work", "damping_work", "coupling_work"):
        ours, theirs = (getattr(each[0], name) for each in (nodes, beams))
        assert ours == pytest.approx(theirs, abs=1e-8 * np.abs(beams[0].energy).max())


@pytest.mark.parametrize("kind", ["wheel", "sector", "blade"])
def test_engine_orders_act_on_points_of_the_file(kind: str, tmp_path: Path) -> None:
    """The points of a file of beams are its nodes: forces at half of the blade act on the nodes
    there."""
    order = {"type": "engine-order", "order": [2, 3], "amplitude": 40.0, "direction": "30 deg"}
    middle = {"position": 0.5} | order
    pair(tmp_path, kind, excitation=middle, own=order)
    points = bw.read_superelement(tmp_path / "part.npz").points
    assert points is not None
    half = np.flatnonzero(np.isclose(np.hypot(*points[:, :2].T), 0.275))
    beams, nodes = pair(
        tmp_path, kind, excitation=middle, own=order | {"points": [int(n) for n in half]}
    )
    moved = [marched(each)[1] for each in (beams, nodes)]
    assert np.abs(moved[0]).max() > 1e-7
    assert moved[1] == pytest.approx(moved[0], abs=1e-7 * np.abs(moved[0]).max())


@pytest.mark.parametrize("kind", ["wheel", "sector", "blade"])
@pytest.mark.parametrize("wall", ["ring", "rigid"])
@pytest.mark.parametrize("sliding", slow_except(["permanent", "full"], "full"))
def test_contact_in_every_wall_is_that_of_the_beams(
    kind: str, wall: str, sliding: str, tmp_path: Path
) -> None:
    given = {
        "casing": PINCHED | {"type": wall, "clearance_lobes": [{"lobes": 2, "amplitude": 2e-4}]},
        "contact": {"sliding": sliding, "tip_rotation": True},
    }
    beams, nodes = (marched(each) for each in pair(tmp_path, kind, **given))
    assert (beams[0].contact_impulse.sum(axis=0) > 0.0).sum() >= 2
    assert nodes[1] == pytest.approx(beams[1], abs=1e-7 * np.abs(beams[1]).max())
    for name in ("contact_impulse", "friction_impulse", "energy", "friction_work", "closing_work"):
        ours, theirs = (getattr(each[0], name) for each in (nodes, beams))
        assert ours == pytest.approx(theirs, abs=1e-6 * np.abs(theirs).max())


@pytest.mark.parametrize("kind", ["wheel", "sector", "blade"])
def test_springs_to_the_casing_are_those_of_the_beams(kind: str, tmp_path: Path) -> None:
    springs = {"stiffness": 2e8, "modes": "all", "amplitude": "physical"}
    order = {"type": "engine-order", "order": 1, "amplitude": 40.0, "direction": "30 deg"}
    given = {"coupling": springs, "casing": PINCHED, "excitation": order}
    problems = pair(tmp_path, kind, **given)
    without = marched(replace(problems[0], springs=None))[1]
    beams, nodes = (marched(each) for each in problems)
    largest = np.abs(beams[1]).max()
    assert np.abs(without - beams[1]).max() > 1e-2 * largest
    assert nodes[1] == pytest.approx(beams[1], abs=1e-8 * largest)
    for name in ("energy", "coupling_work", "external_work"):
        ours, theirs = (getattr(each[0], name) for each in (nodes, beams))
        assert ours == pytest.approx(theirs, abs=1e-6 * np.abs(theirs).max())
    assert nodes[0].coupling_work.any()
    critical = problems[0].critical_time_step, problems[1].critical_time_step
    assert 0.9 * critical[0] < critical[1] <= critical[0]

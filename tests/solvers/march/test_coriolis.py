"""Marches of a rotor that feels Coriolis forces, against what is known of whirling and of speed."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.linalg as la
from contact_cases import random_problem, run, wall
from places import EXAMPLES

from bladewhirl.models.case.case import case_from
from bladewhirl.models.case.file import read_case
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.studies.verification.stages import observed_order


@cache
def turning_stage(example: str, *changes: str) -> ContactProblem:
    case = read_case(EXAMPLES / f"{example}.toml", ['rotation.effects="full"', *changes])
    return contact_problem(build_beams(case))


def test_a_disk_that_turns_the_other_way_moves_as_in_a_mirror() -> None:
    small = "bladed_disk.blades=8", "reduction.fixed_interface_modes=40"
    forward, backward = (
        turning_stage("imbalance", *small, f"march.speed={speed}") for speed in (1.05, -1.05)
    )
    mirrored = -np.arange(8) % 8
    actual = []
    for given in (forward, backward):
        load = replace(given.loads[0], rotor=3e2 * given.loads[0].rotor)
        _, chunk, _ = run(replace(given, loads=(load,)), 1e-6, 6000, every=100)
        assert chunk.contact_impulse.any()
        moved = chunk.rotor_displacement
        actual.append((moved @ given.rotor.tip_radial.T, moved @ given.rotor.tip_tangential.T))
    (radial, tangential), (other_radial, other_tangential) = actual
    size = 1e-7 * np.abs(tangential).max()
    np.testing.assert_allclose(other_radial, radial[:, mirrored], atol=size)
    np.testing.assert_allclose(other_tangential, -tangential[:, mirrored], atol=size)


@pytest.mark.slow
def test_dampers_that_stand_still_in_a_case() -> None:
    dampers = ("shaft.damping=2e4", "shaft.damping_frame=static")
    for speed in (1.05, -1.05):
        given = turning_stage("imbalance", *dampers, f"march.speed={speed}")
        assert given.rotor.circulation == pytest.approx(2e4 * given.speed, rel=1e-12)
    assert turning_stage("imbalance", dampers[0]).rotor.circulation == 0.0
    with pytest.raises(CaseError, match=r'damping_frame = "static": expected "rotating", or rot'):
        case_from({"shaft": {"damping_frame": "static"}})
    with pytest.raises(
        CaseError, match=r"damping_y = 20(\.0)?: expected the value of shaft\.damping"
    ):
        case_from(
            {
                "rotation": {"effects": "full"},
                "shaft": {"damping": 10.0, "damping_y": 20.0, "damping_frame": "static"},
            }
        )


def test_reference_solution_of_a_reduced_rotor() -> None:
    """Loads, dampers and motion at the start, all of the second order: the matrix exponential."""
    given, random = random_problem(3, speed=30.0), np.random.default_rng(3)
    modes = len(given.rotor.frequency)
    skew, half = 300.0 * random.normal(size=(modes,) * 2), 3.0 * random.normal(size=(modes,) * 2)
    rotor = replace(
        given.rotor,
        by_velocity=skew - skew.T + half.T @ half,
        dampers=3.0 * random.normal(size=(2, modes)),
        circulation=2e4,
    )
    load = replace(given.loads[0], ramp=0.0, frequency=0.0, phase=0.0)
    far = replace(
        given,
        rotor=rotor,
        casing=wall(1e3),
        loads=(replace(load, casing=np.zeros(1)),),
        start=replace(given.start, casing=np.zeros(1), casing_velocity=np.zeros(1)),
    )
    stiffness = np.diag(rotor.stiffness) + rotor.circulation_stiffness
    rates = np.zeros((2 * modes + 1,) * 2)
    rates[:modes, modes:-1] = np.eye(modes)
    rates[modes:-1] = np.column_stack([-stiffness, -rotor.damping, load.rotor])
    begin = np.concatenate([far.start.rotor, far.start.rotor_velocity, [1.0]])
    end = 0.01
    exact = (la.expm(end * rates) @ begin)[:modes]
    errors = []
    for steps in (400, 800, 1600):
        _, chunk, _ = run(far, end / steps, steps)
        errors.append(np.abs(chunk.rotor_displacement[-1] - exact).max())
    assert errors[-1] < 1e-3 * np.abs(exact).max()
    np.testing.assert_allclose(observed_order(np.array(errors)), 2.0, atol=0.1)

"""Tips of beams as contact nodes: the march of many nodes is that of the tips."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import bladewhirl as bw
from bladewhirl.models.stage.beam_rotor import with_contact_nodes
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem, ReducedCasing, Start
from bladewhirl.solvers.march.central_difference import CentralDifference

DT, STEPS = 2e-6, 500
CASE: dict[str, Any] = {
    "bladed_disk": {"blades": 5, "elements_per_blade": 2},
    "casing": {"elements": 20, "support": 8e6, "clearance": 2e-4},
    "contact": {"friction": 0.1},
    "reduction": {"fixed_interface_modes": 4},
    "excitation": {"type": "imbalance", "unbalance": 0.5, "ramp": 0.0},
    "march": {"speed": "3000 rpm", "time_step": DT},
    "initial": {"tip_velocity": [[1.5 + 0.3 * n, 0.4] for n in range(5)]},
}
CHANGES: dict[str, dict[str, Any]] = {
    "tips that turn": {"contact": {"tip_rotation": True}},
    "Coriolis forces": {"rotation": {"effects": "full"}},
    "springs": {"coupling": {"stiffness": 500.0}},
    "unequal bearings, dampers, closure": {
        "shaft": {"stiffness_y": 2e7, "frame": "static", "damping": 1e3},
        "casing": {"closure": {"amount": 1e-4, "time_constant": 5e-4}},
    },
}


def problem(changes: dict[str, Any]) -> ContactProblem:
    """The contact problem of five blades that move outward."""
    case = CASE | {key: CASE.get(key, {}) | value for key, value in changes.items()}
    return contact_problem(bw.build_stage(bw.case_from(case)))


@pytest.mark.parametrize("wall", ["ring", "rigid"])
@pytest.mark.parametrize("changes", CHANGES)
def test_tips_march_as_contact_nodes(changes: str, wall: str) -> None:
    tips = problem(CHANGES[changes])
    if wall == "rigid":
        if tips.springs is not None:
            return  # they need a casing that moves
        fixed = ReducedCasing.rigid(tips.casing.clearance, tips.casing.radius)
        start = Start.of_rotor(tips.start.rotor, tips.start.rotor_velocity)
        loads = tuple(replace(load, casing=np.zeros(0)) for load in tips.loads)
        tips = replace(tips, casing=fixed, start=start, loads=loads)
    nodes = replace(tips, rotor=with_contact_nodes(tips.rotor))
    schemes = [CentralDifference(each, DT, 1) for each in (tips, nodes)]
    first, second = (each.advance(each.init(), STEPS)[1] for each in schemes)
    assert (first.contact_steps.sum(axis=0) > 0).sum() >= 2
    for name in (
        *("rotor_displacement", "casing_displacement", "gap", "contact_impulse"),
        *("friction_impulse", "energy", "normal_work", "friction_work", "damping_work"),
        *("external_work", "coupling_work", "closing_work"),
    ):
        expected = getattr(first, name)
        largest = np.abs(expected).max(initial=0.0)
        assert getattr(second, name) == pytest.approx(expected, abs=1e-9 * largest), name
    assert np.array_equal(first.contact_steps, second.contact_steps)

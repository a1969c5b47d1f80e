"""Marches with a support that fuses, against two marches joined at the instant."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from places import EXAMPLES

from bladewhirl.models.case.file import read_case, with_values
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.beams import Beams
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.checkpoint import state_arrays, state_from
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.solvers.march.sudden_changes import ChangingState, make_scheme
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.verification.bodies import ledger_residual

ALL_MODES = {
    "bladed_disk.blades": 7,
    "bladed_disk.elements_per_blade": 3,
    "reduction.fixed_interface_modes": 110,
    "casing.clearance": "50 mm",
    "excitation.ramp": 0.0,
    "excitation.clearance_speed": None,
    "excitation.unbalance": "200 kg mm",
    "damping.ratio": 0.0,
    "march.record_step": "50 us",
    "march.duration": "0.02 s",
    "march.speed": "265 rad/s",
}
FUSE = {"shaft.fuse_force": "20 kN", "shaft.fused_stiffness": "10 MN/m"}


def stage_of(changes: dict[str, Any]) -> Beams:
    case = read_case(EXAMPLES / "imbalance.toml")
    return build_beams(with_values(case, ALL_MODES | changes))


def marched(given: ContactProblem, steps: int, every: int) -> tuple[ChangingState, Chunk]:
    scheme = make_scheme(given, 1e-6, every)
    state, chunk, end = scheme.advance(scheme.init(), steps)
    assert end is None
    return state, chunk


@pytest.mark.slow
@pytest.mark.parametrize("effects", ["none", "full"])
def test_a_support_that_fuses_is_two_marches_joined(effects: str) -> None:
    turning = {"rotation.effects": effects}
    stage, other = stage_of(turning | FUSE), stage_of(turning | {"shaft.stiffness": "10 MN/m"})
    problem, softer = contact_problem(stage), contact_problem(other)
    assert problem.fuse is not None
    state, chunk = marched(problem, 12001, 1)
    at = state.fused_step
    assert 100 < at < 10000
    whole = marched(replace(problem, fuse=None, loss=None), at + 2, 1)[1]
    force = 3.4e7 * np.hypot(*(whole.rotor_displacement @ problem.rotor.centre.T).T)
    assert np.flatnonzero(force > 20e3)[0] == at
    np.testing.assert_array_equal(chunk.rotor_displacement[:at], whole.rotor_displacement[:at])
    fields = (
        stage.reduction.modes.shapes
        @ np.array([chunk.rotor_displacement[at], chunk.rotor_velocity[at]]).T
    )
    own = other.reduction.modes.shapes.T @ (other.disk.structure.mass @ fields)
    start = replace(softer.start, rotor=own[:, 0], rotor_velocity=own[:, 1])
    second = marched(replace(softer, start=start), 12001 - at, 1)[1]
    centre = second.rotor_displacement @ softer.rotor.centre.T
    found = chunk.rotor_displacement[at:] @ problem.rotor.centre.T
    assert np.abs(found).max() > 2.0 * np.abs(found[0]).max()
    np.testing.assert_allclose(found, centre, atol=1e-9 * np.abs(centre).max())
    assert ledger_residual(chunk) < 1e-8


@pytest.mark.slow
def test_a_support_fuses_after_a_blade_is_lost_and_the_march_is_resumed() -> None:
    loss = {"blade_loss": {"blade": 2, "time": 0.004}, "rotation.effects": "full"}
    quiet = {"excitation.unbalance": "20 kg mm", "casing.clearance": "0.5 mm"}
    problem = contact_problem(stage_of(FUSE | loss | quiet | {"damping.ratio": 0.01}))
    state, chunk = marched(problem, 12001, 50)
    assert state.phase == "both"
    assert 4000 < state.fused_step < 12000
    assert chunk.contact_impulse.any()
    assert ledger_residual(chunk) < 1e-8
    for stop in (state.fused_step - 3, state.fused_step, state.fused_step + 7):
        scheme = make_scheme(problem, 1e-6, 50)
        half = scheme.advance(scheme.init(), stop)[0]
        rest = scheme.advance(state_from(scheme.init(), state_arrays(half)), 12001 - stop)[0]
        for name in ("rotor", "work"):
            np.testing.assert_array_equal(
                rest.arrays["both"][name][:2], state.arrays["both"][name][:2]
            )
    first = contact_problem(
        stage_of(
            loss
            | {"shaft.fuse_force": "10 kN", "shaft.fused_stiffness": 1e7}
            | {"blade_loss": {"blade": 2, "time": 0.009}}
        )
    )
    state, chunk = marched(first, 12001, 50)
    assert state.phase == "both"
    assert state.fused_step < 9000
    assert ledger_residual(chunk) < 1e-8


def test_energy_while_the_speed_is_free() -> None:
    drive = {"march.drive": {"inertia": 1.0}, "rotation.effects": "full", "damping.ratio": 0.01}
    moving = {"initial.centre_velocity": [0.5, 0.0]}
    problem = contact_problem(stage_of(FUSE | drive | moving))
    state, chunk = marched(problem, 12001, 50)
    assert state.fused_step > 0
    energy = chunk.energy + chunk.rotor_energy + chunk.damping_work - chunk.braking_work
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


def test_a_run_states_the_instant() -> None:
    result, report = march_in_memory(prepare(stage_of(FUSE).case))
    assert 0.0 < report["fuse_time"] < 0.02
    assert result.attrs["fuse_time"] == report["fuse_time"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"shaft.fuse_force": 1e4}, "shaft.fused_stiffness: expected a value with shaft.fuse"),
        ({"shaft.fused_stiffness": 1e4}, "shaft.fuse_force: expected a value with shaft.fused"),
        (FUSE | {"shaft.clamped": True}, "expected springs, shaft.clamped = false"),
        (FUSE | {"coupling.stiffness": 1e5}, "expected 0 with shaft.fuse_force"),
        (
            FUSE | {"shaft.stiffness_y": 3e7, "shaft.frame": "static"},
            'expected equal springs or shaft.frame = "rotating"',
        ),
        (
            FUSE | {"initial.centre_displacement": [2e-3, 0.0]},
            "expected more than 6.8e+04 N, the force at the start",
        ),
    ],
)
def test_refusals(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(CaseError) as error:
        contact_problem(stage_of(changes))
    assert message in str(error.value)

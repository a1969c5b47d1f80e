"""Responses to engine-order forces, compared with closed-form solutions, the full model and the
march."""

from typing import Any

import numpy as np
import scipy.sparse.linalg as spla

from bladewhirl.meshes.ring_mesh import W
from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.file import with_values
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.engine_order import unit_forces
from bladewhirl.models.stage.mass_scaling import screening_cut, with_scaled_casing
from bladewhirl.postprocess.modal.response import amplitude, by_nodal_diameter
from bladewhirl.studies.modal.response import response
from bladewhirl.studies.verification.bodies import default_stage, marched
from bladewhirl.studies.verification.case import Pair, verifies

BLADES, DAMPING, TIME_STEP = 8, 0.2, 4e-6
MISTUNED = [1.0, 1.03, 0.98, 1.01, 0.97, 1.02, 0.99, 1.005]
SETTLED, LAST, RECORD = 75_000, 84_999, 25
"""Step at which the start has decayed, last step, and steps between records."""


def forced(order: int, *, damping: float = DAMPING, tuned: bool = True, **tables: Any) -> Case:
    """Return a case with small blades, a large clearance and forces of one engine order."""
    blades: dict[str, Any] = {"blades": BLADES, "elements_per_blade": 3}
    if not tuned:
        blades["mistuning"] = {"stiffness": MISTUNED}
    return case_from(
        {
            "bladed_disk": blades,
            "casing": {"clearance": "50 mm"},
            "damping": {"ratio": damping},
            "excitation": {"type": "engine-order", "order": order, "amplitude": 2.0},
            "march": {"speed": 0.9, "time_step": TIME_STEP},
            **tables,
        }
    )


@verifies(1, 3, 4, 5, 11)
def aliased_nodal_diameter(order: int) -> Pair:
    """Compare the share of the aliased nodal diameter in the mean square of the tips with 1."""
    square = by_nodal_diameter(response(forced(order))).values[0] ** 2
    alias = min(order % BLADES, -order % BLADES)
    return 1.0, square[alias] / square.sum()


@verifies()
def response_of_full_model() -> Pair:
    """Compare the undamped response of a stage with the response computed from the dynamic
    stiffness of its full model."""
    case = forced(3, damping=0.0, tuned=False)
    stage = build_beams(case)
    structure, disk = stage.disk.structure, stage.disk
    assert isinstance(case.excitation, EngineOrder)
    factors = case.excitation.amplitude * np.exp(3j * disk.tip_angles)
    force = factors @ unit_forces(case, disk, case.excitation)
    dynamic = (structure.stiffness - (3.0 * stage.speed) ** 2 * structure.mass).tocsc()
    expected = spla.splu(dynamic.astype(np.complex128)).solve(force)[disk.tip_tangential]
    computed = response(stage)["tip_tangential"].values[0]
    return _parts(expected), _parts(computed)


@verifies("none", "full")
def march_with_engine_order(effects: str) -> Pair:
    """Compare the steady motion of the mistuned tips in the march with the response."""
    stage = build_beams(forced(2, tuned=False, rotation={"effects": effects}))
    chunk = marched(contact_problem(stage), TIME_STEP, LAST, every=RECORD)
    late = chunk.step >= SETTLED
    phase = 2.0 * stage.speed * chunk.time[late]
    waves = np.column_stack([np.cos(phase), -np.sin(phase)])
    tips = chunk.rotor_displacement[late] @ stage.rotor.tip_tangential.T
    cosine, sine = np.linalg.lstsq(waves, tips, rcond=None)[0]
    return _parts(response(stage)["tip_tangential"].values[0]), np.concatenate([cosine, sine])


@verifies()
def bound_of_whitehead() -> Pair:
    """Compare with zero the excess of an amplitude ratio over Whitehead's bound (1 + sqrt N) / 2
    for N blades. The ratio is the largest amplitude with different blades divided by that with
    equal blades."""
    speeds = np.linspace(0.4, 0.6, 101).tolist()
    mistuned, tuned = (
        float(amplitude(response(forced(2, damping=0.005, tuned=tuned), speeds=speeds)).max())
        for tuned in (False, True)
    )
    return 0.0, max(0.0, mistuned / tuned - 0.5 * (1.0 + np.sqrt(BLADES)))


@verifies()
def bound_for_a_thousand_patterns() -> Pair:
    """Compare with zero the excess over Whitehead's bound of the largest amplitude ratio of 1,000
    patterns of blade stiffness with a standard deviation of 1 %."""
    speeds = np.linspace(0.494, 0.516, 23).tolist()  # around the resonance of the tuned stage
    tuned = forced(2, damping=0.005)
    patterns = (
        with_values(tuned, {"bladed_disk.mistuning": {"stiffness_spread": 0.01, "seed": seed}})
        for seed in range(1000)
    )
    smallest = float(amplitude(response(tuned, speeds=speeds)).max())
    largest = max(float(amplitude(response(each, speeds=speeds)).max()) for each in patterns)
    return 0.0, max(0.0, largest / smallest - 0.5 * (1.0 + np.sqrt(BLADES)))


@verifies()
def static_answer_of_scaled_masses() -> Pair:
    """Compare the deflections of the wall with scaled masses and with true masses, for the paper's
    stage under unit forces at the nodes of the wall."""
    problem = default_stage({})
    scaled = with_scaled_casing(problem, screening_cut(problem))
    expected, computed = (
        each.casing.nodal[:, W] / each.casing.frequency**2 @ each.casing.nodal[:, W].T
        for each in (problem, scaled)
    )
    return expected, computed


def _parts(values: Any) -> Any:
    """Return the real parts and then the imaginary parts."""
    return np.concatenate([np.real(values), np.imag(values)])

"""Small contact problems with known answers, and what tests ask of any march."""

from dataclasses import replace
from functools import cache
from typing import Any, Literal

import numpy as np
from reference_march import Reference

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import Chunk, EndReason, KernelState
from bladewhirl.studies.verification.bodies import (
    FAR,
    Bar,
    ledger_residual,
    problem,
    small_casing,
    small_rotor,
    wall,
)

__all__ = [
    "FAR",
    "Bar",
    "assert_same",
    "ledger_residual",
    "problem",
    "random_problem",
    "run",
    "run_as_reference",
    "run_reference",
    "small_casing",
    "small_problem",
    "small_rotor",
    "stage_problem",
    "thrown",
    "wall",
]


def thrown(
    given: ContactProblem, outward: float | FloatArray, spread: float = 0.0
) -> ContactProblem:
    """Return the problem with initial outward velocities of the tips [m/s], with random scatter."""
    tips = len(given.rotor.tip_angle)
    expected = outward * (1.0 + spread * np.random.default_rng(0).normal(size=tips))
    velocity = np.linalg.lstsq(given.rotor.tip_radial, expected, rcond=None)[0]
    start = replace(given.start, rotor_velocity=np.asarray(velocity, dtype=np.float64))
    return replace(given, start=start)


def run(
    given: ContactProblem, dt: float, steps: int, *, every: int = 1, cyclic: bool = True
) -> tuple[KernelState, Chunk, EndReason | None]:
    """March, and record x_0 .. x_steps every so many steps."""
    scheme = CentralDifference(given, dt, every, cyclic=cyclic)
    return scheme.advance(scheme.init(), steps + 1)


def run_reference(
    given: ContactProblem, dt: float, steps: int, *, dampers_feel_contact: bool = False
) -> Chunk:
    """x_0 .. x_steps by the march in plain NumPy."""
    scheme = Reference(given, dt, 1, dampers_feel_contact=dampers_feel_contact)
    return scheme.advance(scheme.init(), steps + 1)[1]


IMPULSES = ("contact_impulse", "friction_impulse")
"""Contact magnifies rounding; the impulses of single steps show it most, by this:"""

MAGNIFICATION = 100.0


def assert_same(found: Chunk, expected: Chunk, tolerance: float = 1e-9) -> None:
    """All that the expected march recorded is the same in the other, but for rounding.

    Energy and works are compared by the largest of them, so are both impulses.
    """
    values, expected_values = (_values(chunk) for chunk in (found, expected))
    energies = ("energy", *(name for name in expected_values if name.endswith("work")))
    for field in (name for name, values in expected_values.items() if np.size(values)):
        family = next((names for names in (energies, IMPULSES) if field in names), None)
        largest = max(np.abs(expected_values[name]).max(initial=0.0) for name in family or [field])
        size = largest * tolerance * (MAGNIFICATION if family is IMPULSES else 1.0)
        np.testing.assert_allclose(
            values[field], expected_values[field], rtol=0.0, atol=size, err_msg=field
        )


def _values(chunk: Chunk) -> dict[str, FloatArray]:
    values = dict(vars(chunk))
    coating = values.pop("coating")
    return values | ({} if coating is None else vars(coating))


def run_as_reference(
    given: ContactProblem, dt: float, steps: int, *, cyclic: bool = True
) -> tuple[KernelState, Chunk]:
    """March with contact, every step being the one that plain NumPy takes."""
    expected = run_reference(given, dt, steps)
    assert expected.contact_impulse.any()
    state, chunk, _ = run(given, dt, steps, cyclic=cyclic)
    assert_same(chunk, expected)
    return state, chunk


def small_problem(**tables: Any) -> ContactProblem:
    """A stage of five blades without a load; `tables` replaces tables of the case."""
    small: dict[str, Any] = {
        "bladed_disk": {"blades": 5},
        "casing": {},
        "reduction": {"fixed_interface_modes": 10},
        "excitation": {"type": "none"},
    }
    case = small | tables
    case["casing"] = {"elements": 12} | case["casing"]
    return contact_problem(build_beams(Case(**case)))


@cache
def stage_problem(blades: int = 22, elements: int = 40) -> ContactProblem:
    """The paper's stage for contact simulations, its casing struck by the distortion load."""
    case = Case.model_validate(
        {
            "bladed_disk": {"blades": blades},
            "casing": {"elements": elements, "support": 7.975e6},
            "excitation": {"type": "casing-distortion"},
            "reduction": {"fixed_interface_modes": 5 * blades},
        }
    )
    return contact_problem(build_beams(case))


def random_problem(
    seed: int,
    *,
    tips: int = 4,
    nodes: int = 5,
    rotor_modes: int = 7,
    casing_modes: int = 6,
    speed: float = 90.0,
    friction: float = 0.05,
    sliding: Literal["permanent", "signed"] = "permanent",
    tip_rotation: bool = False,
) -> ContactProblem:
    """Two bodies without any symmetry, thrown at each other; time steps of 1e-4 s suit them."""
    random = np.random.default_rng(seed)
    radial = random.normal(size=(tips, rotor_modes))
    rotor = small_rotor(
        random.uniform(0.0, 3000.0, rotor_modes),
        tips,
        damping_ratio=random.uniform(0.0, 0.05, rotor_modes),
        tip_radial=radial,
        tip_tangential=random.normal(size=(tips, rotor_modes)),
        centre=random.normal(size=(2, rotor_modes)),
        tip_angle=np.sort(random.uniform(0.0, 2.0 * np.pi, tips)),
        tip_radius=0.5,
        contact_radius=np.full(tips, 0.5),
        tip_recess=np.random.default_rng([seed, 1]).uniform(-2e-4, 4e-4, tips),
    )
    clearance = np.column_stack(
        [random.uniform(5e-4, 1.5e-3, nodes), random.normal(scale=1e-4, size=nodes)]
    )
    casing = replace(
        small_casing(random.uniform(0.0, 3000.0, casing_modes), nodes=nodes),
        damping_ratio=random.uniform(0.0, 0.05, casing_modes),
        nodal=random.normal(size=(nodes, 4, casing_modes)),
        clearance=clearance,
        radius=0.501,
    )
    loads = (
        Load(
            rotor=random.normal(scale=100.0, size=rotor_modes),
            casing=random.normal(scale=100.0, size=casing_modes),
            frequency=300.0,
            phase=0.7,
            ramp=0.005,
        ),
        Load(rotor=3e3 * radial.sum(axis=0) / tips, casing=np.zeros(casing_modes), end=0.0051),
    )
    start = {
        "rotor": random.normal(scale=1e-5, size=rotor_modes),
        "rotor_velocity": random.normal(scale=0.3, size=rotor_modes),
        "casing": random.normal(scale=1e-5, size=casing_modes),
        "casing_velocity": random.normal(scale=0.3, size=casing_modes),
    }
    return problem(
        rotor,
        casing,
        start=start,
        loads=loads,
        speed=speed,
        friction=friction,
        sliding=sliding,
        tip_rotation=tip_rotation,
    )

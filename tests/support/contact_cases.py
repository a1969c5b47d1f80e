"""Small contact problems with known answers, and what tests ask of any march."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from functools import cache
from typing import Any, Literal

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import (
    ContactProblem,
    Load,
    ReducedCasing,
    ReducedRotor,
    at_rest,
)
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.solvers.march.central_difference import CentralDifference, CentralDifferenceState
from bladewhirl.solvers.march.march import Chunk, EndReason
from bladewhirl.solvers.march.reference import Reference

FAR = 1e3
"""A displacement limit out of reach [m]."""


def small_rotor(frequency: FloatArray, tips: int = 1, **rows: Any) -> ReducedRotor:
    """Undamped rotor with tips at angle 0 that no mode moves, but for the rows given."""
    modes = len(frequency)
    body = ReducedRotor(
        frequency=frequency,
        damping_ratio=np.zeros(modes),
        tip_radial=np.zeros((tips, modes)),
        tip_tangential=np.zeros((tips, modes)),
        centre=np.zeros((2, modes)),
        tip_angle=np.zeros(tips),
        tip_radius=1.0,
        tip_recess=np.zeros(tips),
        column=np.full(modes, -1),
        dampers=np.zeros((0, modes)),
    )
    return replace(body, **rows)


def small_casing(
    frequency: FloatArray, clearance: float = 0.0, nodes: int = 4, **rows: Any
) -> ReducedCasing:
    """Undamped casing of 1 m that no mode moves, but for the rows given."""
    modes = len(frequency)
    body = ReducedCasing(
        frequency=frequency,
        damping_ratio=np.zeros(modes),
        nodal=np.zeros((nodes, 4, modes)),
        clearance=np.tile([clearance, 0.0], (nodes, 1)),
        radius=1.0,
        column=np.full(modes, -1),
        dampers=np.zeros((0, modes)),
    )
    return replace(body, **rows)


def wall(clearance: float, nodes: int = 4) -> ReducedCasing:
    """A rigid casing, of one mode that moves nothing."""
    return small_casing(np.ones(1), clearance, nodes)


def problem(
    rotor: ReducedRotor,
    casing: ReducedCasing,
    *,
    start: Mapping[str, FloatArray] | None = None,
    loads: tuple[Load, ...] = (),
    speed: float = 0.0,
    friction: float = 0.0,
    sliding: Literal["permanent", "signed"] = "permanent",
    tip_rotation: bool = False,
    displacement_limit: float = FAR,
) -> ContactProblem:
    """A contact problem, without friction, at standstill and from rest unless said."""
    return ContactProblem(
        rotor=rotor,
        casing=casing,
        speed=speed,
        friction=friction,
        sliding=sliding,
        tip_rotation=tip_rotation,
        displacement_limit=displacement_limit,
        loads=loads,
        start=replace(at_rest(rotor, casing), **(start or {})),
    )


def run(
    given: ContactProblem, dt: float, steps: int, *, every: int = 1, cyclic: bool = True
) -> tuple[CentralDifferenceState, Chunk, EndReason | None]:
    """March, and record x_0 .. x_steps every so many steps."""
    scheme = CentralDifference(given, dt, every, cyclic=cyclic)
    return scheme.advance(scheme.init(), steps + 1)


def run_reference(
    given: ContactProblem, dt: float, steps: int, *, dampers_feel_contact: bool = False
) -> Chunk:
    """x_0 .. x_steps by the march in plain NumPy."""
    scheme = Reference(given, dt, 1, dampers_feel_contact=dampers_feel_contact)
    return scheme.advance(scheme.init(), steps + 1)[1]


MAGNIFIED = {"contact_impulse": 100.0, "friction_impulse": 100.0, "coupling_work": 1e3}
"""Contact magnifies rounding; the impulses of single steps, and small sums, show it most."""


def assert_same(found: Chunk, expected: Chunk, tolerance: float = 1e-9) -> None:
    """All that two marches recorded is the same, but for rounding."""
    for field in fields(Chunk):
        exact = getattr(expected, field.name)
        size = np.abs(exact).max() * tolerance * MAGNIFIED.get(field.name, 1.0)
        np.testing.assert_allclose(
            getattr(found, field.name), exact, rtol=0.0, atol=size, err_msg=field.name
        )


def run_as_reference(
    given: ContactProblem, dt: float, steps: int
) -> tuple[CentralDifferenceState, Chunk]:
    """March with contact, every step being the one that plain NumPy takes."""
    expected = run_reference(given, dt, steps)
    assert expected.contact_impulse.any()
    state, chunk, _ = run(given, dt, steps)
    assert_same(chunk, expected)
    return state, chunk


def thrown(
    given: ContactProblem, outward: float | FloatArray, spread: float = 0.0
) -> ContactProblem:
    """The same problem, its tips thrown outward at these speeds [m/s], spread at random."""
    tips = len(given.rotor.tip_angle)
    wanted = outward * (1.0 + spread * np.random.default_rng(0).normal(size=tips))
    velocity = np.linalg.lstsq(given.rotor.tip_radial, wanted, rcond=None)[0]
    start = replace(given.start, rotor_velocity=np.asarray(velocity, dtype=np.float64))
    return replace(given, start=start)


def ledger_residual(chunk: Chunk) -> float:
    """Largest mismatch of energy and work, by the largest term."""
    work = chunk.external_work + chunk.normal_work + chunk.friction_work + chunk.coupling_work
    mismatch = (chunk.energy - chunk.energy[0]) - (work - chunk.damping_work)
    terms = [
        chunk.energy,
        chunk.external_work,
        chunk.normal_work,
        chunk.friction_work,
        chunk.damping_work,
        chunk.coupling_work,
    ]
    return float(np.abs(mismatch).max() / max(np.abs(term).max() for term in terms))


class Bar:
    """Free bar of linear elements with consistent mass, in all its modes; it lies along r."""

    def __init__(
        self, *, length: float, area: float, young_modulus: float, density: float, elements: int
    ) -> None:
        h = length / elements
        size = elements + 1
        diagonal = np.full(size, 2.0)
        diagonal[[0, -1]] = 1.0
        beside = np.ones(elements)
        stiffness = np.diag(diagonal) - np.diag(beside, 1) - np.diag(beside, -1)
        mass = np.diag(2.0 * diagonal) + np.diag(beside, 1) + np.diag(beside, -1)
        square, shapes = la.eigh(
            young_modulus * area / h * stiffness, density * area * h / 6.0 * mass
        )
        square[0] = 0.0  # the rigid motion
        self.mass = density * area * length
        self.frequency = np.sqrt(square)
        self.shapes = shapes
        self.rigid = shapes.T @ (density * area * h / 6.0 * mass @ np.ones(size))
        self.time_step = 0.9 * 2.0 / self.frequency[-1]

    def as_rotor(self) -> ReducedRotor:
        """Its outer end is the tip."""
        return small_rotor(self.frequency, tip_radial=self.shapes[-1:])

    def as_casing(self, gap: float) -> ReducedCasing:
        """Its inner end is all nodes of a casing."""
        nodal = np.zeros((4, 4, len(self.frequency)))
        nodal[:, 0] = self.shapes[0]
        return small_casing(self.frequency, gap, nodal=nodal)


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
    return contact_problem(build_stage(case))


def without_symmetry(given: ContactProblem, *, rotor: bool, casing: bool) -> ContactProblem:
    """The same problem with modes that carry no DFT columns."""
    if rotor:
        column = np.full_like(given.rotor.column, -1)
        given = replace(given, rotor=replace(given.rotor, column=column))
    if casing:
        column = np.full_like(given.casing.column, -1)
        given = replace(given, casing=replace(given.casing, column=column))
    return given


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
        Load(
            rotor=3e3 * radial.sum(axis=0) / tips,
            casing=np.zeros(casing_modes),
            end=0.0051,
        ),
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

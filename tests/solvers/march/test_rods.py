"""Abradable coating under many contact nodes, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from boundary_cases import (
    CLEARANCE,
    HARD,
    THICK,
    YIELD,
    E,
    advanced,
    casing,
    coating,
    ledger,
    rubbing,
)

from bladewhirl.models.case.closure import Closure
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.wall import ReducedCasing, WallClosure


def still_node(*depths: float, footprint: float = 0.01) -> ContactProblem:
    """A node that hardly moves, into which a coated wall comes to depths, one after another."""
    wall = np.column_stack([np.full(64, CLEARANCE), np.zeros(64)])
    table = [(0.0, 0.0)]
    for n, depth in enumerate(depths):
        table += [(0.01 * n + 0.005, CLEARANCE + depth), (0.01 * n + 0.01, 0.0)]
    worn = coating(np.zeros(1), footprint)
    closure = WallClosure(course=Closure(table=tuple(table)), share=wall * 0.0 + [1.0, 0.0])
    return ContactProblem(
        rotor=ReducedRotor.of_copies(
            frequency=np.linspace(900.0, 3e4, 8)[None],
            damping_ratio=np.zeros((1, 8)),
            contact=np.zeros((3, 8)),
            compliance=1e-15 * np.eye(3)[None],
            angle=np.full((1, 1), 0.3),
            radius=np.full(1, 0.3),
            recess=np.zeros(1),
            tip_radius=0.3,
        ),
        casing=ReducedCasing.rigid(wall, 0.3),
        speed=0.0,
        friction=0.0,
        sliding="permanent",
        tip_rotation=False,
        displacement_limit=1.0,
        loads=(),
        start=Start.of_rotor(*np.zeros((2, 8))),
        closure=closure,
        coating=worn,
    )


def test_an_intrusion_has_the_closed_form_and_its_repetition_removes_nothing() -> None:
    depth = 1e-4
    chunk = advanced(still_node(depth, depth), 1e-5, 2001)
    worn = chunk.coating
    assert worn is not None
    strain = worn.coating_strain[-1, 0]
    touched = strain > 0.0
    under = 0.01 / (2.0 * np.pi * 0.3 / 720)
    assert abs(touched.sum() - under) <= 1.0
    expected = (E * depth / THICK - YIELD) / (E + HARD)
    assert strain[touched] == pytest.approx(expected, rel=1e-6)
    volume = touched.sum() * 2.0 * np.pi * 0.3 / 720 * 5e-3 * THICK
    assert worn.wear_volume[-1] == pytest.approx(volume * expected, rel=1e-6)
    loss = volume * (YIELD + 0.5 * HARD * expected) * expected
    assert worn.wear_dissipated[-1] == pytest.approx(loss, rel=1e-6)
    assert worn.wear_volume[1000] == pytest.approx(worn.wear_volume[-1], rel=1e-12)
    peak = -chunk.contact_force[:, 0, 0].min()
    stress = YIELD + HARD * expected
    assert peak == pytest.approx(volume / THICK * stress, rel=1e-3)
    assert chunk.contact_impulse.sum() == pytest.approx(worn.coating_impulse.sum())


def test_rods_are_touched_where_a_short_closure_is_steep() -> None:
    """The wall is even, but a closure of some milliseconds leaves a narrow ridge beside a node."""
    problem = still_node(1e-4, footprint=0.2)
    grid = 2.0 * np.pi / 64 * np.arange(64)
    share = np.column_stack([np.cos(8 * grid), -8.0 * np.sin(8 * grid) / 0.3])
    assert problem.closure is not None
    ridged = replace(problem, closure=replace(problem.closure, share=share))
    worn = advanced(ridged, 1e-5, 1001).coating
    assert worn is not None
    most = CLEARANCE + 1e-4
    middle = 2.0 * np.pi * (np.arange(720) + 0.5) / 720
    under = np.abs(np.angle(np.exp(1j * (middle - 0.3)))) * 0.3 <= 0.1
    depth = most * np.cos(8 * middle) - CLEARANCE
    expected = np.maximum(0.0, (E * depth / THICK - YIELD) / (E + HARD)) * under
    assert expected.max() > 0.02
    assert worn.coating_strain[-1, 0] == pytest.approx(expected, abs=1e-2 * expected.max())


def test_a_stiff_ring_is_a_rigid_wall() -> None:
    ring = casing(24, support=1e12, thickness=0.2, width=10.0)
    even = np.column_stack([np.full(24, CLEARANCE), np.zeros(24)])
    rigid = replace(rubbing(), casing=ReducedCasing.rigid(even, 0.3))
    start = Start.of_rotor(rigid.start.rotor, rigid.start.rotor_velocity, len(ring.frequency))
    soft = replace(rigid, casing=ring, start=start)
    dt = 0.5 * min(soft.critical_time_step, 4e-6)
    expected, chunk = (advanced(given, dt, round(6e-4 / dt)) for given in (rigid, soft))
    assert expected.coating is not None
    assert chunk.coating is not None
    removed = expected.coating.wear_volume[-1]
    assert removed > 1e-10
    assert chunk.coating.wear_volume[-1] == pytest.approx(removed, rel=2e-3)
    assert ledger(chunk) < 1e-9

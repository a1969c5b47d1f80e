"""Abradable coating under many contact nodes, against closed forms and plain NumPy."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.optimize as so

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.closure import Closure
from bladewhirl.models.stage.boundary_problem import BoundaryProblem
from bladewhirl.models.stage.contact_problem import NodeCoating, WallClosure
from bladewhirl.models.stage.ring import flexible_ring
from bladewhirl.solvers.march.boundary import BoundaryChunk, BoundaryMarch
from bladewhirl.solvers.march.march import CoatingRecords

E, YIELD, HARD, THICK, LIMIT = 1e9, 1e7, 5e7, 2e-3, 0.9
CLEARANCE = 2e-4


def coating(tracks: FloatArray, footprint: FloatArray, *, rods: int = 720, **changes: Any) -> Any:
    axial = np.unique(tracks)
    values: dict[str, Any] = {
        "strain": np.zeros((len(axial), rods)),
        "axial": axial,
        "width": np.full(len(axial), 5e-3),
        "track": np.searchsorted(axial, tracks),
        "footprint": footprint,
        "radius": 0.3,
        "thickness": THICK,
        "young_modulus": E,
        "yield_stress": YIELD,
        "hardening": HARD,
        "limit": LIMIT,
    }
    return NodeCoating(**(values | changes))


def advanced(problem: BoundaryProblem, dt: float, steps: int) -> tuple[BoundaryChunk, Any]:
    scheme = BoundaryMarch(problem, dt, 1)
    state, chunk, end = scheme.advance(scheme.init(), steps + 1)
    assert end is None
    assert state.statistics.lcp_failures == 0
    assert isinstance(chunk.coating, CoatingRecords)
    return chunk, chunk.coating


def still_node(depths: list[float]) -> BoundaryProblem:
    """Return a node that hardly moves, into which the wall comes to depths, one after another."""
    wall = np.column_stack([np.full(64, CLEARANCE), np.zeros(64)])
    table = [(0.0, 0.0)]
    for n, depth in enumerate(depths):
        table += [(0.01 * n + 0.005, CLEARANCE + depth), (0.01 * n + 0.01, 0.0)]
    worn = coating(np.zeros(1), np.full(1, 0.01))
    return BoundaryProblem(
        frequency=np.full((1, 1), 1e3),
        damping_ratio=np.zeros((1, 1)),
        contact=np.zeros((3, 1)),
        compliance=1e-15 * np.eye(3)[None],
        massless=True,
        angle=np.full((1, 1), 0.3),
        radius=np.full(1, 0.3),
        recess=np.full(1, worn.removable),
        wall=wall,
        speed=0.0,
        friction=0.0,
        full_sliding=False,
        displacement_limit=1.0,
        displacement=np.zeros((1, 1)),
        velocity=np.zeros((1, 1)),
        coating=worn,
        closure=WallClosure(
            course=Closure(table=tuple(table)), share=wall * [0.0, 0.0] + [1.0, 0.0]
        ),
    )


def test_an_intrusion_has_the_closed_form_and_its_repetition_removes_nothing() -> None:
    depth = 1e-4
    chunk, worn = advanced(still_node([depth, depth]), 1e-5, 2001)
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


def test_behind_the_coating_is_metal() -> None:
    problem = still_node([LIMIT * THICK + 1e-5])
    stiff = replace(problem, compliance=1e-9 * np.eye(3)[None])
    chunk, worn = advanced(stiff, 1e-5, 501)
    assert chunk.gap.min() == pytest.approx(0.0, abs=1e-12)
    assert chunk.contact_impulse.sum() > 1.01 * worn.coating_impulse.sum()


def rubbing(*, massless: bool) -> BoundaryProblem:
    """Return two blades of random modes that rub in an oval coated wall, with two tracks."""
    random = np.random.default_rng(3)
    nodes, modes = 4, 5
    square = random.standard_normal((3 * nodes, 3 * nodes))
    contact = random.standard_normal((3 * nodes, modes))
    contact[::3, 0] = 1.5
    grid = 2.0 * np.pi / 64 * np.arange(64)
    pitch = 0.02 * np.arange(nodes)
    worn = coating(np.array([0.0, 0.0, 1.0, 1.0]), np.full(nodes, 4e-3), limit=0.06)
    return BoundaryProblem(
        frequency=np.tile(np.linspace(900.0, 2e4, modes), (2, 1)),
        damping_ratio=np.full((2, modes), 0.01),
        contact=contact,
        compliance=np.tile(
            massless * 2e-9 * (square @ square.T / nodes + np.eye(3 * nodes)), (2, 1, 1)
        ),
        massless=massless,
        angle=np.array([pitch, np.pi + pitch]),
        radius=np.full(nodes, 0.3),
        recess=worn.removable + np.linspace(1e-5, -1e-5, nodes),
        wall=np.column_stack([CLEARANCE + 1e-4 * np.cos(2 * grid), -2e-4 * np.sin(2 * grid)]),
        speed=150.0,
        friction=0.1,
        full_sliding=False,
        displacement_limit=1.0,
        displacement=np.zeros((2, modes)),
        velocity=np.tile([0.8, *[0.0] * (modes - 1)], (2, 1)),
        coating=worn,
    )


def pressed(
    gap: float, worn: NodeCoating, track: int, plastic: FloatArray, offset: FloatArray
) -> tuple[float, FloatArray]:
    """Return the force of rods on a node at a gap to the metal, and their plastic strains."""
    depth = worn.removable - gap - offset
    trial = np.maximum(0.0, worn.young_modulus * (depth / worn.thickness - plastic))
    rise = np.maximum(0.0, trial - worn.yield_stress - worn.hardening * plastic)
    rise = rise / (worn.young_modulus + worn.hardening)
    rise = np.minimum(rise, np.maximum(0.0, worn.limit - plastic))
    stress = trial - worn.young_modulus * rise
    return float(worn.arc * worn.width[track] * stress.sum()), plastic + rise


def miss(gap: float, others: float, flexibility: float, *node: Any) -> float:
    """Return the error of a gap for given forces on the other nodes."""
    return gap - others - flexibility * pressed(gap, *node)[0]


def plain(p: BoundaryProblem, dt: float, steps: int) -> dict[str, FloatArray]:
    """March with NumPy: for one node at a time its gap is the root of a scalar equation."""
    worn = p.coating
    assert worn is not None
    copies, nodes = p.angle.shape
    rods, rows = worn.strain.shape[1], p.contact.reshape(nodes, 3, -1)
    drag = p.damping_ratio * p.frequency / dt
    now, strain = p.displacement, worn.strain.copy()
    old = now - dt * p.velocity - dt**2 * p.damping_ratio * p.frequency * p.velocity
    force = np.zeros((copies, nodes, 3))
    out: dict[str, Any] = {"force": [], "volume": []}
    grid = 2.0 * np.pi / len(p.wall)
    middle = 2.0 * np.pi * (np.arange(rods) + 0.5) / rods

    def wall(angle: Any) -> FloatArray:
        place = np.mod(angle, 2.0 * np.pi) / grid
        e = place.astype(int) % len(p.wall)
        x = place - np.floor(place)
        (a, da), (b, db) = p.wall[e].T, p.wall[(e + 1) % len(p.wall)].T
        cubic = (1 - x) ** 2 * (a * (1 + 2 * x) + grid * da * x)
        return np.asarray(cubic + x**2 * (b * (3 - 2 * x) - grid * db * (1 - x)))

    for step in range(steps + 1):
        volume = (strain.sum(axis=1) * worn.width).sum() * worn.arc * worn.thickness
        out["force"].append(force)
        out["volume"].append(volume)
        push = np.einsum("ikm,cik->cm", rows, force) if p.massless else 0.0
        inertia = 1.0 / dt**2 + drag
        new = (2.0 / dt**2 - p.frequency**2) * now + (drag - 1.0 / dt**2) * old + push
        new, after, grown = new / inertia, np.zeros_like(force), strain.copy()
        for copy in range(copies):
            flexible = p.compliance[copy] if p.massless else p.contact / inertia[copy] @ p.contact.T
            ways = np.tile([-1.0, -p.friction, 0.0], (nodes, 1))
            w = -np.einsum("iajb,jb->iaj", flexible.reshape(nodes, 3, nodes, 3), ways)[:, 0]
            angle = p.angle[copy] + p.speed * (step + 1) * dt
            free = wall(angle) + p.recess - (rows @ new[copy])[:, 0]
            apart = np.abs(np.angle(np.exp(1j * (middle - angle[:, None])))) * worn.radius
            under = apart <= 0.5 * worn.footprint[:, None]

            places = [np.flatnonzero(row) for row in under]
            offsets = [wall(middle[h]) - wall(angle[i : i + 1]) for i, h in enumerate(places)]
            plastic = [strain[worn.track[i], here] for i, here in enumerate(places)]
            normal, gap = np.zeros(nodes), free.copy()
            for _ in range(60):
                for i in range(nodes):
                    others = free[i] + w[i] @ normal - w[i, i] * normal[i]

                    node = (worn, int(worn.track[i]), plastic[i], offsets[i])
                    if others + w[i, i] * pressed(0.0, *node)[0] < 0.0:  # metal
                        gap[i], normal[i] = 0.0, -others / w[i, i]
                    else:
                        top = max(others, 0.0) + w[i, i] * pressed(0.0, *node)[0] + 1e-6
                        gap[i] = so.brentq(miss, 0.0, top, (others, w[i, i], *node), xtol=1e-18)
                        normal[i] = pressed(gap[i], *node)[0]
                if np.abs(gap - free - w @ normal).max() < 1e-17:
                    break
            for i in range(nodes):
                node = (worn, int(worn.track[i]), plastic[i], offsets[i])
                grown[worn.track[i], places[i]] = pressed(gap[i], *node)[1]
            after[copy] = normal[:, None] * ways
        if not p.massless:
            new += np.einsum("ikm,cik->cm", rows, after) / inertia
        old, now, force, strain = now, new, after, grown
    return {name: np.array(values) for name, values in out.items()} | {"strain": strain}


@pytest.mark.parametrize("massless", [True, False])
def test_the_compiled_coating_is_that_of_plain_numpy(*, massless: bool) -> None:
    problem, dt, steps = rubbing(massless=massless), 4e-6, 250
    expected, (chunk, worn) = plain(problem, dt, steps), advanced(problem, dt, steps)
    force = chunk.contact_force.reshape(expected["force"].shape)
    assert force == pytest.approx(expected["force"], abs=1e-7 * np.abs(force).max())
    assert worn.wear_volume == pytest.approx(expected["volume"], rel=1e-7)
    strain = worn.coating_strain[-1]
    assert (worn.coating_impulse.sum(axis=0) < 0.99 * chunk.contact_impulse.sum(axis=0)).any()
    assert (strain > 0.0).any(axis=1).all()


def test_a_stiff_ring_is_a_rigid_wall() -> None:
    rigid = rubbing(massless=True)
    wall = {"thickness": 0.2, "width": 10.0}
    values = {"casing": {"elements": 24, "support": 1e12, "clearance": CLEARANCE, "wall": wall}}
    ring = flexible_ring(Case.model_validate(values)).reduced_casing
    even = np.column_stack([np.full(24, CLEARANCE), np.zeros(24)])
    grid = np.column_stack([np.full(64, CLEARANCE), np.zeros(64)])
    soft = replace(rigid, casing=ring, wall=even)
    dt = 0.5 * min(soft.critical_time_step, 4e-6)
    steps = round(6e-4 / dt)
    _, expected = advanced(replace(rigid, wall=grid), dt, steps)
    chunk, worn = advanced(soft, dt, steps)
    assert expected.wear_volume[-1] > 1e-10
    assert worn.wear_volume[-1] == pytest.approx(expected.wear_volume[-1], rel=2e-3)
    gained = chunk.normal_work + chunk.friction_work - chunk.damping_work
    error = np.abs(chunk.energy - chunk.energy[0] - gained).max()
    assert error < 1e-9 * chunk.energy.max()


def test_a_march_in_a_coating_can_be_split() -> None:
    problem, dt = rubbing(massless=True), 4e-6
    _, whole = advanced(problem, dt, 200)
    scheme = BoundaryMarch(problem, dt, 50)
    state, _, _ = scheme.advance(scheme.init(), 120)
    state, none, _ = scheme.advance(state, 20)  # without a record
    assert none.records == 0
    _, rest, _ = scheme.advance(state, 61)
    assert rest.coating is not None
    assert rest.coating.wear_volume[-1] == whole.wear_volume[-1]
    assert np.array_equal(rest.coating.coating_strain[-1], whole.coating_strain[-1])


def test_rods_are_touched_where_a_short_closure_is_steep() -> None:
    """The wall is even, but a closure of some milliseconds leaves a narrow ridge beside a node."""
    problem = still_node([1e-4])
    grid = 2.0 * np.pi / 64 * np.arange(64)
    share = np.column_stack([np.cos(8 * grid), -8.0 * np.sin(8 * grid)])
    assert problem.closure is not None
    ridged = replace(problem, closure=replace(problem.closure, share=share))
    whole = replace(ridged, coating=coating(np.zeros(1), np.full(1, 0.2)))
    _, worn = advanced(whole, 1e-5, 1001)
    most = CLEARANCE + 1e-4
    middle = 2.0 * np.pi * (np.arange(720) + 0.5) / 720
    under = np.abs(np.angle(np.exp(1j * (middle - 0.3)))) * 0.3 <= 0.1
    depth = most * np.cos(8 * middle) - CLEARANCE
    expected = np.maximum(0.0, (E * depth / THICK - YIELD) / (E + HARD)) * under
    assert expected.max() > 0.02
    assert worn.coating_strain[-1, 0] == pytest.approx(expected, abs=1e-2 * expected.max())

"""March of structures with many contact nodes in a flexible ring, against the march of beams, plain
NumPy and symmetries."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from contact_cases import stage_problem

from bladewhirl.meshes.hermite import cubic_weights
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.stage.boundary_problem import BoundaryLoad, BoundaryProblem
from bladewhirl.models.stage.contact_problem import ReducedCasing
from bladewhirl.models.stage.ring import flexible_ring
from bladewhirl.solvers.march.boundary import BoundaryChunk, BoundaryMarch
from bladewhirl.solvers.march.central_difference import CentralDifference

SPEED = 150.0


def advanced(problem: BoundaryProblem, dt: float, steps: int) -> BoundaryChunk:
    scheme = BoundaryMarch(problem, dt, 1)
    state, chunk, end = scheme.advance(scheme.init(), steps + 1)
    assert end is None
    assert state.statistics.lcp_failures == 0
    return chunk


def ledger(chunk: BoundaryChunk) -> float:
    gained = chunk.external_work + chunk.normal_work + chunk.friction_work - chunk.damping_work
    error = np.abs(chunk.energy - chunk.energy[0] - gained)
    return float(error.max() / np.abs(chunk.energy).max())


@cache
def casing(elements: int, *, support: float = 1e7) -> ReducedCasing:
    values: dict[str, Any] = {
        "casing": {
            "elements": elements,
            "clearance": 2e-4,
            "support": support,
            "wall": {"thickness": 5e-3, "width": 0.05},
        },
        "damping": {"ratio": 0.0},
    }
    return flexible_ring(Case.model_validate(values)).reduced_casing


def bladed(
    copies: int, nodes: int, ring: ReducedCasing, *, massless: bool, full: bool, first: float = 0.0
) -> BoundaryProblem:
    """Return equal blades of random modes that move outward into a flexible ring."""
    random = np.random.default_rng(7)
    modes = 8
    square = random.standard_normal((3 * nodes, 3 * nodes))
    flexibility = 3e-9 * (square @ square.T / nodes + np.eye(3 * nodes))
    contact = random.standard_normal((3 * nodes, modes))
    contact[::3, 0] = np.linspace(1.4, 1.6, nodes)
    pitch = 2.0 * np.pi / copies * np.arange(copies)
    return BoundaryProblem(
        frequency=np.tile(np.linspace(900.0, 3e4, modes), (copies, 1)),
        damping_ratio=np.full((copies, modes), 0.002),
        contact=contact,
        compliance=np.tile(massless * flexibility, (copies, 1, 1)),
        massless=massless,
        angle=first + pitch[:, None] + np.linspace(-0.06, 0.06, nodes),
        radius=np.full(nodes, ring.radius),
        recess=np.linspace(2e-5, -2e-5, nodes),
        wall=ring.clearance * [1.0, ring.radius],
        speed=SPEED,
        friction=0.1,
        full_sliding=full,
        displacement_limit=1.0,
        displacement=np.zeros((copies, modes)),
        velocity=(1.0 + 0.5 * np.cos(pitch - 0.4))[:, None] * np.eye(modes)[0],
        casing=ring,
    )


def under_nodes(ring: ReducedCasing, angle: FloatArray) -> FloatArray:
    """Return w and u of the ring at angles for unit modal coordinates, (2, angles, modes)."""
    nodes = len(ring.nodal)
    place = np.mod(angle * nodes / (2.0 * np.pi), nodes)
    element = place.astype(int) % nodes
    weight = cubic_weights(place - np.floor(place), ring.element_length)
    ends = np.concatenate([ring.nodal[element], ring.nodal[(element + 1) % nodes]], axis=1)
    radial, tangential = ends[:, [0, 1, 4, 5]], ends[:, [2, 3, 6, 7]]
    return np.asarray(np.einsum("qn,knqm->knm", weight, np.array([radial, tangential])))


def plain(p: BoundaryProblem, dt: float, steps: int) -> Mapping[str, FloatArray]:
    """March with NumPy only: dense products, Gauss-Seidel iterations for all nodes together."""
    ring = p.casing
    assert ring is not None
    copies, nodes = p.angle.shape
    rows, count = p.contact.reshape(nodes, 3, -1), copies * nodes
    drag, lost = p.damping_ratio * p.frequency / dt, ring.damping_ratio * ring.frequency / dt
    now, slow = p.displacement, np.zeros(len(ring.frequency))
    old, slow_old = now - dt * p.velocity - 0.5 * dt**2 * p.frequency**2 * now, slow
    old = old - dt**2 * p.damping_ratio * p.frequency * p.velocity
    force, direction = np.zeros((count, 3)), np.tile([np.sign(p.speed), 0.0], (count, 1))
    out: dict[str, list[FloatArray]] = {"force": [], "q": [], "casing": []}
    for step in range(steps + 1):
        for name, value in {"force": force, "q": now, "casing": slow}.items():
            out[name].append(value)
        by_copy = force.reshape(copies, nodes, 3)
        push = np.einsum("ikm,cik->cm", rows, by_copy) if p.massless else 0.0
        inertia, heavy = 1.0 / dt**2 + drag, 1.0 / dt**2 + lost
        stiff = 2.0 / dt**2 - p.frequency**2
        new = (stiff * now + (drag - 1.0 / dt**2) * old + push) / inertia
        later = (2.0 / dt**2 - ring.frequency**2) * slow + (lost - 1.0 / dt**2) * slow_old
        later = later / heavy
        w, u = under_nodes(ring, (p.angle + p.speed * (step + 1) * dt).ravel())
        on_wall = np.stack([w, u, 0.0 * u], axis=1)
        flexible = np.einsum("iam,m,jbm->iajb", on_wall, 1.0 / heavy, on_wall)
        for copy in range(copies):
            own = slice(copy * nodes, (copy + 1) * nodes)
            block = p.compliance[copy]
            if not p.massless:
                block = p.contact / inertia[copy] @ p.contact.T
            flexible[own, :, own] += block.reshape(nodes, 3, nodes, 3)
        moved = np.einsum("ikm,cm->cik", rows, new).reshape(count, 3)
        change = moved - np.einsum("ikm,cm->cik", rows, now).reshape(count, 3)
        if p.massless:
            change -= np.einsum("cij,cj->ci", p.compliance, by_copy.reshape(copies, -1)).reshape(
                count, 3
            )
        change = change - on_wall @ (later - slow)
        clearance = ring.clearance[0, 0] + np.tile(p.recess, copies)
        gap = clearance + w @ later - moved[:, 0]
        normal, after = -force[:, 0], np.zeros_like(force)
        for _ in range(300 if gap.min() < 0.0 else 0):
            before = normal.copy()
            ways = np.column_stack([-np.ones(count), -p.friction * direction])
            answer = np.einsum("iajb,jb->iaj", flexible, ways)
            for _ in range(30):
                for i in range(count):
                    slack = gap[i] - answer[i, 0] @ normal
                    normal[i] = max(0.0, normal[i] + slack / answer[i, 0, i])
            slip = change[:, 1:] + (answer @ normal)[:, 1:]
            slip[:, 0] += p.speed * np.tile(p.radius, copies) * dt
            if p.full_sliding:
                touching = normal > 0.0
                direction = direction.copy()
                length = np.linalg.norm(slip, axis=1)[:, None]
                direction[touching] = (slip / length)[touching]
            after = normal[:, None] * ways
            if np.allclose(normal, before, rtol=1e-13, atol=1e-15):
                break
        if not p.massless:
            new += np.einsum("ikm,cik->cm", rows, after.reshape(copies, nodes, 3)) / inertia
        later = later - np.einsum("iam,ia->m", on_wall, after) / heavy
        old, now, slow_old, slow, force = now, new, slow, later, after
    return {name: np.array(values) for name, values in out.items()}


@pytest.mark.parametrize(("massless", "full"), [(True, True), (True, False), (False, True)])
def test_the_compiled_march_is_that_of_plain_numpy(*, massless: bool, full: bool) -> None:
    problem = bladed(2, 3, casing(8), massless=massless, full=full)
    dt, steps = 4e-6, 150
    expected, chunk = plain(problem, dt, steps), advanced(problem, dt, steps)
    force = chunk.contact_force
    assert (force[:, :, 0] < 0.0).any(axis=0).sum() > 2
    assert force == pytest.approx(expected["force"], abs=1e-7 * np.abs(force).max())
    for name, values in {
        "q": chunk.modal_displacement,
        "casing": chunk.casing_displacement,
    }.items():
        assert values == pytest.approx(expected[name], abs=1e-9 * np.abs(values).max())
    assert ledger(chunk) < 1e-9


def test_with_mass_the_march_is_that_of_beams() -> None:
    problem = stage_problem(5, 10)
    rotor, ring, tips = problem.rotor, problem.casing, len(problem.rotor.tip_angle)
    contact = np.zeros((3 * tips, len(rotor.frequency)))
    contact[0::3], contact[1::3] = rotor.tip_radial, rotor.tip_tangential
    outward = np.linalg.norm(rotor.tip_radial[0])
    velocity = 3.0 * rotor.tip_radial[0] / outward
    same = BoundaryProblem(
        frequency=rotor.frequency[None],
        damping_ratio=rotor.damping_ratio[None],
        contact=contact,
        compliance=np.zeros((1, 3 * tips, 3 * tips)),
        massless=False,
        angle=rotor.tip_angle[None],
        radius=np.full(tips, rotor.tip_radius),
        recess=rotor.tip_recess,
        wall=ring.clearance * [1.0, ring.radius],
        speed=problem.speed,
        friction=problem.friction,
        full_sliding=False,
        displacement_limit=problem.displacement_limit,
        displacement=np.zeros((1, len(rotor.frequency))),
        velocity=velocity[None],
        loads=tuple(
            BoundaryLoad(
                amplitude=load.rotor[None],
                casing=load.casing,
                frequency=load.frequency,
                phase=load.phase,
                ramp=load.ramp,
                end=load.end,
            )
            for load in problem.loads
        ),
        casing=ring,
    )
    dt, steps = 0.5 * problem.critical_time_step, 4000
    beams = CentralDifference(
        replace(problem, start=replace(problem.start, rotor_velocity=velocity)), dt, 1
    )
    _, expected, _ = beams.advance(beams.init(), steps + 1)
    chunk = advanced(same, dt, steps)
    assert expected.contact_steps.sum() > 50
    assert np.array_equal(chunk.contact_steps, expected.contact_steps)
    tip = expected.rotor_displacement @ rotor.tip_radial.T
    assert chunk.contact_displacement[:, :, 0] == pytest.approx(tip, abs=1e-10)
    assert chunk.casing_displacement == pytest.approx(expected.casing_displacement, abs=1e-10)


@pytest.mark.parametrize("massless", [True, False])
def test_blades_in_a_ring_keep_energy_momentum_and_symmetries(*, massless: bool) -> None:
    copies, nodes, dt, steps = 22, 9, 4e-6, 250
    ring = casing(44, support=0.0)
    problem = bladed(copies, nodes, ring, massless=massless, full=True)
    chunk = advanced(problem, dt, steps)
    force = chunk.contact_force
    assert (force[:, :, 0] < 0.0).any(axis=0).sum() > 40  # nodes in contact
    assert ledger(chunk) < 1e-9
    # Momentum: the wall gets the forces on the nodes with the opposite sign.
    angle = problem.angle.ravel() + SPEED * chunk.time[:, None]
    outward, along = force[:, :, 0], force[:, :, 1]
    pushed = -(np.exp(1j * angle) * (outward + 1j * along)).sum(axis=1)
    impulse = dt * pushed.cumsum()
    nodal = ring.nodal[:, :, :2] @ chunk.casing_velocity[-2, :2]  # rigid translations
    theta = 2.0 * np.pi / len(nodal) * np.arange(len(nodal))
    mass = 7800.0 * 0.05 * 5e-3 * 2.0 * np.pi * ring.radius
    velocity = np.mean(np.exp(1j * theta) * (nodal[:, 0] + 1j * nodal[:, 2]))
    assert mass * velocity == pytest.approx(0.5 * (impulse[-2] + impulse[-1]), rel=1e-5)
    # Turned by a pitch, which is two elements, every blade does the same.
    turned = bladed(copies, nodes, ring, massless=massless, full=True, first=2.0 * np.pi / copies)
    again = advanced(turned, dt, steps)
    assert again.contact_force == pytest.approx(force, abs=1e-6 * np.abs(force).max())
    # The mirror image turns the other way; tangential displacements change their sign.
    flip = np.tile([1.0, -1.0, 1.0], nodes)
    mirrored = replace(
        problem,
        contact=flip[:, None] * problem.contact,
        compliance=flip[:, None] * problem.compliance * flip,
        angle=-problem.angle,
        speed=-SPEED,
    )
    image = advanced(mirrored, dt, steps).contact_force * [1.0, -1.0, 1.0]
    assert image == pytest.approx(force, abs=1e-6 * np.abs(force).max())

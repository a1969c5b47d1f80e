"""March of structures with many contact nodes, against closed forms and a plain NumPy version."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.boundary_problem import BoundaryLoad, BoundaryProblem
from bladewhirl.solvers.march.boundary import BoundaryChunk, BoundaryMarch
from bladewhirl.solvers.march.march import EndReason

GAP, FLEXIBILITY, OMEGA = 1e-3, 1e-6, 100.0

SPRING = BoundaryProblem(
    frequency=np.array([[OMEGA]]),
    damping_ratio=np.zeros((1, 1)),
    contact=np.array([[1.0], [0.0], [0.0]]),
    compliance=FLEXIBILITY * np.eye(3)[None],
    massless=True,
    angle=np.zeros((1, 1)),
    radius=np.array([0.5]),
    recess=np.zeros(1),
    wall=np.column_stack([np.full(8, GAP), np.zeros(8)]),
    speed=0.0,
    friction=0.0,
    full_sliding=False,
    displacement_limit=1.0,
    displacement=np.zeros((1, 1)),
    velocity=np.ones((1, 1)),
)
"""A mass of 1 kg on a spring that meets a wall through another spring."""


def advanced(problem: BoundaryProblem, dt: float, steps: int, every: int = 1) -> BoundaryChunk:
    scheme = BoundaryMarch(problem, dt, every)
    _, chunk, end = scheme.advance(scheme.init(), steps + 1)
    assert end is None
    return chunk


def ledger(chunk: BoundaryChunk) -> float:
    gained = chunk.external_work + chunk.normal_work + chunk.friction_work - chunk.damping_work
    error = np.abs(chunk.energy - chunk.energy[0] - gained)
    return float(error.max() / np.abs(chunk.energy).max())


def test_a_massless_contact_rebounds_without_loss_and_its_force_is_gap_over_flexibility() -> None:
    stiffness = OMEGA**2 + 1.0 / FLEXIBILITY
    start = np.arcsin(GAP * OMEGA) / OMEGA
    speed, centre = np.cos(OMEGA * start), GAP / FLEXIBILITY / stiffness
    rate = np.sqrt(stiffness)
    phase = np.arctan2(speed / rate, GAP - centre)
    times = np.linspace(start, start + 2.0 * phase / rate, 20001)
    swing = np.hypot(speed / rate, GAP - centre)
    force = (centre + swing * np.cos(rate * (times - start) - phase) - GAP) / FLEXIBILITY
    errors = []
    for dt in (2e-5, 1e-5):
        chunk = advanced(SPRING, dt, round(6e-3 / dt))
        assert -chunk.contact_force[:, 0, 0] == pytest.approx(
            np.maximum(0.0, (chunk.modal_displacement[:, 0, 0] - GAP) / FLEXIBILITY), abs=1e-9
        )
        errors.append(abs(chunk.contact_impulse.sum() / np.trapezoid(force, times) - 1.0))
        assert chunk.modal_velocity[-1, 0, 0] < 0.0
        assert chunk.energy[-1] == pytest.approx(chunk.energy[0], rel=3e-4)
        assert ledger(chunk) < 1e-9
    assert max(errors) < 3e-5


def blades(
    *, massless: bool, full: bool, coupled: bool = False, modes: int = 6, nodes: int = 4
) -> BoundaryProblem:
    """Two blades of random modes in an oval wall that closes in on them; velocities may couple
    their modes."""
    random = np.random.default_rng(4)
    grid = 2.0 * np.pi / 64 * np.arange(64)
    square = random.standard_normal((3 * nodes, 3 * nodes))
    flexibility = 1e-8 * (square @ square.T / nodes + np.eye(3 * nodes))
    pitch = 0.02 * np.arange(nodes)
    turning = np.random.default_rng(5).standard_normal((modes, modes))
    return BoundaryProblem(
        by_velocity=300.0 * (turning - turning.T) + 20.0 * turning @ turning.T if coupled else None,
        frequency=np.linspace(300.0, 9e3, modes) * np.array([[1.0], [1.05]]),
        damping_ratio=np.full((2, modes), 0.01),
        contact=random.standard_normal((3 * nodes, modes)),
        compliance=flexibility * np.array([1.0, 1.05**-2])[:, None, None] * massless,
        massless=massless,
        angle=np.array([pitch, np.pi + pitch]),
        radius=np.linspace(0.3, 0.31, nodes),
        recess=np.linspace(1e-5, -1e-5, nodes),
        wall=np.column_stack([4e-4 + 5e-4 * np.cos(2 * grid), -1e-3 * np.sin(2 * grid)]),
        speed=-220.0,
        friction=0.15,
        full_sliding=full,
        displacement_limit=1.0,
        displacement=np.full((2, modes), -2e-5),
        velocity=np.zeros((2, modes)),
        loads=(
            BoundaryLoad(
                amplitude=random.standard_normal((2, modes)),
                frequency=300.0,
                phase=0.3,
                ramp=5e-3,
                end=8e-3,
            ),
        ),
    )


def plain(problem: BoundaryProblem, dt: float, steps: int) -> dict[str, FloatArray]:
    """March with NumPy only, with Gauss-Seidel iterations in place of an active set."""
    p, squares = problem, problem.frequency**2
    drag = p.damping_ratio * p.frequency / dt
    copies, nodes = p.angle.shape
    modes = p.contact.shape[1]
    velocity = np.zeros((modes, modes)) if p.by_velocity is None else 0.5 / dt * p.by_velocity
    inverse = [np.linalg.inv(np.diag(1.0 / dt**2 + row) + velocity) for row in drag]
    rows = p.contact.reshape(nodes, 3, -1)
    now = p.displacement
    old = now - 0.5 * dt**2 * squares * now
    force = np.zeros((copies, nodes, 3))
    direction = np.tile([np.sign(p.speed), 0.0], (copies, nodes, 1))
    out: dict[str, Any] = {"force": [], "q": []}
    grid = 2.0 * np.pi / len(p.wall)

    def wall(angle: FloatArray) -> FloatArray:
        place = np.mod(angle, 2.0 * np.pi) / grid
        e = place.astype(int) % len(p.wall)
        x = place - np.floor(place)
        (a, da), (b, db) = p.wall[e].T, p.wall[(e + 1) % len(p.wall)].T
        cubic = (1 - x) ** 2 * (a * (1 + 2 * x) + grid * da * x)
        return np.asarray(cubic + x**2 * (b * (3 - 2 * x) - grid * db * (1 - x)))

    for step in range(steps + 1):
        out["force"].append(force)
        out["q"].append(now)
        time = step * dt
        load = np.zeros_like(now)
        for one in p.loads:
            rise = 0.5 - 0.5 * np.cos(np.pi * min(1.0, time / one.ramp))
            load += (
                one.amplitude * rise * np.cos(one.frequency * time + one.phase) * (time < one.end)
            )
        push = np.einsum("ikm,cik->cm", rows, force) if p.massless else 0.0
        pulled = (2.0 / dt**2 - squares) * now + (drag - 1.0 / dt**2) * old + load + push
        new = np.array([a @ b for a, b in zip(inverse, pulled + old @ velocity.T, strict=True)])
        after = np.zeros_like(force)
        for copy in range(copies):
            answer = p.contact @ inverse[copy] @ p.contact.T
            flexible = p.compliance[copy] if p.massless else answer
            u = rows @ new[copy]
            angle = p.angle[copy] + p.speed * (time + dt)
            gap = np.array([wall(one) for one in angle]) + p.recess - u[:, 0]
            moved = u - rows @ now[copy]
            if p.massless:
                moved = moved - (flexible @ force[copy].ravel()).reshape(-1, 3)
            normal = -force[copy][:, 0].copy()
            for _ in range(400 if gap.min() < 0.0 else 0):
                d, previous = direction[copy], normal.copy()
                ways = np.column_stack([-np.ones(nodes), -p.friction * d])
                w = np.einsum("iajb,jb->iaj", flexible.reshape(nodes, 3, nodes, 3), ways)
                for _ in range(20):
                    for i in range(nodes):
                        slack = gap[i] - w[i, 0] @ normal
                        normal[i] = max(0.0, normal[i] + slack / w[i, 0, i])
                slip = moved[:, 1:] + (w @ normal)[:, 1:]
                slip[:, 0] += p.speed * p.radius * dt
                if p.full_sliding:
                    touching = normal > 0.0
                    turned = slip / np.linalg.norm(slip, axis=1)[:, None]
                    direction[copy][touching] = turned[touching]
                if np.allclose(normal, previous, rtol=1e-13, atol=1e-15):
                    break
            if gap.min() < 0.0:
                after[copy] = normal[:, None] * ways
            if not p.massless:
                new[copy] += inverse[copy] @ np.einsum("ikm,ik->m", rows, after[copy])
        old, now, force = now, new, after
    return {name: np.array(values) for name, values in out.items()}


@pytest.mark.parametrize("massless", [True, False])
@pytest.mark.parametrize(("full", "coupled"), [(True, False), (False, False), (True, True)])
def test_the_compiled_march_is_that_of_plain_numpy(
    *, massless: bool, full: bool, coupled: bool
) -> None:
    problem = blades(massless=massless, full=full, coupled=coupled)
    dt, steps = 2e-5, 400
    expected, chunk = plain(problem, dt, steps), advanced(problem, dt, steps)
    force = chunk.contact_force.reshape(expected["force"].shape)
    assert (expected["force"][:, :, :, 0] < 0.0).any(axis=(0, 2)).all()  # both blades touch
    assert force == pytest.approx(expected["force"], abs=1e-7 * np.abs(force).max())
    largest = np.abs(expected["q"]).max()
    assert chunk.modal_displacement == pytest.approx(expected["q"], abs=1e-9 * largest)
    assert ledger(chunk) < 1e-9
    assert (np.abs(chunk.axial_impulse).max() > 0.0) == full


def test_records_do_not_depend_on_their_distance_and_a_march_can_be_split() -> None:
    problem, dt = blades(massless=True, full=True), 2e-5
    fine, coarse = advanced(problem, dt, 400), advanced(problem, dt, 400, 20)
    assert np.array_equal(coarse.modal_displacement, fine.modal_displacement[::20])
    assert coarse.contact_impulse.sum(axis=0) == pytest.approx(fine.contact_impulse.sum(axis=0))
    scheme = BoundaryMarch(problem, dt, 20)
    state, _, _ = scheme.advance(scheme.init(), 150)
    _, rest, _ = scheme.advance(state, 251)
    assert np.array_equal(rest.modal_displacement[-1], coarse.modal_displacement[-1])
    assert np.array_equal(rest.energy[-1], coarse.energy[-1])


def test_a_march_ends_at_the_displacement_limit_and_refuses_long_steps() -> None:
    scheme = BoundaryMarch(replace(SPRING, displacement_limit=5e-4), 1e-5, 10)
    state, chunk, end = scheme.advance(scheme.init(), 1000)
    assert end is EndReason.DIVERGENT
    assert state.step < 60
    assert chunk.modal_displacement[-1, 0, 0] <= 5e-4
    assert SPRING.critical_time_step == pytest.approx(2.0 / np.sqrt(OMEGA**2 + 1.0 / FLEXIBILITY))
    with pytest.raises(ValueError, match="at or above the critical step"):
        BoundaryMarch(SPRING, 2e-3, 1)

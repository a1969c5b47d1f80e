"""Marches with the loss of a blade, against full-order integrations without reduction."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from numpy.typing import NDArray
from places import EXAMPLES

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.file import read_case, with_values
from bladewhirl.models.elements.bladed_disk import assemble_bladed_disk
from bladewhirl.models.elements.build import case_bladed_disk
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.stage.beams import Beams
from bladewhirl.models.stage.blade_loss import lost_part, remaining_disk, without_part
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel.structs import lib
from bladewhirl.solvers.march.checkpoint import state_arrays, state_from
from bladewhirl.solvers.march.march import Chunk, KernelState
from bladewhirl.solvers.march.sudden_changes import Phase, SuddenChanges, make_scheme
from bladewhirl.studies.verification.bodies import ledger_residual

ALL_MODES = {
    "bladed_disk.blades": 13,
    "bladed_disk.elements_per_blade": 3,
    "reduction.fixed_interface_modes": 130,
    "casing.clearance": "50 mm",
    "excitation.ramp": 0.0,
    "excitation.clearance_speed": None,
    "excitation.unbalance": "50 kg mm",
    "damping.ratio": 0.01,
    "march.record_step": "50 us",
    "march.duration": "0.04 s",
}
LOST_AT = 0.01


def stage_of(**changes: Any) -> Beams:
    case = read_case(EXAMPLES / "imbalance.toml")
    loss = {"blade": changes.pop("blade", 4), "time": LOST_AT, "from": changes.pop("share", 0.0)}
    values = {**ALL_MODES, "blade_loss": loss}
    values |= {name.replace("__", "."): value for name, value in changes.items()}
    return build_beams(with_values(case, values))


def marched(given: ContactProblem, duration: float, every: int, dt: float) -> Chunk:
    scheme = make_scheme(given, dt, every)
    return scheme.advance(scheme.init(), round(duration / dt) + 1)[1]


class FullOrder:
    """Bladed disk before and after a loss in all degrees of freedom, without contact."""

    def __init__(self, stage: Beams) -> None:
        case, model, self.stage = stage.case, stage.disk.model, stage
        assert case.blade_loss is not None
        self.disk = case_bladed_disk(case, clamped=case.shaft.clamped)
        lost = lost_part(case, model)
        others = np.setdiff1d(np.arange(len(model.mesh.points)), lost.nodes)
        lines = np.setdiff1d(np.arange(len(model.mesh.lines)), lost.lines)
        alone = without_part(model, replace(lost, nodes=others, lines=lines))
        loose = assemble_bladed_disk(alone, shaft_stiffness=0.0, clamped=case.shaft.clamped)
        self.before, self.fragment = rotation_matrices(self.disk), loose.structure
        self.lost, self.remaining = lost, remaining_disk(case, model, lost).structure

    def damping(self, mass: FloatArray, stiffness: FloatArray) -> FloatArray:
        square, modes = la.eigh(stiffness, mass)
        weighted = mass @ modes
        rate = 2.0 * self.stage.case.damping.ratio * np.sqrt(square)
        return np.asarray((weighted * rate) @ weighted.T)


def dense(matrix: Any) -> FloatArray:
    return np.asarray(matrix.toarray())


def first_order(mass: FloatArray, damping: FloatArray, stiffness: FloatArray) -> FloatArray:
    size = len(mass)
    state = np.zeros((2 * size, 2 * size))
    state[:size, size:] = np.eye(size)
    state[size:] = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    return state


def constant_load(
    mass: FloatArray,
    damping: FloatArray,
    stiffness: FloatArray,
    force: FloatArray,
    start: FloatArray,
    times: NDArray[np.floating[Any]],
) -> FloatArray:
    """Return the exact states of linear motion at equally spaced times, (times, 2 size)."""
    rest = np.concatenate([np.linalg.solve(stiffness, force), np.zeros(len(mass))])
    step = la.expm(first_order(mass, damping, stiffness) * (times[1] - times[0]))
    states = [start - rest]
    for _ in times[1:]:
        states.append(step @ states[-1])
    return np.asarray(np.array(states) + rest)


def full_march(stage: Beams, step: float, end: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times, centre and tips of a march in all degrees of freedom at constant speed."""
    case, omega = stage.case, stage.speed
    full = FullOrder(stage)
    before, after = full.before, full.remaining
    centre = full.disk.centre
    unbalance = 50e-3 * omega**2
    turning = case.rotation.effects == "full"
    size = full.disk.structure.size

    def matrices(given: Structure, mass: FloatArray, alive: Any) -> Any:
        stiffness = dense(given.stiffness)[np.ix_(alive, alive)]
        mass = mass[np.ix_(alive, alive)]
        damping = full.damping(mass, stiffness)
        if turning:
            extra = dense(given.stiffness_speed)[np.ix_(alive, alive)]
            stiffness = stiffness + omega**2 * extra
            damping = damping + 2.0 * omega * dense(given.coriolis)[np.ix_(alive, alive)]
        return mass, damping, stiffness

    whole = np.arange(size)
    force = np.zeros(size)
    force[centre[0]] = unbalance
    times = np.arange(round(LOST_AT / step) + 1) * step
    mass, damping, stiffness = matrices(before, dense(before.mass), whole)
    first = constant_load(mass, damping, stiffness, force, np.zeros(2 * size), times)
    alive = np.flatnonzero(dense(after.mass).diagonal() > 0.0)
    if turning:
        soft = dense(before.stiffness) - omega**2 * dense(before.translated)
        grown = np.linalg.solve(soft, omega**2 * before.loads[:, 0])
        pull = omega**2 * (after.loads[:, 0] + after.translated @ grown) - after.stiffness @ grown
    else:
        pull = -(omega**2) * rigid_pull(full)
    rest = np.concatenate([first[-1][alive], first[-1][size + alive]])
    later = np.arange(round((end - LOST_AT) / step) + 1) * step
    mass, damping, stiffness = matrices(after, dense(after.mass), alive)
    second = constant_load(mass, damping, stiffness, (force + pull)[alive], rest, later)
    shown = np.zeros((len(later), size))
    shown[:, alive] = second[:, : len(alive)]
    motion = np.concatenate([first[:-1, :size], shown])
    tips = motion[:, full.disk.tip_radial]
    return np.concatenate([times[:-1], LOST_AT + later]), motion[:, centre], tips


def rigid_pull(full: FullOrder) -> FloatArray:
    """Return the centrifugal force and moment of the lost part at the node of the fracture, at
    1 rad/s, from statics."""
    disk, mesh = full.disk, full.disk.mesh
    (cut,) = full.lost.cuts
    properties = disk.properties
    force, moment = np.zeros(2), 0.0
    places, weights = np.polynomial.legendre.leggauss(6)
    for line in full.lost.lines:
        first, second = mesh.points[mesh.lines[line]]
        for place, weight in zip(0.5 * (1.0 + places), 0.5 * weights, strict=True):
            line_mass = properties.at(np.array([place])).line_mass[line, 0]
            at = first + place * (second - first)
            own = line_mass * weight * np.linalg.norm(second - first) * at
            arm = at - mesh.points[cut]
            force = force + own
            moment += arm[0] * own[1] - arm[1] * own[0]
    axes = mesh.node_axes[cut]
    turn = np.array([[np.cos(axes), np.sin(axes)], [-np.sin(axes), np.cos(axes)]])
    pull = np.zeros(disk.structure.size)
    pull[disk.structure.node_dofs[cut]] = [*(turn @ force), moment]
    return pull


@pytest.mark.slow
@pytest.mark.parametrize("effects", ["none", "full"])
@pytest.mark.parametrize("share", [0.0, 0.4])
def test_a_stage_that_loses_a_blade_in_all_degrees_of_freedom(effects: str, share: float) -> None:
    stage = stage_of(rotation__effects=effects, share=share)
    problem = contact_problem(stage)
    coarse, fine = (marched(problem, 0.04, round(5e-5 / dt), dt) for dt in (1e-6, 5e-7))
    assert not fine.contact_impulse.any()
    displacement = (4.0 * fine.rotor_displacement - coarse.rotor_displacement) / 3.0
    time, centre, tips = full_march(stage, 5e-5, 0.04)
    np.testing.assert_allclose(fine.time, time, atol=1e-12)
    moved = displacement @ problem.rotor.centre.T
    scale = np.abs(centre).max()
    assert scale > 5e-4
    np.testing.assert_allclose(moved, centre, atol=1e-6 * scale)
    others = np.arange(13) != 4
    radial = displacement @ problem.rotor.tip_radial.T
    np.testing.assert_allclose(radial[:, others], tips[:, others], atol=1e-6 * np.abs(tips).max())


def rigid_motions(full: FullOrder) -> FloatArray:
    """Return unit translations along x and y and a unit rotation about the axis, (size, 3)."""
    mesh, dofs = full.disk.mesh, full.disk.structure.node_dofs
    motions = np.zeros((full.disk.structure.size, 3))
    for node, (x, y) in enumerate(mesh.points):
        c, s = np.cos(mesh.node_axes[node]), np.sin(mesh.node_axes[node])
        moved = np.array([[c, s, c * -y + s * x], [-s, c, s * y + c * x], [0.0, 0.0, 1.0]])
        free = dofs[node] >= 0
        motions[dofs[node][free]] = moved[free]
    return motions


@pytest.mark.parametrize("effects", ["none", "full"])
def test_momentum_and_energy_of_both_parts_are_those_before(effects: str) -> None:
    stage = stage_of(rotation__effects=effects)
    problem, full = contact_problem(stage), FullOrder(stage)
    assert problem.loss is not None
    scheme = SuddenChanges(problem, 1e-6, 100)
    state, _, _ = scheme.advance(scheme.init(), 7000)
    at = KernelState(step=state.step, arrays=state.arrays["whole"])
    start, _ = scheme.motion(Phase(problem, "whole", 1e-6, 100), at)
    shapes = stage.reduction.modes.shapes
    u, v = shapes @ start.rotor, shapes @ start.rotor_velocity
    rest_of = shapes @ problem.loss.extension @ problem.loss.restriction
    kept_u, kept_v = rest_of @ start.rotor, rest_of @ start.rotor_velocity
    rigid, one = rigid_motions(full), full.disk.structure
    other, part = full.remaining, full.fragment
    np.testing.assert_allclose(dense(other.mass + part.mass), dense(one.mass), atol=1e-13)
    momentum = rigid.T @ (one.mass @ v)
    parts = rigid.T @ (other.mass @ kept_v), rigid.T @ (part.mass @ v)
    assert np.abs(parts[1]).max() > 1e-6 * np.abs(momentum).max()
    np.testing.assert_allclose(sum(parts), momentum, atol=1e-10 * np.abs(momentum).max())
    energies = [
        0.5 * (rate @ (each.mass @ rate) + moved @ (each.stiffness @ moved))
        for each, moved, rate in ((one, u, v), (other, kept_u, kept_v), (part, u, v))
    ]
    np.testing.assert_allclose(energies[1] + energies[2], energies[0], rtol=1e-10)
    assert energies[2] > 0.01 * energies[0]


@pytest.mark.slow
def test_the_energy_of_the_lost_blade_leaves_as_work() -> None:
    stage = stage_of(rotation__effects="none")
    problem, full = contact_problem(stage), FullOrder(stage)
    assert ledger_residual(marched(problem, 0.02, 10, 1e-6)) < 1e-8
    dt = 1e-7
    chunk, whole = (_around_the_loss(each, dt) for each in (problem, replace(problem, loss=None)))
    u, v = (
        stage.reduction.modes.shapes @ each[0]
        for each in (whole.rotor_displacement, whole.rotor_velocity)
    )
    part = full.fragment
    lost = 0.5 * (v @ (part.mass @ v) + u @ (part.stiffness @ u))
    # records contain the energy half a step before
    energy = [each.energy[:2].mean() for each in (whole, chunk)]
    assert lost > 0.01 * energy[0]
    np.testing.assert_allclose(energy[0] - energy[1], lost, rtol=2e-3)
    left = whole.external_work[0] - chunk.external_work[0]
    np.testing.assert_allclose(left, lost, rtol=2e-2)


def _around_the_loss(given: ContactProblem, dt: float) -> Chunk:
    scheme = make_scheme(given, dt, 1000)
    state = scheme.advance(scheme.init(), round(LOST_AT / dt))[0]
    return scheme.advance(state, 3, 1)[1]


@pytest.mark.slow
def test_a_constant_speed_in_a_table_loses_a_blade_alike() -> None:
    for effects in ("none", "full"):
        given = contact_problem(stage_of(rotation__effects=effects))
        table = (("0 s", 1.05), ("0.01 s", 1.05))
        varying = contact_problem(stage_of(rotation__effects=effects, march__speed_table=table))
        one, other = (marched(each, 0.02, 100, 1e-6) for each in (given, varying))
        np.testing.assert_allclose(
            other.rotor_displacement,
            one.rotor_displacement,
            atol=1e-11 * np.abs(one.rotor_displacement).max(),
        )


@pytest.mark.slow
def test_a_blade_is_lost_while_the_speed_changes() -> None:
    """Against an integration of the matrices of the full bladed disk with exponentials."""
    small: dict[str, Any] = {"bladed_disk__blades": 5, "bladed_disk__elements_per_blade": 2}
    small |= {"reduction__fixed_interface_modes": 110, "rotation__effects": "full"}
    table = (("0 s", 0.9), ("0.02 s", 1.3))
    stage = stage_of(**small, march__speed_table=table)
    problem = contact_problem(stage)
    coarse, fine = (marched(problem, 0.02, round(1e-4 / dt), dt) for dt in (1e-6, 5e-7))
    assert not fine.contact_impulse.any()
    displacement = (4.0 * fine.rotor_displacement - coarse.rotor_displacement) / 3.0
    full, course = FullOrder(stage), stage.case.march.course(stage.reference_frequency)
    assert course is not None
    before, after, base = full.before, full.remaining, stage.speed
    size, (x, y) = full.disk.structure.size, full.disk.centre
    soft = dense(before.stiffness) - base**2 * dense(before.translated)
    grown = np.linalg.solve(soft, base**2 * before.loads[:, 0])
    first = float(course.speed(0.0))
    stiff = dense(before.stiffness_at(first))
    state = np.zeros(2 * size)
    state[:size] = np.linalg.solve(
        stiff, (first**2 - base**2) * (before.loads[:, 0] + before.translated @ grown)
    )

    def marched_on(given: Structure, state: FloatArray, start: float) -> list[FloatArray]:
        alive = np.flatnonzero(dense(given.mass).diagonal() > 0.0)
        at = np.ix_(alive, alive)
        mass, stiffness, turning, softening = (
            dense(each)[at]
            for each in (
                given.mass,
                given.stiffness,
                given.coriolis,
                given.stiffness_speed,
            )
        )
        damping, count, h = full.damping(mass, stiffness), len(alive), 2.5e-5
        rows = np.concatenate([alive, size + alive])
        pulled = given.loads[:, 0] + given.translated @ grown
        swept = given.coriolis @ grown - given.loads[:, 1]
        state, states = np.append(state[rows], 1.0), [state]
        for step in range(400):
            time = start + (step + 0.5) * h
            speed, rate = float(course.speed(time)), float(course.acceleration(time))
            force = speed**2 * pulled - given.stiffness @ grown - rate * swept
            force[x] += 50e-3 * speed**2
            force[y] -= 50e-3 * rate
            system = np.zeros((2 * count + 1, 2 * count + 1))
            system[:-1, :-1] = first_order(
                mass,
                damping + 2.0 * speed * turning,
                stiffness + speed**2 * softening + rate * turning,
            )
            system[count:-1, -1] = np.linalg.solve(mass, force[alive])
            state = la.expm(system * h) @ state
            if step % 4 == 3:
                shown = np.zeros(2 * size)
                shown[rows] = state[:-1]
                states.append(shown)
        return states

    states = marched_on(before, state, 0.0)
    states = [*states[:-1], *marched_on(after, states[-1], LOST_AT)]
    exact = np.array(states)[:, [x, y]]
    moved = displacement @ problem.rotor.centre.T
    np.testing.assert_allclose(moved, exact, atol=2e-5 * np.abs(exact).max())


@pytest.mark.slow
def test_a_free_rotor_keeps_what_the_lost_blade_leaves() -> None:
    """A balanced rotor coasts; the blade takes its part of the moment of inertia along."""
    stage = stage_of(
        rotation__effects="full",
        excitation={"type": "none"},
        damping__ratio=0.0,
        march__drive={"inertia": 1.0},
    )
    problem, full = contact_problem(stage), FullOrder(stage)
    chunk = marched(problem, 0.03, 10, 1e-6)
    assert not chunk.contact_impulse.any()
    lost = chunk.time > LOST_AT
    momentum = chunk.angular_momentum
    for part in (momentum[~lost][:-1], momentum[lost]):
        np.testing.assert_allclose(part, part[0], rtol=1e-10)
    assert problem.loss is not None
    assert problem.loss.after.drive is not None
    matrices = full.remaining
    soft = dense(full.before.stiffness) - stage.speed**2 * dense(full.before.mass)
    grown = np.linalg.solve(soft, stage.speed**2 * full.before.loads[:, 0])
    inertia = (
        1.0 + matrices.inertia + grown @ (2.0 * matrices.loads[:, 0] + matrices.translated @ grown)
    )
    np.testing.assert_allclose(momentum[lost][0], inertia * stage.speed, rtol=1e-10)
    energy = chunk.energy + chunk.rotor_energy - chunk.braking_work
    scale = np.abs(chunk.rotor_energy).max()
    np.testing.assert_allclose(energy, energy[0], atol=1e-9 * scale)
    assert np.abs(chunk.rotation_speed[lost] / stage.speed - 1.0).max() > 1e-6


def test_a_torque_on_a_free_rotor_moves_on_through_the_loss() -> None:
    """The state at the loss has the momentum of the march, to the second order of the step: the
    Euler forces of the acceleration act once."""
    drive = {"inertia": 0.5, "torque": 2000.0}
    given = stage_of(
        rotation__effects="full",
        march__speed="100 rad/s",
        march__drive=drive,
        blade_loss__time=2e-3,
    )
    problem, lacks = contact_problem(given), []
    for dt in (5e-7, 1e-6):
        scheme = SuddenChanges(problem, dt, 1000)
        phase = scheme._phases["whole"]
        state, _, _ = phase.scheme.advance(phase.scheme.init(), round(LOST_AT / dt))
        start, turned = scheme.motion(phase, state)
        assert problem.drive is not None
        assert problem.change is not None
        momentum = problem.drive.momentum(
            turned.speed, problem.change, start.rotor, start.rotor_velocity
        )
        marched_on = state.arrays["drive"][lib.DRIVE_MOMENTUM] + 0.5 * dt * drive["torque"]
        lacks.append(abs(momentum - marched_on) / marched_on)
    assert lacks[1] < 1e-6
    assert lacks[1] / lacks[0] == pytest.approx(4.0, rel=0.1)


@pytest.mark.slow
def test_the_shaft_is_displaced_about_the_new_centre_of_mass() -> None:
    """Below and far above the critical speed of a disk with short, stiff blades on soft springs, in
    rotating axes: the static displacement under the load after the loss is that of a rigid disk
    with the unbalance of what remains, and tends to its eccentricity."""
    rigid_disk = {
        "rotation__effects": "full",
        "excitation": {"type": "none"},
        "shaft__stiffness": 4e4,
        "bladed_disk__disk_radius": 0.3,
        "bladed_disk__disk__thickness": 0.1,
        "march__time_step": 2e-7,
        "march__record_step": 1e-5,
    }
    for factor, tolerance in ((0.4, 1e-3), (4.0, 1e-2)):
        stage = stage_of(**rigid_disk, march__speed=f"{factor * 20.0} rad/s")
        problem, full = contact_problem(stage), FullOrder(stage)
        assert problem.loss is not None
        matrices, rigid = full.remaining, rigid_motions(full)
        mass = float(rigid[:, 0] @ (matrices.mass @ rigid[:, 0]))
        unbalance = np.hypot(*(rigid[:, :2].T @ matrices.loads[:, 0]))
        after, square = problem.loss.after, stage.speed**2
        force = sum((load.rotor for load in after.loads), np.zeros(len(after.rotor.frequency)))
        moved = np.hypot(*(after.rotor.centre @ (force / after.rotor.stiffness)))
        steady = unbalance * square / abs(4e4 - mass * square)
        np.testing.assert_allclose(moved, steady, rtol=tolerance)
        if factor > 1.0:
            np.testing.assert_allclose(moved, unbalance / mass, rtol=0.02)


@pytest.mark.slow
def test_contact_of_a_lost_tip_ends_and_that_of_others_continues() -> None:
    for changes in ({}, {"contact__sliding": "full"}, {"contact__foreshortening": True}):
        stage = stage_of(
            blade=0,
            rotation__effects="full",
            casing__clearance="0.1 mm",
            march__time_step=1e-6,
            **changes,
        )
        chunk = marched(contact_problem(stage), 0.02, 50, 1e-6)
        lost = chunk.time > LOST_AT
        assert chunk.contact_impulse[~lost][:, 0].any()
        assert not chunk.contact_impulse[chunk.time > LOST_AT + 5e-5][:, 0].any()
        assert chunk.contact_impulse[lost].any()
        assert ledger_residual(chunk) < 1e-8
        assert chunk.gap[lost][:, 0].min() > 0.3


@pytest.mark.slow
def test_a_resumed_march_with_a_loss_is_the_same() -> None:
    problem = contact_problem(stage_of(rotation__effects="full", casing__clearance="0.1 mm"))
    scheme = make_scheme(problem, 1e-6, 100)
    whole = scheme.advance(scheme.init(), 15001)[0]
    for stop in (9950, 10000, 10001, 12345):
        half = scheme.advance(scheme.init(), stop)[0]
        other = make_scheme(problem, 1e-6, 100)
        stored = state_from(other.init(), state_arrays(half))
        rest = other.advance(stored, 15001 - stop)[0]
        np.testing.assert_array_equal(
            rest.arrays["lost"]["rotor"][:2], whole.arrays["lost"]["rotor"][:2]
        )
        np.testing.assert_array_equal(rest.arrays["lost"]["work"], whole.arrays["lost"]["work"])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"blade_loss": {"blade": 13, "time": 0.01}}, "blade_loss.blade = 13: expected blades"),
        ({"blade_loss": {"blade": [2, 2], "time": 0.01}}, "blade_loss.blade = [2, 2]: expected"),
        ({"blade_loss": {"blade": 2, "time": 1.0}}, "blade_loss.time = 1.0: expected a time"),
        ({"blade_loss": {"blade": 2, "time": 1e-7}}, "blade_loss.time = 1e-7: expected a time"),
        ({"blade_loss.from": 0.9}, "blade_loss.from = 0.9: expected a share nearer to 0.6667"),
        ({"blade_loss.from": 1.0}, "blade_loss.from = 1.0: expected a share"),
        ({"bladed_disk.mistuning": {"stiffness_spread": 0.02}}, "expected equal blades"),
        (
            {"bladed_disk.shrouds": [{"radius": 0.4, "cuts": [5, 9]}]},
            "expected blades without shrouds, packets included, with [blade_loss]",
        ),
        ({"coupling.stiffness": 1e5}, "coupling.stiffness = 1e5: expected 0"),
        ({"march.time_step": 3e-6, "march.record_step": 3e-5}, "after the loss of a blade"),
    ],
)
def test_a_loss_that_is_not_possible_is_refused(changes: dict[str, Any], message: str) -> None:
    case = read_case(EXAMPLES / "imbalance.toml")
    values = {**ALL_MODES, "blade_loss": {"blade": 4, "time": LOST_AT}, "rotation.effects": "full"}
    with pytest.raises(CaseError) as error:
        contact_problem(build_beams(with_values(case, {**values, **changes})))
    assert message in str(error.value)

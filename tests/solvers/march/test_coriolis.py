"""Marches of a rotor that feels Coriolis forces, against what is known of whirling and of speed."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.linalg as la
from contact_cases import assert_same, ledger_residual, random_problem, run, thrown, wall
from places import EXAMPLES

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.check import case_from
from bladewhirl.models.case.file import read_case
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.rotation.eigenproblems import damped_eigenvalues, gyroscopic_eigen
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem, ReducedRotor, Start
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.reference import Reference
from bladewhirl.studies.verification.case import reference
from bladewhirl.studies.verification.stages import observed_order
from bladewhirl.studies.verification.whirl import jeffcott, pulled, stage_at_speed

JEFFCOTT = reference("jeffcott")["rotor"]


def coupled(seed: int, *, dampers: bool) -> ContactProblem:
    """Two bodies without any symmetry, the rotor with everything that turning adds."""
    given, random = random_problem(seed, speed=30.0), np.random.default_rng(seed)
    modes = len(given.rotor.frequency)
    skew = 300.0 * random.normal(size=(modes, modes))
    half = 3.0 * random.normal(size=(modes, modes))
    rotor = replace(
        given.rotor, by_velocity=skew - skew.T + half.T @ half, anisotropy=1e4, circulation=2e4
    )
    if dampers:
        rotor = replace(rotor, dampers=3.0 * random.normal(size=(2, modes)))
        casing = random.normal(size=(3, len(given.casing.frequency)))
        given = replace(given, casing=replace(given.casing, dampers=casing))
    return replace(given, rotor=rotor)


@cache
def turning_stage(example: str, *changes: str) -> ContactProblem:
    case = read_case(EXAMPLES / f"{example}.toml", ['rotation.effects="full"', *changes])
    return contact_problem(build_stage(case))


@pytest.mark.parametrize("dampers", [False, True])
@pytest.mark.parametrize("seed", [1, 5])
def test_every_step_is_the_one_plain_numpy_takes(seed: int, dampers: bool) -> None:
    given, dt = coupled(seed, dampers=dampers), 1e-4
    fast, plain = CentralDifference(given, dt, 1), Reference(given, dt, 1)
    _, chunk, _ = fast.advance(fast.init(), 150)
    _, expected, _ = plain.advance(plain.init(), 150)
    assert expected.contact_impulse.any()
    assert np.abs(expected.coupling_work).max() > 1e-3 * expected.energy.max()
    assert_same(chunk, expected)
    assert ledger_residual(chunk) < 1e-12


STAGES: dict[str, tuple[str, ...]] = {
    "casing_distortion": (),
    "unequal_bearings": ("shaft.damping=2e4", "shaft.damping_y=2e4", "shaft.damping_frame=static"),
    "imbalance": ("contact.sliding=signed", "contact.tip_rotation=true", "shaft.damping=2e4"),
    "mistuned_blades": (),
    "shrouded_fan": (),
}


@pytest.mark.parametrize("example", STAGES)
@pytest.mark.parametrize("cyclic", [True, False])
def test_every_kind_of_stage_marches_as_the_reference(example: str, cyclic: bool) -> None:
    given = thrown(turning_stage(example, *STAGES[example]), 40.0, spread=0.5)
    assert given.rotor.by_velocity is not None
    dt, steps = min(1e-6, 0.5 * given.critical_time_step), 120
    fast, plain = CentralDifference(given, dt, 1, cyclic=cyclic), Reference(given, dt, 1)
    state, chunk, _ = fast.advance(fast.init(), steps)
    reached, expected, _ = plain.advance(plain.init(), steps)
    assert expected.contact_impulse.any()
    assert_same(chunk, expected)
    assert reached.statistics.contact_steps == state.statistics.contact_steps
    assert ledger_residual(chunk) < 1e-11


def test_an_odd_number_of_blades_and_dampers_that_differ() -> None:
    """What the blocks of the kernel leave out: single harmonics, and cosines unlike sines."""
    changes = (
        "bladed_disk.blades=7",
        "reduction.fixed_interface_modes=28",
        "shaft.damping=3e4",
        "shaft.damping_y=1e3",
    )
    given = thrown(turning_stage("imbalance", *changes), 40.0, spread=0.5)
    fast, plain = CentralDifference(given, 1e-6, 1), Reference(given, 1e-6, 1)
    assert fast.cyclic[0]
    _, chunk, _ = fast.advance(fast.init(), 120)
    _, expected, _ = plain.advance(plain.init(), 120)
    assert expected.contact_impulse.any()
    assert_same(chunk, expected)


def test_a_constant_force_ends_at_the_static_answer_at_speed() -> None:
    """With K_Omega: Coriolis forces vanish as the motion does."""
    known = {
        ratio: x for ratio, x, _ in reference("rotation")["stages"]["0.01"]["steady_per_newton"]
    }
    given = pulled(stage_at_speed("0.01", ratio=0.05, damper=2e4), 1.0, ramp=0.2)
    _, chunk, _ = run(given, 4e-6, 150_000, every=150_000)
    x, y = given.rotor.centre @ chunk.rotor_displacement[-1]
    assert x == pytest.approx(known[1.05], rel=1e-6)
    assert abs(y) < 1e-6 * x


def test_past_the_critical_speed_the_shaft_moves_against_the_force() -> None:
    """K_Omega is indefinite there; what a damper that stands still adds to it is skew."""
    speed, damper = 2.5, 5e4
    given = pulled(
        stage_at_speed("0.01", speed=speed, damper=damper, frame="static"), 1.0, ramp=0.1
    )
    assert given.rotor.frequency.min() < 0.0
    rows = reference("rotation")["stages"]["0.01"]["steady_per_newton"]
    (answer,) = [x for ratio, x, _ in rows if ratio == speed]
    assert answer < 0.0
    x, y = np.linalg.solve(
        np.eye(2) / answer + damper * given.speed * np.array([[0.0, -1.0], [1.0, 0.0]]), [1.0, 0.0]
    )
    _, chunk, _ = run(given, 4e-6, 150_000, every=150_000)
    reached = given.rotor.centre @ chunk.rotor_displacement[-1]
    np.testing.assert_allclose(reached, [x, y], atol=1e-4 * np.hypot(x, y))
    assert ledger_residual(chunk) < 1e-8


def test_internal_damping_feeds_whirl_past_the_critical_speed() -> None:
    """At the rate of complex modes of the full model, while it loses energy."""
    growth, _ = next(
        row[1:]
        for row in reference("rotation")["stages"]["0.01"]["growth_rates_xi_0.005"]
        if row[0] == 2.5
    )
    given = stage_at_speed("0.01", speed=2.5, ratio=0.005)
    rotor = given.rotor
    rates, modes = damped_eigenvalues(
        np.eye(len(rotor.frequency)), rotor.damping, np.diag(rotor.stiffness)
    )
    first = int(rates.real.argmax())
    assert rates[first].real == pytest.approx(growth, rel=1e-4)
    whirl, still = 1e-4 * modes[:, first], np.zeros(len(given.casing.frequency))
    start = Start(
        rotor=whirl.real,
        rotor_velocity=(rates[first] * whirl).real,
        casing=still,
        casing_velocity=still,
    )
    _, chunk, _ = run(replace(given, start=start), 4e-6, 50_000, every=50)
    exact = (whirl * np.exp(rates[first] * chunk.time)[:, None]).real
    np.testing.assert_allclose(chunk.rotor_displacement, exact, atol=1e-4 * np.abs(exact).max())
    assert chunk.energy[-1] < chunk.energy[0] < 0.0
    assert ledger_residual(chunk) < 1e-9


def whirls(rotor: ReducedRotor) -> tuple[FloatArray, ComplexArray]:
    """Frequencies, positive and negative, and modes of a reduced rotor."""
    assert rotor.by_velocity is not None
    w, p = gyroscopic_eigen(
        np.eye(len(rotor.frequency)), np.diag(rotor.stiffness), rotor.by_velocity
    )
    return w.real, p


def test_free_whirl_has_the_frequencies_of_the_whirling_modes() -> None:
    """k = 1 at 1.05: 47.29 Hz backward, 29.74 Hz forward; of the second order in time."""
    given = stage_at_speed("0.01")
    w, p = whirls(given.rotor)
    (row,) = [r for r in reference("rotation")["stages"]["0.01"]["speeds"] if r["ratio"] == 1.05]
    for way in ("backward", "forward"):
        expected_values = 2 * np.pi * row[way]["1"][0]
        mode = int(np.abs(np.abs(w) - expected_values).argmin())
        assert abs(w[mode]) == pytest.approx(expected_values, rel=1e-4)  # of the reduction
        whirl, rate = 1e-4 * p[:, mode], 1j * w[mode]
        still = np.zeros(len(given.casing.frequency))
        start = Start(
            rotor=whirl.real,
            rotor_velocity=(rate * whirl).real,
            casing=still,
            casing_velocity=still,
        )
        errors = []
        for dt in (4e-6, 2e-6):
            _, chunk, _ = run(replace(given, start=start), dt, round(0.1 / dt), every=1000)
            exact = (whirl * np.exp(rate * chunk.time)[:, None]).real
            errors.append(np.abs(chunk.rotor_displacement - exact).max() / np.abs(exact).max())
            assert ledger_residual(chunk) < 1e-9
        assert errors[0] < 1e-5
        np.testing.assert_allclose(observed_order(np.array(errors)), 2.0, atol=0.05)


def test_a_disk_that_turns_the_other_way_moves_as_in_a_mirror() -> None:
    small = "bladed_disk.blades=8", "reduction.fixed_interface_modes=40"
    forward, backward = (
        turning_stage("imbalance", *small, f"march.speed={speed}") for speed in (1.05, -1.05)
    )
    mirrored = -np.arange(8) % 8
    actual = []
    for given in (forward, backward):
        load = replace(given.loads[0], rotor=3e2 * given.loads[0].rotor)
        _, chunk, _ = run(replace(given, loads=(load,)), 1e-6, 6000, every=100)
        assert chunk.contact_impulse.any()
        moved = chunk.rotor_displacement
        actual.append((moved @ given.rotor.tip_radial.T, moved @ given.rotor.tip_tangential.T))
    (radial, tangential), (other_radial, other_tangential) = actual
    size = 1e-7 * np.abs(tangential).max()
    np.testing.assert_allclose(other_radial, radial[:, mirrored], atol=size)
    np.testing.assert_allclose(other_tangential, -tangential[:, mirrored], atol=size)


def test_a_damper_that_stands_still_holds_both() -> None:
    """Its loss in rotating axes is less than it takes: turning it does the rest of the work."""
    natural = np.sqrt(JEFFCOTT["stiffness"] / JEFFCOTT["mass"])
    omega, damping = 1.3 * natural, 5e3
    given = jeffcott(omega, internal=1e3, external=damping)
    softened = JEFFCOTT["stiffness"] - JEFFCOTT["mass"] * omega**2
    answer = JEFFCOTT["unbalance"] * omega**2 / (softened + 1j * damping * omega)
    _, chunk, _ = run(given, 1e-4, 30_000, every=100)
    x, y = given.rotor.centre @ chunk.rotor_displacement[-1]
    assert x + 1j * y == pytest.approx(answer, rel=1e-6)
    assert np.abs(chunk.coupling_work).max() > 0.0
    assert ledger_residual(chunk) < 1e-9


def test_dampers_that_stand_still_in_a_case() -> None:
    dampers = ("shaft.damping=2e4", "shaft.damping_frame=static")
    for speed in (1.05, -1.05):
        given = turning_stage("imbalance", *dampers, f"march.speed={speed}")
        assert given.rotor.circulation == pytest.approx(2e4 * given.speed, rel=1e-12)
    assert stage_at_speed("0.01", damper=2e4).rotor.circulation == 0.0
    with pytest.raises(CaseError, match=r'damping_frame = "static": expected "rotating", or rot'):
        case_from({"shaft": {"damping_frame": "static"}})
    with pytest.raises(
        CaseError, match=r"damping_y = 20(\.0)?: expected the value of shaft\.damping"
    ):
        case_from(
            {
                "rotation": {"effects": "full"},
                "shaft": {"damping": 10.0, "damping_y": 20.0, "damping_frame": "static"},
            }
        )


def test_reference_solution_of_a_reduced_rotor() -> None:
    """Loads, dampers and motion at the start, all of the second order: the matrix exponential."""
    given = coupled(3, dampers=True)
    rotor = replace(given.rotor, anisotropy=0.0)
    load = replace(given.loads[0], ramp=0.0, frequency=0.0, phase=0.0)
    far = replace(
        given,
        rotor=rotor,
        casing=wall(1e3),
        loads=(replace(load, casing=np.zeros(1)),),
        start=replace(given.start, casing=np.zeros(1), casing_velocity=np.zeros(1)),
    )
    modes = len(rotor.frequency)
    stiffness = np.diag(rotor.stiffness) + rotor.circulation_stiffness
    rates = np.zeros((2 * modes + 1,) * 2)
    rates[:modes, modes:-1] = np.eye(modes)
    rates[modes:-1] = np.column_stack([-stiffness, -rotor.damping, load.rotor])
    begin = np.concatenate([far.start.rotor, far.start.rotor_velocity, [1.0]])
    end = 0.01
    exact = (la.expm(end * rates) @ begin)[:modes]
    errors = []
    for steps in (400, 800, 1600):
        _, chunk, _ = run(far, end / steps, steps)
        errors.append(np.abs(chunk.rotor_displacement[-1] - exact).max())
    assert errors[-1] < 1e-3 * np.abs(exact).max()
    np.testing.assert_allclose(observed_order(np.array(errors)), 2.0, atol=0.1)

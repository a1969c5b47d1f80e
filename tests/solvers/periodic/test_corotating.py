"""Contact that is constant in rotating axes against marches."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
import scipy.optimize as so
from boundary_cases import CLEARANCE, advanced, bladed, casing
from command_line import answer, refusal
from periodic_cases import case
from places import ROOT

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load, Start
from bladewhirl.models.stage.reduced_rotor import ReducedRotor, contact_rows
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.solvers.periodic.contact_branch import FOLD, ContactBranch
from bladewhirl.solvers.periodic.corotating import (
    Equations,
    Structure,
    contact_states,
    corotating_contact,
    obstacles,
)
from bladewhirl.solvers.periodic.corotating import _deviations as deviations
from bladewhirl.solvers.periodic.ring import Ring
from bladewhirl.studies.periodic.initial_states import of_corotating

STIFFNESS, DAMPING, GAP = 0.04, 0.05, 1.05
RIM = np.linspace(-0.3, 0.3, 121)  #: angles of tips on both sides of the displacement
IMBALANCE = ROOT / "examples" / "imbalance.toml"


def imbalance(**changes: Any) -> bw.Case:
    return bw.with_values(bw.read_case(IMBALANCE), changes)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_forces_on_the_tips_are_those_of_a_long_march(tmp_path: Path, friction: float) -> None:
    own = imbalance(
        **{
            "contact.friction": friction,
            "damping.ratio": 0.05,
            "march.duration": 0.8,
            "march.record_step": "1 ms",
            "march.time_step": "2 us",
        }
    )
    found = corotating_contact(contact_problem(build_stage(own)))
    bw.run(own, tmp_path / "run", frames=0)
    with bw.open_result(tmp_path / "run") as result:
        force = result["contact_impulse"].values[-50:].mean(axis=0) / 1e-3
    assert found.normal == pytest.approx(force, abs=5e-3 * force.max())


def test_complementarity() -> None:
    found = corotating_contact(contact_problem(build_stage(imbalance())))
    touching = found.normal > 0.0
    assert 0 < np.count_nonzero(touching) < len(touching)
    assert np.abs(found.gap[touching]).max() < 1e-12
    assert found.gap[~touching].min() > 0.0
    assert (found.normal >= 0.0).all()


def test_the_command_prints_the_radius_of_the_shaft(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(imbalance(**{"contact.friction": 0.0})))
    document = json.loads(answer("periodic", file, "--speeds", "1.05,1.06", "--json").stdout)
    first, second = document["solutions"]
    assert first["radius"] == pytest.approx(1.1984e-3, rel=1e-4)
    assert first["stable"] is True
    assert first["growth_rate"] < 0.0
    assert first["largest_multiplier"] == pytest.approx(
        np.exp(first["growth_rate"] * 2.0 * np.pi / first["speed_rad_s"]), rel=1e-3
    )
    assert second["impulse_per_revolution"] != first["impulse_per_revolution"]
    assert "no contact at 0.5" in refusal("periodic", file, "--speeds", "0.5")


@pytest.mark.slow
def test_the_command_draws_the_forces(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(imbalance(**{"contact.friction": 0.0})))
    assert "1.198" in answer("periodic", file, "-o", tmp_path / "out").stdout
    assert (tmp_path / "out" / "periodic.png").exists()


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"casing.profile": {"harmonics": [{"lobes": 2, "amplitude": "0.1 mm"}]}}, "round"),
        ({"coupling.stiffness": 1e5}, "static frame"),
        ({"shaft": {"frame": "static", "stiffness_y": "20 MN/m"}}, "static frame"),
    ],
)
def test_what_is_not_constant_in_rotating_axes(changes: Any, reason: str) -> None:
    problem = contact_problem(build_stage(imbalance(**changes)))
    assert any(reason in each for each in obstacles(problem))
    with pytest.raises(ValueError, match=reason):
        corotating_contact(problem)


def round_disk(speed: float, friction: float, angle: FloatArray, local: float) -> ContactProblem:
    """A rotor of unit mass in an elastic stator of unit stiffness, in the form of Jiang and Ulbrich
    (2001), X'' + 2 z X' + b X + (1 - R0 / R)(1 + i mu) X = W^2 exp(i W t) with b = 0.04, z = 0.05,
    R0 = 1.05. Tips at angles touch the wall of the stator, with a flexibility of their own."""
    tips, square = len(angle), STIFFNESS - speed**2
    compliance = np.zeros((1, 3 * tips, 3 * tips))
    compliance[0, 0::3, 0::3] = np.cos(angle[:, None] - angle) + local * np.eye(tips)
    rotor = ReducedRotor(
        frequency=np.full(2, np.sign(square) * np.sqrt(np.abs(square))),
        damping_ratio=np.zeros(2),
        contact=contact_rows(
            np.column_stack([np.cos(angle), np.sin(angle)]),
            np.column_stack([-np.sin(angle), np.cos(angle)]),
            np.zeros((tips, 2)),
        ),
        centre=np.eye(2),
        tip_angle=angle,
        tip_radius=1.0,
        tip_recess=np.zeros(tips),
        column=np.full(2, -1),
        dampers=np.sqrt(2.0 * DAMPING) * np.eye(2),
        by_velocity=2.0 * speed * np.array([[0.0, -1.0], [1.0, 0.0]]),
        circulation=2.0 * DAMPING * speed,
        contact_radius=np.ones(tips),
        compliance=compliance,
    )
    return ContactProblem(
        rotor=rotor,
        casing=ReducedCasing.rigid(np.tile([GAP, 0.0], (8, 1)), 2.0),
        speed=speed,
        friction=friction,
        sliding="permanent",
        tip_rotation=False,
        displacement_limit=10.0,
        loads=(Load(rotor=np.array([speed**2, 0.0]), casing=np.zeros(0)),),
        start=Start.of_rotor(np.zeros(2), np.zeros(2), 0),
    )


def annular_rub(speed: float, friction: float) -> tuple[complex, float]:
    """Displacement of the centre and growth rate of the equation itself, in rotating axes."""
    alone = STIFFNESS - speed**2 + 2j * DAMPING * speed

    def moved(radius: float) -> complex:
        return speed**2 / (alone + (1.0 - GAP / radius) * (1.0 + 1j * friction))

    radius = so.brentq(lambda radius: abs(moved(radius)) - radius, GAP, 10.0)
    x, share = moved(radius), 0.5 * GAP / radius
    own = alone + (1.0 + 1j * friction) * (1.0 - share)
    other = (1.0 + 1j * friction) * share * np.exp(2j * np.angle(x))
    rate = 2.0 * DAMPING + 2j * speed
    matrix = np.zeros((4, 4), dtype=np.complex128)
    matrix[:2, 2:] = np.eye(2)
    matrix[2:] = [[-own, -other, -rate, 0.0], [-np.conj(other), -np.conj(own), 0.0, -np.conj(rate)]]
    return x, float(np.linalg.eigvals(matrix).real.max())


@pytest.mark.parametrize(
    ("friction", "speed", "radius"),
    [(0.05, 0.5, 1.61397028), (0.1, 0.5, 1.59595483), (0.05, 0.8, 3.78726350)],
)
def test_radii_of_annular_rub_above_the_critical_speed(
    friction: float, speed: float, radius: float
) -> None:
    """With one tip in the direction of the displacement, and with a rim of many tips."""
    x, growth = annular_rub(speed, friction)
    assert abs(x) == pytest.approx(radius, abs=1e-8)
    one = corotating_contact(round_disk(speed, friction, np.array([np.angle(x)]), 0.0))
    assert complex(*one.centre) == pytest.approx(x, abs=1e-9)
    rim = corotating_contact(round_disk(speed, friction, RIM + np.angle(x), 0.1))
    assert np.hypot(*rim.centre) == pytest.approx(radius, rel=1e-2)
    assert rim.stable
    assert rim.rates[0].real == pytest.approx(growth, rel=0.05)
    assert not one.stable  # a single tip slips aside


@pytest.mark.parametrize(("friction", "limit"), [(0.15, 0.4215), (0.2, 0.2890), (0.3, 0.1855)])
def test_annular_rub_loses_its_stability_at_known_speeds(friction: float, limit: float) -> None:
    for speed in (0.97 * limit, 1.03 * limit):
        x, growth = annular_rub(speed, friction)
        found = corotating_contact(round_disk(speed, friction, RIM + np.angle(x), 0.2))
        assert found.stable == (growth < 0.0) == (speed < limit)


@pytest.mark.parametrize(
    ("speed", "touches"), [(0.152, False), (0.157, True), (0.95, True), (1.0, False)]
)
def test_the_range_of_annular_rub(speed: float, touches: bool) -> None:
    """From 0.154 to 0.9925; near its end the motion without contact exists too."""
    around = 2.0 * np.pi / 120 * np.arange(120.0)
    assert corotating_contact(round_disk(speed, 0.1, around, 0.02)).normal.any() == touches


def test_a_branch_leads_through_the_folds_of_annular_rub() -> None:
    """It turns back and forth as tips join or leave those in contact, and ends without contact; of
    the states at a speed it meets each once."""
    angle = 2.0 * np.pi / 12 * np.arange(12.0)

    def at(speed: float) -> ContactProblem:
        return round_disk(speed, 0.1, angle, 0.02)

    followed = ContactBranch(lambda speed: Equations(at(speed)), 0.1, 1.2, 8)
    points = list(followed.follow(contact_states(at(0.1))[0]))
    place, way = (
        np.array([getattr(point, name) for point in points]) for name in ("parameter", "way")
    )
    folds = np.array([point.kind == FOLD for point in points])
    assert (folds[1:] == (way[1:] != way[:-1])).all()
    assert place[-1] == 1.2
    assert place[folds].max() == pytest.approx(0.9925, rel=0.01)  # end of the rub of a full rim
    for point in points:
        contact = point.contact
        assert contact.normal.min() >= 0.0
        assert contact.gap.min() > -1e-7
        assert np.abs(contact.normal * contact.gap).max() < 1e-9
    for speed in (0.5, 0.9, 0.96):
        known = {tuple(np.flatnonzero(each.normal)) for each in contact_states(at(speed))}
        ends = (place[:-1] - speed) * (place[1:] - speed) < 0.0
        met = [tuple(np.flatnonzero(points[n].chosen)) for n in np.flatnonzero(ends)]
        assert len(met) == len(set(met))
        assert set(met) <= known  # there are closed branches besides


@pytest.mark.parametrize("ring", [None, pytest.param(96, marks=pytest.mark.slow)])
def test_small_deviations_are_those_of_a_march(ring: int | None) -> None:
    """With friction in the direction of the slip velocity and Coriolis forces."""
    skew, push = np.zeros((8, 8)), np.zeros((3, 8))
    skew[0, 1], skew[1, 0] = 300.0, -300.0
    push[:, 0] = 300.0, 250.0, 0.0
    wall = None if ring is None else casing(ring, damping=0.01)
    given = bladed(3, 2, ring=wall, by_velocity=skew, friction=0.3, sliding="full")
    if wall is None:
        flat = np.tile([CLEARANCE, 0.0], (len(given.casing.clearance), 1))
        given = replace(given, casing=replace(given.casing, clearance=flat))
    still = np.zeros(len(given.casing.frequency))
    problem = replace(given, loads=(Load(rotor=push.ravel(), casing=still),))
    found = corotating_contact(problem)
    assert 0 < np.count_nonzero(found.normal) < 6
    start = of_corotating(problem, found)[0]
    kick, moved = 1e-4 * np.random.default_rng(3).standard_normal(24), []
    for velocity in (start.rotor_velocity, start.rotor_velocity + kick):
        begun = replace(problem, start=replace(start, rotor_velocity=velocity))
        moved.append(advanced(begun, 1e-6, 1600, 200).rotor_displacement)
    stiffness, damping = deviations(problem, Structure.of_problem(problem), found.normal)
    size = len(stiffness)
    matrix = np.block([[np.zeros((size, size)), np.eye(size)], [-stiffness, -damping]])
    first = np.zeros(2 * size)
    first[size : size + 24] = kick
    expected = np.array([(la.expm(matrix * 2e-4 * n) @ first)[:24].real for n in range(9)])
    assert moved[1] - moved[0] == pytest.approx(expected, abs=3e-3 * np.abs(expected).max())


def test_a_ring_without_contact_decays_by_its_damping_ratio() -> None:
    """A wave of the frequency w and n periods decays by zeta w, and in axes that turn with Omega
    its frequency is lower by n Omega."""
    problem = bladed(3, 2, ring=casing(24, damping=0.02), friction=0.3)
    rotor, wall = problem.rotor, problem.casing
    stiffness, damping = deviations(problem, Structure.of_problem(problem), np.zeros(6))
    size = len(stiffness)
    matrix = np.block([[np.zeros((size, size)), np.eye(size)], [-stiffness, -damping]])
    found, own = la.eigvals(matrix), len(rotor.frequency) * rotor.copies
    assert size > own
    order, _, mode = (ring := Ring.of_casing(wall)).both_ways
    w = ring.frequency[mode]
    turned = -0.02 * w + 1j * (w * np.sqrt(1.0 - 0.02**2) - order * problem.speed)
    apart = np.abs(found[:, None] - turned).min(axis=0)
    assert apart == pytest.approx(0.0, abs=1e-9 * wall.frequency.max())


def test_constant_contact_of_beams_needs_no_time_step(tmp_path: Path) -> None:
    """With a damper in the static frame above the critical speed."""
    changes = {
        "bladed_disk.elements_per_blade": 2,
        "casing": {"type": "rigid", "clearance": "1 mm"},
        "shaft": {"stiffness": "3.4e7 N/m", "damping": 1e4, "damping_frame": "static"},
        "rotation.effects": "full",
        "march.speed": 1.3,
        "march.time_step": "1 ms",
        "march.record_step": "1 ms",
        "excitation": {"type": "imbalance", "clearance_speed": 0.9, "ramp": "0.1 s"},
    }
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(imbalance(**changes)))
    (found,) = json.loads(answer("periodic", file, "--json").stdout)["solutions"]
    assert found["tips"] > 0
    done = answer("periodic", file, "-o", tmp_path / "motion")
    assert "no record for films: march.time_step" in done.output
    assert "critical step" in refusal("run", file, "-o", tmp_path / "run")


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"coupling.stiffness": 1e5}, "springs in the static frame"),
        ({"excitation": {"type": "none"}}, "no load acts on the bladed disk"),
    ],
)
def test_refusals_of_beams_name_what_is_not_constant(
    tmp_path: Path, changes: Any, reason: str
) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(imbalance(**changes)))
    message = refusal("periodic", file)
    assert reason in message
    assert "not constant in rotating axes" in message


def test_a_blade_without_load_has_other_obstacles() -> None:
    assert list(obstacles(contact_problem(build_stage(case())))) == ["the clearance is not round"]

"""Marches whose speed is free: angular momentum, energy, and a disk that friction brakes."""

from dataclasses import replace

import numpy as np
import pytest
from contact_cases import problem, small_casing, wall

from bladewhirl.models.case.case import case_from
from bladewhirl.models.case.closure import Closure
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.models.stage.varying_speed import FreeSpeed, SpeedChange
from bladewhirl.models.stage.wall import WallClosure
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import Chunk
from bladewhirl.studies.verification.bodies import marched, point_mass
from bladewhirl.studies.verification.speed import five_masses, masses_on_springs

SMALL = {
    "bladed_disk": {"blades": 9},
    "reduction": {"fixed_interface_modes": 36},
    "rotation": {"effects": "full"},
    "excitation": {"type": "imbalance", "unbalance": 0.05, "ramp": 0.0},
    "initial": {"centre_velocity": [0.3, 0.0]},
}


def free_stage(*, clearance: float = 1e-3, ratio: float = 0.0, **drive: float) -> ContactProblem:
    further = {
        "casing": {"clearance": clearance},
        "damping": {"ratio": ratio},
        "march": {"speed": 0.8, "drive": {"inertia": 0.1, **drive}},
    }
    return contact_problem(build_beams(case_from(SMALL | further)))


def lost_energy(chunk: Chunk) -> float:
    """Largest error of the balance of the whole energy, relative to this energy."""
    energy = chunk.energy + chunk.rotor_energy
    works = chunk.normal_work + chunk.friction_work + chunk.braking_work
    works = works + chunk.drive_work - chunk.loss_work - chunk.damping_work
    return float(np.abs(energy - energy[0] - works + works[0]).max() / energy[0])


def test_friction_brakes_a_rigid_disk() -> None:
    course = SpeedCourse.through([0.0], [50.0], 0.0)
    start = {"rotor": np.zeros(1), "rotor_velocity": np.array([1.0])}
    body = point_mass(2.0, 300.0)
    given = problem(body, wall(0.0), start=start, speed=50.0, friction=0.2)
    given = replace(given, change=SpeedChange(course=course), drive=FreeSpeed(inertia=0.5))
    chunk = marched(given, 1e-5, 20_000, every=10)
    braked = 0.2 * np.cumsum(chunk.contact_impulse[:, 0]) / 0.5
    assert braked[-1] > 0.1
    np.testing.assert_allclose(chunk.rotation_speed, 50.0 - braked, rtol=1e-12)
    assert lost_energy(chunk) < 1e-12


def test_normal_forces_turn_a_rotor_in_a_wall_that_closes_by_lobes() -> None:
    """A tip is pushed to where the wall is wider: the torque is the force times dR/dtheta, with the
    radius R = 1 m - 1 mm cos(2 theta)."""
    angle = 2.0 * np.pi / 128.0 * np.arange(128.0)
    share = np.column_stack([np.cos(2.0 * angle), -2.0 * np.sin(2.0 * angle)])
    ring, push = (
        small_casing(np.ones(1), 1e-3, nodes=128),
        Load(rotor=np.array([5e3]), casing=np.zeros(1)),
    )
    given = problem(point_mass(2.0, 300.0), ring, loads=(push,), speed=50.0)
    given = replace(
        given,
        closure=WallClosure(course=Closure(table=((0.0, 1e-3),)), share=share),
        change=SpeedChange(course=SpeedCourse.through([0.0], [50.0], 0.0)),
        drive=FreeSpeed(inertia=0.5),
    )
    chunk = marched(given, 1e-5, 20_000, every=1)
    impulse, wider = chunk.contact_impulse[:, 0], 2e-3 * np.sin(2.0 * chunk.rotation_angle)
    turned = np.cumsum(impulse * wider) / 0.5
    assert np.ptp(turned) > 0.05
    np.testing.assert_allclose(
        chunk.rotation_speed[1:] - 50.0, turned[:-1], atol=1e-3 * np.ptp(turned)
    )


def test_momentum_and_energy_of_masses_that_spin_freely() -> None:
    """The momentum from the records, by its own formula, which central differences of the records
    give to the second order; the scheme keeps its own momentum."""
    mass, stiffness, unbalance = five_masses()
    ranges = []
    for dt in (4e-5, 2e-5):
        course = SpeedCourse.through([0.0], [260.0], 0.0)
        given = masses_on_springs(mass, stiffness, unbalance, course)
        along = sum(load.by_square * load.rotor for load in given.loads)
        across = sum(-load.by_acceleration * load.rotor for load in given.loads)
        drive = FreeSpeed(inertia=0.02, along=np.asarray(along), across=np.asarray(across))
        given = replace(given, drive=drive)
        chunk = marched(given, dt, round(1.0 / dt), every=round(1e-3 / dt))
        assert np.ptp(chunk.rotation_speed) > 1e-3
        assert np.ptp(chunk.angular_momentum) <= 1e-10 * chunk.angular_momentum[0]
        assert lost_energy(chunk) < 1e-9
        assert given.change is not None
        momenta = [
            drive.momentum(float(speed), given.change, x, v)
            for speed, x, v in zip(
                chunk.rotation_speed, chunk.rotor_displacement, chunk.rotor_velocity, strict=True
            )
        ]
        ranges.append(np.ptp(momenta) / momenta[0])
    assert ranges[1] < 1e-10
    assert ranges[0] / ranges[1] == pytest.approx(4.0, rel=0.05)


def test_momentum_and_energy_of_a_stage_with_a_torque() -> None:
    given = free_stage(torque=50.0, loss=0.05, ratio=0.01)
    chunk = marched(given, 1e-6, 50_000, every=100)
    assert lost_energy(chunk) < 1e-10
    gained = np.ptp(chunk.angular_momentum)
    lost = 0.05 * (chunk.rotation_angle[-1] - chunk.rotation_angle[0])
    assert gained == pytest.approx(50.0 * chunk.time[-1] - lost, rel=1e-6)


def test_static_dampers_take_the_momentum_of_their_torque() -> None:
    """A damper c at rest brakes a shaft by c (u x v + Omega u^2) with the displacement u and the
    velocity v of its centre in rotating axes."""
    damping, dt = 3e4, 4e-6
    further = {
        "casing": {"clearance": 0.1},
        "damping": {"ratio": 0.0},
        "march": {"speed": 0.8, "drive": {"inertia": 0.1}},
        "shaft": {"stiffness": 3e7, "damping": damping, "damping_frame": "static"},
        "initial": {"centre_velocity": [4.0, -2.0]},
    }
    given = contact_problem(build_beams(case_from(SMALL | further)))
    chunk = marched(given, dt, 5000, every=1)
    x, y = (chunk.rotor_displacement @ given.rotor.centre.T).T
    v, w = (chunk.rotor_velocity @ given.rotor.centre.T).T
    speed = chunk.rotation_speed
    torque = -damping * (x * w - y * v + speed * (x**2 + y**2))
    braked = dt * (np.cumsum(torque) - 0.5 * (torque + torque[0]))
    gained = chunk.angular_momentum - chunk.angular_momentum[0]
    assert np.abs(x * w - y * v).max() > 0.5 * (speed * (x**2 + y**2)).max()  # both parts act
    np.testing.assert_allclose(gained, braked, atol=2e-3 * np.abs(braked).max())


def test_energy_of_a_stage_that_rubs() -> None:
    chunk = marched(free_stage(clearance=2e-4, ratio=0.01), 1e-6, 50_000, every=100)
    assert chunk.contact_impulse.sum() > 1.0
    assert lost_energy(chunk) < 5e-12
    assert chunk.rotation_speed[-1] < chunk.rotation_speed[0]
    for dt in (1e-6, 2.5e-7):
        hard = marched(free_stage(clearance=7e-5), dt, round(0.05 / dt), every=round(1e-4 / dt))
        assert hard.contact_impulse.sum() > 100.0
        assert lost_energy(hard) < 3e-9  # 2e-8 and 4e-7 with works at other speeds


def test_a_coasting_march_that_is_resumed_is_the_same() -> None:
    given = free_stage(clearance=2e-4)
    scheme, other = CentralDifference(given, 1e-6, 100), CentralDifference(given, 1e-6, 100)
    whole = scheme.advance(scheme.init(), 5001)[0]
    half = scheme.advance(scheme.init(), 2301)[0]
    rest = other.advance(half, 5001 - 2301)[0]
    for name in ("rotor", "drive"):
        np.testing.assert_array_equal(rest.arrays[name][:2], whole.arrays[name][:2])


@pytest.mark.parametrize(
    ("further", "message"),
    [
        ({"march": {"speed": 0.0, "drive": {}}}, r"march\.speed = 0.*other than 0"),
        (
            {"march": {"run_up": {"from": 0.3, "to": 1.0, "end": 2.0}, "drive": {}}},
            r"march\.run_up",
        ),
        ({"excitation": {"type": "imbalance", "unbalance": 0.1}}, r"excitation\.ramp = 0\.2"),
        ({"excitation": {"type": "harmonic"}}, r"excitation\.type"),
        ({"coupling": {"stiffness": 1e5}}, r"coupling\.stiffness"),
        ({"contact": {"sliding": "full"}}, r"contact\.sliding"),
        ({"rotation": {"effects": "centrifugal"}}, r"rotation\.effects"),
    ],
)
def test_what_a_free_speed_does_not_allow(
    further: dict[str, dict[str, object]], message: str
) -> None:
    with pytest.raises(CaseError, match=message):
        case_from(SMALL | {"march": {"drive": {"inertia": 0.1}}} | further)

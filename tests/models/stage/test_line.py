"""A shaft line marched in rotating axes against the same line integrated in static axes."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contact_cases import ledger_residual
from reference_march import Reference
from scipy.integrate import solve_ivp

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.case.excitation import Harmonic
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.shaft_line.line import real_form
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.line import LineStage
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import Chunk

LINE: dict[str, Any] = {
    "segments": [{"length": 0.6, "outer_diameter": 0.04, "elements": 2}],
    "disks": [
        {
            "position": 0.45,
            "mass": 8.0,
            "polar_inertia": 0.06,
            "diametral_inertia": 0.032,
            "offset": 0.01,
        }
    ],
    "bearings": [
        {
            "position": 0.0,
            "stiffness": [[2e6, 3e5], [-2e5, 4e6]],
            "damping": [[400.0, 30.0], [-50.0, 900.0]],
            "tilt_stiffness": [[3e3, 100.0], [0.0, 1e3]],
            "support": {"mass": 3.0, "stiffness": [[4e6, 0.0], [1e5, 6e6]], "damping": 300.0},
        },
        {"position": 0.6, "stiffness": [[3e6, 0.0], [0.0, 2e6]], "damping": 500.0},
    ],
    "unbalance": [
        {"position": 0.45, "unbalance": 2e-3, "phase": 0.4},
        {"position": 0.3, "couple": 1e-4, "couple_phase": 2.0},
    ],
    "loss_time": 2e-6,
}


def line_case(
    march: dict[str, Any], *, gravity: bool = True, loads: Any = None, **changed: Any
) -> Case:
    """A case of the line."""
    tables = {"shaft_line": LINE | {"modes": 100} | changed, "march": march}
    tables |= {"excitation": loads} if loads else {}
    return case_from(tables | ({"gravity": {}} if gravity else {}))


def stage_of(case: Case) -> LineStage:
    """The stage of a shaft line."""
    stage = build_stage(case)
    assert isinstance(stage, LineStage)
    return stage


def marched(case: Case, step: float, end: float) -> tuple[FloatArray, Chunk]:
    """Deflections x and y of all nodes at the last record, (nodes, 2), and the records."""
    stage = build_stage(with_values(case, {"march.time_step": step}))
    scheme = CentralDifference(contact_problem(stage), step, 10)
    chunk = scheme.advance(scheme.init(), round(end / step) + 1)[1]
    return chunk.shaft_displacement[-1, :, :2], chunk


def in_static_axes(stage: LineStage, end: float) -> FloatArray:
    """The same deflections by integration of the equations in static axes, from the sag."""
    line, course = stage.line, stage.case.march.course(stage.reference_frequency)
    unbalance = line.unbalance_force(line.table.unbalance)
    gravity = stage.case.gravity
    weight = line.weight(complex(*gravity.acceleration) if gravity else 0.0)
    inverse = np.linalg.inv(real_form(line.mass))
    still = np.array(line.matrices(0.0)[1:])  # damping and stiffness, linear in the speed
    by_speed = (np.array(line.matrices(1e3)[1:]) - still) / 1e3
    euler = real_form((-0.5j * line.polar).astype(np.complex128))

    def turned(time: float) -> tuple[float, float, float]:
        if course is None:
            return stage.speed * time, stage.speed, 0.0
        each = course.angle(time), course.speed(time), course.acceleration(time)
        return float(each[0]), float(each[1]), float(each[2])

    def real(values: ComplexArray) -> FloatArray:
        return np.concatenate([values.real, values.imag])

    def rate(time: float, state: FloatArray) -> FloatArray:
        angle, speed, acceleration = turned(time)
        damping, stiffness = still + speed * by_speed
        z, v = np.split(state, 2)
        whirling = unbalance * (speed**2 - 1j * acceleration) * np.exp(1j * angle)
        for load in stage.case.excitations.values():
            if not isinstance(load, Harmonic):
                continue
            assert load.position is not None
            turn = np.exp(1j * angle) if load.frame == "rotating" else 1.0
            push = load.force * np.cos(2.0 * np.pi * load.frequency * time)
            whirling[2 * line.node(load.position)] += push * turn
        force = real(weight + whirling) - damping @ v - stiffness @ z - acceleration * (euler @ z)
        return np.concatenate([v, inverse @ force])

    sag = np.linalg.solve(line.matrices(turned(0.0)[1])[2], real(weight))
    start = np.concatenate([sag, np.zeros_like(sag)])
    found = solve_ivp(rate, (0.0, end), start, method="DOP853", rtol=1e-11, atol=1e-14)
    x, y = np.split(found.y[: len(sag), -1], 2)
    size = 2 * len(line.position)
    return np.stack([x[:size:2], y[:size:2]], axis=1)


@pytest.mark.parametrize(
    ("march", "loads"),
    [
        ({"speed": "2400 rpm"}, ["static", "rotating"]),
        pytest.param({"speed": "-2400 rpm"}, [], marks=pytest.mark.slow),
        pytest.param(
            {"speed_table": [[0.0, "0 rpm"], [0.02, "6000 rpm"], [0.03, "5000 rpm"]]},
            ["static"],
            marks=pytest.mark.slow,
        ),
    ],
    ids=["constant", "reversed", "varying"],
)
def test_second_order_of_the_step_towards_the_motion_in_static_axes(
    march: dict[str, Any], loads: list[str]
) -> None:
    """Unequal bearings with cross terms, a support, tilt springs, gravity, internal damping, and
    harmonic forces."""
    pushes = [
        {"type": "harmonic", "force": 200.0, "frequency": 60.0, "position": at, "frame": frame}
        for frame, at in zip(loads, (0.45, 0.3), strict=False)
    ]
    case, end = line_case(march, loads=pushes), 0.02
    exact = in_static_axes(stage_of(case), end)
    errors = []
    for step in (2e-6, 1e-6):
        found, chunk = marched(case, step, end)
        errors.append(np.abs(found - exact).max() / np.abs(exact).max())
        assert ledger_residual(chunk) < 1e-9
    assert errors[1] < 3e-7
    assert 3.7 < errors[0] / errors[1] < 4.3


def test_a_line_on_few_modes_moves_as_the_whole_line() -> None:
    case, end = line_case({"speed": "2400 rpm"}), 0.02
    fewer = line_case({"speed": "2400 rpm"}, modes=6)
    whole, few = (marched(each, 1e-6, end)[0] for each in (case, fewer))
    assert np.abs(few - whole).max() < 1e-3 * np.abs(whole).max()


def test_sag_is_a_state_of_rest() -> None:
    """Without unbalance, a line that starts from its sag stays there, also on supports."""
    for speed in ("0 rpm", "2400 rpm"):
        case = line_case({"speed": speed}, unbalance=[])
        _, chunk = marched(case, 2e-6, 0.02)
        moved = chunk.shaft_displacement
        assert np.abs(moved - moved[0]).max() < 1e-7 * np.abs(moved).max()
        weight = -stage_of(case).line.weight(1j)[:-1:2].sum()
        np.testing.assert_allclose(chunk.bearing_force[-1].sum(axis=0)[1], -9.81 * weight.imag)
        assert chunk.support_displacement[-1, 0, 1] < 0.0
        assert not chunk.support_displacement[:, 1].any()
    unbent = with_values(line_case({"speed": 0.5}), {"gravity.start": "unbent"})
    assert not contact_problem(build_stage(unbent)).start.rotor.any()


def test_reversed_speed_is_the_mirror_image() -> None:
    """In a mirror, cross terms and phases change their sign."""
    bearings = LINE["bearings"]
    mirrored = [
        {**row, **{key: (np.array(row[key]) * [[1, -1], [-1, 1]]).tolist() for key in keys}}
        for row, keys in zip(
            bearings, (("stiffness", "damping", "tilt_stiffness"), ("stiffness",)), strict=True
        )
    ]
    mirrored[0]["support"] = {**bearings[0]["support"], "stiffness": [[4e6, 0.0], [-1e5, 6e6]]}
    unbalance = [
        {key: -value if "phase" in key else value for key, value in row.items()}
        for row in LINE["unbalance"]
    ]
    image = line_case({"speed": "-2400 rpm"}, gravity=False, bearings=mirrored, unbalance=unbalance)
    given = line_case({"speed": "2400 rpm"}, gravity=False)
    found, expected = marched(image, 2e-6, 0.01)[0], marched(given, 2e-6, 0.01)[0]
    np.testing.assert_allclose(found * [1, -1], expected, rtol=0, atol=1e-9 * abs(expected).max())


FREE = {"speed": "3000 rpm", "drive": {"inertia": 0.0}, "displacement_limit": 1.0}


def free_line(
    march: dict[str, Any], tilt: float, every: int, modes: int
) -> tuple[LineStage, Chunk]:
    """A tilted line without bearings, with records every `every` steps in 0.04 s."""
    case = line_case(march, gravity=False, unbalance=[], loss_time=0.0, modes=modes)
    stage, step = stage_of(case), case.march.time_step
    problem = contact_problem(stage)
    tilted = np.zeros(2 * len(stage.line.position), dtype=np.complex128)
    tilted[0::2], tilted[1::2] = stage.line.position - 0.3, 1.0
    start = tilt * stage.reduced.coordinates(tilted * (1.0 + 0.5j))
    moving = Start.of_rotor(start, 400.0 * start[::-1], len(stage.casing_rest))
    assert problem.bearings is not None
    nothing = 0.0 * problem.bearings.stiffness
    free = replace(problem.bearings, stiffness=nothing, damping=nothing)
    scheme = CentralDifference(replace(problem, start=moving, bearings=free), step, every)
    return stage, scheme.advance(scheme.init(), round(0.04 / step) + 1)[1]


def test_a_free_tilted_line_keeps_its_momentum_about_the_axis() -> None:
    stage, chunk = free_line(FREE | {"time_step": 2e-6}, 0.05, 100, modes=100)
    assert np.ptp(chunk.rotation_speed) > 1e-3 * stage.speed
    momentum, total = chunk.angular_momentum, chunk.energy + chunk.rotor_energy
    assert np.ptp(momentum) < 1e-10 * abs(momentum[0])
    assert np.ptp(total) < 3e-6 * abs(total[0])  # Coriolis forces half a step late, see `speed.h`


@pytest.mark.parametrize(
    ("march", "tolerance"),
    [
        ({"speed": "3000 rpm", "displacement_limit": 1.0, "time_step": 5e-5}, 1e-10),
        (FREE | {"time_step": 1e-5}, 2e-9),
    ],
    ids=["constant", "free"],
)
def test_a_free_tilted_line_keeps_its_momentum_across_the_axis(
    march: dict[str, Any], tolerance: float
) -> None:
    """In static axes, to rounding, which is a larger part of the small changes in short steps: M z'
    - i W P z for the translation and the rotation about a point. The tilt is so small that the
    third order of the motion, which linear equations lack, is below the tolerance."""
    stage, chunk = free_line(march, 1e-6, 1, modes=6)
    size, modes = 2 * len(stage.line.position), len(stage.reduced.squares)
    mass, polar = (each[:size, :size] for each in (stage.line.mass, stage.line.polar))
    rigid = np.zeros((size, 2))
    rigid[0::2] = np.stack([np.ones(size // 2), stage.line.position - 0.3], axis=1)
    rigid[1::2, 1] = 1.0
    moved = chunk.rotor_displacement
    place = (moved[:, :modes] + 1j * moved[:, modes:]) @ stage.reduced.shapes.T
    place *= np.exp(1j * stage.speed * chunk.time)[:, None]
    rate, mean = np.diff(place, axis=0) / march["time_step"], (place[1:] + place[:-1]) / 2.0
    momentum = (rate @ mass - 1j * stage.speed * (mean @ polar)) @ rigid
    changes = np.abs(momentum - momentum[0]).max(axis=0) / np.abs(momentum[0])
    assert (changes < tolerance).all()
    assert (np.abs(np.diff(momentum, axis=0)) > 0.0).any()


def test_the_kernel_marches_a_line_with_a_free_speed_as_numpy() -> None:
    march = {"speed": "2400 rpm", "drive": {"inertia": 0.01, "torque": 3.0, "loss": 1e-3}}
    problem = contact_problem(build_stage(line_case(march, gravity=False)))
    fast, plain = CentralDifference(problem, 4e-6, 7), Reference(problem, 4e-6, 7)
    chunk = fast.advance(fast.init(), 400)[1]
    expected = plain.advance(plain.init(), 400)[1]
    for name in ("rotor_displacement", "rotation_speed", "angular_momentum"):
        found, known = getattr(chunk, name), getattr(expected, name)
        np.testing.assert_allclose(found, known, rtol=0, atol=1e-9 * np.abs(known).max())
    known = expected.casing_displacement / np.sqrt(3.0)  # the mass of the support
    found = chunk.support_displacement[:, 0]
    np.testing.assert_allclose(found, known, rtol=0, atol=1e-9 * np.abs(known).max())
    assert ledger_residual(chunk) < 1e-10
    whole = chunk.energy + chunk.rotor_energy - chunk.braking_work - chunk.drive_work
    whole += chunk.loss_work + chunk.damping_work
    assert np.ptp(whole) < 1e-10 * abs(whole[0])


@pytest.mark.parametrize(
    ("load", "fault"),
    [
        ({"type": "harmonic"}, r"excitation.position.*: expected the position of the force along"),
        ({"type": "harmonic", "position": 0.7}, r"excitation.position = 0.7: .*from 0 m to 0.6 m"),
        ({"type": "imbalance"}, r"excitation.type = .*: expected a row of shaft_line.unbalance"),
        ({"type": "engine-order"}, r"excitation.*: not allowed together with"),
    ],
)
def test_loads_that_a_line_does_not_feel_are_refused(load: dict[str, Any], fault: str) -> None:
    with pytest.raises(CaseError, match=fault):
        line_case({"speed": "2400 rpm"}, loads=load)

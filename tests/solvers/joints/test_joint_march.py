"""Marches with joints against linear limits, an independent march, and the contact law."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from joint_cases import BLADES, blade, tables
from joint_march import Wheel

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.postprocess.run.measures import energy_residual
from bladewhirl.solvers.periodic import joint_search
from bladewhirl.solvers.periodic.joint_search import joint_motion
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

MODES, ORDER, RECORDS = 8, 2, 64


def case(
    folder: Path, steps: int, turns: int, changes: dict[str, Any] | None = None, **joint: Any
) -> bw.Case:
    """A case of so many steps in a turn, of which some are recorded."""
    own = tables(folder, **joint) | {
        "reduction": {"free_interface_modes": MODES},
        "damping": {"ratio": 0.1},
        "march": {
            "speed": "3000 rpm",
            "revolutions": turns,
            "steps_per_revolution": steps,
            "record_step": 0.02 / RECORDS,
        },
    }
    for key, value in (changes or {}).items():
        own[key] = own[key] | value if isinstance(own.get(key), dict) else value
    return bw.case_from(own)


def marched(given: bw.Case) -> xr.Dataset:
    data, report = march_in_memory(prepare(given))
    assert report["unsolved_steps"] == 0
    return data


def amplitude(moved: FloatArray, order: int) -> ComplexArray:
    """Amplitude of an engine order in the last turn of histories, (time, ...)."""
    late = moved[-RECORDS:]
    return np.asarray(np.fft.fft(late, axis=0)[order] * 2.0 / RECORDS)


@pytest.mark.parametrize(
    ("joint", "held"),
    [
        ({"friction": 1e4, "preload": "1 kN"}, [0, 1, 2]),
        ({"friction": 0.0, "preload": "1 kN"}, [0]),
        ({"gap": "20 mm"}, []),
    ],
    ids=["stuck", "frictionless", "free"],
)
def test_limits_are_linear(tmp_path: Path, joint: dict[str, Any], held: list[int]) -> None:
    stage = build_stage(case(tmp_path, 512, 1, **joint))
    assert isinstance(stage, Matrices)
    given = jointed_wheel(stage)
    flexible = given.flexibility(ORDER, ORDER * given.speed)
    force = np.zeros(given.values, dtype=np.complex128)
    if held:
        own = flexible[np.ix_(held, held)]
        force[held] = np.linalg.solve(own, -given.unloaded(ORDER)[held])
    exact = np.abs(given.at_points(ORDER, force)[-1])  # the tip, which is contact node 2
    coarse, fine = (
        np.abs(
            amplitude(
                marched(case(tmp_path, steps, 40, **joint))["contact_displacement"].values[:, 2],
                ORDER,
            )
        )
        for steps in (1024, 2048)
    )
    assert fine == pytest.approx(exact, rel=2e-4)
    assert (4.0 * fine - coarse) / 3.0 == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize(
    "factors",
    [pytest.param((), marks=pytest.mark.slow), (1.1, 0.95, 1.02)],
    ids=["tuned", "mistuned"],
)
@pytest.mark.parametrize(
    "overclosure",
    [*(pytest.param(each, marks=pytest.mark.slow) for each in (1.2e-3, 5e-4)), 3e-4],
)
def test_a_motion_is_that_of_an_independent_march(
    tmp_path: Path, overclosure: float, factors: tuple[float, ...]
) -> None:
    file = tmp_path / "three.npz"
    bw.write_superelement(file, blade(3))
    changes = {
        "bladed_disk": {
            "superelement": {"file": str(file), "copies": 3},
            "mistuning": {"stiffness": list(factors)},
        },
        "excitation": {"order": 1, "amplitude": 20.0},
    }
    speed, inclined = 100.0 * np.pi, np.pi / 6.0
    independent = Wheel(3, MODES, 0.1, speed, 1, 20.0, -overclosure, 0.3, inclined, factors)
    coarse, fine = (
        marched(case(tmp_path, steps, 12, changes, overclosure=overclosure))
        for steps in (1024, 2048)
    )
    moved = []
    for data in (coarse, fine):
        modes = amplitude(data["rotor_displacement"].values, 1).reshape(3, MODES)
        moved.append(np.abs(modes @ data["contact_shape"].values[2].T)[:, 1:])
    assert moved[0] == pytest.approx(moved[1], rel=3e-3)
    assert moved[1] == pytest.approx(independent.march(128, 12)[0][:, 1:], rel=3e-3)
    shares = fine["joint_steps"].values[-RECORDS:].sum(axis=(0, 1))
    assert shares[2] > 0
    assert (shares[0] > 0) == (overclosure < 4e-4)


@pytest.mark.parametrize(
    ("overclosure", "slipping"),
    [(1.2e-3, 0.0), pytest.param(9e-4, 0.0, marks=pytest.mark.slow), (5e-4, 0.9)],
)
def test_a_tuned_wheel_moves_as_the_periodic_motion_of_one_blade(
    tmp_path: Path, overclosure: float, slipping: float
) -> None:
    changes = {"excitation": {"amplitude": 20.0}}
    given = case(tmp_path, 2048, 20, changes, overclosure=overclosure)
    stage = build_stage(given)
    assert isinstance(stage, Matrices)
    wheel = jointed_wheel(stage)
    motion = joint_motion(wheel)
    one = np.abs(wheel.at_points(ORDER, motion.of_order(ORDER)))[-1]
    data = marched(given)
    tips = np.abs(amplitude(data["contact_displacement"].values[:, 2::3], ORDER))
    assert tips[:, 1:] == pytest.approx(np.tile(one[1:], (BLADES, 1)), rel=2e-3)
    work = np.diff(data["joint_work"].values[[-1 - RECORDS, -1]], axis=0)[0] / ORDER
    scale = changes["excitation"]["amplitude"] * one[1]
    assert work == pytest.approx(np.full(BLADES, motion.work.sum()), rel=4e-3, abs=1e-4 * scale)
    steps = data["joint_steps"].values[-RECORDS:].sum(axis=(0, 1))
    assert steps[2] > slipping * steps.sum()


@pytest.mark.slow
def test_a_motion_that_has_no_finer_one_is_compared_with_a_coarser_one(tmp_path: Path) -> None:
    given = case(tmp_path, 2048, 1, {"excitation": {"amplitude": 20.0}}, overclosure=3e-4)
    stage = build_stage(given)
    assert isinstance(stage, Matrices)
    motion = joint_motion(jointed_wheel(stage))
    assert motion.grid.harmonics == joint_search.FIRST * ORDER // motion.grid.order
    assert 0.01 < motion.change < 1.0


def test_forces_satisfy_the_contact_law_and_works_close_the_balance(tmp_path: Path) -> None:
    data = marched(case(tmp_path, 1024, 12, overclosure=2e-5))
    later = data.isel(time=slice(1, None))  # loads begin to act after the first record
    normal, *tangential = np.moveaxis(later["joint_force"].values, -1, 0)
    size, place = np.hypot(*tangential), later["joint_displacement"].values
    gap = data["joint_gap"].values + place[..., 0]
    scale, moved = np.abs(normal).max(), np.abs(place).max()
    assert normal.min() >= 0.0
    assert gap.min() > -1e-9 * moved
    assert (normal * gap).max() < 1e-9 * scale * moved
    assert (size <= 0.3 * normal + 1e-9 * scale).all()
    steps = later["joint_steps"].values.sum(axis=(0, 1))
    assert (steps > 0).all()
    assert steps.sum() == 12 * 1024 * BLADES
    assert np.diff(data["joint_wear"].values, axis=0).min() >= -1e-12
    assert energy_residual(data) < 1e-9


def test_the_start_has_the_preload_without_tangential_force(tmp_path: Path) -> None:
    data = marched(case(tmp_path, 1024, 1, {"excitation": {"amplitude": 0.0}}, preload="200 N"))
    force = data["joint_force"].values
    assert force[..., 0] == pytest.approx(200.0)
    assert np.abs(force[..., 1:]).max() < 1e-9 * 200.0


@pytest.mark.parametrize("sliding", ["permanent", "full"])
@pytest.mark.parametrize("casing", ["rigid", "ring"])
def test_tips_and_joints_touch_in_the_same_step(tmp_path: Path, casing: str, sliding: str) -> None:
    changes = {
        "casing": {"type": casing, "clearance": "0.05 um"},
        "contact": {"sliding": sliding, "friction": 0.1},
        "excitation": {"amplitude": 20.0},
    }
    data = marched(case(tmp_path, 8192, 2, changes, overclosure=2e-5))
    tips = data["gap"].values[:, 2::3]
    assert np.abs(data["contact_force"].values[:, 2::3]).max() > 0.0
    assert tips.min() > -1e-15
    assert data["joint_steps"].values.sum(axis=(0, 1)).min() > 0
    assert energy_residual(data) < 1e-9
    outward = data["contact_displacement"].values[:, 2::3, 0]
    if casing == "rigid":
        assert outward.max() == pytest.approx(5e-8, rel=1e-9)


def damped(folder: Path, steps: int, turns: int, push: float, **wedge: Any) -> bw.Case:
    joint = {"name": "damper", "kind": "wedge", "friction": 0.3, "wedge": wedge}
    changes = {"joint": [joint], "excitation": {"amplitude": push}}
    return case(folder, steps, turns, changes)


def test_a_light_damper_that_sticks_ties_the_blades(tmp_path: Path) -> None:
    stage = build_stage(case(tmp_path, 512, 1, {"excitation": {"amplitude": 0.002}}))
    assert isinstance(stage, Matrices)
    given = jointed_wheel(stage)
    flexible = given.flexibility(ORDER, ORDER * given.speed)
    force = np.linalg.solve(flexible, -given.unloaded(ORDER)).astype(np.complex128)
    exact = np.abs(given.at_points(ORDER, force)[-1])
    data = marched(damped(tmp_path, 2048, 40, 0.002, force="0.5 N", axial="free"))
    found = np.abs(amplitude(data["contact_displacement"].values[:, 2], ORDER))
    assert found == pytest.approx(exact, rel=3e-4)
    assert energy_residual(data) < 1e-9


@pytest.mark.parametrize(
    ("force", "friction"), [(2.0, 0.3), pytest.param(8.0, 0.15, marks=pytest.mark.slow)]
)
def test_dampers_with_mass_move_as_in_an_independent_march(
    tmp_path: Path, force: float, friction: float
) -> None:
    file = tmp_path / "three.npz"
    bw.write_superelement(file, blade(3))
    speed, mass, angle = 100.0 * np.pi, 0.05, np.radians(40.0)
    wedge = {"angle": angle, "mass": mass, "radius": force / mass / speed**2}
    changes = {
        "bladed_disk": {"superelement": {"file": str(file), "copies": 3}},
        "excitation": {"order": 1, "amplitude": 20.0},
        "joint": [{"kind": "wedge", "friction": friction, "wedge": wedge}],
    }
    independent = Wheel(
        3, MODES, 0.1, speed, 1, 20.0, 0.0, friction, angle, damper=(mass, force)
    ).march(256, 12)[0]
    data = marched(case(tmp_path, 2048, 12, changes))
    modes = amplitude(data["rotor_displacement"].values, 1).reshape(3, MODES)
    moved = np.abs(modes @ data["contact_shape"].values[2].T)
    assert moved[:, 1:] == pytest.approx(independent[:, 1:], rel=5e-3)
    assert (data["joint_steps"].values[-RECORDS:].sum(axis=(0, 1))[1:] > 0).all()
    assert energy_residual(data) < 1e-9


def test_a_damper_that_is_free_along_the_axis_walks_alike_each_turn(tmp_path: Path) -> None:
    data = marched(damped(tmp_path, 1024, 20, 5.0, force="3 N", angle="30 deg", axial="free"))
    place = data["damper_displacement"].values[:, :, 2]
    walked = place[-1] - place[-1 - RECORDS]
    assert np.abs(walked).min() > 1e-9
    assert place[-1 - RECORDS] - place[-1 - 2 * RECORDS] == pytest.approx(walked, rel=0.05)
    held = marched(damped(tmp_path, 1024, 2, 5.0, force="3 N", angle="30 deg"))
    assert not held["damper_displacement"].values[:, :, 2].any()


def over_time(given: bw.Case, *speeds: str) -> bw.Case:
    """A case whose speed goes from one to another in twelve turns of 20 ms."""
    march = {
        **dict.fromkeys(["speed", "steps_per_revolution", "revolutions"]),
        "speed_table": [[0.0, speeds[0]], [0.24, speeds[1]]],
        "time_step": 0.02 / 1024,
        "duration": 0.24,
    }
    return bw.with_values(given, {f"march.{key}": value for key, value in march.items()})


def test_a_speed_over_time_that_is_constant_gives_the_same_march(tmp_path: Path) -> None:
    given = case(tmp_path, 1024, 12, overclosure=3e-4)
    one, other = marched(given), marched(over_time(given, "3000 rpm", "3000 rpm"))
    for name in ("contact_displacement", "joint_force"):
        size = np.abs(one[name].values).max()
        assert np.abs(one[name].values - other[name].values).max() < 1e-10 * size


def test_a_march_over_a_varying_speed_conserves_energy(tmp_path: Path) -> None:
    data = marched(over_time(case(tmp_path, 1024, 12, overclosure=3e-4), "2000 rpm", "4000 rpm"))
    assert data["joint_steps"].values[..., 2].sum() > 1000
    assert energy_residual(data) < 1e-8


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"joint.shroud.opening_by_speed": True}, "opening_by_speed = true: expected false"),
        ({"rotation.effects": "centrifugal"}, "rotation.effects"),
        ({"march.drive": {"inertia": 1.0}}, "march.drive"),
        ({"blade_loss": {"blade": 0, "time": 0.01}}, "blade_loss"),
    ],
)
def test_what_a_march_with_joints_does_not_have_is_refused(
    tmp_path: Path, changes: dict[str, Any], expected: str
) -> None:
    given = case(tmp_path, 1024, 12, preload="300 N")
    if "blade_loss" not in changes:
        given = over_time(given, "2000 rpm", "4000 rpm")
    if "march.drive" in changes:
        changes = changes | {"march.speed_table": None, "march.speed": "3000 rpm"}
    with pytest.raises(bw.CaseError, match=expected):
        prepare(bw.with_values(given, changes))

"""Superelements at a speed that varies: beams, static solutions at each speed, energy balance."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from exported_stages import beams, exported
from long_cases import slow_except
from solid_meshes import STEEL, TIE, bladed_sector, cantilever

import bladewhirl as bw
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.cone import in_wall_axes
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.varying_speed import Rotation
from bladewhirl.models.superelements.superelement import dense
from bladewhirl.models.superelements.wheel import whole_wheel
from bladewhirl.postprocess.run.summary import summarise
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

RUN_UP = {
    "time_step": 1e-6,
    "run_up": {"from": 0.5, "to": 0.6, "start": "5 ms", "end": "45 ms"},
    "duration": "50 ms",
}
CLOSING = {"amount": 6e-5, "time_constant": 4e-3, "lobes": [{"lobes": 2, "amplitude": 3e-5}]}


def given(kind: Any = "wheel", march: dict[str, Any] = RUN_UP, **casing: Any) -> bw.Case:
    return beams(
        kind,
        rotation={"effects": "full"},
        excitation={"type": "none"},
        casing={"elements": 20, "support": 7.975e6, "clearance": 5e-5, **casing},
        reduction={"fixed_interface_modes": 35 if kind == "wheel" else 10},
        march=march,
    )


def solid(case: bw.Case, folder: Path, boundary: str, **reduction: Any) -> bw.Case:
    return exported(
        case,
        "wheel",
        folder,
        excitation={"type": "none"},
        reduction={"boundary": boundary, **reduction},
    )


@pytest.mark.parametrize("closure", [None, CLOSING])
def test_a_wheel_with_all_modes_moves_as_its_beams(tmp_path: Path, closure: Any) -> None:
    case = given(closure=closure)
    (one, _), (other, _) = (
        march_in_memory(prepare(each)) for each in (case, solid(case, tmp_path, "consistent"))
    )
    assert (one["contact_impulse"].values.sum() > 0.0) == (closure is not None)
    gap = other["gap"].values.reshape(one["gap"].shape)
    assert np.ptp(gap) > 5e-6
    np.testing.assert_allclose(gap, one["gap"].values, atol=1e-7 if closure else 1e-11)
    np.testing.assert_allclose(
        other["rotor_displacement"].values @ other["centre_shape"].values.T,
        one["rotor_displacement"].values @ one["centre_shape"].values.T,
        atol=1e-8,
    )
    impulse = other["contact_impulse"].values.sum()
    assert impulse == pytest.approx(one["contact_impulse"].values.sum(), rel=1e-4)


def massless(folder: Path, march: dict[str, Any] = RUN_UP, **casing: Any) -> tuple[Any, Any]:
    """Stage and contact problem with few modes and massless ends."""
    case = solid(given(march=march, **casing), folder, "massless", free_interface_modes=12)
    return build_matrices(case), prepare(case).problem


def of_solids(folder: Path, kind: str) -> tuple[Any, Any]:
    """Stage and contact problem of two blades that differ, or of a wheel of sectors."""
    if kind == "blade":
        part = bw.mesh3d(cantilever("hexahedron20", (3, 1, 1)), **STEEL, contacts=2, coriolis=True)
        disk: dict[str, Any] = {"mistuning": {"stiffness": [1.05, 0.98]}}
        disk["superelement"] = {"file": str(folder / "part.npz"), "copies": 2}
    else:
        part = bw.mesh3d(bladed_sector("hexahedron"), **STEEL, **TIE, contacts=2, coriolis=True)
        disk = {"superelement": {"file": str(folder / "part.npz"), "kind": "sector"}}
        disk["superelement"]["copies"] = TIE["copies"]
    assert part.stiffness_speed4 is not None
    bw.write_superelement(folder / "part.npz", part)
    case = bw.case_from(
        {
            "bladed_disk": disk,
            "rotation": {"effects": "full"},
            "casing": {"type": "rigid", "clearance": 1e-4, "slope": "3 deg"},
            "march": {
                "speed_table": [["0 s", "500 rad/s"], ["10 s", "1200 rad/s"]],
                "duration": 0.001,
                "time_step": 2e-7,
            },
            "reduction": {"free_interface_modes": 5},
        }
    )
    return build_matrices(case), prepare(case).problem


def static(problem: ContactProblem, speed: float, force: Any) -> Any:
    """Displacements of the contact nodes from the state at the speed of the problem, at rest at
    another speed and under forces on them, (copies, 3c)."""
    rotor, change, turned = problem.rotor, problem.change, problem.at_speed(speed).rotor
    assert turned.compliance is not None
    assert change is not None
    assert change.rotor is not None
    further = change.rotor.change(speed)
    load = sum(
        (
            each.amplitude(0.0, Rotation(0.0, speed, 0.0), problem.speed) * each.rotor
            for each in problem.loads
        ),
        np.zeros(len(rotor.frequency)),
    )
    found = []
    for copy, (squares, factor) in enumerate(
        zip(rotor.by_copy(rotor.stiffness), change.factor, strict=True)
    ):
        pushed = rotor.by_copy(load)[copy] + rotor.contact.T @ force[copy]
        moved = rotor.contact @ np.linalg.solve(np.diag(squares) + factor * further, pushed)
        found.append(moved + turned.compliance[copy] @ force[copy])
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["wheel", "blade", "sector"])
def test_contact_nodes_are_where_statics_place_them(tmp_path: Path, kind: str) -> None:
    """The steady state of K(Omega) u = Omega^2 F, and the flexibility of K(Omega)."""
    stage, problem = massless(tmp_path) if kind == "wheel" else of_solids(tmp_path, kind)
    part = bw.read_superelement(stage.table.file)
    if kind == "sector":
        part = whole_wheel(part, stage.table.copies)
    springs = np.zeros(part.size)
    if part.centre_dofs is not None:
        springs[part.centre_dofs] = stage.case.shaft.stiffnesses
    shape = (stage.copies, 3 * part.contacts)
    force, zero = np.random.default_rng(3).standard_normal(shape), np.zeros(shape)
    rows, pull = part.contact_rows, part.loads[:, :1]

    def steady(omega: float, force: Any) -> Any:
        stiffness = dense(part.at(omega).stiffness) + np.diag(springs)
        forces = in_wall_axes(force.T, -problem.slope)
        loads = omega**2 * pull + rows.T @ forces
        moved = rows @ np.linalg.solve(stiffness, loads) / stage.factor
        return in_wall_axes(moved, problem.slope).T

    low, high = problem.change.course.range
    for speed in (low, low + 0.3 * (high - low), low + 0.7 * (high - low), high):
        change = steady(speed, zero) - steady(problem.speed, zero)
        scale = np.abs(steady(problem.speed, zero)).max()
        np.testing.assert_allclose(static(problem, speed, zero), change, atol=3e-6 * scale)
        pressed = steady(speed, force) - steady(speed, zero)
        found = static(problem, speed, force) - static(problem, speed, zero)
        np.testing.assert_allclose(found, pressed, atol=3e-6 * np.abs(pressed).max())


@pytest.mark.parametrize("kind", slow_except(["wheel", "blade", "sector"], "wheel", "blade"))
def test_frequencies_at_each_speed_are_those_of_the_file(tmp_path: Path, kind: str) -> None:
    """The first ten, without Coriolis forces, of coordinates that belong to the fastest speed."""
    stage, problem = massless(tmp_path) if kind == "wheel" else of_solids(tmp_path, kind)
    low, high = problem.change.course.range
    fixed = np.sqrt(problem.rotor.by_copy(problem.rotor.stiffness)[0])
    for speed in (low, 0.5 * (low + high), high):
        turned, still = Rotation(0.0, speed, 0.0), np.zeros(len(problem.rotor.frequency))
        columns = [
            -problem.change.change_of_force(problem.speed, turned, unit, still)
            for unit in np.eye(len(still))
        ]
        stiffness = np.diag(problem.rotor.stiffness) + np.array(columns).T
        found = np.sqrt(np.linalg.eigvalsh(stiffness)[:10])
        exact = np.sort(
            (np.sqrt(stage.factor)[:, None] * stage.reduced_at(speed).frequency).ravel()
        )
        np.testing.assert_allclose(found, exact[:10], rtol=2e-4)
    assert abs(fixed[0] / np.sort(stage.reduced_at(low).frequency)[0] - 1.0) > 1e-3


@pytest.mark.slow
def test_the_start_is_the_state_at_the_first_speed(tmp_path: Path) -> None:
    """Without a load nothing moves until the speed does, and the gaps are those at this speed."""
    stage, problem = massless(tmp_path)
    first = 0.5 * stage.reference_frequency
    grown = static(problem, first, np.zeros((1, 3 * len(problem.rotor.tip_angle))))[0, 0::3]
    gap = 5e-5 - grown
    np.testing.assert_allclose(problem.initial_gap(), gap, atol=1e-12)
    result, _ = march_in_memory(prepare(stage.case))
    early = result["time"].values < 0.0045
    np.testing.assert_allclose(
        result["gap"].values[early], np.tile(gap, (early.sum(), 1)), rtol=1e-8
    )


@pytest.mark.slow
def test_works_balance_the_energy_of_massless_ends(tmp_path: Path) -> None:
    stage, _ = massless(tmp_path, closure=CLOSING)
    result, report = march_in_memory(prepare(stage.case))
    assert result["contact_impulse"].values.sum() > 0.0
    assert summarise(result, report).energy_residual < 1e-8


def test_a_constant_speed_in_a_table_is_the_march_at_this_speed(tmp_path: Path) -> None:
    march = {"time_step": 1e-6, "duration": "10 ms"}
    table = march | {"speed_table": [["0 s", 0.6], ["1 s", 0.6]]}
    constant, varied = (
        march_in_memory(prepare(massless(tmp_path, each, closure=CLOSING)[0].case))[0]
        for each in (march | {"speed": 0.6}, table)
    )
    assert constant["contact_impulse"].values.sum() > 0.0
    for name in ("gap", "rotor_displacement", "contact_impulse"):
        one, other = constant[name].values, varied[name].values
        np.testing.assert_allclose(other, one, atol=1e-12 * np.abs(one).max())


def test_a_file_without_the_loads_of_the_rotation_is_refused(tmp_path: Path) -> None:
    case = solid(given(), tmp_path, "massless", free_interface_modes=12)
    file = case.bladed_disk.superelement.file  # type: ignore[union-attr]
    part = bw.read_superelement(file)
    bw.write_superelement(file, replace(part, euler_load=None))
    with pytest.raises(CaseError, match=r"rotation.effects.*centrifugal_load and euler_load"):
        bw.case_from(case.model_dump(exclude_defaults=True))


def coasting(folder: Path, **march: Any) -> bw.Case:
    """Two blades that differ in an oval wall, without effects of the rotation."""
    stage, _ = of_solids(folder, "blade")
    file = stage.table.file
    bw.write_superelement(file, replace(bw.read_superelement(file), gyroscopic=None))
    given = stage.case.model_dump(exclude_defaults=True, include={"bladed_disk", "reduction"})
    return bw.case_from(
        given
        | {
            "casing": {
                "type": "rigid",
                "clearance": 1e-5,
                "clearance_lobes": [{"lobes": 2, "amplitude": 4e-5}],
                "closure": {"amount": 2e-5, "time_constant": 1e-3},
            },
            "contact": {"friction": 0.05},
            "march": {"duration": 0.02, "time_step": 2e-7, "record_step": 1e-5, **march},
        }
    )


def test_blades_brake_a_rotor_that_coasts(tmp_path: Path) -> None:
    """The speed lost is the impulse of the forces on the contact nodes about the axis."""
    drive = {"inertia": 0.05, "torque": 0.3}
    case = coasting(tmp_path, speed="800 rad/s", drive=drive)
    result, report = march_in_memory(prepare(case))
    impulse = result["friction_impulse"].values.sum(axis=0)
    pushed = result["contact_impulse"].values.sum(axis=0)
    assert pushed.sum() > 0.0
    np.testing.assert_allclose(impulse, 0.05 * pushed, rtol=1e-9)
    speed = result["rotation_speed"].values
    gained = 0.05 * (speed[-1] - speed[0])
    # The normal forces of an oval wall have a torque too: force times change of the radius.
    force = result["contact_force"].values[..., 0]
    angle = result["rotation_angle"].values[:, None] + result["tip_angle"].values
    slope = -2 * 4e-5 * np.sin(2 * angle)
    steps = np.gradient(result["time"].values)[:, None]
    normal = float((-force * slope * steps).sum())
    friction = -float((impulse * result["contact_radius"].values).sum())
    assert abs(normal) < 0.2 * abs(friction)
    assert gained == pytest.approx(0.3 * 0.02 + friction + normal, rel=0.02)
    assert summarise(result, report).energy_residual < 1e-8


def test_coriolis_forces_of_one_speed_are_refused(tmp_path: Path) -> None:
    stage, _ = of_solids(tmp_path, "blade")
    given = stage.case.model_dump(exclude_defaults=True, exclude={"rotation"})
    with pytest.raises(CaseError, match=r"rotation.effects.*a file without gyroscopic"):
        bw.case_from(given)


def test_friction_on_blades_changes_its_sign_with_the_speed(tmp_path: Path) -> None:
    table = [["0 s", "300 rad/s"], ["0.02 s", "-300 rad/s"]]
    result, _ = march_in_memory(prepare(coasting(tmp_path, speed_table=table)))
    time, force = result["time"].values, result["contact_force"].values
    for sign, chosen in ((-1.0, time < 0.009), (1.0, time > 0.011)):
        normal, tangential = force[chosen, :, 0], force[chosen, :, 1]
        assert (normal < 0.0).any()
        np.testing.assert_allclose(tangential, -0.05 * sign * normal, atol=1e-9)


SUPERCRITICAL = {"time_step": 5e-7, "duration": "18 ms", "displacement_limit": 1.0}


@pytest.mark.parametrize(
    "march",
    [
        {"speed": "900 rad/s"},
        {"run_up": {"from": "500 rad/s", "to": "800 rad/s", "start": "1 ms", "end": "10 ms"}},
        {"run_up": {"from": "900 rad/s", "to": "500 rad/s", "start": "1 ms", "end": "10 ms"}},
    ],
)
def test_a_wheel_runs_above_its_first_critical_speed(tmp_path: Path, march: Any) -> None:
    """The stiffness of a wheel that spins fast is indefinite; the motion is that of the beams."""
    tables: dict[str, Any] = {"excitation": {"type": "imbalance", "unbalance": 4e-3, "ramp": 0.0}}
    case = beams(
        rotation={"effects": "full"},
        casing={"elements": 20, "support": 7.975e6, "clearance": 1e-4},
        reduction={"fixed_interface_modes": 35},
        march=SUPERCRITICAL | march,
        **tables,
    )
    tables |= {"damping": {"boundary_ratio": case.damping.ratio}}
    wheel = exported(case, "wheel", tmp_path, reduction={"boundary": "consistent"}, **tables)
    assert build_matrices(wheel).reduced.squares[0] < 0.0
    one, other = (march_in_memory(prepare(each))[0] for each in (case, wheel))
    assert one["contact_impulse"].values.sum() > 0.0
    gap, found = one["gap"].values, other["gap"].values
    assert np.abs(found.reshape(gap.shape) - gap).max() < 1e-7 * np.ptp(gap)


def test_a_wheel_with_massless_ends_has_its_frequencies_above_its_critical_speed(
    tmp_path: Path,
) -> None:
    case = given(march={"speed": "900 rad/s", "time_step": 1e-6})
    wheel = solid(case, tmp_path, "massless", free_interface_modes=20)
    stage = build_matrices(wheel)
    table: Any = stage.table
    part: Any = bw.read_superelement(table.file)
    stiffness = dense(part.at(900.0).stiffness)
    stiffness[part.centre_dofs, part.centre_dofs] += stage.case.shaft.stiffnesses
    exact = la.eigh(stiffness, dense(part.mass), eigvals_only=True)[:20]
    assert exact[1] < 0.0 < exact[2]
    np.testing.assert_allclose(stage.reduced.squares, exact, rtol=1e-7)
    static = part.contact_rows @ np.linalg.solve(stiffness, part.contact_rows.T.toarray())
    modes, rest = stage.reduced.contact, stage.reduced.compliance
    found = (modes / stage.reduced.squares) @ modes.T + rest
    np.testing.assert_allclose(found, static, atol=1e-9 * np.abs(static).max())


def test_too_many_modes_are_named_at_speed_too(tmp_path: Path) -> None:
    case = given(march={"speed": 0.6, "time_step": 1e-6})
    with pytest.raises(CaseError, match=r"reduction\.free_interface_modes = 60.*expected") as error:
        build_matrices(solid(case, tmp_path, "massless", free_interface_modes=60))
    assert "march.speed" not in str(error.value)


def test_a_blade_that_loses_its_stiffness_is_refused_by_its_speed(tmp_path: Path) -> None:
    part = bw.mesh3d(cantilever("hexahedron20", (3, 1, 1)), **STEEL, coriolis=True)
    soft = replace(part, stiffness_speed=-1.0 * part.mass, stiffness_speed4=None)
    bw.write_superelement(tmp_path / "soft.npz", soft)
    tables = {
        "bladed_disk": {"superelement": {"file": str(tmp_path / "soft.npz")}},
        "rotation": {"effects": "full"},
        "casing": {"type": "rigid"},
        "march": {"speed": 1.2, "time_step": 1e-7},
        "reduction": {"free_interface_modes": 5},
    }
    with pytest.raises(CaseError, match=r"march\.speed = 1\.2.*keeps its stiffness"):
        build_matrices(bw.case_from(tables))
    tables["march"] = {"speed": 0.9, "time_step": 1e-7}
    assert build_matrices(bw.case_from(tables)).reduced.squares[0] > 0.0

"""Stress of superelements: static forces, steady rotation, wheels, gauges, summary and files."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from solid_meshes import STEEL, TIE, bladed_sector, cantilever, grid_mesh

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.build import steady_problem
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.superelements.condensed import condensed
from bladewhirl.models.superelements.reduction import consistent, massless
from bladewhirl.models.superelements.superelement import Superelement, dense
from bladewhirl.models.superelements.wheel import WheelOverSpeeds, whole_wheel
from bladewhirl.postprocess.fields.point_stresses import PointStresses
from bladewhirl.postprocess.fields.points import points_of
from bladewhirl.postprocess.pictures.colouring import colouring
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.run.stresses import peak_stresses
from bladewhirl.postprocess.run.summary_table import summary_rows
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

SPEED = 700.0  #: [rad/s]


def solved(part: Superelement, load: FloatArray) -> FloatArray:
    """Stress at the points under a load on the coordinates, from all of them, (6 points,)."""
    moved = spl.spsolve(sp.csc_array(part.stiffness), load)
    return np.asarray(part.stress_recovery @ moved)


def von_mises(stress: FloatArray) -> FloatArray:
    """From the deviator, (points,)."""
    components = stress.reshape(-1, 6)
    tensor = components[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    trace = np.trace(tensor, axis1=1, axis2=2)
    deviator = tensor - trace[:, None, None] / 3.0 * np.eye(3)
    return np.asarray(np.sqrt(1.5 * (deviator**2).sum(axis=(1, 2))))


def bar() -> meshio.Mesh:
    """A radial bar of 10 x 10 mm from a radius of 0.2 to 0.3 m."""

    def shape(place: Any) -> Any:
        return place * [0.1, 0.01, 0.01] + [0.2, -0.005, -0.005]

    return grid_mesh(
        *((10, 2, 2), shape, "hexahedron20"),
        root=lambda place: place[:, 0] == 0.0,
        tip=lambda place: place[:, 0] == 1.0,
    )


def case(folder: Path, part: Superelement, **tables: Any) -> bw.Case:
    """Two blades in a rigid wall at speed."""
    bw.write_superelement(folder / "part.npz", part)
    given: dict[str, Any] = {
        "bladed_disk": {"superelement": {"file": str(folder / "part.npz"), "copies": 2}},
        "casing": {"type": "rigid", "clearance": 1e-4},
        "contact": {"friction": 0.1},
        "march": {"speed": f"{SPEED} rad/s", "duration": 0.002, "time_step": 5e-7},
        "reduction": {"free_interface_modes": 12},
        "initial": {"tip_velocity": [[2.0, -4.0], [0.0, 1.0]]},
    }
    return bw.case_from(given | tables)


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["massless", "consistent"])
def test_stress_of_a_spinning_bar_is_the_closed_form(boundary: str, tmp_path: Path) -> None:
    """rho Omega^2 (R^2 - r^2) / 2 along the bar; without lateral contraction also at the clamp."""
    part = bw.mesh3d(bar(), **STEEL | {"poisson_ratio": 0.0})
    kept = {"boundary": boundary, "free_interface_modes": 6, "fixed_interface_modes": 3}
    stage = build_matrices(
        case(tmp_path, part, rotation={"effects": "centrifugal"}, reduction=kept)
    )
    arrays = stage.arrays
    radius = arrays.point[:, 0]
    expected = 0.5 * 7800.0 * SPEED**2 * (0.3**2 - radius**2)
    error = arrays.steady_stress[:, 0] - expected
    assert abs(error).max() < 0.005 * expected.max()
    assert abs(arrays.steady_stress[:, 1:]).max() < 0.005 * expected.max()


@pytest.mark.slow
def test_stress_of_a_spinning_bar_follows_its_speed(tmp_path: Path) -> None:
    part = bw.mesh3d(bar(), **STEEL | {"poisson_ratio": 0.0}, coriolis=True)
    table = [["1 ms", "300 rad/s"], ["1 s", f"{SPEED} rad/s"]]
    given = case(
        tmp_path,
        part,
        rotation={"effects": "full"},
        march={"speed_table": table, "duration": 5e-4, "time_step": 5e-7},
        reduction={"free_interface_modes": 6},
        initial={},
    )
    result, _ = march_in_memory(prepare(given))
    stress = PointStresses(result).at(np.array([0, 2, 3]))
    radius = result["point"].values[:, 0]
    expected = 300.0**2 * 7800.0 * (0.3**2 - radius**2) / 2.0
    for found in stress.reshape(-1, len(radius)):
        assert abs(found - expected).max() < 0.005 * expected.max()


@pytest.mark.slow
def test_steady_stress_is_left_out_without_effects_of_rotation(tmp_path: Path) -> None:
    stage = build_matrices(case(tmp_path, bw.mesh3d(bar(), **STEEL)))
    assert "steady_stress" not in stage.arrays.stored
    assert stage.arrays.stress_shape.shape == (stage.part.point_count, 6, 12)


def test_centrifugal_forces_pull_as_the_mass_at_its_radius() -> None:
    """Their sum is that of the mass times the radius of the centre of mass, less the share of the
    clamped nodes."""
    part = bw.mesh3d(cantilever("tetra10"), **STEEL, clamped=None)
    assert part.centrifugal_load is not None
    total = part.centrifugal_load.reshape(-1, 3).sum(axis=0)
    mass = 7800.0 * 0.1 * 0.03 * 0.005
    assert total == pytest.approx([0.25 * mass, 0.0, 0.0], abs=1e-9 * mass)


def test_stress_of_static_forces_is_exact_with_few_modes(tmp_path: Path) -> None:
    """With modes, residual flexibility and steady rotation, for blades of different stiffness."""
    part = bw.mesh3d(cantilever("hexahedron20", (4, 2, 1)), **STEEL)
    point = 9
    assert part.points is not None
    middle = int(abs(part.points[:, 0] - 0.25).argmin())
    rows = dense(part.recovery)[[3 * middle, 3 * middle + 2]]
    part = replace(part, strain_recovery=rows / 0.01)
    given = case(
        tmp_path,
        part,
        rotation={"effects": "centrifugal"},
        bladed_disk={
            "superelement": {"file": str(tmp_path / "part.npz"), "copies": 2},
            "mistuning": {"stiffness": [1.0, 1.3]},
        },
        march={"speed": f"{SPEED} rad/s", "duration": 1e-4, "time_step": 1e-7, "record_step": 5e-5},
    )
    result = march_in_memory(prepare(given))[0]
    force = np.zeros((2, part.contacts, 3))
    force[0, 2] = [-3.0, -0.3, 0.2]
    force[1] = np.random.default_rng(4).standard_normal((part.contacts, 3))
    reduced = build_matrices(given).reduced
    push = np.einsum("cm,bc->bm", reduced.contact, force.reshape(2, -1))
    stiffness = np.array([[1.0], [1.3]]) * reduced.frequency**2
    static = result.isel(time=[0, 1]).copy()
    modal = np.tile((push / stiffness).ravel(), (2, 1))
    static["rotor_displacement"] = ("time", "rotor_mode"), modal
    static["rotor_velocity"] = ("time", "rotor_mode"), 0.0 * modal
    forces = np.tile(force.reshape(-1, 3), (2, 1, 1))
    static["contact_force"] = result["contact_force"].isel(time=[0, 1]).copy(data=forces)
    turning = part.at(SPEED, "centrifugal")
    rig: list[dict[str, Any]] = [
        {"type": "strain", "point": point, "direction": [1.0, 0.0, 0.0], "name": "hooke"},
        {"type": "strain", "gauge": 1, "name": "row"},
    ]
    strains = bw.sensors(static, rig)
    by_modes = bw.sensors(static.assign(contact_force=0.0 * static["contact_force"]), rig)
    for name, strain in strains.data_vars.items():
        assert abs(by_modes[name] - strain).max() > 1e-4 * abs(strain).max()
    assert part.centrifugal_load is not None
    steady = SPEED**2 * part.centrifugal_load
    for blade, (factor, each, found) in enumerate(
        zip(
            (1.0, 1.3),
            force,
            np.split(PointStresses(static).at(np.array([0]))[0], 2),
            strict=True,
        )
    ):
        of_blade, pushed = strains.isel(time=1, blade=blade), part.contact_rows.T @ each.ravel()
        own = solved(turning, pushed)[6 * point :][:3] / factor
        strain = (1.3 * own[0] - 0.3 * own.sum()) / 2.1e11
        assert float(of_blade["hooke"]) == pytest.approx(strain, rel=1e-6)
        moved = spl.spsolve(sp.csc_array(turning.stiffness), pushed) / factor
        strain = dense(part.strain_recovery)[1] @ moved
        assert float(of_blade["row"]) == pytest.approx(strain, rel=1e-6)
        # a stiffer blade has the same stress under the same forces
        load = part.contact_rows.T @ each.ravel() + steady
        expected = von_mises(solved(turning, load))
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * expected.max())


def test_the_largest_stress_is_that_away_from_contact_nodes(tmp_path: Path) -> None:
    """Also if a force on a single node makes the largest stress beside it."""
    part = bw.mesh3d(cantilever("hexahedron20", (4, 2, 1)), **STEEL)
    short = {"speed": f"{SPEED} rad/s", "duration": 1e-6, "time_step": 1e-7, "record_step": 1e-6}
    result = march_in_memory(prepare(case(tmp_path, part, initial={}, march=short)))[0]
    force = np.zeros(result["contact_force"].shape)
    force[1, 0, 0] = -1e4
    pushed = result.assign(contact_force=result["contact_force"].copy(data=force))
    everywhere = PointStresses(pushed).at(np.array([1]))[0, : part.point_count]
    assert part.points is not None
    apart = np.linalg.norm(part.points[:, None] - part.contact_position, axis=2).min(axis=1)
    far = apart > 0.1 * result.attrs["blade_length"]
    history = bw.stress_history(pushed)
    largest = float(history["largest_stress"].sel(member="blade 0")[1])
    assert largest == pytest.approx(everywhere[far].max())
    assert 0.0 < largest < 0.5 * everywhere.max()


def test_the_split_is_that_of_the_six_components(tmp_path: Path) -> None:
    """Von Mises stress of their mean, and largest one of their deviation from it."""
    part = bw.mesh3d(cantilever("hexahedron20", (4, 2, 1)), **STEEL)
    effects = {"effects": "centrifugal"}
    result = march_in_memory(prepare(case(tmp_path, part, rotation=effects)))[0]
    motion = result["rotor_displacement"].values.reshape(result.sizes["time"], 2, -1)
    force = result["contact_force"].values.reshape(len(motion), 2, -1)
    assert abs(force).max() > 0.0
    assert part.points is not None
    apart = np.linalg.norm(part.points[:, None] - part.contact_position, axis=2).min(axis=1)
    far = apart > 0.1 * result.attrs["blade_length"]
    peaks = peak_stresses(result)
    for blade in (0, 1):
        stress = np.einsum("pcm,tm->tpc", result["stress_shape"].values, motion[:, blade])
        by_force = result["stress_by_force"].values[0].reshape(-1, 6, force.shape[2])
        stress += np.einsum("pcf,tf->tpc", by_force, force[:, blade])
        stress += result["steady_stress"].values
        stress = stress[:, far]
        mean = stress.mean(axis=0)
        alternating = np.max([von_mises(now - mean) for now in stress], axis=0)
        worst = int((von_mises(mean) + alternating).argmax())
        found = peaks.sel(member=f"blade {blade}")
        assert float(found["alternating_stress"]) == pytest.approx(alternating[worst])
        assert float(found["mean_stress"]) == pytest.approx(von_mises(mean)[worst])
        radius = np.hypot(*part.points[far][worst, :2])
        assert float(found["split_radius"]) == pytest.approx(radius)


@pytest.mark.slow
def test_stress_of_a_wheel_from_a_sector_is_that_of_the_whole_wheel() -> None:
    """Under forces on two of its sectors, and in steady rotation; in the axes of each sector."""
    part = bw.mesh3d(bladed_sector("hexahedron20"), **STEEL, **TIE, contacts=2)
    sectors = TIE["copies"]
    turning = part.at(SPEED, "centrifugal")
    _, reduced = WheelOverSpeeds(turning, sectors, 3).at(SPEED)
    wheel = whole_wheel(turning, sectors)
    force = np.zeros((sectors, 6))
    force[0], force[5] = [-3.0, 1.0, 0.3, 0.0, 0.0, 2.0], [0.0, 0.5, 0.0, -1.0, 0.0, 0.0]
    stress = reduced.stress
    assert stress is not None
    assert stress.steady is not None
    found = stress.modes @ (reduced.contact.T @ force.ravel() / reduced.frequency**2)
    found = found.reshape(sectors, -1)
    for sector in (0, 5):
        for distance, by_force in enumerate(stress.forces):
            found[(sector + distance) % sectors] += by_force @ force[sector]
    expected = solved(wheel, wheel.contact_rows.T @ force.ravel())
    assert found.ravel() == pytest.approx(expected, abs=1e-6 * abs(expected).max())
    assert wheel.centrifugal_load is not None
    expected = solved(wheel, wheel.centrifugal_load)
    assert stress.steady == pytest.approx(expected, abs=1e-6 * abs(expected).max())


def test_condensed_and_consistent_superelements_keep_the_stress_of_steady_rotation() -> None:
    part = bw.mesh3d(cantilever("hexahedron20", (4, 2, 1)), **STEEL, contacts=3)
    small = condensed(part, 1000.0, 6)
    reductions = [
        massless(part.at(1000.0, "centrifugal"), 6),
        massless(small.at(1000.0, "centrifugal"), 6),
        consistent(part.at(1000.0, "centrifugal"), 6, 6),
    ]
    steady = [one.stress.steady for one in reductions if one.stress is not None]
    assert part.centrifugal_load is not None
    expected = solved(part.at(1000.0, "centrifugal"), part.centrifugal_load)
    for one in steady:
        assert one == pytest.approx(expected, abs=1e-6 * abs(expected).max())
    assert len(steady) == 3


def test_gauges_at_points_have_the_strain_of_the_stress(tmp_path: Path) -> None:
    """By the inverse of the law of Hooke, in three directions, on both blades."""
    part = bw.mesh3d(cantilever("hexahedron20", (4, 2, 1)), **STEEL)
    point, ways = 7, [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, -0.5]]
    rig: list[dict[str, Any]] = [
        {"type": "strain", "point": point, "direction": way, "name": f"way-{number}"}
        for number, way in enumerate(ways)
    ]
    rig += [rig[2] | {"name": "one", "blade": 1}]
    given = case(tmp_path, part, sensor=rig, contact={"friction": 0.0})
    result = march_in_memory(prepare(given))[0]
    signals = bw.sensors(result)
    arrays = build_matrices(given).arrays
    shape, by_force = arrays.stress_shape[point], arrays.stress_by_force[0, point]
    modal = result["rotor_displacement"].values.reshape(-1, 2, shape.shape[1])
    force = result["contact_force"].values.reshape(len(modal), 2, -1)
    assert abs(force).max() > 0.0
    stress = modal @ shape.T + force @ by_force.reshape(6, -1).T
    stress = stress[..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    law = 2.1e11 / 1.3 * (np.eye(9) + 0.3 / 0.4 * np.outer(np.eye(3), np.eye(3)))
    strain = np.linalg.solve(law, stress.reshape(*stress.shape[:2], 9, 1)).reshape(stress.shape)
    assert abs(strain).max() > 1e-6
    for number, way in enumerate(ways):
        unit = np.array(way) / np.linalg.norm(way)
        expected = np.einsum("i,tbij,j->tb", unit, strain, unit)
        np.testing.assert_allclose(
            signals[f"way-{number}"], expected, atol=1e-9 * abs(strain).max()
        )
    np.testing.assert_allclose(signals["one"], signals["way-2"].sel(blade=1), rtol=1e-12)


@pytest.mark.parametrize(
    ("sensor", "expected"),
    [
        ({"point": 3}, "expected both point, position or group and direction"),
        ({"point": 3, "direction": [0, 0, 0]}, "three numbers"),
        ({"point": 3, "direction": "x"}, "three numbers"),
        (
            {"point": 3, "gauge": 0, "direction": [0, 0, 1]},
            "one of span, element, gauge, point, position and group",
        ),
        ({"point": 9999, "direction": [0, 0, 1]}, "a point of the file, from 0 to"),
    ],
)
def test_invalid_gauges_are_refused(sensor: dict[str, Any], expected: str, tmp_path: Path) -> None:
    part = bw.mesh3d(cantilever("hexahedron20", (2, 1, 1)), **STEEL)
    with pytest.raises(bw.CaseError, match=expected):
        bw.sensors(march_in_memory(prepare(case(tmp_path, part)))[0], [{"type": "strain"} | sensor])


@pytest.mark.slow
def test_a_run_writes_the_largest_stress_with_a_hint(tmp_path: Path) -> None:
    """In summary, figure, picture and series: that of all records and points."""
    part = bw.mesh3d(cantilever("hexahedron20", (4, 2, 1)), **STEEL)
    given = case(
        tmp_path, part, rotation={"effects": "centrifugal"}, material={"yield_strength": 1e6}
    )
    run = bw.run(given, tmp_path / "run", frames=2)
    peak = json.loads((run.directory / "summary.json").read_text())["stress_max"]["bladed_disk"]
    assert peak["measure"] == "von Mises stress away from contact nodes"
    assert peak["centrifugal"] is True
    with run.open() as result:
        assert result["contact_impulse"].sum() > 0.0
        records = np.arange(result.sizes["time"])
        everywhere = PointStresses(result).at(records)
        apart = part.points[:, None] - part.contact_position  # type: ignore[index]
        near = np.linalg.norm(apart, axis=2).min(axis=1) <= 0.1 * result.attrs["blade_length"]
        assert 0 < near.sum() < len(near)
        values = everywhere * ~np.tile(near, 2)
        record, place = np.unravel_index(values.argmax(), values.shape)
        assert peak["stress"] == pytest.approx(values.max())
        assert peak["time"] == pytest.approx(float(result["time"][record]))
        assert peak["member"] == f"blade {place // part.point_count}"
        x, y, _ = part.points[place % part.point_count]  # type: ignore[index]
        assert peak["radius"] == pytest.approx(np.hypot(x, y))
        history = bw.stress_history(result)
        assert [*history["member"].values] == ["blade 0", "blade 1"]
        largest = values.reshape(len(records), 2, -1).max(axis=2)
        np.testing.assert_allclose(history["largest_stress"], largest)
        figures = RunFigures(result)
        assert "stress" in figures.kinds
        figure, _ = figures.draw("stress")
        assert len(figure.axes) == 2
        points = points_of(result, 1)
        shown = colouring([(result, points)], "stress", records[:3], 1, rotating=True)
        assert (shown.name, shown.disk.unit, shown.disk.limits[0]) == (
            "von Mises stress",
            "MPa",
            0.0,
        )
        np.testing.assert_allclose(shown.points[..., 0], everywhere[:3])
    rows = summary_rows(run.summary)
    assert "von Mises stress away from contact nodes" in rows["stress of bladed disk, largest"]
    assert "with centrifugal stress" in rows["stress of bladed disk, largest"]
    assert rows["stress of bladed disk, largest"].endswith("beyond the yield strength, 1 MPa")
    blades = meshio.read(next((run.directory / "vtk").glob("**/*rotor*.vtu")))
    assert blades.point_data["von_mises_stress"].shape == (2 * part.point_count,)


@pytest.mark.slow
def test_a_result_of_sectors_has_the_stress_of_the_whole_wheel(tmp_path: Path) -> None:
    """Static forces on two blades: von Mises stress at all points, and gauges on all blades."""
    part = bw.mesh3d(bladed_sector("hexahedron20"), **STEEL, **TIE, contacts=2)
    sectors = TIE["copies"]
    assert part.points is not None
    point = int(abs(np.hypot(*part.points[:, :2].T) - 0.1).argmin())  # low on the blade
    file = {"file": str(tmp_path / "part.npz"), "kind": "sector", "copies": sectors}
    given = case(
        tmp_path,
        part,
        bladed_disk={"superelement": file},
        shaft={"clamped": True},
        reduction={"free_interface_modes": 3},
        initial={},
        march={"speed": "10 rad/s", "duration": 1e-6, "time_step": 1e-7, "record_step": 1e-6},
        sensor=[{"type": "strain", "point": point, "direction": [0.0, 0.0, 1.0]}],
    )
    result = march_in_memory(prepare(given))[0]
    force = np.zeros((sectors, 6))
    force[2], force[7] = [-3.0, 1.0, 0.3, 0.0, 0.0, 2.0], [0.0, 0.5, 0.0, -1.0, 0.0, 0.0]
    reduced = build_matrices(given).reduced
    static = result.copy()
    moved = reduced.contact.T @ force.ravel() / reduced.frequency**2
    records = result.sizes["time"]
    static["rotor_displacement"] = ("time", "rotor_mode"), np.tile(moved, (records, 1))
    static["contact_force"] = result["contact_force"].copy(
        data=np.tile(force.reshape(-1, 3), (records, 1, 1))
    )
    wheel = whole_wheel(part, sectors)
    stress = solved(wheel, wheel.contact_rows.T @ force.ravel())
    expected = von_mises(stress)
    found = PointStresses(static).at(np.array([0]))[0]
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * expected.max())
    ours = stress.reshape(sectors, -1, 6)[:, point]
    strain = (1.3 * ours[:, 2] - 0.3 * ours[:, :3].sum(axis=1)) / 2.1e11
    (signal,) = bw.sensors(static).data_vars.values()
    assert abs(strain).max() > 1e-10
    assert signal.values[0] == pytest.approx(strain, abs=1e-6 * abs(strain).max())
    still = static.assign(contact_force=0.0 * static["contact_force"])
    (by_modes,) = bw.sensors(still).data_vars.values()
    assert abs(by_modes.values[0] - strain).max() > 0.01 * abs(strain).max()


@pytest.mark.parametrize(
    ("velocity", "end", "hint"),
    [
        pytest.param(5.0, "completed", "", marks=pytest.mark.slow),
        pytest.param(20.0, "completed", "draw back", marks=pytest.mark.slow),
        (600.0, "divergent", "a tenth or"),
    ],
)
def test_a_blade_that_bends_far_gets_a_hint_and_ends_at_its_length(
    velocity: float, end: str, hint: str, tmp_path: Path
) -> None:
    """A staggered blade of 100 mm bends along axis and circumference, without contact."""
    part = bw.mesh3d(cantilever("hexahedron20", (4, 2, 1)), **STEEL)
    given = case(
        tmp_path,
        part,
        casing={"type": "rigid", "clearance": 0.2},
        initial={"tip_velocity": [[0.0, velocity], [0.0, 0.0]]},
    )
    stage = build_matrices(given)
    assert steady_problem(stage).displacement_limit == pytest.approx(0.1, rel=5e-3)
    run = bw.run(given, tmp_path / "run", frames=0)
    assert run.end_reason == end
    found = " ".join(run.hints)
    assert ("of the length of a blade" in found) == bool(hint)
    assert hint in found
    if end == "divergent":
        assert "axially" in run.end_message
        assert "passed march.displacement_limit = 0.1" in run.end_message

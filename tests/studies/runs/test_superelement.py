"""Runs of superelements: from a file of matrices to a folder with results."""

import json
import runpy
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

import meshio
import numpy as np
import pytest
import xarray as xr
from command_line import answer, refusal
from PIL import Image
from report_pages import reported
from rod_blade import blade, tables
from small_run import assert_same_bits

import bladewhirl as bw
from bladewhirl.models.case.file import loads
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.stage.build import steady_problem
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.coating import axial_tracks, spacing
from bladewhirl.models.stage.hints import stage_hints
from bladewhirl.models.superelements.superelement import dense
from bladewhirl.postprocess.fields.kinematics import casing_rows, clearance_at
from bladewhirl.postprocess.fields.nodes import displacement
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.run.contact_nodes import ring_motion, tip_orbits
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.studies.runs.outputs import Run
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.properties import stage_properties
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.runs.run import resume

UNMARKED = {"thickness": 1e-3, "young_modulus": 1e9, "yield_stress": 2e6}
LAYER = UNMARKED | {"footprint": 4e-3}
"""Coating of the wall."""

WAVE = {"lobes": 3, "amplitude": 2e-5}

LEANING = np.array([[0.29995, 0.0, -0.02], [0.3, 0.0, 0.0], [0.30005, 0.0, 0.02]])
"""Contact nodes at other radii, of which the last one touches first."""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("part") / "rods.npz"
    bw.write_superelement(path, blade())
    return path


@pytest.fixture(scope="module")
def run(file: Path, tmp_path_factory: pytest.TempPathFactory) -> Run:
    return bw.run(bw.case_from(tables(file)), tmp_path_factory.mktemp("runs") / "run", frames=3)


def test_a_run_records_contact_nodes_and_closes_the_ledger(run: Run) -> None:
    summary: Any = run.summary
    assert run.end_reason == "completed"
    assert summary.energy_residual < 1e-9
    assert summary.unsolved_steps == 0
    assert min(summary.contact_impulse_by_blade) > 0.0
    assert "impulse per revolution" in repr(run)
    with run.open() as result:
        assert result["contact_impulse"].dims == ("time", "contact_node")
        assert result["blade"].values.tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2]
        assert result["node"].values.tolist() == [0, 1, 2] * 3
        tip = displacement(result, result.sizes["point"] - 1, copy=1)
        radial = result["contact_displacement"][:, 5, 0].values
        # The contact node moves as its point, except for the residual flexibility in contact.
        free = result["contact_force"][:, 3:6, 0].values.max(axis=1) == 0.0
        free &= result["contact_force"][:, 3:6, 0].values.min(axis=1) == 0.0
        assert tip.sel(xyz="x").values[free] == pytest.approx(radial[free], abs=1e-12)
        assert tip_orbits(result, turns=1.0).sizes["node"] == 3
        with pytest.raises(bw.ResultError, match="expected a result with centre_shape"):
            bw.shaft_orbit(result)
        with pytest.raises(bw.ViewError, match="expected a point from 0 to"):
            displacement(result, 99)
    names = {path.name for path in run.directory.iterdir()}
    assert {"case.toml", "superelement.npz", "result.nc", "summary.json", "vtk"} <= names
    assert len(list((run.directory / "vtk" / "frames").glob("rotor_*.vtu"))) == 3


def test_a_run_can_be_continued(run: Run, file: Path, tmp_path: Path) -> None:
    half = tables(file, march__duration=0.01)
    bw.run(bw.case_from(half), tmp_path / "half", frames=0)
    more = ["--set", "march.duration=0.02", "--frames=0"]
    answer("run", "--resume", tmp_path / "half", *more)
    assert_same_bits(run.directory, tmp_path / "half")


def test_modes_and_properties_are_printed(file: Path, tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(
        f'[bladed_disk.superelement]\nfile = "{file}"\n[casing]\ntype = "rigid"\n'
        '[reduction]\nfree_interface_modes = 15\n[march]\nspeed = "6000 rpm"\n'
    )
    document = json.loads(answer("modes", case, "--count", 4, "--json").stdout)
    listed = [mode["frequency_hz"] for mode in document["bladed_disk"]]
    part = blade()
    squares = np.linalg.eigvalsh(part.stiffness / 5e-3)[:4]
    assert listed == pytest.approx(np.sqrt(squares) / (2 * np.pi), rel=1e-9)
    derived = json.loads(answer("show", case, "--json").stdout)["derived"]
    assert derived["speed"]["rpm"] == pytest.approx(6000.0)
    assert len(derived["contact_nodes"]) == 3


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"casing__clearance": 1e-4}, "casing.clearance = 1e-4: expected all contact nodes"),
    ({"excitation": {"type": "casing-distortion"}}, 'or casing.type = "ring"'),
    ({"march__time_step": 1e-4, "march__record_step": 1e-4}, "less than the critical step"),
    ({"reduction": {"free_interface_modes": 54}}, "at most 53 modes of 54 coordinates"),
    ({"contact__sliding": "signed"}, 'contact.sliding = "signed": expected "full" or "perm'),
    ({"excitation": {"type": "harmonic"}}, '= "wheel", which has a centre'),
    (
        {"excitation": {"type": "engine-order", "position": 0.5}},
        'excitation.position = 0.5: expected "tip"',
    ),
    ({"rotation": {"effects": "full"}}, '"none", or a file with stiffness_speed, without which'),
    ({"casing__coating": UNMARKED}, "are at the same angle"),
    ({"casing__coating": UNMARKED | {"footprint": 1e-4}}, "less than one rod in a time step"),
    ({"casing__coating": UNMARKED | {"footprint": 1e-12}}, "for at most 100000 rods"),
    ({"casing__coating": UNMARKED | {"footprint": 5.0}}, "less than the radius of the tips"),
    # The first modes are not radial.
    ({"initial": {"tip_displacement": [[1e-5, 2e-4]] * 3}}, "a motion that the modes can have"),
    ({"initial": {"centre_velocity": [1.0, 0.0]}}, "motion of the tips only"),
]


@pytest.mark.parametrize(("changes", "expected"), REFUSED)
def test_cases_that_cannot_be_marched_are_refused(
    file: Path, changes: dict[str, Any], expected: str
) -> None:
    with pytest.raises(bw.CaseError) as caught:
        prepare(bw.case_from(tables(file, **changes)))
    assert expected in str(caught.value)


@pytest.mark.parametrize("key", ["points", "contact", "stiffness"])
def test_numbers_that_are_not_finite_end_before_the_march(file: Path, key: str) -> None:
    stage = build_matrices(bw.case_from(tables(file)))
    wrong = dense(getattr(stage.reduced, key))
    wrong.flat[0] = np.nan
    changed: dict[str, Any] = {"of_points": lambda turn: wrong} if key == "points" else {key: wrong}
    stage = replace(stage, reduced=replace(stage.reduced, **changed))
    with pytest.raises(bw.UserError, match="of the stage: expected finite numbers"):
        prepare(stage)


def test_a_damping_matrix_that_feeds_energy_is_refused(file: Path, tmp_path: Path) -> None:
    damping = np.eye(54) - 0.5  # feeds equal motion of all coordinates
    bw.write_superelement(tmp_path / "rods.npz", replace(blade(), damping=damping))
    with pytest.raises(bw.CaseError, match="a damping matrix without negative eigenvalues"):
        build_matrices(bw.case_from(tables(tmp_path / "rods.npz")))


def test_a_slow_closure_is_marched(file: Path) -> None:
    closure = {"amount": 5e-4, "time_constant": 1e9}
    problem: Any = prepare(bw.case_from(tables(file, casing__closure=closure))).problem
    assert problem.closure.course.largest_loss == pytest.approx(5e-4)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"casing": {"type": "rigid", "radius": 0.5}}, "casing.radius"),
        ({"excitation": {"type": "engine-order", "points": [1]}}, "excitation.points"),
    ],
)
def test_keys_of_superelements_need_one(changes: dict[str, Any], key: str) -> None:
    expected = rf"{key} = .*: not allowed without bladed_disk\.superelement"
    with pytest.raises(bw.CaseError, match=expected):
        bw.case_from(changes)


def test_engine_order_forces_give_the_steady_answer_of_the_modes(file: Path) -> None:
    """The amplitude of the contact nodes without contact, against the closed form."""
    given = tables(
        file,
        casing={"type": "rigid", "clearance": 0.05},
        excitation={
            "type": "engine-order",
            "order": 3,
            "amplitude": 2.0,
            "phase": 0.4,
            "factors": [1.0, 0.5, 0.0],
        },
        damping__ratio=0.2,
    )
    stage = build_matrices(bw.case_from(given))
    problem, dt = steady_problem(stage), 1e-6
    scheme = CentralDifference(problem, dt, 20)
    _, chunk, _ = scheme.advance(scheme.init(), 40_001)
    w, frequency = 3.0 * stage.speed, problem.rotor.by_copy(problem.rotor.frequency)[0]
    rows = problem.rotor.contact
    answer = rows[1::3].mean(axis=0) / (frequency**2 - w**2 + 2j * 0.2 * frequency * w)
    middle = np.angle(np.exp(1j * stage.angle).mean(axis=1))
    force = 2.0 * np.array([1.0, 0.5, 0.0]) * np.exp(1j * (3.0 * middle + 0.4))
    late = chunk.time > 0.03
    waves = np.exp(1j * w * chunk.time[late])[:, None, None]
    expected = (waves * force[:, None] * (rows @ answer)).real
    moved = chunk.contact_displacement[late].reshape(expected.shape)
    assert moved == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        ("plot RUN orbit", "figure 'orbit': expected a result with centre_shape"),
        ("plot RUN casing", "figure 'casing': expected a result with casing_displacement"),
        ("render RUN --orbit", "expected a result with centre_shape"),
        ("veering RUN/case.toml", "this bladed disk has no centre that can be free or clamped"),
        ("stability RUN/case.toml", "join the wall to one tip of each blade"),
        ("critical-speeds RUN/case.toml", "this bladed disk has no centre that whirls"),
    ],
)
def test_commands_for_beams_refuse_a_superelement(run: Run, command: str, expected: str) -> None:
    assert expected in refusal(*command.replace("RUN", str(run.directory)).split())


def test_damping_of_the_file_is_reported(file: Path, tmp_path: Path) -> None:
    part = replace(blade(), damping=0.4 * np.eye(54), gyroscopic=np.zeros((54, 54)))
    bw.write_superelement(tmp_path / "damped.npz", part)
    damped = build_matrices(bw.case_from(tables(tmp_path / "damped.npz")))
    assert [hint.split()[2] for hint in stage_hints(damped)] == ["damping"]
    assert damped.rotor.by_velocity == pytest.approx(80.0 * np.eye(15), abs=1e-9)
    assert not [*stage_hints(build_matrices(bw.case_from(tables(file))))]


@pytest.mark.slow
def test_blades_rub_in_a_flexible_ring(file: Path, tmp_path: Path) -> None:
    closure = {"table": [[0.0, 0.0], [0.004, 3.2e-4]]}
    casing = {"elements": 12, "clearance": 3e-4, "support": 1e7, "closure": closure}
    pushed = {"type": "casing-distortion", "modal_force": 300.0, "duration": 0.005}
    given = tables(file, casing=casing, excitation=pushed, march__duration=0.006)
    run = bw.run(bw.case_from(given), tmp_path / "run", frames=2)
    summary: Any = run.summary
    farthest = abs(summary.casing_displacement_max["radial"]["displacement"])
    assert farthest > 1e-5
    assert run.summary.contact_impulse > 0.0
    assert run.summary.energy_residual < 1e-9
    with bw.open_result(run.directory) as result:
        assert result["casing_displacement"].sizes["casing_mode"] == 4 * 12 - 1
        motion = ring_motion(result)
        largest = float(np.abs(motion["radial"]).max())
        assert largest == pytest.approx(farthest, rel=5e-2)  # which is between two nodes
        gap, moved = result["gap"].values[-1], result["contact_displacement"].values[-1, :, 0]
        ring = result["casing_displacement"].values[-1]
        angle = result["tip_angle"].values + result.attrs["speed"] * float(result["time"][-1])
        wall = clearance_at(result, angle) + casing_rows(result, angle)[:, 0] @ ring
        closed = np.median(wall - moved - gap)
        assert closed == pytest.approx(3.2e-4, abs=2e-5)  # gaps are the smallest between records
    series = (run.directory / "vtk" / "series.pvd").read_text(encoding="utf-8")
    assert 'name="casing"' in series
    continued: Any = resume(run.directory, ["march.duration=0.007"], frames=0)
    assert continued.summary.energy_residual < 1e-9


def test_blades_wear_a_coating(file: Path, tmp_path: Path) -> None:
    changes: dict[str, Any] = {"casing__coating": LAYER, "march__duration": 0.006}
    changes["casing__closure"] = {"amount": 2e-4, "time_constant": 2e-3}
    run = bw.run(bw.case_from(tables(file, **changes)), tmp_path / "run", frames=0)
    summary = json.loads((run.directory / "summary.json").read_text(encoding="utf-8"))
    assert 0.0 < summary["wear_volume"]
    assert 0.0 < summary["wear_strain_max"] < 0.9
    assert summary["energy_residual"] < 1e-9
    assert (run.directory / "wear-tracks.png").is_file()
    stage = build_matrices(bw.case_from(tables(file, **changes)))
    actual = (run.directory / "result.nc").stat().st_size
    assert stage_properties(stage)["result_bytes"] == pytest.approx(actual, rel=0.1)
    with bw.open_result(run.directory) as result:
        worn = bw.wear(result).isel(wear_time=-1)
        assert worn.sizes["track"] == 3
        assert worn["axial"].values == pytest.approx([-0.02, 0.0, 0.02])
        width = xr.DataArray([0.01, 0.02, 0.01], dims="track")
        arc = 2.0 * np.pi * 0.3 / worn.sizes["rod"]
        removed = float((worn["recess"] * width).sum()) * arc
        assert removed == pytest.approx(summary["wear_volume"], rel=1e-2)  # the last record
        drawing = Drawing(result, np.array([result.sizes["time"] - 1]), colour="wear")
        _, _, coating, *_ = drawing.picture(0).solids
        assert [solid.shows for solid in drawing.solids[:3]] == ["disk", None, "wall"]
        deepest = float(worn["recess"].max())
        assert np.nanmax(drawing.colouring.casing) == pytest.approx(deepest, rel=1e-12)
        assert 0.0 < np.nanmax(coating.values) <= deepest
        inner = np.isfinite(coating.values.reshape(-1, 4))
        assert inner.all(axis=0).tolist() == [True, True, False, False]


@pytest.mark.slow
def test_a_second_run_begins_with_the_tracks_of_the_first(tmp_path: Path) -> None:
    file = tmp_path / "leaning.npz"
    changes: dict[str, Any] = {"march__duration": 0.004, "casing__coating": LAYER}
    changes["casing__closure"] = {"amount": 2e-4, "time_constant": 2e-3}
    changes["casing__radius"] = 0.30005
    bw.write_superelement(file, replace(blade(), contact_position=LEANING))
    run = bw.run(bw.case_from(tables(file, **changes)), tmp_path / "run", frames=0)
    with bw.open_result(run.directory) as result:
        worn = result["coating_strain"].values[-1]
    deepest = worn.max(axis=1)
    assert deepest[2] > 1.1 * deepest[1] > 1.2 * deepest[0]  # each track is another one
    given = tables(file, **changes)
    given["casing"]["coating"] = LAYER | {"profile": {"file": str(run.directory / "wear.csv")}}
    again = bw.case_from(given)
    second = build_matrices(again).coating
    assert second is not None
    np.testing.assert_allclose(second.strain, worn, rtol=0.0, atol=1e-15)
    assert loads(bw.dumps_case(again)) == again
    with pytest.raises(bw.CaseError, match=r"without axial positions, or a bladed_disk\.super"):
        bw.case_from({"casing": {"coating": given["casing"]["coating"]}})
    moved = replace(blade(), contact_position=np.add(LEANING, [0.0, 0.0, 1e-3]))
    bw.write_superelement(file, moved)
    with pytest.raises(bw.CaseError, match=r"nodes, -19, 1, 21 mm, not at -20, 0, 20 mm$"):
        prepare(bw.case_from(given))


def test_a_profile_without_axial_positions_is_that_of_all_tracks(file: Path) -> None:
    profile = {"points": [[0.7 * k, 1e-5 * k] for k in range(8)], "lobes": [WAVE]}
    given = tables(file, casing__coating=LAYER | {"profile": profile})
    same = build_matrices(bw.case_from(given)).coating
    tracks = [{"axial": z, "points": profile["points"]} for z in ("2 cm", 0.0, "-20 mm")]
    profile = {"tracks": tracks, "lobes": [WAVE]}
    each = build_matrices(
        bw.case_from(tables(file, casing__coating=LAYER | {"profile": profile}))
    ).coating
    assert same is not None
    assert each is not None
    assert same.strain.max() > 0.05
    np.testing.assert_array_equal(same.strain, each.strain)


def test_tracks_of_unequal_numbers_of_nodes() -> None:
    axial, track = axial_tracks(np.array([0.01, 0.0, 0.0, 1e-9, 0.02, 0.01]), np.full(6, 0.3))
    assert axial == pytest.approx([0.0, 0.01, 0.02], abs=1e-9)
    assert track.tolist() == [1, 0, 0, 0, 2, 1]


def test_footprints_follow_from_the_distances_of_contact_nodes(file: Path) -> None:
    assert spacing(np.array([0.0, 3.0, 1.0])) == pytest.approx([0.5, 1.0, 1.5])
    coated = bw.case_from(tables(file, casing__coating=LAYER))
    plain = stage_properties(build_matrices(bw.case_from(tables(file))))
    shown = stage_properties(build_matrices(coated))
    assert shown["smallest_clearance"] == plain["smallest_clearance"]
    assert shown["coating"]["tracks"] == 3
    assert shown["coating"]["width"] == pytest.approx(0.04)


def test_blades_start_with_the_motion_of_their_tips(file: Path) -> None:
    moved = [[1e-5, 2e-4], [0.0, 0.0], [-2e-5, 1e-4]]
    given = tables(file, initial={"tip_displacement": moved, "tip_velocity": moved})
    given["reduction"] = {"free_interface_modes": 50}
    given["march"] |= {"duration": 1e-3, "time_step": 5e-7}
    problem = steady_problem(build_matrices(bw.case_from(given)))
    rotor, start = problem.rotor, problem.rotor.by_copy(problem.start.rotor)
    nodes = start @ rotor.contact.T
    assert nodes.reshape(3, 3, 3).mean(axis=1)[:, :2] == pytest.approx(np.array(moved), abs=1e-15)
    assert problem.start.rotor_velocity == pytest.approx(problem.start.rotor)
    frequency = rotor.by_copy(rotor.frequency)
    least = 0.5 * ((frequency * start) ** 2).sum(axis=1)
    means = [rotor.contact[0::3].mean(axis=0), rotor.contact[1::3].mean(axis=0)]
    other = start[0] + np.linalg.svd(np.array(means))[2][5] * 1e-6
    assert 0.5 * ((frequency[0] * other) ** 2).sum() > least[0]
    chunk = march_in_memory(prepare(bw.case_from(given)))[0]
    assert float(abs(chunk["contact_displacement"][0, 0:3, 1].mean()) - 2e-4) < 1e-9


@pytest.mark.slow
def test_show_draws_the_blades_and_the_wall(file: Path, tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(dumps_case(bw.case_from(tables(file))))
    answer("show", case, "--png", "-o", tmp_path / "stage.png")
    picture = np.asarray(Image.open(tmp_path / "stage.png").convert("RGB")).reshape(-1, 3)
    assert len(np.unique(picture, axis=0)) > 20
    bare = replace(blade(), points=None, recovery=None, triangles=None)
    bw.write_superelement(tmp_path / "bare.npz", bare)
    case.write_text(dumps_case(bw.case_from(tables(tmp_path / "bare.npz"))))
    assert "points and recovery" in refusal("show", case, "--png")


@pytest.mark.slow
def test_a_run_has_figures_by_name_and_a_report(run: Run, tmp_path: Path) -> None:
    answer("export", run.directory, "--frames", "2", "-o", tmp_path / "series")
    plots = tmp_path / "plots"
    printed = answer("plot", run.directory, "all", "--from", "0.01", "-o", plots).stdout
    drawn = {line.split()[1].rpartition("/")[2] for line in printed.splitlines()}
    assert {"contact-nodes.png", "tips.png", "gaps.png", "work.png", "energy.png"} <= drawn
    with xr.open_dataset(plots / "contact-nodes.nc", engine="h5netcdf") as data:
        assert float(data["time"][0]) == pytest.approx(0.01)
    words = reported(run.directory).words
    assert "Contact of blades and casing" in words
    assert run.summary.regime.capitalize() in words
    assert "impulse per revolution" in words
    with run.open() as result:
        assert bw.plot.contact_nodes(result).axes


def test_a_series_of_blades_has_a_view_and_the_names_of_beams(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "vtk"
    printed = answer("export", run.directory, "--frames", "5", "-o", folder).stdout
    assert "5 instants from 0 s" in printed
    rotor = meshio.read(folder / "frames" / "rotor_00000.vtu")
    triangles = np.bincount(rotor.cell_data["blade"][0])
    assert (triangles == triangles[0]).all()
    assert len(triangles) == 3
    nodes = meshio.read(folder / "frames" / "contact_00000.vtu")
    assert {"displacement", "velocity", "warp", "contact_force", "gap"} == set(nodes.point_data)
    assert nodes.cell_data["blade"][0].tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2]
    simple = MagicMock()
    simple.GetParaViewVersion.return_value = (5, 11)
    monkeypatch.setitem(sys.modules, "paraview", MagicMock(simple=simple))
    monkeypatch.setattr(sys, "argv", ["view.py", "picture.png"])
    runpy.run_path(str(folder / "view.py"))
    assert simple.WarpByVector.return_value.Vectors == ["POINTS", "warp"]
    assert simple.Glyph.return_value.ScaleArray == ["POINTS", "contact_force"]
    assert simple.SaveScreenshot.call_args.args[0] == "picture.png"


@pytest.mark.parametrize("share", [0.25, 0.35, 0.7])
def test_a_long_step_with_a_flexible_ring_is_hinted_at_with_its_loss(
    file: Path, share: float
) -> None:
    casing = {"elements": 12, "clearance": 3e-4, "support": 1e7}
    given = tables(file, casing=casing)
    limit = steady_problem(build_matrices(bw.case_from(given))).critical_time_step
    steps = {"time_step": share * limit, "record_step": share * limit, "duration": 10 * limit}
    stage = build_matrices(bw.case_from({**given, "march": {"speed": 0.5, **steps}}))
    hints = [*stage_hints(stage)]
    if share < 0.3:
        assert hints == []
        return
    mass = 1.0 / np.sum(stage.reduced_casing.nodal[0, 0] ** 2)
    omega = 1.0 / np.sqrt(np.diag(stage.reduced.compliance)[::3].min() * mass)
    loss = 100.0 * omega * share * limit / 2.0
    assert loss > 1.0
    [hint] = hints
    assert hint.startswith(f"march.time_step is {share:.2g} of the critical step")
    assert f"a damping ratio of up to {loss:.2g} %" in hint

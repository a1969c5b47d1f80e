"""Sweeps of superelements."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer, refusal
from faults import fault
from numpy.testing import assert_array_equal
from report_pages import reported
from rod_blade import blade, tables
from sweep_work import assert_carried_on, in_process

import bladewhirl as bw
from bladewhirl.models.stage.build import build_stage
from bladewhirl.postprocess.sweep.dataset import SWEEP_NAME, open_sweep
from bladewhirl.solvers.march.free_motion import FreeMotion
from bladewhirl.studies.runs.folder import write_provenance
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.sweeps.axes import make_grid
from bladewhirl.studies.sweeps.plan import plan_sweep, read_plan, write_plan

SPEEDS = {"march.speed": ("6000 rpm", "9000 rpm")}


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("part") / "rods.npz"
    bw.write_superelement(path, blade())
    return path


@pytest.fixture(scope="module")
def case(file: Path) -> bw.Case:
    return bw.case_from(tables(file, march__record_step=2e-5, march__duration=0.025))


@pytest.fixture(scope="module")
def swept(case: bw.Case, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sweep") / "swept"
    with in_process(figures=True):
        done = bw.run_sweep(case, SPEEDS | {"contact.friction": (0.0, 0.1)}, folder)
    assert (done.points, done.done, done.left_out) == (4, 4, {})
    return folder


def test_a_sweep_is_resumed_with_the_reductions_beside_the_original_file(
    case: bw.Case, file: Path, tmp_path: Path
) -> None:
    """If the original is gone or was changed, beside the copy."""
    original = tmp_path / "original.npz"
    shutil.copy(file, original)
    given = bw.with_values(case, {"bladed_disk.superelement.file": str(original)})
    (folder := tmp_path / "sweep").mkdir()
    plan = plan_sweep(given, make_grid(given, SPEEDS, large=False))
    write_plan(plan, folder)
    write_provenance(folder, plan.case)
    assert read_plan(folder).case == given
    original.write_bytes(b"changed")
    part = read_plan(folder).case.bladed_disk.superelement
    assert part is not None
    assert Path(part.file) == folder / "superelement.npz"


@pytest.mark.slow
def test_a_point_is_the_run_of_its_case(case: bw.Case, swept: Path, tmp_path: Path) -> None:
    part = case.bladed_disk.superelement
    assert part is not None
    fast = bw.case_from(
        tables(
            Path(part.file),
            march__speed="9000 rpm",
            march__record_step=2e-5,
            march__duration=0.025,
            contact__friction=0.0,
        )
    )
    summary: Any = bw.run(fast, tmp_path / "run", frames=0).summary
    with open_sweep(swept) as actual:
        point = actual.isel(march_speed=1, contact_friction=0)
        for name in ("impulse_per_revolution", "energy_residual", "steps"):
            assert float(point[name]) == getattr(summary, name)
        assert float(point["contact_force_max"]) == summary.contact_force_max["force"]
        assert float(point["displacement_max"]) == max(summary.contact_displacement_max.values())
        assert point["contact_share"].shape == (3,)
        assert float(point["contact_share"].max()) == max(summary.contact_share)
        assert str(point["regime"].values) == "sustained"
        spectrum = point["contact_spectrum"].values
        near = abs(float(point["frequency"][spectrum.argmax()]) % 150.0)
        assert min(near, 150.0 - near) <= float(point["frequency"][1])  # an engine order


@pytest.mark.usefixtures("process")
@pytest.mark.slow
def test_lost_points_are_marched_again_with_the_same_bits(swept: Path) -> None:
    before = (swept / SWEEP_NAME).read_bytes()
    (swept / SWEEP_NAME).unlink()
    assert bw.resume_sweep(swept).marched == 4
    assert (swept / SWEEP_NAME).read_bytes() == before


@pytest.mark.slow
def test_it_has_figures_and_a_report(swept: Path, tmp_path: Path) -> None:
    messages = answer("plot", swept, "all", "-o", tmp_path).stderr
    assert "probability left out" in messages
    assert "wear left out" in messages
    names = {path.stem for path in tmp_path.glob("*.nc")}
    assert names == {"contact-nodes", "node-spectra", "regimes", "contact-classes", "maps"}
    assert "figure 'whirl': expected a result with whirl_frequency" in refusal(
        "plot", swept, "whirl"
    )
    assert "largest recorded displacement of the contact node [mm]" in reported(swept).words


def test_what_only_beams_can_do_is_refused(case: bw.Case, tmp_path: Path) -> None:
    draws: Any = {"screen": True, "draws": 5, "perturb": ["contact.friction = 0.1"]}
    line = fault(bw.run_sweep, case, SPEEDS, tmp_path / "s", **draws)
    assert '--screen: expected casing.type = "ring"' in line
    line = fault(bw.run_sweep, case, {"casing.clearance": (3e-4, 1e-4)}, tmp_path / "w")
    assert "point casing.clearance = 1e-4: " in line
    assert "all contact nodes inside the wall" in line
    assert not any(tmp_path.iterdir())


def test_a_stopped_march_begins_as_the_whole_one_and_nothing_touches_later(file: Path) -> None:
    thrown = {"tip_velocity": [[6.0, 0.0], [0.0, 0.0], [0.0, 0.0]]}
    round_wall = {"type": "rigid", "clearance": 5e-5}
    case = bw.case_from(
        tables(
            file,
            initial=thrown,
            reduction={"free_interface_modes": 40},
            casing=round_wall,
            damping__ratio=0.05,
            march__duration=0.6,
            march__record_step=2e-4,
        )
    )
    whole = prepare(case)
    long, _ = march_in_memory(whole)
    stop = FreeMotion.of(whole.problem, 2e-6)
    short, report = march_in_memory(replace(whole, stop=stop))
    assert short.attrs["end_reason"] == "damped"
    assert report["steps"] < 250_000
    for name in ("rotor_displacement", "energy", "contact_steps"):
        assert_array_equal(short[name], long[name][: short.sizes["time"]])
    assert long["contact_steps"].values.any()
    assert not long["contact_steps"][short.sizes["time"] // 2 :].any()


def test_no_motion_with_so_little_energy_closes_the_gap(file: Path) -> None:
    case = bw.case_from(tables(file, casing={"type": "rigid", "clearance": 3e-4}))
    problem = prepare(case).problem
    rotor = problem.rotor
    stop = FreeMotion.of(problem, 2e-6)
    reach = []
    for frequency in rotor.by_copy(rotor.frequency):
        way = rotor.tip_radial / frequency  # of each node, scaled by the worst state
        reach.append(np.sqrt(2.0 * stop.enough) * np.linalg.norm(way, axis=1).max())
    share = np.sqrt(1.0 - (2e-6 / problem.critical_time_step) ** 2)
    assert max(reach) <= 0.8 * 3e-4 * share
    feeding = replace(problem, rotor=replace(rotor, by_velocity=-1e6 * np.eye(len(frequency))))
    with pytest.raises(ValueError, match="feeds energy"):
        FreeMotion.of(feeding, 2e-6)


def test_a_carried_march_goes_on(file: Path) -> None:
    """At the same speed the carried motion goes on: after whole revolutions the forces of an engine
    order are those of the start, and the ring moves on too."""
    pushed = [
        {"type": "engine-order", "order": [3], "amplitude": 300.0, "ramp": 0.0},
        {"type": "casing-distortion", "modal_force": 100.0, "duration": "15 ms"},
    ]
    casing = {"clearance": 3e-4, "support": 1e9, "elements": 24}
    case = bw.case_from(
        tables(
            file,
            excitation=pushed,
            casing=casing,
            contact={"friction": 0.0},
            initial={"tip_velocity": [[6.0, 0.0]] * 3},
            reduction={"free_interface_modes": 40},
            march__duration=0.025,
            march__record_step=1e-4,
        )
    )
    assert_carried_on(build_stage(case), "rotor_displacement", "casing_displacement")

"""Sweeps: points, folders, refusals and resumption, marched in this process."""

import json
import os
import subprocess
import sys
from multiprocessing.spawn import get_preparation_data
from pathlib import Path

import dask
import numpy as np
import pytest
import sweep_work
import xarray as xr
from command_line import answer
from sweep_work import CASE, OVER, InProcess, Killed, same_bits
from synthetic_sweep import LAYOUT

import bladewhirl as bw
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.plotting.registry import SWEEP_FIGURES
from bladewhirl.postprocess.run.blade_contact import contact_share
from bladewhirl.postprocess.run.summary import summarise
from bladewhirl.postprocess.sweep.digest import late_motion
from bladewhirl.postprocess.sweep.figures import LEFT_BY_A_SWEEP
from bladewhirl.studies.runs import folder as run_folder
from bladewhirl.studies.runs.folder import FAILURES_NAME, HISTORIES_NAME, read_failures
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.sweeps import cluster as sweep_cluster
from bladewhirl.studies.sweeps import plan as sweep_plan
from bladewhirl.studies.sweeps import workers
from bladewhirl.studies.sweeps.axes import make_grid
from bladewhirl.studies.sweeps.marching import march_points
from bladewhirl.studies.sweeps.plan import PLAN_NAME, plan_sweep, read_plan, write_plan
from bladewhirl.studies.sweeps.points import Failure, Point, Work
from bladewhirl.studies.sweeps.sweep import Watch, resume_sweep, run_sweep

TOO_MANY_MODES = 50_000


@pytest.mark.slow
def test_a_point_is_what_a_run_of_its_case_says(swept: Path) -> None:
    case = bw.with_values(CASE, {"march.speed": 1.05})
    result, report = march_in_memory(prepare(case))
    summary = summarise(result, report)
    with bw.open_sweep(swept) as dataset:
        point = dataset.sel(march_speed=1.05, contact_friction=0.1)
        for name in ("regime", "end_reason", "shaft_radius_max", "strain_energy_max", "steps"):
            assert point[name].item() == getattr(summary, name)
        assert (summary.end_reason, summary.steps) == ("completed", 6000)
        np.testing.assert_array_equal(point["contact_share"], summary.contact_share)
        held = summary.strain_energy_final
        assert held is not None
        history = point["energy_history"].dropna("sample", how="all").isel(sample=-1)
        assert float(history.sel(energy_group="suspension")) == pytest.approx(
            held["suspension"], rel=1e-6
        )
        late = late_part(result)
        motion = late_motion(late, bw.shaft_orbit(late))
        for name in ("whirl_frequency", "whirl_static", "scenario"):
            assert point[name].item() == motion[name]
        np.testing.assert_array_equal(point["late_contact_share"], contact_share(late))
        assert point["rotation_speed"].item() == result.attrs["speed"]


def test_the_dataset_names_its_dimensions(swept: Path) -> None:
    with bw.open_sweep(swept) as dataset:
        assert dataset["spectrum"].dims == ("march_speed", "contact_friction", "frequency")
        assert dataset["march_speed"].attrs["units"] == "1"
        assert (dataset["state"] == "done").all()
        assert (np.diff(dataset["shaft_radius_max"].values, axis=0) > 0).all()
        np.testing.assert_allclose(
            dataset["speed_ratio"], dataset["march_speed"] + 0 * dataset["steps"]
        )
    with xr.open_dataset(swept / "sweep.nc", engine="h5netcdf") as plain:
        assert plain["steps"].dtype == np.int64


@pytest.mark.usefixtures("process")
@pytest.mark.slow
def test_full_histories_are_runs_of_the_size_that_was_told(tmp_path: Path) -> None:
    run_sweep(CASE, {"contact.friction": [0.05, 0.1]}, tmp_path / "sweep", histories=True)
    files = sorted((tmp_path / "sweep" / HISTORIES_NAME).iterdir())
    assert [path.name for path in files] == ["point_0.nc", "point_1.nc"]
    with bw.open_result(files[1]) as history:
        assert history.attrs["friction"] == 0.1
        assert history.sizes["time"] == 121
    plan = read_plan(tmp_path / "sweep")
    actual = (tmp_path / "sweep" / "sweep.nc").stat().st_size
    assert plan.dataset_bytes <= actual <= plan.dataset_bytes + 100_000  # names, attributes
    written = sum(path.stat().st_size for path in files)
    assert plan.history_bytes == pytest.approx(written, rel=0.02)


def test_figures_are_left(swept: Path) -> None:
    names = {path.name for path in swept.iterdir()}
    of_beams = [
        stem for stem in LEFT_BY_A_SWEEP if "contact_spectrum" not in SWEEP_FIGURES[stem].needs
    ]
    assert len(of_beams) == 3
    for stem in of_beams:
        assert {f"{stem}.png", f"{stem}.nc"} <= names


def test_an_interrupted_sweep_is_finished_with_the_same_bits(
    swept: Path, tmp_path: Path, process: InProcess
) -> None:
    process.left = 2
    with pytest.raises(Killed):
        run_sweep(CASE, OVER, tmp_path / "sweep")
    process.left = 10
    done = resume_sweep(tmp_path / "sweep")
    assert (done.marched, done.done) == (4, 6)
    assert same_bits(swept, tmp_path / "sweep")
    assert resume_sweep(tmp_path / "sweep").marched == 0


@pytest.mark.usefixtures("process")
def test_failed_points_are_reported_and_the_others_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first and the last stage are looked at beforehand; the one between can't be reduced."""
    monkeypatch.setattr(sweep_plan, "CHECKED_STAGES", 0)
    case = bw.with_values(CASE, {"march.duration": 1e-4})
    (tmp_path / "case.toml").write_text(bw.dumps_case(case))
    key = "reduction.fixed_interface_modes"
    over = f"--over={key}=9,{TOO_MANY_MODES},10"
    folder = tmp_path / "out"
    arguments = ["sweep", str(tmp_path / "case.toml"), over, "-o", str(folder), "--json"]
    result = answer(*arguments)
    report = json.loads(result.stdout)
    assert (report["points"], report["done"], report["failed"]) == (3, 2, 1)
    [failure] = report["failures"]
    assert failure[key] == TOO_MANY_MODES
    assert "at most" in failure["reason"]
    assert json.loads((folder / "failures.json").read_text()) == [failure]
    with bw.open_sweep(folder) as dataset:
        assert dataset["state"].values.tolist() == ["done", "failed", "done"]
        assert np.isnan(dataset["end_time"].values).tolist() == [False, True, False]


@pytest.mark.usefixtures("process")
@pytest.mark.parametrize(("time", "checked"), [(0.0, [0, 8]), (1e9, [0, 8, 2, 4, 6])])
def test_checks_before_a_sweep_end_after_some_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, time: float, checked: list[int]
) -> None:
    """The first and the last point are checked, others while there is time; then the sweep reports
    that it begins, before the first point is finished."""
    calls: list[object] = []

    def problem_of(stage: Stage) -> ContactProblem:
        calls.append(round(100 * stage.case.contact.friction))
        return prepare(stage).problem

    monkeypatch.setattr(sweep_plan, "problem_of", problem_of)
    monkeypatch.setattr(sweep_plan, "CHECK_TIME", time)
    case = bw.with_values(CASE, {"march.duration": 1e-4})
    watch = Watch(
        progress=lambda *numbers: calls.append(numbers), planned=lambda plan: calls.append("plan")
    )
    over = {"contact.friction": [0.0, 0.02, 0.04, 0.06, 0.08]}
    run_sweep(case, over, tmp_path / "sweep", watch=watch)
    began = calls.index("plan")
    assert calls[: began + 2] == [*checked, "plan", (0, 0, 5)]


def test_a_folder_in_use_is_refused(swept: Path) -> None:
    with pytest.raises(bw.UserError, match="--resume finishes the sweep in it"):
        run_sweep(CASE, OVER, swept)
    hold = "import h5py, sys; file = h5py.File(sys.argv[1], 'r+'); print(); input()"
    with subprocess.Popen(
        [sys.executable, "-c", hold, swept / "sweep.nc"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as other:
        assert other.stdout is not None
        other.stdout.readline()
        with pytest.raises(bw.UserError, match="still running"):
            resume_sweep(swept)
        other.communicate(b"\n")


@pytest.mark.parametrize(
    ("was", "is_now", "message"),
    [
        ("0.95", "1.5", "it was changed"),
        ("duration = 0.006", "duration = 0.009", "it was changed"),
        ('"over"', '"ov', "expected the plan of a sweep"),
        ('"over": {', '"over": {"x": 3, ', "expected the plan of a sweep"),
    ],
)
def test_a_changed_plan_is_refused(
    swept: Path, tmp_path: Path, was: str, is_now: str, message: str
) -> None:
    plan = (swept / PLAN_NAME).read_text()
    assert was in plan
    (tmp_path / PLAN_NAME).write_text(plan.replace(was, is_now, 1))
    with pytest.raises(bw.UserError, match=message):
        resume_sweep(tmp_path)


@pytest.mark.slow
def test_a_dataset_of_another_plan_is_refused(swept: Path, tmp_path: Path) -> None:
    grid = make_grid(CASE, {"march.speed": [1, 2]}, large=False)
    write_plan(plan_sweep(CASE, grid), tmp_path)
    (tmp_path / "sweep.nc").write_bytes((swept / "sweep.nc").read_bytes())
    with pytest.raises(bw.UserError, match="expected the dataset of the plan in this folder"):
        resume_sweep(tmp_path)


@pytest.mark.parametrize(
    "damaged",
    ["[", "[[1, 2]]", '[{"point": "x", "reason": "why"}]', '[{"point": 2, "reason": "why"}]'],
)
def test_damaged_failures_are_told(damaged: str, tmp_path: Path) -> None:
    (tmp_path / FAILURES_NAME).write_text(damaged)
    with pytest.raises(bw.UserError, match="expected the failed points of a sweep"):
        read_failures(tmp_path, 2)


def test_a_sweep_of_another_version_is_not_mixed(
    swept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_folder, "version", lambda: "0.0.0")
    with pytest.raises(bw.UserError, match=r"expected a plan of bladewhirl 0\.0\.0"):
        read_plan(swept)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "127.0.0.1:9"])
def test_a_scheduler_without_encryption_has_to_be_allowed(
    monkeypatch: pytest.MonkeyPatch, address: str
) -> None:
    refused = pytest.raises(bw.UserError, match=r"expected tls://HOST:PORT; without TLS anybody")
    work = Work(case="", layout=LAYOUT, histories="")
    points = [Point(number=0, values={})]
    with refused:
        next(march_points(work, points, scheduler=address, workers=None))
    monkeypatch.setattr(sweep_cluster, "PATIENCE", 1.0)
    allowed = pytest.raises(bw.UserError, match="expected the address of a dask scheduler")
    with dask.config.set({sweep_cluster.ENCRYPTION: False}), allowed:
        next(march_points(work, points, scheduler=address, workers=None))


def test_what_is_no_sweep_is_refused(tmp_path: Path) -> None:
    with pytest.raises(bw.ResultError, match="no such file"):
        bw.open_sweep(tmp_path)


def test_implausible_values_of_a_key_are_hinted_at(tmp_path: Path) -> None:
    grid = make_grid(CASE, {"contact.friction": [0.1, 0.2, 30.0]}, large=True)
    (hint,) = plan_sweep(CASE, grid).hints
    assert hint.startswith("unusual contact.friction = 30.0")


SCRIPT = """
import bladewhirl as bw
from sweep_work import CASE, OVER
print("started")
done = bw.run_sweep(CASE, OVER, {folder!r}, workers=2)
print(done.done, done.failed)
"""


def test_workers_do_not_import_the_main_module() -> None:
    main = sys.modules["__main__"]
    with workers._starting():
        handed_over = get_preparation_data("worker")
    assert not [key for key in handed_over if key.startswith("init_main")]
    assert sys.modules["__main__"] is main


@pytest.mark.slow
def test_a_script_without_a_guard_sweeps_once(swept: Path, tmp_path: Path) -> None:
    script, folder = tmp_path / "script.py", tmp_path / "unguarded"
    script.write_text(SCRIPT.format(folder=str(folder)), encoding="utf-8")
    support = str(Path(sweep_work.__file__).parent)
    done = subprocess.run(
        [sys.executable, script],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": support},
    )
    assert done.stdout.split() == ["started", "6", "0"]
    assert same_bits(swept, folder)


@pytest.mark.slow
def test_a_sweep_whose_points_all_fail_raises(process: InProcess, tmp_path: Path) -> None:
    process.outcome = lambda work, point: Failure(reason=f"no luck at {point.number}")
    with pytest.raises(bw.UserError, match=r"all 6 points failed, first .*: no luck at 0"):
        bw.run_sweep(CASE, OVER, tmp_path / "failed")
    with pytest.raises(bw.UserError, match="all 6 points failed"):
        bw.resume_sweep(tmp_path / "failed")

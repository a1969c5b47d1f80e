"""Sweeps on real workers: the same bits whatever happens on the way."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import dask
import h5py
import numpy as np
import psutil
import pytest
import sweep_work
import xarray as xr
from distributed import LocalCluster
from synthetic_sweep import LAYOUT
from typer.testing import CliRunner

import bladewhirl as bw
from bladewhirl.models.case.case import Case, March
from bladewhirl.models.case.excitation import Imbalance
from bladewhirl.models.case.file import dumps_case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.fields.result import ResultError, open_result
from bladewhirl.postprocess.run.late_motion import late_motion
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.sweep.dataset import DONE, Layout, open_sweep
from bladewhirl.postprocess.sweep.figures import LEFT_BY_A_SWEEP
from bladewhirl.solvers.march.schema import SWEEP_FORMAT
from bladewhirl.studies.commands.cli import app
from bladewhirl.studies.runs.folder import FAILURES_NAME, read_failures
from bladewhirl.studies.sweeps import cluster as sweep_cluster
from bladewhirl.studies.sweeps import plan as sweep_plan
from bladewhirl.studies.sweeps.axes import make_grid
from bladewhirl.studies.sweeps.cluster import march_groups
from bladewhirl.studies.sweeps.plan import PLAN_NAME, plan_sweep, read_plan, write_plan
from bladewhirl.studies.sweeps.points import Failure, Group, Outcome, Work
from bladewhirl.studies.sweeps.sweep import HISTORIES_NAME, resume_sweep, run_sweep

pytestmark = pytest.mark.usefixtures("pictures_unsaved")

CASE = Case(
    excitation=Imbalance(ramp=1e-3),
    march=March(duration=6e-3, record_step=5e-5),
)
OVER = {"march.speed": [0.95, 1.05, 1.15], "contact.friction": [0.05, 0.1]}

TOO_MANY_MODES = 50_000

RUNNER = CliRunner()

IMBALANCE = "examples/imbalance.toml"


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep of six points by two workers."""
    folder = tmp_path_factory.mktemp("sweep") / "two"
    done = run_sweep(CASE, OVER, folder, workers=2, histories=True)
    assert (done.points, done.done, done.failed) == (6, 6, 0)
    return folder


def same_bits(one: Path, other: Path) -> bool:
    return (one / "sweep.nc").read_bytes() == (other / "sweep.nc").read_bytes()


def test_a_point_is_what_a_run_of_its_case_says(swept: Path, tmp_path: Path) -> None:
    case = CASE.model_copy(update={"march": March(speed=1.05, duration=6e-3, record_step=5e-5)})
    run = bw.run(case, tmp_path / "run", frames=0)
    with open_sweep(swept) as dataset, run.open() as result:
        point = dataset.sel(march_speed=1.05, contact_friction=0.1)
        assert point["regime"].item() == run.summary.regime
        assert point["end_reason"].item() == "completed"
        assert point["shaft_radius_max"].item() == run.summary.shaft_radius_max
        assert point["strain_energy_max"].item() == run.summary.strain_energy_max
        assert point["steps"].item() == run.summary.steps == 6000
        np.testing.assert_array_equal(point["contact_share"], run.summary.contact_share)
        held = run.summary.strain_energy_final
        history = point["energy_history"].dropna("sample", how="all").isel(sample=-1)
        assert float(history.sel(energy_group="suspension")) == pytest.approx(
            held["suspension"], rel=1e-6
        )
        late = late_motion(result, shaft_orbit(result))
        assert point["whirl_frequency"].item() == late["whirl_frequency"].item()
        assert point["whirl_static"].item() == late["whirl_static"].item()
        assert point["scenario"].item() == late["scenario"].item()
        np.testing.assert_array_equal(point["late_contact_share"], late["late_contact_share"])
        assert point["rotation_speed"].item() == result.attrs["speed"]


def test_the_dataset_names_its_dimensions(swept: Path) -> None:
    with open_sweep(swept) as dataset:
        assert dataset["spectrum"].dims == ("march_speed", "contact_friction", "frequency")
        assert dataset["march_speed"].attrs["units"] == "1"
        assert (dataset["state"] == "done").all()
        assert (np.diff(dataset["shaft_radius_max"].values, axis=0) > 0).all()
        np.testing.assert_allclose(
            dataset["speed_ratio"], dataset["march_speed"] + 0 * dataset["steps"]
        )
    with xr.open_dataset(swept / "sweep.nc", engine="h5netcdf") as plain:
        assert plain["steps"].dtype == np.int64


def test_full_histories_are_runs(swept: Path) -> None:
    names = sorted(path.name for path in (swept / "histories").iterdir())
    assert names == [f"point_{i}.nc" for i in range(6)]
    with open_result(swept / "histories" / "point_5.nc") as history:
        assert history.attrs["friction"] == 0.1
        assert history.sizes["time"] == 121


def test_figures_are_left(swept: Path) -> None:
    names = {path.name for path in swept.iterdir()}
    for stem in LEFT_BY_A_SWEEP:
        assert {f"{stem}.png", f"{stem}.pdf", f"{stem}.nc"} <= names


def test_the_number_of_workers_does_not_matter(swept: Path, tmp_path: Path) -> None:
    run_sweep(CASE, OVER, tmp_path / "one", workers=1)
    assert same_bits(swept, tmp_path / "one")


@pytest.mark.slow
def test_an_existing_scheduler_gives_the_same_bits(swept: Path, tmp_path: Path) -> None:
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster,
        dask.config.set({sweep_cluster.ENCRYPTION: False}),
    ):
        run_sweep(CASE, OVER, tmp_path / "other", scheduler=cluster.scheduler_address)
        assert len(cluster.scheduler_info["workers"]) == 2  # it lives on
    assert same_bits(swept, tmp_path / "other")


def start(
    folder: Path, tmp_path: Path, *, errors: int = subprocess.DEVNULL
) -> subprocess.Popen[bytes]:
    """The same sweep as a process of its own, by one worker."""
    case = tmp_path / "case.toml"
    case.write_text(dumps_case(CASE))
    options = [f"--over={key}={','.join(map(str, values))}" for key, values in OVER.items()]
    # A shell that runs the tests in the background has its children ignore Ctrl-C.
    heed = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    code = f"{heed}; from bladewhirl.studies.commands.cli import main; main()"
    return subprocess.Popen(
        [sys.executable, "-c", code, "sweep", case, *options, "-o", folder, "--workers", "1"],
        stdout=subprocess.DEVNULL,
        stderr=errors,
        start_new_session=True,
    )


def points_done(folder: Path) -> int:
    if not (folder / "sweep.nc").exists():
        return 0
    with h5py.File(folder / "sweep.nc", "r", locking=False) as file:
        return int(np.count_nonzero(file["state"][()] == DONE))


def wait_for(condition: Callable[[], bool], process: subprocess.Popen[bytes]) -> None:
    while not condition():
        assert process.poll() is None, "ended before it could be disturbed"
        time.sleep(0.01)


def workers(process: subprocess.Popen[bytes]) -> list[psutil.Process]:
    """Its workers, as far as they have started."""
    found = []
    for child in psutil.Process(process.pid).children(recursive=True):
        with suppress(psutil.NoSuchProcess):  # it has just ended
            if "spawn_main" in " ".join(child.cmdline()):
                found.append(child)
    return found


def gone(children: list[psutil.Process]) -> bool:
    _, alive = psutil.wait_procs(children, timeout=60)
    return not alive


@pytest.mark.parametrize(
    "how", [signal.SIGKILL, pytest.param(signal.SIGINT, marks=pytest.mark.slow)]
)
def test_an_ended_sweep_is_finished_with_the_same_bits(
    swept: Path, tmp_path: Path, how: signal.Signals
) -> None:
    folder = tmp_path / "ended"
    process = start(folder, tmp_path)
    wait_for(lambda: points_done(folder) >= 2, process)
    children = psutil.Process(process.pid).children(recursive=True)
    if how is signal.SIGINT:
        os.killpg(process.pid, how)  # as a terminal does
    else:
        process.send_signal(how)
    assert process.wait() == (130 if how is signal.SIGINT else -how)
    assert gone(children)
    left = 6 - points_done(folder)
    assert 0 < left <= 4
    done = resume_sweep(folder, workers=2)
    assert (done.marched, done.done) == (left, 6)
    assert same_bits(swept, folder)
    assert resume_sweep(folder).marched == 0


def test_ctrl_c_while_workers_start_is_one_line(tmp_path: Path) -> None:
    folder = tmp_path / "ended"
    process = start(folder, tmp_path, errors=subprocess.PIPE)
    wait_for(lambda: bool(workers(process)), process)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, errors = process.communicate()
    assert process.returncode == 130
    size, told = errors.decode().splitlines()
    assert " points, " in size
    assert told == f"interrupted; bladewhirl sweep --resume {folder} finishes it"


@pytest.mark.slow
def test_a_killed_worker_costs_its_point_a_second_march(swept: Path, tmp_path: Path) -> None:
    folder = tmp_path / "worker"
    process = start(folder, tmp_path)
    wait_for(lambda: points_done(folder) >= 1, process)
    workers(process)[0].kill()
    assert process.wait() == 0
    assert same_bits(swept, folder)


def work(folder: Path) -> Work:
    layout = Layout(frequency=np.zeros(1), samples=1, nodal_diameters=1, blades=3)
    return Work(case="", layout=layout, histories=str(folder))


GROUPS = [Group(number=i, points={i: {}}, history_names={}) for i in range(6)]


@pytest.mark.slow
def test_a_point_that_kills_every_worker_fails_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweep_cluster, "march_group", sweep_work.deadly)
    found: dict[int, Outcome] = {}
    for outcomes in sweep_cluster.march_groups(work(tmp_path), GROUPS, scheduler=None, workers=2):
        found.update(outcomes)
    assert sorted(found) == list(range(6))
    failed = {point for point, outcome in found.items() if isinstance(outcome, Failure)}
    assert failed == {sweep_work.DEADLY}


def test_a_worker_that_dies_once_is_forgiven(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweep_cluster, "march_group", sweep_work.deadly_once)
    found: dict[int, Outcome] = {}
    for outcomes in sweep_cluster.march_groups(work(tmp_path), GROUPS, scheduler=None, workers=2):
        found.update(outcomes)
    assert found == {i: Failure(reason=f"point {i}") for i in range(6)}


def test_workers_of_another_version_are_told_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweep_cluster, "march_group", sweep_work.of_another_version)
    with pytest.raises(UserError, match=r"workers: expected bladewhirl .*No module named 'old'"):
        list(sweep_cluster.march_groups(work(tmp_path), GROUPS[:1], scheduler=None, workers=1))


def test_failed_points_are_told_and_the_others_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first and the last stage are looked at beforehand; the one between can't be reduced."""
    monkeypatch.setattr(sweep_plan, "CHECKED_STAGES", 2)
    case = CASE.model_copy(update={"march": March(duration=1e-4, record_step=5e-5)})
    (tmp_path / "case.toml").write_text(dumps_case(case))
    key = "reduction.fixed_interface_modes"
    over = f"--over={key}=109,{TOO_MANY_MODES},110"
    folder = tmp_path / "out"
    arguments = ["sweep", str(tmp_path / "case.toml"), over, "-o", str(folder), "--json"]
    result = RUNNER.invoke(app, arguments)
    assert result.exit_code == 0, result.stderr
    report = json.loads(result.stdout)
    assert (report["points"], report["done"], report["failed"]) == (3, 2, 1)
    [failure] = report["failures"]
    assert failure[key] == TOO_MANY_MODES
    assert "at most" in failure["reason"]
    assert json.loads((folder / "failures.json").read_text()) == [failure]
    with open_sweep(folder) as dataset:
        assert dataset["state"].values.tolist() == ["done", "failed", "done"]
        assert np.isnan(dataset["end_time"].values).tolist() == [False, True, False]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "expected CASE, --over KEY=VALUES and -o DIR, or --resume DIR"),
        (["--resume", "x", "--over", "a=1,2"], "--resume x: expected no --over"),
        (["--resume", "x"], "expected the plan of a sweep"),
        (["--workers", "1", "--scheduler", "tcp://x:1"], "expected one of them"),
        (
            [IMBALANCE, "--over", "march.speed=1,2", "--set", "march.speed=3", "-o", "x"],
            "--over march.speed, --set march.speed=3: expected one of them",
        ),
        (
            [IMBALANCE, "--over", "march.duration=0.01,1e5", "-o", "x"],
            "--over: 1e+11 steps of one march are more than 1e+09; --yes runs them all",
        ),
    ],
)
def test_options_that_do_not_go_together(arguments: list[str], message: str) -> None:
    result = RUNNER.invoke(app, ["sweep", *arguments])
    assert result.exit_code == 2
    assert message in result.stderr


def test_a_folder_in_use_is_refused(swept: Path) -> None:
    with pytest.raises(UserError, match="--resume finishes the sweep in it"):
        run_sweep(CASE, OVER, swept)
    hold = "import h5py, sys; file = h5py.File(sys.argv[1], 'r+'); print(); input()"
    with subprocess.Popen(
        [sys.executable, "-c", hold, swept / "sweep.nc"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as other:
        assert other.stdout is not None
        other.stdout.readline()
        with pytest.raises(UserError, match="still running"):
            resume_sweep(swept)
        other.communicate(b"\n")


@pytest.mark.parametrize(
    ("was", "is_now", "message"),
    [
        ("0.95", "1.5", "it was changed"),
        ("duration = 0.006", "duration = 0.009", "it was changed"),
        ('"over"', '"ov', "expected the plan of a sweep"),
        ('"group_size": 1', '"group_size": 1e999', "expected the plan of a sweep"),
        ('"over": {', '"over": {"x": 3, ', "expected the plan of a sweep"),
    ],
)
def test_a_changed_plan_is_refused(
    swept: Path, tmp_path: Path, was: str, is_now: str, message: str
) -> None:
    plan = (swept / PLAN_NAME).read_text()
    assert was in plan
    (tmp_path / PLAN_NAME).write_text(plan.replace(was, is_now, 1))
    with pytest.raises(UserError, match=message):
        resume_sweep(tmp_path)


def test_a_dataset_of_another_plan_is_refused(swept: Path, tmp_path: Path) -> None:
    grid = make_grid(CASE, {"march.speed": [1, 2]}, large=False)
    write_plan(plan_sweep(CASE, grid, histories=False), tmp_path)
    (tmp_path / "sweep.nc").write_bytes((swept / "sweep.nc").read_bytes())
    with pytest.raises(UserError, match="expected the dataset of the plan beside it"):
        resume_sweep(tmp_path)


@pytest.mark.parametrize(
    "damaged",
    ["[", "3", "[[1, 2]]"]
    + [f'[{{"point": {point}, "reason": "why"}}]' for point in ('"x"', "-1", "2")],
)
def test_damaged_failures_are_told(damaged: str, tmp_path: Path) -> None:
    (tmp_path / FAILURES_NAME).write_text(damaged)
    with pytest.raises(UserError, match="expected the failed points of a sweep"):
        read_failures(tmp_path, 2)


def test_a_sweep_of_another_format_is_not_mixed(swept: Path, tmp_path: Path) -> None:
    plan = json.loads((swept / PLAN_NAME).read_text())
    del plan["format"]
    (tmp_path / PLAN_NAME).write_text(json.dumps(plan))
    with pytest.raises(UserError, match=f"format {SWEEP_FORMAT}, this one is of 1"):
        resume_sweep(tmp_path)


def test_the_size_is_told_right(swept: Path) -> None:
    estimate = read_plan(swept).dataset_bytes
    actual = (swept / "sweep.nc").stat().st_size
    assert estimate <= actual <= estimate + 100_000  # names, attributes, frequencies
    histories = sum(path.stat().st_size for path in (swept / HISTORIES_NAME).iterdir())
    assert read_plan(swept).history_bytes == pytest.approx(histories, rel=0.02)


def test_a_sweep_of_another_version_is_not_mixed(swept: Path, tmp_path: Path) -> None:
    plan = json.loads((swept / PLAN_NAME).read_text())
    (tmp_path / PLAN_NAME).write_text(json.dumps({**plan, "bladewhirl": "0.0.0"}))
    with pytest.raises(UserError, match=r"this one is of 0\.0\.0"):
        resume_sweep(tmp_path)


def test_a_scheduler_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep_cluster, "PATIENCE", 1.0)
    with pytest.raises(UserError, match="expected the address of a dask scheduler"):
        run_sweep(CASE, OVER, tmp_path / "new", scheduler="tls://127.0.0.1:9")


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "127.0.0.1:9"])
def test_a_scheduler_without_encryption_has_to_be_allowed(
    monkeypatch: pytest.MonkeyPatch, address: str
) -> None:
    refused = pytest.raises(UserError, match=r"expected tls://HOST:PORT; without TLS anybody")
    work = Work(case="", layout=LAYOUT, histories="")
    groups = [Group(number=0, points={0: {}}, history_names={})]
    with refused:
        next(march_groups(work, groups, scheduler=address, workers=None))
    monkeypatch.setattr(sweep_cluster, "PATIENCE", 1.0)
    allowed = pytest.raises(UserError, match="expected the address of a dask scheduler")
    with dask.config.set({sweep_cluster.ENCRYPTION: False}), allowed:
        next(march_groups(work, groups, scheduler=address, workers=None))


def test_what_is_no_sweep_is_refused(tmp_path: Path, swept: Path) -> None:
    with pytest.raises(ResultError, match="no such file"):
        open_sweep(tmp_path)
    with pytest.raises(ResultError, match="no state"):
        open_sweep(swept / "histories" / "point_0.nc")

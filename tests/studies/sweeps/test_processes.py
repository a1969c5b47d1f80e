"""Sweeps in worker processes: the same bits as in one process, whatever is killed on the way."""

import os
import re
import signal
import socket
import subprocess
import sys
import threading
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
from distributed import LocalCluster
from sweep_work import CASE, OVER, same_bits

import bladewhirl as bw
from bladewhirl.postprocess.sweep.dataset import DONE, Layout
from bladewhirl.studies.sweeps import cluster as sweep_cluster
from bladewhirl.studies.sweeps import workers
from bladewhirl.studies.sweeps.marching import march_points
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point, Work

Found = Callable[["subprocess.Popen[bytes]"], list[psutil.Process]]

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("workers", [1, 2])
def test_the_number_of_workers_does_not_change_the_bits(
    swept: Path, tmp_path: Path, workers: int
) -> None:
    bw.run_sweep(CASE, OVER, tmp_path / "sweep", workers=workers)
    assert same_bits(swept, tmp_path / "sweep")


def test_the_number_of_workers_does_not_change_the_draws(tmp_path: Path) -> None:
    perturb = ["contact.friction = 0.5 uniform"]
    folders = [tmp_path / "1", tmp_path / "2"]
    for count, folder in enumerate(folders, 1):
        done = bw.run_sweep(CASE, OVER, folder, draws=6, perturb=perturb, until=0.2, workers=count)
        assert (done.done, done.not_needed) == (24, 12)
    assert same_bits(*folders)


def test_an_existing_scheduler_gives_the_same_bits(swept: Path, tmp_path: Path) -> None:
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster,
        dask.config.set({sweep_cluster.ENCRYPTION: False}),
    ):
        bw.run_sweep(CASE, OVER, tmp_path / "other", scheduler=cluster.scheduler_address)
        assert len(cluster.scheduler_info["workers"]) == 2  # it lives on
    assert same_bits(swept, tmp_path / "other")


def start(
    folder: Path, tmp_path: Path, *, errors: int = subprocess.DEVNULL
) -> subprocess.Popen[bytes]:
    """Start the same sweep in another process, with one worker."""
    case = tmp_path / "case.toml"
    case.write_text(bw.dumps_case(CASE))
    options = [f"--over={key}={','.join(map(str, values))}" for key, values in OVER.items()]
    # A shell that runs the tests in the background has its children ignore Ctrl-C.
    raise_on_interrupt = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    code = f"{raise_on_interrupt}; from bladewhirl.studies.commands.cli import main; main()"
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


def started(process: subprocess.Popen[bytes]) -> list[psutil.Process]:
    """Return the process that starts the workers of a sweep, if it exists, and the workers."""
    found = []
    for child in psutil.Process(process.pid).children(recursive=True):
        with suppress(psutil.NoSuchProcess):  # it has just ended
            if {"forkserver", "spawn_main"} & set(re.findall(r"\w+", " ".join(child.cmdline()))):
                found.append(child)
    return found


def worker_processes(process: subprocess.Popen[bytes]) -> list[psutil.Process]:
    """Return the workers of a sweep that have started."""
    above = {child.pid for child in psutil.Process(process.pid).children()}
    return [child for child in started(process) if child.pid not in above]


def gone(children: list[psutil.Process]) -> bool:
    _, alive = psutil.wait_procs(children, timeout=60)
    return not alive


@pytest.mark.parametrize("found", [started, worker_processes])
def test_workers_that_start_end_with_their_parent(tmp_path: Path, found: Found) -> None:
    process = start(tmp_path / "ended", tmp_path)
    wait_for(lambda: bool(found(process)), process)
    children = psutil.Process(process.pid).children(recursive=True)
    process.kill()
    process.wait()
    assert gone(children)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
def test_an_ended_sweep_is_finished_with_the_same_bits(
    swept: Path, tmp_path: Path, how: signal.Signals
) -> None:
    folder = tmp_path / "ended"
    process = start(folder, tmp_path)
    wait_for(lambda: points_done(folder) >= 2, process)
    children = psutil.Process(process.pid).children(recursive=True)
    if how is signal.SIGKILL:
        process.send_signal(how)
    else:
        os.killpg(process.pid, how)  # as a terminal and a batch system do
    assert process.wait() == (-how if how is signal.SIGKILL else 130)
    assert gone(children)
    left = 6 - points_done(folder)
    assert 0 < left <= 4
    done = bw.resume_sweep(folder, workers=2)
    assert (done.marched, done.done) == (left, 6)
    assert same_bits(swept, folder)
    assert bw.resume_sweep(folder).marched == 0


@pytest.mark.parametrize("found", [started, worker_processes])
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_an_end_while_workers_start_is_one_line(
    tmp_path: Path, how: signal.Signals, found: Found
) -> None:
    folder = tmp_path / "ended"
    process = start(folder, tmp_path, errors=subprocess.PIPE)
    wait_for(lambda: bool(found(process)), process)
    os.killpg(process.pid, how)
    _, errors = process.communicate()
    assert process.returncode == 130
    size, message = errors.decode().splitlines()
    assert " points, " in size
    assert message == f"interrupted; bladewhirl sweep --resume {folder} finishes it"


def test_a_killed_worker_costs_its_point_a_second_march(swept: Path, tmp_path: Path) -> None:
    folder = tmp_path / "worker"
    process = start(folder, tmp_path)
    wait_for(lambda: points_done(folder) >= 1, process)
    worker_processes(process)[0].kill()
    assert process.wait() == 0
    assert same_bits(swept, folder)


def work(folder: Path) -> Work:
    layout = Layout(frequency=np.zeros(1), samples=1, nodal_diameters=1, blades=3)
    return Work(case="", layout=layout, histories=str(folder))


POINTS = [Point(number=i, values={}) for i in range(6)]


def test_a_point_that_kills_every_worker_fails_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers, "march_point", sweep_work.deadly)
    outcomes: dict[int, Outcome] = dict(
        march_points(work(tmp_path), POINTS, scheduler=None, workers=2)
    )
    assert sorted(outcomes) == list(range(6))
    failed = {point for point, outcome in outcomes.items() if isinstance(outcome, Failure)}
    assert failed == {sweep_work.DEADLY}


def test_workers_of_another_version_are_reported_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweep_cluster, "march_point", sweep_work.of_another_version)
    with (
        LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0") as cluster,
        dask.config.set({sweep_cluster.ENCRYPTION: False}),
    ):
        outcomes = march_points(
            work(tmp_path), POINTS[:1], scheduler=cluster.scheduler_address, workers=None
        )
        with pytest.raises(
            bw.UserError, match=r"workers: expected bladewhirl .*No module named 'old'"
        ):
            list(outcomes)


def test_a_lost_scheduler_is_reported_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(sweep_cluster, "IDLE", 0.5)
    command = [str(Path(sys.executable).with_name("dask")), "scheduler", "--host", "127.0.0.1"]
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    scheduler = subprocess.Popen(
        [*command, "--port", str(port), "--no-dashboard"], stderr=subprocess.DEVNULL
    )
    try:
        address = f"tcp://127.0.0.1:{port}"
        while not answers(port):
            time.sleep(0.1)

        def kill_after_the_warning() -> None:
            while not any(each.levelname == "WARNING" for each in caplog.records):
                time.sleep(0.1)
            scheduler.kill()

        threading.Thread(target=kill_after_the_warning, daemon=True).start()
        with (
            dask.config.set({sweep_cluster.ENCRYPTION: False}),
            pytest.raises(bw.UserError, match=r"connection was lost; .* sweep --resume DIR"),
        ):
            list(march_points(work(tmp_path), POINTS, scheduler=address, workers=None))
    finally:
        scheduler.kill()
        scheduler.wait()
    assert [each.getMessage() for each in caplog.records if each.levelname == "WARNING"] == [
        "The scheduler has no worker; the sweep goes on when one joins."
    ]
    assert not [each for each in caplog.records if each.levelname == "ERROR"]


def answers(port: int) -> bool:
    """Return whether a process listens at a port of this computer."""
    with socket.socket() as client:
        return client.connect_ex(("127.0.0.1", port)) == 0

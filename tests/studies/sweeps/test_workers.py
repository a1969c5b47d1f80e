"""Start of worker processes: from two threads, in a pool, under little memory; a removed folder."""

import multiprocessing
import shutil
import sys
import threading
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import forkserver
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from long_cases import slow_except
from sweep_work import CASE, OVER, InProcess

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.sweeps import workers
from bladewhirl.studies.sweeps.points import Point, Work
from bladewhirl.studies.sweeps.sweep import Watch, run_sweep

WORK = Work(case="", layout=None, histories="")


def test_two_threads_leave_the_main_module() -> None:
    """The second thread begins before the first one ends, and ends after it."""
    main, began, overlaps = sys.modules["__main__"], threading.Event(), threading.Event()
    seen: list[Any] = []

    def first() -> None:
        with workers._starting():
            began.set()
            overlaps.wait()

    def second() -> None:
        began.wait()
        with workers._starting():
            overlaps.set()
            threads[0].join()
            seen.append(sys.modules["__main__"])

    threads = [threading.Thread(target=target) for target in (first, second)]
    for thread in threads:
        thread.start()
    threads[1].join()
    assert sys.modules["__main__"] is main
    assert seen[0] is not main


def test_a_sweep_in_a_pool_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    worker = SimpleNamespace(daemon=True)
    monkeypatch.setattr(multiprocessing, "current_process", lambda: worker)
    with pytest.raises(UserError, match="expected a call in the main process"):
        run_sweep(CASE, OVER, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("after", slow_except([1, 6], 1))
def test_a_removed_folder_does_not_come_back(
    tmp_path: Path, process: InProcess, after: int
) -> None:
    folder = tmp_path / "out"

    def remove(done: int, failed: int, points: int) -> None:
        if done == after:
            shutil.rmtree(folder)

    with pytest.raises(UserError, match="out: was removed while the sweep was running"):
        run_sweep(CASE, OVER, folder, watch=Watch(progress=remove))
    assert not folder.exists()


def test_workers_that_cannot_start_end_the_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_memory(*_: Any) -> None:
        raise BlockingIOError("Resource temporarily unavailable")

    monkeypatch.setattr(ProcessPoolExecutor, "submit", no_memory)
    with pytest.raises(UserError, match=r"while they start \(Resource .* more free memory"):
        list(workers.march_in_processes(WORK, [Point(number=0, values={})], 2))


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are those of Linux")
def test_workers_without_memory_end_the_sweep_at_once() -> None:
    """The process that starts the workers has no room for what they import."""
    resource = pytest.importorskip("resource")
    forkserver._forkserver._stop()  # type: ignore[attr-defined]  # one with a limit begins
    workers.process_context()
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (60 << 20, hard))
    try:
        forkserver.ensure_running()
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
    points = [Point(number=number, values={}) for number in range(100)]
    try:
        with pytest.raises(UserError, match="worker processes end while they start"):
            list(workers.march_in_processes(WORK, points, 2))
    finally:
        forkserver._forkserver._stop()  # type: ignore[attr-defined]
    assert not multiprocessing.active_children()

"""Points marched by processes of this machine: a few at a time, results in any order.

Processes, not threads, although the march leaves Python's lock: a point that crashes, or that the
system kills for its memory, takes its process along. So no sweep is lost with it.
"""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import chain, islice

from bladewhirl.studies.runs.interrupts import held_back
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point, Work, march_point

READY = 1
"""Points that wait for each worker in addition to the running one, so that it is never idle."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables of the threads of linear algebra, which would compete for the cores."""


def march_points(
    work: Work, points: Iterable[Point], *, scheduler: str | None, workers: int | None
) -> Iterator[tuple[int, Outcome]]:
    """March points and yield the number and the outcome of each on arrival.

    A worker that dies takes down nothing but what it was doing: others are started. Points that
    were on their way then are put aside and tried alone at the end, when no other can be to blame;
    if their worker dies even so, they fail.

    Args:
        work: what the points have in common.
        points: to march.
        scheduler: address of a dask scheduler, whose workers march; None for this machine.
        workers: number of processes of this machine; one a core when None.

    Raises:
        UserError: the scheduler does not answer, has no TLS, or its workers have another version.
    """
    if scheduler is not None:
        from bladewhirl.studies.sweeps.cluster import march_on_cluster

        yield from march_on_cluster(work, points, scheduler)
        return
    waiting: Iterator[Point] = iter(points)
    suspects: list[Point] = []
    while ahead := list(islice(waiting, workers or cores())):
        waiting = chain(ahead, waiting)
        yield from _in_flight(work, waiting, len(ahead), suspects)
    for point in suspects:
        dead: list[Point] = []
        yield from _in_flight(work, iter([point]), 1, dead)
        if dead:
            reason = (
                "the worker died every time it marched this point, also when it marched no other"
            )
            yield point.number, Failure(reason=reason)


def cores() -> int:
    """Number of cores that this process may use."""
    available = getattr(os, "sched_getaffinity", None)
    return len(available(0)) if available else os.cpu_count() or 1


def _in_flight(
    work: Work, waiting: Iterator[Point], workers: int, suspects: list[Point]
) -> Iterator[tuple[int, Outcome]]:
    """March points until there are none left or a worker dies; few are sent at a time."""
    marching: dict[Future[Outcome], Point] = {}
    with _processes(workers) as pool:
        while True:
            for point in islice(waiting, (1 + READY) * workers - len(marching)):
                try:
                    with _starting():
                        marching[pool.submit(march_point, work, point)] = point
                except BrokenProcessPool:
                    suspects += [point, *marching.values()]
                    return
            if not marching:
                return
            for future in wait(marching, return_when=FIRST_COMPLETED).done:
                try:
                    outcome = future.result()
                except BrokenProcessPool:
                    suspects += marching.values()
                    return
                yield marching.pop(future).number, outcome


@contextmanager
def _processes(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Worker processes; those that still march when an error or Ctrl-C leaves here are killed."""
    others = set(multiprocessing.active_children())
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_leave_with_parent)
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for child in set(multiprocessing.active_children()) - others:
            child.kill()
        raise
    finally:
        pool.shutdown()


@contextmanager
def _starting() -> Iterator[None]:
    """Start workers that hear no Ctrl-C, with one thread of linear algebra each."""
    missing = [name for name in ONE_THREAD if name not in os.environ]
    os.environ.update(dict.fromkeys(missing, "1"))
    try:
        with held_back():
            yield
    finally:
        for name in missing:
            del os.environ[name]


def _leave_with_parent() -> None:
    """End this process when its parent does, even when that is killed."""
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()

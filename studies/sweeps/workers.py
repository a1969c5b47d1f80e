"""Points marched by processes of this computer: a few at a time, with results in any order.

Processes are used instead of threads, although the march releases Python's global lock: a point
that crashes, or that the system kills for its memory, ends only its worker process and not the
sweep.
"""

import multiprocessing
import sys
import threading
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import chain, islice
from multiprocessing.context import BaseContext
from types import ModuleType

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.machine import cores
from bladewhirl.studies.runs.interrupts import held_back, leave_with_parent
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point, Work, march_point

READY = 1  #: number of points that wait for each worker, so that no worker is ever idle

_HIDING, _HIDDEN = threading.Lock(), list[ModuleType]()
"""The main module, once for each thread that starts workers, and the lock of this list."""


def march_in_processes(
    work: Work, points: Iterable[Point | None], workers: int | None
) -> Iterator[tuple[int, Outcome]]:
    """March points in processes of this computer, see `march_points`.

    If a worker dies, new workers are started. The points that were being marched at that time are
    marched again at the end, one at a time, so that a point is certainly the cause if its worker
    dies again; this point fails.
    """
    waiting: Iterator[Point | None] = iter(points)
    suspects: list[Point] = []
    while True:
        while ahead := ready(waiting, workers or cores()):
            waiting = chain(ahead, waiting)
            yield from _in_flight(work, waiting, len(ahead), suspects)
        if not suspects:
            return
        _check_start()
        point, dead = suspects.pop(0), list[Point]()
        yield from _in_flight(work, iter([point]), 1, dead)
        if dead:
            reason = (
                "the worker died every time it marched this point, also when it had no other point"
            )
            yield point.number, Failure(reason=reason)


def ready(points: Iterator[Point | None], most: int) -> list[Point]:
    """Return the next points before the first None, at most `most` of them."""
    chosen: list[Point] = []
    for point in islice(points, most):
        if point is None:
            break
        chosen.append(point)
    return chosen


def _in_flight(
    work: Work, waiting: Iterator[Point | None], workers: int, suspects: list[Point]
) -> Iterator[tuple[int, Outcome]]:
    """March points until all are finished or a worker dies; then the points being marched are added
    to `suspects`. Only a few points are sent to the workers at a time."""
    marching: dict[Future[Outcome], Point] = {}
    with _processes(workers) as pool:
        while True:
            for point in ready(waiting, (1 + READY) * workers - len(marching)):
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


def _check_start() -> None:
    """Check that a worker starts and can import what it needs.

    Raises:
        UserError: it ends before.
    """
    with _processes(1) as pool, _starting():
        try:
            pool.submit(callable, march_point).result()
        except BrokenProcessPool as error:
            raise EOFError(*error.args) from None


@contextmanager
def _processes(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of worker processes; after an error or Ctrl-C, busy workers are killed."""
    pool = ProcessPoolExecutor(workers, mp_context=process_context(), initializer=leave_with_parent)
    try:
        yield pool
    except BaseException:
        children = list((pool._processes or {}).values())  # there is no public way to end them
        pool.shutdown(wait=False, cancel_futures=True)
        for child in children:
            child.kill()
        raise
    finally:
        pool.shutdown()


def process_context() -> BaseContext:
    """Return the way in which workers start: on Linux they are copies of one process that has
    imported what they need, which is not imported again for each worker and for each sweep.

    Raises:
        UserError: this process is a worker itself, of a pool that does not allow it.
    """
    if multiprocessing.current_process().daemon:
        raise UserError(
            "sweep: a worker of multiprocessing.Pool may not start processes; expected a call in"
            " the main process, or in concurrent.futures.ProcessPoolExecutor"
        )
    if sys.platform != "linux":
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([march_point.__module__])
    return context


@contextmanager
def _starting() -> Iterator[None]:
    """Let workers that start in the ``with`` block ignore Ctrl-C and not import the main module:
    they need nothing of it, and a script would start its sweep again.

    Raises:
        UserError: they cannot start.
    """
    with _HIDING:
        _HIDDEN.append(_HIDDEN[0] if _HIDDEN else sys.modules["__main__"])
        sys.modules["__main__"] = ModuleType("__main__")
    try:
        with held_back():
            yield
    except (OSError, EOFError) as error:
        raise UserError(
            f"sweep: worker processes end while they start ({str(error) or type(error).__name__});"
            " expected more free memory, or fewer --workers"
        ) from None
    finally:
        with _HIDING:
            main = _HIDDEN.pop()
            if not _HIDDEN:
                sys.modules["__main__"] = main

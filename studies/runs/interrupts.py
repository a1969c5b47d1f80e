"""Delayed Ctrl-C during operations that must end in order."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker


@contextmanager
def asked_to_stop() -> Iterator[Callable[[], bool]]:
    """Turn the first Ctrl-C into a question to ask; the second one is a KeyboardInterrupt again.

    Only the main thread gets signals; elsewhere the answer stays False.
    """
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked.is_set
        return
    before = signal.getsignal(signal.SIGINT)

    def ask(number: int, frame: object) -> None:
        asked.set()
        signal.signal(signal.SIGINT, before)

    signal.signal(signal.SIGINT, ask)
    try:
        yield asked.is_set
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def held_back() -> Iterator[None]:
    """Let Ctrl-C wait until what is started here runs.

    Processes started here never get it where a terminal sends it to all, which takes POSIX's
    masks; elsewhere they end by themselves when this one does.
    """
    if not hasattr(signal, "pthread_sigmask"):
        with asked_to_stop() as asked:
            yield
        if asked():
            raise KeyboardInterrupt
        return
    resource_tracker.ensure_running()  # a later start would let the signal through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

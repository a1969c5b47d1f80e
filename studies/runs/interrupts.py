"""Delay of Ctrl-C during operations that must not be interrupted at once, and end of processes.

The module imports the standard library only, so that workers call `leave_with_parent` at once.
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker


@contextmanager
def asked_to_stop() -> Iterator[Callable[[], bool]]:
    """Yield a function that returns whether Ctrl-C was pressed; a second Ctrl-C raises
    KeyboardInterrupt.

    Only the main thread receives signals; in other threads the function always returns False.
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
    """Delay Ctrl-C while processes are started.

    A terminal sends Ctrl-C to all its processes. With the signal masks of POSIX, processes started
    here never receive it; on other systems they end by themselves when this process ends.
    """
    if not hasattr(signal, "pthread_sigmask"):
        with asked_to_stop() as asked:
            yield
        if asked():
            raise KeyboardInterrupt
        return
    resource_tracker.ensure_running()  # a later start would unblock the signal
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def leave_with_parent() -> None:
    """End this process when its parent process ends, even if the parent is killed."""
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()

"""Progress of long computations, which report it to whoever listens; commands show it as a bar."""

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from threading import Lock
from typing import TypeVar

Listener = Callable[[str, int, int, str], None]
"""Called with an activity, the numbers of its finished items and of all items, and the name of an
item for a log, empty for what a log leaves out. The number of all items is 0 if it is not known."""

Item = TypeVar("Item")


@dataclass
class _Watch:
    listener: Listener
    counts: dict[str, tuple[int, int]] = field(default_factory=dict)
    """Finished items and all items of each activity whose items are announced."""
    lock: Lock = field(default_factory=Lock)  #: items may be finished in threads


_watch: ContextVar[_Watch | None] = ContextVar("watch", default=None)


@contextmanager
def listening(listener: Listener) -> Iterator[None]:
    """Call a listener with the progress of everything that is computed inside this context."""
    token = _watch.set(_Watch(listener))
    try:
        yield
    finally:
        _watch.reset(token)


def report(activity: str, done: int = 0, total: int = 0) -> None:
    """Report the numbers of finished items and of all items of an activity."""
    if (watch := _watch.get()) is not None:
        watch.listener(activity, done, total, "")


def tracked(activity: str, items: Collection[Item]) -> Iterator[Item]:
    """Yield items, and report each one that is finished."""
    report(activity, 0, len(items))
    for done, item in enumerate(items, 1):
        yield item
        report(activity, done, len(items))


def count(activity: str, *, expected: int = 0, finished: int = 0, noun: str = "") -> None:
    """Report that items are expected besides those of the activity that are not finished yet, or
    that some are finished; `noun` is the name of an item for a log."""
    if (watch := _watch.get()) is None:
        return
    with watch.lock:
        done, total = watch.counts.get(activity, (0, 0))
        if expected and done == total:
            done = total = 0
        total += expected
        done = min(done + finished, total)
        watch.counts[activity] = done, total
        watch.listener(activity, done, total, noun)

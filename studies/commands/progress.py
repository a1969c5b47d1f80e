"""Progress on standard error: a bar on a terminal, occasional lines in a log."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Protocol

import typer

if TYPE_CHECKING:
    from rich.console import Console

TENTHS = 10
"""Number of lines for a short job: one for each tenth."""

PAUSE = 60.0
"""Longest time between two lines [s]."""


class Update(Protocol):
    """Callback for progress."""

    def __call__(
        self, done: int, total: int, *, label: str = "", text: str = "", failed: int = 0
    ) -> None:
        """Show progress.

        Args:
            done: number of finished items, failures included.
            total: number of items.
            label: text before the bar; unchanged if empty.
            text: text after the bar; the percentage if empty.
            failed: number of failures.
        """


@cache
def _console() -> Console:
    """Return standard error; all bars share one console, so that they stand below each other."""
    from rich.console import Console

    return Console(stderr=True)


@contextmanager
def progress_bar(label: str, *, lines: str = "") -> Iterator[Update]:
    """Show a bar that disappears at the end of the job.

    Args:
        label: text before the bar.
        lines: noun of the counted items, "points"; without a terminal, lines are written if set.
    """
    from rich import progress as bars

    console = _console()
    terminal = console.is_terminal
    log = ProgressLines(lines)
    with bars.Progress(
        bars.TextColumn("{task.description}"),
        bars.BarColumn(),
        bars.TextColumn("{task.fields[text]}"),
        bars.TimeRemainingColumn(),
        bars.TextColumn("left"),
        console=console,
        transient=True,
        disable=not terminal,
    ) as bar:
        task = bar.add_task(label, total=None, text="")

        def update(
            done: int, total: int, *, label: str = "", text: str = "", failed: int = 0
        ) -> None:
            failures = f", {failed} failed" if failed else ""
            if lines and not terminal:
                log(done, total, failures)
            text = (text or f"{done / max(total, 1):4.0%}") + failures
            bar.update(task, completed=done, total=total, description=label or None, text=text)

        yield update


class ProgressLines:
    """Lines on standard error, one each tenth or each minute, with the remaining time."""

    def __init__(self, noun: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Args: noun of the counted items; clock in seconds."""
        self._noun, self._clock = noun, clock
        self._last, self._last_time = (0, 0), clock()
        self._start: tuple[int, int, float] | None = None  # done before, total, time

    def __call__(self, done: int, total: int, suffix: str = "") -> None:
        """Write a line if it is due.

        Args:
            done: number of finished items; a smaller number or another total starts a new job.
            total: number of items.
            suffix: text after the numbers.
        """
        now = self._clock()
        if self._start is None or self._start[1] != total or done < self._start[0]:
            self._start = done, total, now
        if done <= 0 or total <= 0 or (done, total) == self._last:
            return
        tenth = done * TENTHS // total > self._last[0] * TENTHS // total
        if tenth or total != self._last[1] or now - self._last_time >= PAUSE:
            first, _, start = self._start
            left = ""
            if first < done < total:  # the rate since the start of the job
                left = f", {_duration((now - start) / (done - first) * (total - done))} left"
            typer.echo(f"{done} of {total} {self._noun}{suffix}{left}", err=True)
            self._last, self._last_time = (done, total), now


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"

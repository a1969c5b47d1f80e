"""Progress on standard error: a bar on a terminal, else a line now and then, for logs."""

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
"""Lines that a short job has: one each time another tenth is done."""

PAUSE = 60.0
"""Longest silence while something is being done [s]."""


class Update(Protocol):
    """Called with how much is done and of how much."""

    def __call__(
        self, done: int, total: int, *, label: str = "", told: str = "", failed: int = 0
    ) -> None:
        """Note it.

        Args:
            done: of what is counted, failures included.
            total: of it.
            label: before the bar; as it was if empty.
            told: after the bar; the percentage if empty.
            failed: how many have.
        """


@cache
def _console() -> Console:
    """Standard error, one for all bars: they stand below each other."""
    from rich.console import Console

    return Console(stderr=True)


@contextmanager
def progress_bar(label: str, *, lines: str = "") -> Iterator[Update]:
    """A bar that goes when its job ends.

    Args:
        label: before the bar.
        lines: things that are counted, "points", in lines where there is no terminal; no lines if
            empty.
    """
    from rich import progress as bars

    console = _console()
    terminal = console.is_terminal
    log = ProgressLines(lines)
    with bars.Progress(
        bars.TextColumn("{task.description}"),
        bars.BarColumn(),
        bars.TextColumn("{task.fields[told]}"),
        bars.TimeRemainingColumn(),
        bars.TextColumn("left"),
        console=console,
        transient=True,
        disable=not terminal,
    ) as bar:
        task = bar.add_task(label, total=None, told="")

        def update(
            done: int, total: int, *, label: str = "", told: str = "", failed: int = 0
        ) -> None:
            if lines and not terminal:
                log(done, total, f", {failed} failed" if failed else "")
            told = told or f"{done / max(total, 1):4.0%}"
            if failed:
                told += f", {failed} failed"
            bar.update(task, completed=done, total=total, description=label or None, told=told)

        yield update


class ProgressLines:
    """Writes how much is done and the time left to standard error, a line a tenth or a minute."""

    def __init__(self, what: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Of so many things, "points"; by a clock [s]."""
        self._what, self._clock = what, clock
        self._told, self._at = (0, 0), clock()
        self._begun: tuple[int, int, float] | None = None  # done before, of so many, and when

    def __call__(self, done: int, total: int, more: str = "") -> None:
        """Note how much is done; what there is more to say follows the numbers.

        The time left is as if the rest took as long a piece as what was done since the first call
        of so many.
        """
        if self._begun is None or self._begun[1] != total or done < self._begun[0]:
            self._begun = done, total, self._clock()
        if done <= 0 or total <= 0 or (done, total) == self._told:
            return
        another_tenth = total != self._told[1] or (
            done * TENTHS // total > self._told[0] * TENTHS // total
        )
        if another_tenth or self._clock() - self._at >= PAUSE:
            typer.echo(f"{done} of {total} {self._what}{more}{self._left(done, total)}", err=True)
            self._told, self._at = (done, total), self._clock()

    def _left(self, done: int, total: int) -> str:
        """The time left in words; nothing where it can't be told, or nothing is left."""
        before, _, began = self._begun or (done, total, 0.0)
        if not before < done < total:
            return ""
        left = round((self._clock() - began) / (done - before) * (total - done))
        minutes, seconds = divmod(left, 60)
        hours, minutes = divmod(minutes, 60)
        if hours:
            return f", {hours} h {minutes} min left"
        return f", {minutes} min {seconds} s left" if minutes else f", {seconds} s left"

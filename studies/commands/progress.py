"""Progress on standard error: a bar on a terminal, or in a log a line after each tenth of the
work."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from functools import cache
from typing import TYPE_CHECKING, Protocol

import typer

if TYPE_CHECKING:
    from rich.console import Console

LINES = 10
"""Number of lines in a log for a complete job."""

RATE_PERIOD = 3600.0
"""Time over which the rate of progress is averaged [s]."""


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
    """Return the console of standard error, shared by all bars, which appear below each other."""
    from rich.console import Console

    return Console(stderr=True)


@contextmanager
def reduction_bar() -> Iterator[None]:
    """Show a bar while a large superelement is reduced."""
    from bladewhirl.models.superelements.solver import reduction_progress

    with progress_bar("reducing the superelement") as update, reduction_progress(update):
        yield


@contextmanager
def progress_bar(label: str, *, lines: str = "") -> Iterator[Update]:
    """Show a bar that disappears at the end of the job.

    Args:
        label: text before the bar.
        lines: noun of the counted items, such as "points", in the lines that are written if there
            is no terminal; if empty, no lines are written.
    """
    from rich import progress as bars

    console = _console()
    terminal = console.is_terminal
    last = (0, -1)  # total, tenth
    with bars.Progress(
        bars.TextColumn("{task.description}"),
        bars.BarColumn(),
        bars.TextColumn("{task.fields[text]}"),
        bars.TimeRemainingColumn(),
        bars.TextColumn("left"),
        console=console,
        transient=True,
        disable=not terminal,
        speed_estimate_period=RATE_PERIOD,
    ) as bar:
        task = bar.add_task(label, total=None, text="")

        def update(
            done: int, total: int, *, label: str = "", text: str = "", failed: int = 0
        ) -> None:
            nonlocal last
            failures = f", {failed} failed" if failed else ""
            text = (text or f"{done / max(total, 1):4.0%}") + failures
            bar.update(task, completed=done, total=total, description=label or None, text=text)
            tenth = (total, LINES * done // max(total, 1))
            if lines and not terminal and done and tenth != last:
                last, left = tenth, bar.tasks[0].time_remaining
                remaining = f", {timedelta(seconds=round(left))} left" if left else ""
                typer.echo(f"{done} of {total} {lines}{failures}{remaining}", err=True)

        yield update

"""The terminal: documents and tables, progress, errors and exit codes.

Progress is on standard error: a bar on a terminal, or in a log a line after each tenth of the work.
"""

from __future__ import annotations

import errno
import io
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from datetime import timedelta
from functools import cache
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, NoReturn, Protocol

import typer
from typer.core import TyperGroup

from bladewhirl.models.inputs.errors import Hint, UserError
from bladewhirl.models.inputs.progress import listening

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress
    from rich.table import Table

LINES = 10  #: number of lines in a log for a complete job

QUIET = 2.0  #: time in which each analysis before a march writes no lines of progress [s]

WORKING = "working"  #: activity of a command that reports no other one

RATE_PERIOD = 3600.0  #: time over which the rate of progress is averaged [s]

ALL_FAILED = 1  #: exit code of a sweep without a finished point

USER_ERROR = 2
"""Exit code of errors that the user can correct; click uses the same code for wrong options."""

INTERRUPTED = 130  #: exit code after Ctrl-C, as in shells


def emit(
    document: Any, *parts: Table | str, json: bool, written: Sequence[Path | None] = ()
) -> None:
    """Print one JSON document, or tables and lines; then the names of written files.

    Args:
        document: document printed with --json; NaN is null.
        parts: tables and lines printed without --json.
        json: whether --json is set.
        written: written files and folders, or None; with --json the names are printed on standard
            error.
    """
    from rich.console import Console

    from bladewhirl.files import json_text

    if json:
        typer.echo(json_text(document), nl=False)
        parts = ()
    for part in parts:
        if isinstance(part, str):
            typer.echo(part)
        else:
            Console().print(part, crop=False)
    name_written(written, json=json)


def name_written(written: Sequence[Path | None], *, json: bool) -> None:
    """Print the names of written files and folders, with --json on standard error."""
    for path in written:
        if path is not None:
            typer.echo(f"Wrote {path}.", err=json)


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


_bar: ContextVar[_Bar | None] = ContextVar("bar", default=None)
"""Bar that is shown; a terminal shows one at a time."""


@contextmanager
def progress_bar(label: str, *, lines: str = "", quiet: float = 0.0) -> Iterator[Update]:
    """Show a bar until the end of a job, also with the progress of computations inside it that
    report some; inside another one the same bar shows this job for its time.

    Args:
        label: text before the bar until there is progress.
        lines: noun of the counted items, such as "points", in the lines that are written if there
            is no terminal; if empty, no lines are written.
        quiet: time at the beginning of each job in which no lines are written [s].
    """
    with ExitStack() as stack:
        outer = _bar.get()
        bar = outer or stack.enter_context(_opened())
        before = bar.label
        token = _bar.set(bar)
        stack.callback(_bar.reset, token)
        logs = dict[str, _Log]()

        def update(
            done: int, total: int, *, label: str = "", text: str = "", failed: int = 0
        ) -> None:
            failures = f", {failed} failed" if failed else ""
            bar.show(label or bar.label, done, total, text + failures)
            if lines and bar.shown is None:
                logs.setdefault(lines, _Log(lines, quiet)).write(done, total, failures)

        def heard(activity: str, done: int, total: int, noun: str) -> None:
            bar.show(*((label,) if 0 < total <= done else (activity, done, total)))
            if noun and bar.shown is None:
                logs.setdefault(noun, _Log(noun, QUIET)).write(done, total)

        stack.enter_context(listening(heard))
        bar.show(label)
        yield update
        bar.show(before)


class _Log:
    """Lines of progress of one kind of items, one after each tenth of the work."""

    def __init__(self, noun: str, quiet: float) -> None:
        self.noun, self.quiet = noun, quiet
        self.start, self.first, self.done = monotonic(), 0, 0
        self.last = 0, -1  #: number of all items, and of tenths, of the last line

    def write(self, done: int, total: int, failures: str = "") -> None:
        """Write a line if another tenth is finished and lines have begun."""
        now = monotonic()
        if total != self.last[0] or done < self.done:  # another job
            self.start, self.first, self.last = now, done, (total, -1)
        self.done = done
        tenth = total, LINES * done // max(total, 1)
        if tenth == self.last or now < self.start + self.quiet:
            return
        self.last = tenth
        each = (now - self.start) / max(done - self.first, 1)
        left = round(each * (total - done))
        remaining = f", {timedelta(seconds=left)} left" if left else ""
        typer.echo(f"{done} of {total} {self.noun}{failures}{remaining}", err=True)


class _Bar:
    """The bar of a terminal; nothing is shown where there is none."""

    def __init__(self, shown: Progress | None) -> None:
        self.shown = shown
        self.label = ""
        self.total = 0
        self._task = None if shown is None else shown.add_task("", total=None, text="", left="")

    def show(self, label: str, done: int = 0, total: int = 0, text: str = "") -> None:
        """Show an activity with its finished items, and with an estimate of the time that is left
        if the number of all items is known and some are not finished."""
        total = total if done < total else 0
        other = (label, total) != (self.label, self.total)
        self.label, self.total = label, total
        if self.shown is None or self._task is None:
            return
        if other:  # the rate is that of this activity
            self.shown.reset(self._task, total=total or None, completed=done)
        share = f"{done / total:4.0%}" if total else ""
        self.shown.update(
            self._task,
            completed=done,
            description=label,
            text=text or share,
            left="left" * bool(total),
        )


@contextmanager
def _opened() -> Iterator[_Bar]:
    """Show a bar on standard error, if it is a terminal."""
    if not sys.stderr.isatty():
        yield _Bar(None)
        return
    from rich import progress as bars

    with bars.Progress(
        bars.TextColumn("{task.description}"),
        bars.BarColumn(),
        bars.TextColumn("{task.fields[text]}"),
        bars.TimeElapsedColumn(),
        bars.TimeRemainingColumn(),
        bars.TextColumn("{task.fields[left]}"),
        console=_console(),
        transient=True,
        redirect_stdout=sys.stdout.isatty(),
        speed_estimate_period=RATE_PERIOD,
    ) as shown:
        yield _Bar(shown)


@contextmanager
def hints_at_once() -> Iterator[set[str]]:
    """Print hints about a case as soon as they are known; yields those that were printed."""
    shown = set[str]()
    with warnings.catch_warnings():
        usual = warnings.showwarning

        def show(message: Any, category: type[Warning], *place: Any) -> None:
            if not issubclass(category, Hint):
                usual(message, category, *place)
            elif (text := str(message)) not in shown:
                shown.add(text)
                typer.echo(f"Hint: {text}.", err=True)

        warnings.simplefilter("always", Hint)
        printed: Any = show  # without the type of the last arguments
        warnings.showwarning = printed
        yield shown


class UserErrorGroup(TyperGroup):
    """Group of commands that show their progress from the start, and print a `UserError` on
    standard error, without a traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            with progress_bar(WORKING):
                return super().invoke(ctx)
        except UserError as error:
            for line in error.lines:
                typer.echo(line, err=True)
            raise typer.Exit(USER_ERROR) from None


@contextmanager
def robust_output() -> Iterator[None]:
    """Replace characters that the output cannot encode; report I/O errors on one line."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        yield
    except OSError as error:  # from any file or stream
        _leave(error)
    finally:
        try:
            sys.stdout.flush()
        except OSError as error:
            _leave(error)


def _leave(error: OSError) -> NoReturn:
    """Print the error of the system and exit; the remaining standard output is dropped."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if error.errno != errno.EPIPE:
        place = error.filename or "standard output"
        sys.stderr.write(f"{place}: cannot be used ({error.strerror or error})\n")
    raise SystemExit(USER_ERROR) from None


@contextmanager
def interruptible(remedy: str, place: Path | None, *, new: bool = False) -> Iterator[None]:
    """On Ctrl-C, print one line that says how to continue if the place exists, and exit; `new`:
    only if it was written since, so that it is not what an earlier command left there."""
    before = _written(place) if new else None
    try:
        yield
    except KeyboardInterrupt:
        begun = _written(place) not in (None, before)
        typer.echo(f"interrupted; {remedy if begun else 'nothing is written'}", err=True)
        raise typer.Exit(INTERRUPTED) from None


def _written(place: Path | None) -> int | None:
    """Return when a file or folder was written last [ns]; None if it does not exist."""
    return place.stat().st_mtime_ns if place is not None and place.exists() else None

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
from datetime import timedelta
from functools import cache
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, NoReturn, Protocol

import typer
from typer.core import TyperGroup

from bladewhirl.models.inputs.errors import Hint, UserError

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

LINES = 10  #: number of lines in a log for a complete job

QUIET = 2.0  #: time in which analyses before a march write no lines of progress [s]

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


@contextmanager
def reduction_bar() -> Iterator[None]:
    """Show a bar while a large superelement is reduced; the bar begins with the first progress."""
    from bladewhirl.models.superelements.solver import reduction_progress

    with ExitStack() as stack:
        label, noun = "reducing the superelement", "solutions of the reduction"
        bar = cache(lambda: stack.enter_context(progress_bar(label, lines=noun, quiet=QUIET)))
        stack.enter_context(reduction_progress(lambda done, total: bar()(done, total)))
        yield


@contextmanager
def progress_bar(label: str, *, lines: str = "", quiet: float = 0.0) -> Iterator[Update]:
    """Show a bar that disappears at the end of the job.

    Args:
        label: text before the bar.
        lines: noun of the counted items, such as "points", in the lines that are written if there
            is no terminal; if empty, no lines are written.
        quiet: time at the beginning in which no lines are written [s].
    """
    from rich import progress as bars

    console = _console()
    terminal = console.is_terminal
    last, start = (0, -1), monotonic()  # total, tenth
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
            late = monotonic() - start >= quiet
            if lines and not terminal and done and tenth != last and late:
                last, left = tenth, bar.tasks[0].time_remaining
                remaining = f", {timedelta(seconds=round(left))} left" if left else ""
                typer.echo(f"{done} of {total} {lines}{failures}{remaining}", err=True)

        yield update


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
    """Group of commands that print a `UserError` on standard error, without a traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
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
def interruptible(remedy: str, folder: Path | None) -> Iterator[None]:
    """On Ctrl-C, print one line that says how to continue if the folder exists, and exit."""
    try:
        yield
    except KeyboardInterrupt:
        begun = folder is not None and folder.exists()
        typer.echo(f"interrupted; {remedy if begun else 'nothing is written'}", err=True)
        raise typer.Exit(INTERRUPTED) from None

"""Exit codes, one-line errors, and interruption by Ctrl-C."""

import errno
import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from bladewhirl.models.inputs.errors import UserError

ALL_FAILED = 1
"""Exit code of a sweep without a finished point."""

USER_ERROR = 2
"""Exit code of errors that the user can correct; click uses the same code for wrong options."""

INTERRUPTED = 130
"""Exit code after Ctrl-C, as in shells."""


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
def interruptible(remedy: str) -> Iterator[None]:
    """On Ctrl-C, print one line that tells how to continue, and exit."""
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(f"interrupted; {remedy}", err=True)
        raise typer.Exit(INTERRUPTED) from None

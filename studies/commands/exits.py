"""How commands end: exit codes, one line a fault of the user's, what to do after Ctrl-C."""

from __future__ import annotations

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
"""A sweep without a single point done."""

USER_ERROR = 2
"""The user can put it right; click uses the same for wrong options."""

INTERRUPTED = 130
"""Ctrl-C, as shells have it."""


class UserErrorGroup(TyperGroup):
    """Commands whose `UserError`s end in their lines on standard error, with no traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except UserError as error:
            for line in error.lines:
                typer.echo(line, err=True)
            raise typer.Exit(USER_ERROR) from None


@contextmanager
def whole_output() -> Iterator[None]:
    """Standard output of any encoding; what it does not take in the end is an error in one line."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        yield
    except OSError as error:  # what the system refuses, of files too
        _leave(error)
    finally:
        try:
            sys.stdout.flush()
        except OSError as error:
            _leave(error)


def _leave(error: OSError) -> NoReturn:
    """Say what the system refused, and end; what standard output still holds is dropped."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if error.errno != errno.EPIPE:
        place = error.filename or "standard output"
        sys.stderr.write(f"{place}: cannot be used ({error.strerror or error})\n")
    raise SystemExit(USER_ERROR) from None


@contextmanager
def interruptible(how_to_go_on: str) -> Iterator[None]:
    """Say after Ctrl-C how to go on, in one line."""
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(f"interrupted; {how_to_go_on}", err=True)
        raise typer.Exit(INTERRUPTED) from None

"""Progress where there is no terminal for a bar: a line now and then, for logs."""

from __future__ import annotations

import time
from collections.abc import Callable

import typer

TENTHS = 10
"""Lines that a short job has: one each time another tenth is done."""

PAUSE = 60.0
"""Longest silence while something is being done [s]."""


class ProgressLines:
    """Writes how much is done to standard error, a line a tenth or a minute."""

    def __init__(self, what: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Of so many things, "points"; by a clock [s]."""
        self._what, self._clock = what, clock
        self._told, self._at = (0, 0), clock()

    def __call__(self, done: int, total: int, more: str = "") -> None:
        """Note how much is done; what there is more to say follows the numbers."""
        if done <= 0 or total <= 0 or (done, total) == self._told:
            return
        another_tenth = total != self._told[1] or (
            done * TENTHS // total > self._told[0] * TENTHS // total
        )
        if another_tenth or self._clock() - self._at >= PAUSE:
            typer.echo(f"{done} of {total} {self._what}{more}", err=True)
            self._told, self._at = (done, total), self._clock()

"""Times on the command line."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial


def parse_time(option: str, text: str | None) -> float | None:
    """A time [s] from a number of seconds or text with a unit; None where none was given.

    Args:
        option: what errors call it, "--from".
        text: "0.25" or "0.8 ms".

    Raises:
        UserError: anything else.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.models.inputs.units import to_si

    if text is None:
        return None
    for seconds in (float, partial(to_si, unit="s")):
        with suppress(ValueError):
            time = seconds(text)
            if math.isfinite(time):
                return time
    raise UserError(f'{option} {text}: expected a time in seconds, or with a unit such as "0.8 ms"')


@contextmanager
def options_of_window() -> Iterator[None]:
    """Name --from and --to in faults of the window that they span.

    Raises:
        UserError: the view's, with the options before it where its window is to blame.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.postprocess.fields.fields import ViewError

    try:
        yield
    except ViewError as error:
        if not str(error).startswith("window "):
            raise
        raise UserError(f"--from, --to: {error}") from None

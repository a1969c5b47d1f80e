"""Options that several commands share, and the numbers, ranges and times that they take."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.models.inputs.errors import UserError, writing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

CaseFile = Annotated[Path, typer.Argument(help="Case file.", show_default=False)]
RunFolder = Annotated[
    Path, typer.Argument(metavar="DIR", help="Folder of a run, or its result.nc.")
]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change the case: march.speed=1.2."),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Write into a folder that exists.")]
Replace = Annotated[
    bool, typer.Option("--overwrite", help="Replace what is there, also if it is not bladewhirl's.")
]
Force = Annotated[bool, typer.Option("--force", "--overwrite", help="Overwrite an existing file.")]
Start = Annotated[
    str | None,
    typer.Option("--from", help='Start of the window: seconds, or "0.8 ms"; of the run if none.'),
]
End = Annotated[str | None, typer.Option("--to", help="End of the window.")]
Rotating = Annotated[
    bool, typer.Option("--rotating", help="Show the series as seen from the rotor.")
]
Workers = Annotated[int | None, typer.Option(help="Local processes; one a core if none.", min=1)]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="An existing dask scheduler, tls://host:8786."),
]

MOST_POINTS = 100_000
"""Longest range: a chart of that many columns is a slip of the pen."""


def claim_output(target: Path, *, named: bool, overwrite: bool) -> None:
    """See that a file may be written, before anything is drawn.

    Args:
        target: the file.
        named: by the user; else it goes into a folder of the program's and is listed there.
        overwrite: replace it, whosever it is.

    Raises:
        UserError: it is there, and no manifest lists it.
    """
    from bladewhirl.meshes.files.manifest import claim, claim_file

    with writing(target):
        if named:
            claim_file(target, overwrite=overwrite)
        else:
            claim(target.parent, [target.name], overwrite=overwrite)


def print_json(document: Any) -> None:
    """Print one JSON document; a number that JSON does not have is a mistake of ours."""
    import json

    typer.echo(json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False))


def refuse_both(scheduler: str | None, workers: int | None) -> None:
    """See that not both a scheduler and a number of local workers are named.

    Raises:
        UserError: they are.
    """
    if scheduler is not None and workers is not None:
        raise UserError("--scheduler, --workers: expected one of them; a scheduler has its workers")


def parse_range(option: str, text: str, unit: str) -> NDArray[np.float64]:
    """Evenly spaced values from "START:STOP:COUNT", ends included, (COUNT,).

    Args:
        option: what errors call it, "--kappas".
        text: with colons between; START >= 0, STOP > START, COUNT >= 2.
        unit: SI unit of a plain number, which text with another is converted to.

    Raises:
        UserError: anything else.
    """
    import numpy as np

    ends, count = _counted(option, text)
    start, stop = _ends(option, text, ends, _in_unit(unit), f"{RANGE}, [{unit}] or with a unit")
    return np.linspace(start, stop, count)


def parse_interval(option: str, text: str, unit: str) -> tuple[float, float]:
    """Ends of an interval from "START:STOP", as of `parse_range`.

    Raises:
        UserError: anything else.
    """
    return _ends(option, text, text, _in_unit(unit), f"{INTERVAL}, [{unit}] or with a unit")


def parse_speed_interval(option: str, text: str) -> Callable[[float], tuple[float, float]]:
    """Ends of an interval of speeds, multiples of the reference frequency, once that is known.

    Args:
        option: what errors call it, "--speeds".
        text: "START:STOP", each a multiple or text such as "2500 rpm", "40 Hz", "250 rad/s".

    Returns:
        of a reference frequency [rad/s]: the ends.

    Raises:
        UserError: anything else; ends of different kinds are put in order when that is called.
    """
    return _speeds(option, text, text, INTERVAL)


def parse_speed_range(option: str, text: str) -> Callable[[float], NDArray[np.float64]]:
    """Evenly spaced speeds from "START:STOP:COUNT", as of `parse_speed_interval`."""
    import numpy as np

    ends, count = _counted(option, text)
    known = _speeds(option, text, ends, RANGE)
    return lambda reference: np.linspace(*known(reference), count)


INTERVAL = "START:STOP, two numbers"
RANGE = "START:STOP:COUNT, two numbers and a whole number"


def _counted(option: str, text: str) -> tuple[str, int]:
    """The ends of a range, and its count."""
    ends, _, last = text.rpartition(":")
    try:
        count = int(last)
    except ValueError:
        raise UserError(f"{option} {text}: expected {RANGE}") from None
    if not 2 <= count <= MOST_POINTS:
        raise UserError(f"{option} {text}: expected a COUNT from 2 to {MOST_POINTS}")
    return ends, count


def _in_unit(unit: str) -> Callable[[str], float]:
    """Reader of a number, or of text with a unit."""
    from bladewhirl.models.inputs.units import to_si

    def read(part: str) -> float:
        try:
            return float(part)
        except ValueError:
            return to_si(part, unit)

    return read


def _speeds(
    option: str, text: str, ends: str, wanted: str
) -> Callable[[float], tuple[float, float]]:
    from bladewhirl.models.inputs.units import Speed

    def speed(part: str) -> Speed:
        try:
            given: float | str = float(part)
        except ValueError:
            given = part.strip()
        return Speed(given)

    said = f'{wanted}, or speeds such as "2500 rpm"'
    try:
        start, stop = (speed(part) for part in ends.split(":"))
    except ValueError:
        raise UserError(f"{option} {text}: expected {said}") from None
    if start.kind == stop.kind:
        _in_order(option, text, start.value, stop.value)

    def multiples(reference: float) -> tuple[float, float]:
        first, last = (each.multiple(reference) for each in (start, stop))
        return _in_order(option, text, first, last)

    return multiples


def _ends(
    option: str, text: str, ends: str, read: Callable[[str], float], wanted: str
) -> tuple[float, float]:
    try:
        start, stop = (read(part) for part in ends.split(":"))
    except ValueError:
        raise UserError(f"{option} {text}: expected {wanted}") from None
    if not (math.isfinite(start) and math.isfinite(stop)):
        raise UserError(f"{option} {text}: expected {wanted.partition(',')[0]} with finite numbers")
    return _in_order(option, text, start, stop)


def _in_order(option: str, text: str, start: float, stop: float) -> tuple[float, float]:
    if start < 0.0:
        raise UserError(f"{option} {text}: expected a START of zero or more")
    if stop <= start:
        raise UserError(f"{option} {text}: expected a STOP above the START of {start:g}")
    return start, stop


def not_negative(option: str, value: float) -> None:
    """Refuse a negative or non-finite number.

    Raises:
        UserError: naming the option and the value.
    """
    if not (math.isfinite(value) and value >= 0.0):
        raise UserError(f"{option} {value:g}: expected a number of zero or more")


def parse_time(option: str, text: str | None) -> float | None:
    """A time [s] from a number of seconds or text with a unit; None where none was given.

    Args:
        option: what errors call it, "--from".
        text: "0.25" or "0.8 ms".

    Raises:
        UserError: anything else.
    """
    from bladewhirl.models.inputs.units import to_si

    if text is None:
        return None
    for seconds in (float, partial(to_si, unit="s")):
        with suppress(ValueError):
            time = seconds(text)
            if math.isfinite(time):
                return time
    raise UserError(f'{option} {text}: expected a time in seconds, or with a unit such as "0.8 ms"')


def parse_window(start: str | None, end: str | None) -> tuple[float | None, float | None]:
    """Ends [s] of the window of --from and --to; None where none was given."""
    return parse_time("--from", start), parse_time("--to", end)


@contextmanager
def options_of_window() -> Iterator[None]:
    """Name --from and --to in faults of the window that they span.

    Raises:
        UserError: the view's, with the options before it where its window is to blame.
    """
    from bladewhirl.postprocess.fields.kinematics import ViewError

    try:
        yield
    except ViewError as error:
        if not str(error).startswith("window "):
            raise
        raise UserError(f"--from, --to: {error}") from None

"""Shared options of the commands, and parsers of their values."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.models.inputs.errors import UserError, writing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from bladewhirl.models.inputs.units import Speed

MOST_POINTS = 100_000
"""Largest COUNT of a range; larger ones are typing errors."""


def parse_number(text: str, unit: str) -> float:
    """Convert a number in SI units, or text with a unit, to an SI value.

    Raises:
        ValueError: neither, or not finite.
    """
    from bladewhirl.models.inputs.units import finite, to_si

    try:
        return finite(text)  # type: ignore[arg-type]  # float() reads text
    except ValueError:
        return to_si(text, unit)


def parse_time(option: str, text: str) -> float:
    """Convert the text of an option, "0.25" or "0.8 ms", to a time [s]."""
    try:
        return parse_number(text, "s")
    except ValueError:
        expected = 'a time in seconds, or with a unit such as "0.8 ms"'
        raise UserError(f"{option} {text}: expected {expected}") from None


def parse_stiffness(option: str, text: str) -> float:
    """Convert the text of an option to a stiffness of zero or more [N/m]."""
    with suppress(ValueError):
        value = parse_number(text, "N/m")
        if value >= 0.0:
            return value
    raise UserError(f"{option} {text}: expected a number of zero or more, in N/m or with a unit")


def parse_speed(option: str, text: str) -> Speed:
    """Convert the text of an option to a speed, with a unit or relative to the reference."""
    try:
        return _speed(text)
    except ValueError as error:
        expected = "multiples of the reference frequency, or text in rpm, Hz or rad/s"
        raise UserError(f"{option} {text}: expected {expected} ({error})") from None


def _speed(text: str) -> Speed:
    from bladewhirl.models.inputs.units import Speed

    try:
        number = float(text)
    except ValueError:
        return Speed(text.strip())
    return Speed(number)


@dataclass(frozen=True)
class Span:
    """Evenly spaced values of an option "START:STOP" or "START:STOP:COUNT"."""

    source: str  #: option and text, for errors
    start: Speed | float
    stop: Speed | float
    count: int = 2

    def values(self, reference: float = 1.0) -> NDArray[np.float64]:
        """Return the values, ends included, (COUNT,); speeds are relative to a reference [rad/s].

        Raises:
            UserError: the ends are not in order.
        """
        import numpy as np

        start, stop = (
            end if isinstance(end, float) else end.multiple(reference)
            for end in (self.start, self.stop)
        )
        if not 0.0 <= start < stop:
            raise UserError(f"{self.source}: expected a START of zero or more and a STOP above it")
        return np.linspace(start, stop, self.count)


def parse_span(option: str, text: str, *, unit: str = "", counted: bool = False) -> Span:
    """Convert the text of an option to a `Span`.

    Args:
        option: its name, for errors.
        text: "START:STOP", each an SI value or text with a unit.
        unit: SI unit of the ends; speeds if empty.
        counted: expect "START:STOP:COUNT".

    Raises:
        UserError: another form.
    """
    ends, _, last = text.rpartition(":") if counted else (text, "", "2")
    read: Callable[[str], Speed | float] = partial(parse_number, unit=unit) if unit else _speed
    try:
        start, stop = map(read, ends.split(":"))
        count = int(last)
    except ValueError:
        form = "START:STOP" + (":COUNT" if counted else "")
        units = f"numbers [{unit}] or with a unit" if unit else 'numbers or such as "2500 rpm"'
        raise UserError(f"{option} {text}: expected {form}, ends {units}") from None
    if not 2 <= count <= MOST_POINTS:
        raise UserError(f"{option} {text}: expected a COUNT from 2 to {MOST_POINTS}")
    return Span(f"{option} {text}", start, stop, count)


def parse_several(option: str, text: str, *, read: Callable[[str], Any], name: str) -> list[Any]:
    """Convert two or more different positive values, separated by commas; ascending.

    Args:
        option: its name, for errors.
        text: of the option.
        read: converts one value, or raises a ValueError.
        name: of the values, for errors.

    Raises:
        UserError: fewer than two, or another value.
    """
    try:
        values = sorted({read(word.strip()) for word in text.split(",")})
    except ValueError:
        values = []
    if len(values) < 2 or values[0] <= 0:
        raise UserError(f"{option} {text}: expected two or more different {name} above zero")
    return values


def output_option(help_text: str, metavar: str | None = None) -> Any:
    """Return the typer option of the file or folder to write."""
    return typer.Option("--output", "-o", metavar=metavar, help=help_text)


def span_option(name: str, help_text: str, *, unit: str = "", counted: bool = False) -> Any:
    """Return the typer option of a `Span`; its default is text, which is parsed, too."""
    parser = partial(parse_span, name, unit=unit, counted=counted)
    form = "START:STOP:COUNT" if counted else "START:STOP"
    return typer.Option(name, parser=parser, metavar=form, help=help_text)


CaseFolder = Annotated[
    Path | None, output_option("Folder to make; CASE-COMMAND by default, for a chart or figures.")
]
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
    float | None,
    typer.Option(
        "--from",
        parser=partial(parse_time, "--from"),
        metavar="TIME",
        help='Start of the window: seconds, or "0.8 ms"; of the run if none.',
    ),
]
End = Annotated[
    float | None,
    typer.Option(
        "--to", parser=partial(parse_time, "--to"), metavar="TIME", help="End of the window."
    ),
]
Rotating = Annotated[
    bool, typer.Option("--rotating", help="Show the series as seen from the rotor.")
]
Workers = Annotated[int | None, typer.Option(help="Local processes; one a core if none.", min=1)]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="An existing dask scheduler, tls://host:8786."),
]


def claim_output(target: Path, *, named: bool, overwrite: bool) -> None:
    """Check that a file may be written, before anything is drawn.

    Args:
        target: the file.
        named: named by the user; otherwise it belongs to a folder of the program and its manifest.
        overwrite: replace an existing file, whoever wrote it.

    Raises:
        UserError: it exists, and no manifest lists it.
    """
    from bladewhirl.files import claim, claim_file

    with writing(target):
        if named:
            claim_file(target, overwrite=overwrite)
        else:
            claim(target.parent, [target.name], overwrite=overwrite)


def refuse_both(scheduler: str | None, workers: int | None) -> None:
    """Refuse a scheduler together with a number of local workers."""
    if scheduler is not None and workers is not None:
        raise UserError("--scheduler, --workers: expected one of them; a scheduler has its workers")


@contextmanager
def options_of_window() -> Iterator[None]:
    """Name --from and --to in errors of the window that they span.

    Raises:
        UserError: the error of the view, after the options if its window is to blame.
    """
    from bladewhirl.postprocess.fields.kinematics import ViewError

    try:
        yield
    except ViewError as error:
        if not str(error).startswith("window "):
            raise
        raise UserError(f"--from, --to: {error}") from None

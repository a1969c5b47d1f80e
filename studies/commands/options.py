"""Options that several commands have, and parsers of their values."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bladewhirl.models.inputs.errors import UserError, writing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from bladewhirl.models.case.case import Case
    from bladewhirl.models.inputs.units import Speed

MOST_POINTS = 100_000
"""Largest number of values of a range; a larger number is taken as a typing error."""


def option(
    name: str, metavar: str, read: Callable[[str], Any], expected: str, help_text: str | None = None
) -> Any:
    """Return a typer option whose text is converted by the function `read`.

    If this function raises a ValueError, the error message contains the name of the option and a
    description of the expected values. The metavar is the name of the value in the help text.
    """

    def parse(text: str) -> Any:
        try:
            return read(text)
        except ValueError:
            raise UserError(f"{name} {text}: expected {expected}") from None

    return typer.Option(name, parser=parse, metavar=metavar, help=help_text)


def in_si(unit: str, least: float = float("-inf")) -> Callable[[str], float]:
    """Return a function that converts a number in an SI unit, or text with a unit, to a float."""

    def read(text: str) -> float:
        from bladewhirl.models.inputs.units import finite, to_si

        try:
            value = finite(text)  # type: ignore[arg-type]  # float() reads text
        except ValueError:
            value = to_si(text, unit)
        if value < least:
            raise ValueError
        return value

    return read


def time(name: str, help_text: str | None = None) -> Any:
    """Return the typer option of a time [s]."""
    expected = 'a time in seconds, or with a unit such as "0.8 ms"'
    return option(name, "TIME", in_si("s"), expected, help_text)


def stiffness(name: str) -> Any:
    """Return the typer option of a stiffness [N/m]."""
    expected = "a number of zero or more, in N/m or with a unit"
    return option(name, "STIFFNESS", in_si("N/m", 0.0), expected)


def speed(name: str) -> Any:
    """Return the typer option of a speed, with a unit or relative to the reference frequency."""
    expected = "multiples of the reference frequency, or text in rpm, Hz or rad/s"
    return option(name, "SPEED", _speed, expected)


def speeds(name: str) -> Any:
    """Return the typer option of one or more speeds, see `speed`, separated by commas, or of a
    range."""
    expected = (
        'multiples of the reference frequency, or text such as "5000 rpm,5200 rpm" or'
        ' "5000 rpm:6000 rpm:50 rpm"'
    )

    def read(text: str) -> list[Speed]:
        if ":" in text:
            return [*steps(name, text).given]  # type: ignore[list-item]  # not numbers in SI units
        return [_speed(word) for word in text.split(",")]

    return option(name, "SPEED,...", read, expected)


def several(name: str, metavar: str, read: Callable[[str], Any], noun: str) -> Any:
    """Return the typer option of two or more different positive values, separated by commas; the
    parser sorts them."""

    def read_all(text: str) -> list[Any]:
        values = sorted({read(word.strip()) for word in text.split(",")})
        if len(values) < 2 or values[0] <= 0:
            raise ValueError
        return values

    return option(name, metavar, read_all, f"two or more different {noun} above zero")


def _speed(text: str) -> Speed:
    from bladewhirl.models.inputs.units import Speed

    try:
        number = float(text)
    except ValueError:
        return Speed(text.strip())
    return Speed(number)


@dataclass(frozen=True)
class Span:
    """Ascending values, given by an option as "START:STOP", or as "START:STOP:STEP" or
    "VALUE,VALUE" as in `bladewhirl sweep --over`."""

    source: str  #: name and text of the option, for errors
    given: tuple[Speed | float, ...]  #: the ends, or all values

    def values(self, reference: float = 1.0) -> NDArray[np.float64]:
        """Return the two ends, or all values, (values,); speeds are returned as multiples of the
        speed `reference` [rad/s].

        Raises:
            UserError: the values are not in order.
        """
        import numpy as np

        values = np.array(
            [each if isinstance(each, float) else each.multiple(reference) for each in self.given]
        )
        if not (len(values) > 1 and values[0] >= 0.0 and np.all(np.diff(values) > 0.0)):
            raise UserError(f"{self.source}: expected a START of zero or more and a STOP above it")
        return values

    @property
    def speeds(self) -> list[float | str]:
        """All speeds as they are given: multiples of the reference frequency, or text.

        Raises:
            UserError: the speeds are not in order.
        """
        self.values()
        return [each if isinstance(each, float) else each.given for each in self.given]


def span(name: str, *, unit: str = "", stepped: bool = False, help_text: str | None = None) -> Any:
    """Return the typer option of a `Span`; its default is given as text, which typer parses.

    Args:
        name: name of the option.
        unit: SI unit of the ends; if empty, the ends are speeds.
        stepped: whether "START:STOP:STEP" is expected, with the stop included.
        help_text: description, unless each command has its own.
    """
    form = "START:STOP:STEP" if stepped else "START:STOP"
    units = f"numbers in {unit} or have a unit" if unit else 'numbers or text such as "2500 rpm"'
    read_end: Callable[[str], Any] = in_si(unit) if unit else _speed

    def read(text: str) -> Span:
        if stepped:
            return steps(name, text, read_end)
        given = text.split(":")
        if len(given) != 2:
            raise ValueError
        return Span(f"{name} {text}", tuple(map(read_end, given)))

    return option(name, form, read, f"{form}, with ends that are {units}", help_text)


def steps(name: str, text: str, read_end: Callable[[str], Any] | None = None) -> Span:
    """Return the values of "START:STOP:STEP", speeds by default."""
    from bladewhirl.studies.sweeps.axes import parse_values

    given = map(str, parse_values(f"{name} {text}", text, MOST_POINTS))
    return Span(f"{name} {text}", tuple(map(read_end or _speed, given)))


Output = Annotated[Path | None, typer.Option("--output", "-o")]
OutputFolder = Annotated[Path | None, typer.Option("--output", "-o", metavar="DIR")]
OutputFile = Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE")]
CaseFolder = Annotated[
    Path | None, typer.Option("--output", "-o", help="Folder to make; CASE-COMMAND by default.")
]
CaseFile = Annotated[Path, typer.Argument(help="Case file.", show_default=False)]
NewCase = Annotated[
    Path | None, typer.Argument(help="Case file; not with --resume.", show_default=False)
]
Resume = Annotated[Path | None, typer.Option(metavar="DIR")]
RunFolder = Annotated[
    Path, typer.Argument(metavar="DIR", help="Folder of a run, or its result.nc.")
]
Folder = Annotated[Path, typer.Argument(metavar="DIR")]
File = Annotated[Path | None, typer.Option(metavar="FILE")]
Number = Annotated[int, typer.Option(min=1)]
MaybeNumber = Annotated[int | None, typer.Option(min=1)]
Speeds = Annotated[Span, span("--speeds", stepped=True)]
MaybeSpeeds = Annotated[Span | None, span("--speeds", stepped=True)]
Stiffnesses = Annotated[
    Span | None,
    span(
        "--stiffnesses",
        unit="N/m",
        help_text="Stiffness of each shaft spring, N/m or '1 kN/mm:1 MN/mm'; by default a"
        " thousandth to a thousand times that of the case.",
    ),
]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a key: march.speed=1.2."),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Write into an existing folder.")]
Replace = Annotated[
    bool,
    typer.Option(
        "--overwrite", help="Replace existing files, also if bladewhirl did not write them."
    ),
]
Force = Annotated[bool, typer.Option("--force", "--overwrite", help="Overwrite an existing file.")]
Start = Annotated[
    float | None,
    time(
        "--from",
        'Start of the time window in s, or such as "0.8 ms"; by default the start of the run.',
    ),
]
End = Annotated[
    float | None, time("--to", "End of the time window; by default the end of the run.")
]
Rotating = Annotated[
    bool, typer.Option("--rotating", help="Show the series as seen from the rotor.")
]
Workers = Annotated[
    int | None, typer.Option(help="Number of local processes; by default one per core.", min=1)
]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="Address of a running dask scheduler, tls://host:8786."),
]


@contextmanager
def case_of(file: Path, overrides: list[str] | None) -> Iterator[Case]:
    """Yield a case with changes "KEY=VALUE"; errors in the ``with`` block name the file or --set.

    Raises:
        CaseError: all faults of the case.
    """
    from bladewhirl.models.case.file import faults_from, read_case

    case = read_case(file, overrides or [])
    with faults_from(file, overrides or []):
        yield case


def refuse_existing(target: Path | None, *, force: bool) -> None:
    """Raise an error if a file exists that may not be replaced."""
    if target is not None and target.exists() and not force:
        raise UserError(f"{target}: already exists; --force overwrites it")


def claim_output(target: Path, *, named: bool, overwrite: bool) -> None:
    """Check that a file may be written, before its content is computed.

    A file that the user did not name (`named` is false) goes into a folder that bladewhirl writes,
    and is listed in the manifest of this folder. With `overwrite`, an existing file may be replaced
    even if bladewhirl did not write it.

    Raises:
        UserError: the file exists, and no manifest lists it.
    """
    from bladewhirl.files import claim, claim_file

    with writing(target):
        if named:
            claim_file(target, overwrite=overwrite)
        else:
            claim(target.parent, [target.name], overwrite=overwrite)


def refuse_both(scheduler: str | None, workers: int | None) -> None:
    """Raise an error if both a scheduler and a number of local workers are given."""
    if scheduler is not None and workers is not None:
        raise UserError(
            "--workers: not allowed together with --scheduler, which has its own workers"
        )


def only(context: typer.Context, reason: str, *allowed: str) -> None:
    """Check that a command got no arguments and options but the allowed ones, given by the names of
    its parameters, which have a meaning together with the option in `reason`.

    Raises:
        UserError: others are given.
    """
    others = (
        each.opts[-1] if each.param_type_name == "option" else each.opts[-1].upper()
        for each in context.command.params
        if getattr(context.get_parameter_source(each.name or ""), "name", "") == "COMMANDLINE"
        and each.name not in allowed
    )
    omitted(reason, dict.fromkeys(others, True))


def omitted(reason: str, given: Mapping[str, object]) -> None:
    """Check that options that have no meaning together with another one are not given.

    Raises:
        UserError: some are given.
    """
    if names := [name for name, value in given.items() if value is not None]:
        raise UserError(f"{', '.join(names)}: not allowed with {reason}")

"""Errors in user input, reported in one line each, and conversion of values to TOML."""

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path


def toml_value(value: object) -> str:
    """Return a value as TOML, with floats at full precision and tables inline.

    Raises:
        TypeError: the type does not occur in cases.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # Basic strings of TOML and JSON are equal, except that TOML requires DEL to be escaped.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        text = repr(float(value))
        if not math.isfinite(value) or value == 0.0 or 1e-3 <= abs(value) < 1e5:
            return text
        mantissa, _, exponent = f"{Decimal(text).normalize():e}".partition("e")
        return f"{mantissa}e{int(exponent)}"
    if isinstance(value, Mapping):
        pairs = (f"{toml_key(key)} = {toml_value(item)}" for key, item in value.items())
        return f"{{ {', '.join(pairs)} }}" if value else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    raise TypeError(f"no TOML for {type(value).__name__}")


def toml_key(name: object) -> str:
    """Return a key as TOML, in quotes if needed."""
    text = str(name)
    return text if re.fullmatch(r"[A-Za-z0-9_-]+", text) else toml_value(text)


LONGEST_VALUE, LONGEST = 60, 1000
"""Largest numbers of characters of a value in an error message, and of a message."""


def shortened(line: str) -> str:
    """Return a message without its middle if it is long: file and reason are at the ends."""
    half = (LONGEST - 5) // 2
    return line if len(line) <= LONGEST else f"{line[:half]} ... {line[-half:]}"


def demand(text: str) -> str:
    """Return "expected" and the text; only the text if it begins with "not allowed"."""
    return text if text.startswith("not allowed") else f"expected {text}"


class UserError(Exception):
    """A request that cannot be fulfilled; the command line prints `lines` without a traceback."""

    def __str__(self) -> str:
        """Return one line per fault."""
        return "\n".join(self.lines)

    @property
    def lines(self) -> list[str]:
        """Text of each fault on one line; each argument of the exception is a fault."""
        return [shortened(" ".join(str(fault).split())) for fault in self.args]

    @property
    def faults(self) -> "tuple[Fault, ...]":
        """The arguments of the exception; a text is what was expected."""
        return tuple(
            fault if isinstance(fault, Fault) else Fault(expected=str(fault)) for fault in self.args
        )


class Hint(UserWarning):
    """Warning about a valid value that is implausible or could be chosen better."""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One fault of a case, or of a file that it names."""

    file: str = ""  #: path of the case file, or "--set"; empty for a case made in Python
    key: str = ""  #: dotted key as in the file; empty if the entire file is at fault
    value: object = None  #: value of the key as in the file; None if there is no value
    part: str = ""  #: what is at fault in the file that the key names; empty if it is the key
    expected: str  #: text that completes "expected ...", or a complete text, "not allowed ..."

    def __str__(self) -> str:
        """Return the fault on one line."""
        place = self.key if self.value is None else f"{self.key} = {shown(self.value)}"
        parts = (self.file, place, self.part, demand(self.expected))
        return shortened(" ".join(": ".join(part for part in parts if part).splitlines()))


class CaseError(UserError):
    """Error that lists one or more faults of a case."""

    def __init__(self, faults: Iterable[Fault]) -> None:
        super().__init__(tuple(faults))  # so that the error can be pickled

    @property
    def faults(self) -> tuple[Fault, ...]:
        """All faults."""
        return tuple(self.args[0])

    @property
    def lines(self) -> list[str]:
        """Text of each fault on one line."""
        return [str(fault) for fault in self.faults]


@contextmanager
def writing(target: Path) -> Iterator[None]:
    """Turn errors of the operating system while writing into errors for the user.

    Raises:
        UserError: a file or folder cannot be written; the error names its path and the reason.
    """
    try:
        yield
    except OSError as error:
        foreign = isinstance(error, FileExistsError) and Path(error.filename) not in target.parents
        place = error.filename if foreign else target
        raise UserError(f"{place}: cannot be written ({error.strerror or error})") from None


def shown(value: object) -> str:
    """Return a value as TOML, shortened to one line of at most `LONGEST_VALUE` characters."""
    try:
        text = toml_value(value)
    except (TypeError, ValueError):  # a date, or an integer too long to print
        text = "a huge integer" if isinstance(value, int) else str(value)
    except RecursionError:
        text = "deeply nested tables"
    return text if len(text) <= LONGEST_VALUE else f"{text[: LONGEST_VALUE - 3]}..."

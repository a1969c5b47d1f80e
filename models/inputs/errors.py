"""Errors that a user can put right, a line a fault; values in TOML as they show them."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path


def toml_value(value: object) -> str:
    """A value in TOML; floats at full precision, tables inline.

    Raises:
        TypeError: TOML has no such value, or it has and a case has not.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # TOML wants DEL escaped, JSON does not; else their basic strings agree.
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
    """A key, quoted where TOML needs it."""
    text = str(name)
    return text if re.fullmatch(r"[A-Za-z0-9_-]+", text) else toml_value(text)


LONGEST_VALUE = 60
"""Characters of a value that a fault shows."""


class UserError(Exception):
    """A request that cannot be met; the command line prints `lines`, no traceback."""

    def __str__(self) -> str:
        """Return one line per fault."""
        return "\n".join(self.lines)

    @property
    def lines(self) -> list[str]:
        """One line per argument, each a fault."""
        return [" ".join(str(fault).split()) for fault in self.args]


class Hint(UserWarning):
    """A valid but implausible value, or one that could be chosen better."""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One fault of a case."""

    file: str = ""  #: the case file, or "--set"; empty for a case made in Python
    key: str = ""  #: dotted as in the file; empty for the file as a whole
    value: object = None  #: as in the file; None if there is none
    expected: str  #: completes "expected ..."

    def __str__(self) -> str:
        """The fault on one line."""
        place = self.key if self.value is None else f"{self.key} = {shown(self.value)}"
        parts = (self.file, place, f"expected {self.expected}")
        return " ".join(": ".join(part for part in parts if part).splitlines())


class CaseError(UserError):
    """A case with one or more faults."""

    def __init__(self, faults: Iterable[Fault]) -> None:
        self.faults = tuple(faults)
        super().__init__(self.faults)  # so that it can be pickled

    @property
    def lines(self) -> list[str]:
        """One line per fault."""
        return [str(fault) for fault in self.faults]


@contextmanager
def faults_in(file: str) -> Iterator[None]:
    """Name ``file`` in faults raised inside that name none."""
    try:
        yield
    except CaseError as error:
        located = (fault if fault.file else replace(fault, file=file) for fault in error.faults)
        raise CaseError(located) from None


@contextmanager
def writing(target: Path) -> Iterator[None]:
    """Make what the system refuses to write a fault of the user's.

    Raises:
        UserError: naming the file or folder and the reason.
    """
    try:
        yield
    except OSError as error:
        foreign = isinstance(error, FileExistsError) and Path(error.filename) not in target.parents
        place = error.filename if foreign else target
        raise UserError(f"{place}: cannot be written ({error.strerror or error})") from None


def shown(value: object) -> str:
    """A value as TOML would have it, cut to one short line."""
    try:
        text = toml_value(value)
    except (TypeError, ValueError):  # a date, or an integer too long to print
        text = "a huge integer" if isinstance(value, int) else str(value)
    except RecursionError:
        text = "deeply nested tables"
    return text if len(text) <= LONGEST_VALUE else f"{text[: LONGEST_VALUE - 3]}..."

"""Read case files, with other values for some of the keys."""

import os
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from os import PathLike, fspath
from typing import Any, TypeVar

from pydantic import ValidationError

from bladewhirl.files import open_text
from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.case.check import dotted, faults_of
from bladewhirl.models.case.excitation import EXCITATIONS
from bladewhirl.models.inputs.errors import CaseError, Fault, UserError
from bladewhirl.models.inputs.table import Table, path_of, row_of, value_at

MOST_LETTERS = 2**24  #: largest length of a case file [characters]; a longer file cannot be a case

_PART = r"""(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_DEEP_KEY = re.compile(rf"""(?<![\w"'\\-])(?:{_PART}[ \t]*+\.[ \t]*+){{50}}""")
"""Pattern of a dotted key of more than 50 parts; the memory that tomllib needs grows with the
square of the number of parts."""

SET = "--set"  #: text that replaces the name of the file in faults of overridden keys

LOAD_TYPE = re.compile(r"excitation(\.[0-9]+)?\.type")

FILES = (
    *("bladed_disk.mesh", "bladed_disk.superelement", "casing.profile", "casing.coating.profile"),
    "blade_loss.damaged",
)
"""Tables with the path of a file; those of further wheels are rows of shaft_line.wheels."""

EXCLUSIVE = (
    ("shaft.stiffness", "shaft.suspension_frequency"),
    ("march.speed", "march.speed_table", "march.run_up"),
)
"""Keys that exclude each other: setting one of them removes the others."""


def read_case(path: str | PathLike[str], overrides: Iterable[str] = ()) -> Case:
    """Read a case file.

    Args:
        path: path of the case file, which is TOML in UTF-8.
        overrides: values that replace keys, such as "march.speed=1.2", see `loads`.

    Raises:
        CaseError: the file is missing, unreadable or not TOML, or the case is invalid; the error
            lists all faults of the case.
    """
    file = fspath(path)
    try:
        with open_text(file) as stream:
            text = stream.read(MOST_LETTERS + 1)
    except OSError as error:
        expected = f"a readable file ({error.strerror})"
        raise CaseError([Fault(file=file, expected=expected)]) from None
    except ValueError as error:  # not UTF-8, or a null in the path
        raise CaseError([Fault(file=file, expected=f"text in UTF-8 ({error})")]) from None
    return loads(text, file=file, overrides=overrides)


TableT = TypeVar("TableT", bound=Table)


def table_of(text: str, name: str, kind: type[TableT], unread: str = "") -> TableT:
    """Return one table from the text of a case, such as [casing]; the default table if the
    text lacks it.

    Other tables are ignored, so that the files named in them need not exist on this computer. So
    are unknown keys, which results of other versions have.

    Args:
        text: TOML text of the case.
        name: name of the table.
        kind: class of the table.
        unread: a key that is left out, as that of a file which need not exist on this computer.

    Raises:
        CaseError: the text is not TOML, or the table is invalid.
    """
    given = _parsed(text, "case").get(name, {})
    if not isinstance(given, dict):
        raise CaseError([Fault(key=name, expected="a table")])
    known = {field.alias or attribute for attribute, field in kind.model_fields.items()}
    known.discard(unread)
    try:
        return kind(**{key: value for key, value in given.items() if key in known})
    except ValidationError as error:
        raise CaseError(faults_of(error, given, name)) from None


def optional_table_of(text: str, name: str, kind: type[TableT], unread: str = "") -> TableT | None:
    """Return one table from the text of a case, see `table_of`; None if the text lacks it."""
    return table_of(text, name, kind, unread) if name in _parsed(text, "case") else None


def _parsed(text: str, file: str) -> dict[str, Any]:
    """Return the tables of TOML text of limited size.

    Raises:
        CaseError: the text is too long, or not TOML.
    """
    if len(text) > MOST_LETTERS or _DEEP_KEY.search(text):
        expected = f"at most {MOST_LETTERS} letters of TOML, and keys of at most 50 parts"
        raise CaseError([Fault(file=file, expected=expected)])
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise CaseError([Fault(file=file, expected=f"valid TOML ({error})")]) from None


def loads(text: str, *, file: str = "case", overrides: Iterable[str] = ()) -> Case:
    """Make a case from TOML text.

    Args:
        text: TOML text.
        file: name of the file for error messages. The path of a mesh file is relative to the folder
            of this file.
        overrides: texts "KEY=VALUE" with a dotted key, which may lead into inline tables, and a
            TOML value. A value that is not TOML and does not start with a quote or a bracket is
            taken as a string. A value that is a table replaces the entire table:
            ``excitation={type="none"}``. A number selects a row of a list, from 0:
            "excitation.1.amplitude=2"; so does a name: "joint.shroud.friction=0.2". A new
            excitation.type removes the keys of other types.

    Raises:
        CaseError: the text is not TOML, or the case is invalid; the error lists all faults.
    """
    tables = _parsed(text, file)
    _find_beside(tables, os.path.dirname(file))
    overrides = list(overrides)
    with faults_from(SET, ()):
        _replace(tables, override_values(overrides))
    with faults_from(file, overrides):
        return case_from(tables)


def with_values(case: Case, values: Mapping[str, Any]) -> Case:
    """Return a copy of a case with other values, by dotted key: ``{"march.speed": 1.2}``.

    None resets a key to its default: ``{"damping.ratio": None}``. For a key that has rows, a list
    replaces all rows: ``{"bladed_disk.point_masses": [{"radius": "10 cm", "mass": "2 kg"}]}``.
    Setting one of the keys of a row of `EXCLUSIVE` removes the others: march.speed removes
    march.speed_table. A new excitation.type removes the keys of other types.

    Raises:
        CaseError: the new case is invalid; the error lists all faults.
    """
    tables = case.model_dump(exclude_none=True)
    _replace(tables, values)
    return case_from(tables)


def override_values(overrides: Iterable[str]) -> dict[str, Any]:
    """Parse texts "KEY=VALUE" and return the values by dotted key, for `with_values`.

    Raises:
        CaseError: a text that is not of the form KEY=VALUE.
    """
    values: dict[str, Any] = {}
    for override in overrides:
        key, equals, text = (part.strip() for part in override.partition("="))
        if not equals or not re.fullmatch(r"[\w-]+(\.[\w-]+)*", key, re.ASCII):
            expected = "KEY=VALUE with a dotted key, such as march.speed=1.2"
            raise CaseError([Fault(file=f"{SET} {override}", expected=expected)])
        try:
            [(_, values[key])] = tomllib.loads(f"value = {text}").items()
        except (ValueError, RecursionError):
            if not text or text[0] in "\"'[{" or "\n" in text:
                fault = Fault(file=SET, key=key, value=text, expected="a TOML value")
                raise CaseError([fault]) from None
            values[key] = text
    return values


@contextmanager
def faults_from(file: str | PathLike[str], overrides: Iterable[str]) -> Iterator[None]:
    """Add the source of the key, an override or the file, to each fault raised in this context
    that does not state its source.

    Args:
        file: file from which the case was read.
        overrides: texts "KEY=VALUE", see `loads`.
    """
    keys = [override.partition("=")[0].strip() for override in overrides]
    try:
        yield
    except CaseError as error:
        raise CaseError(_placed(fault, fspath(file), keys) for fault in error.faults) from None


def case_fault(case: Case, key: str, expected: str) -> Fault:
    """Return a fault at a dotted key of a case that is valid by itself.

    The caller adds the name of the file, with `faults_from`.
    """
    if key == "march.time_step" and case.march.steps_per_revolution is not None:
        key, expected = "march.steps_per_revolution", f"more, for a time step of {expected}"
    path = path_of(key)
    return Fault(key=dotted(path), value=value_at(case.model_dump(), path), expected=expected)


def faults_at(case: Case, key: str, error: UserError) -> list[Fault]:
    """Return the faults of an error as those of a dotted key of a case, see `case_fault`."""
    return [
        replace(case_fault(case, key, fault.expected), part=fault.key) for fault in error.faults
    ]


def _find_beside(tables: dict[str, Any], folder: str) -> None:
    """Convert the paths of files in a case, given relative to the case file, to paths relative to
    the working directory."""
    wheels = value_at(tables, path_of("shaft_line.wheels"))
    rows = range(len(wheels) if isinstance(wheels, list) else 0)
    for key in (*FILES, *(f"shaft_line.wheels.{row}.superelement" for row in rows)):
        table = value_at(tables, path_of(key))
        if isinstance(table, dict) and isinstance(table.get("file"), str):
            table["file"] = os.path.join(folder, table["file"])


def _placed(fault: Fault, file: str, overridden: list[str]) -> Fault:
    """Attribute a fault to the command line if an override sets its key, otherwise to the file."""
    place = f"{fault.key.partition('[')[0]}."
    keys = [f"{key}." for key in overridden]
    set_here = any(place.startswith(key) or key.startswith(place) for key in keys)
    return replace(fault, file=fault.file or (SET if set_here else file))


def _replace(tables: dict[str, Any], values: Mapping[str, Any]) -> None:
    """Set values in tables by dotted key; excitation.type first, because it removes other keys."""
    for key in sorted(values, key=lambda key: LOAD_TYPE.fullmatch(key) is None):
        _set(tables, key, values[key])
    for keys in EXCLUSIVE:
        for other in keys if any(key in values for key in keys) else ():
            if other not in values:
                _set(tables, other, None)


def _set(tables: dict[str, Any], key: str, value: Any) -> None:
    *parents, name = key.split(".")
    table: Any = tables
    place: Any
    for number, parent in enumerate(parents):
        outer, place = table, parent
        if isinstance(outer, list):
            place = int(row_of(outer, parent))
        else:
            outer.setdefault(place, {})
        table = outer[place]
        expected = f"a key of a table; {parent} is not a table"
        if isinstance(table, list | tuple) and len(table) and isinstance(table[0], dict):
            table = outer[place] = list(table)
            row = str(row_of(table, parents[number + 1])) if number + 1 < len(parents) else ""
            listed = ".".join(parents[: number + 1])
            expected = (
                f"the number of a row, {listed}.0 to {listed}.{len(table) - 1}: {listed} is a list"
            )
            if row.isdigit() and int(row) < len(table):
                continue
        if not isinstance(table, dict):
            raise CaseError([Fault(key=key, value=value, expected=expected)])
    if value is None:
        table.pop(name, None)
    else:
        table[name] = value
    if LOAD_TYPE.fullmatch(key) and isinstance(value, str) and value in EXCITATIONS:
        for other in set(table) - set(EXCITATIONS[value].model_fields):
            del table[other]

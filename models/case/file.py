"""Case files: read, checked and written; keys set from the command line."""

from __future__ import annotations

import errno
import os
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from os import PathLike, fspath
from typing import Any

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.check import case_from
from bladewhirl.models.case.excitation import EXCITATIONS
from bladewhirl.models.inputs.errors import CaseError, Fault, faults_in

MOST_LETTERS = 2**24
"""Longest case file; what is longer is something else."""

_DEEP_KEY = re.compile(r"(?<![\w\"'-])(?:[\w\"'-]++[ \t]*+\.[ \t]*+){50}")
"""A dotted key of more than 50 parts: the memory of tomllib grows with their square."""

SET = "--set"
"""Named instead of the file in faults of overridden keys."""

LOAD_TYPE = "excitation.type"

SPRINGS = ("shaft.stiffness", "shaft.suspension_frequency")
"""Either of these replaces the other in the case that it changes."""


def read_case(path: str | PathLike[str], overrides: Iterable[str] = ()) -> Case:
    """Read a case file.

    Args:
        path: of the file, TOML in UTF-8.
        overrides: "march.speed=1.2" and the like, see `loads`.

    Raises:
        CaseError: the file is missing or unreadable, not TOML, or holds faults: all of them.
    """
    file = fspath(path)
    try:
        if os.path.exists(file) and not os.path.isfile(file) and not os.path.isdir(file):
            raise OSError(errno.EINVAL, "it is not a regular file")
        with open(file, encoding="utf-8-sig") as stream:
            text = stream.read(MOST_LETTERS + 1)
    except OSError as error:
        expected = f"a readable file ({error.strerror})"
        raise CaseError([Fault(file=file, expected=expected)]) from None
    except ValueError as error:  # not UTF-8, or a null in the path
        raise CaseError([Fault(file=file, expected=f"text in UTF-8 ({error})")]) from None
    return loads(text, file=file, overrides=overrides)


def loads(text: str, *, file: str = "case", overrides: Iterable[str] = ()) -> Case:
    """Make a case of TOML text.

    Args:
        text: TOML.
        file: what faults call it; a mesh file that it names is looked for beside it.
        overrides: "KEY=VALUE" with a dotted key, which reaches inline tables too, and a TOML
            value; what is not TOML and opens no quote, array or table is a string. A table
            replaces the whole table: ``excitation={type="none"}``. Another excitation.type drops
            the keys of the load before that it does not have.

    Raises:
        CaseError: not TOML, or faults: all of them.
    """
    if len(text) > MOST_LETTERS or _DEEP_KEY.search(text):
        expected = f"valid TOML of at most {MOST_LETTERS} letters, keys of at most 50 parts"
        raise CaseError([Fault(file=file, expected=expected)])
    try:
        tables = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise CaseError([Fault(file=file, expected=f"valid TOML ({error})")]) from None
    _find_beside(tables, os.path.dirname(file))
    overrides = list(overrides)
    with faults_in(SET):
        _replace(tables, override_values(overrides))
    with faults_from(file, overrides):
        return case_from(tables)


def with_values(case: Case, values: Mapping[str, Any]) -> Case:
    """A copy of a case with other values, by dotted key: ``{"march.speed": 1.2}``.

    None puts a key back to its default: ``{"damping.ratio": None}``. A key of several rows takes a
    list of them, whole, in place of those that it had:
    ``{"bladed_disk.point_masses": [{"radius": "10 cm", "mass": "2 kg"}]}``. shaft.stiffness and
    shaft.suspension_frequency replace each other, as do the loads of excitation.type.

    Raises:
        CaseError: all faults of the new case.
    """
    tables = case.model_dump(exclude_none=True)
    _replace(tables, values)
    return case_from(tables)


def override_values(overrides: Iterable[str]) -> dict[str, Any]:
    """Return the values of "KEY=VALUE" texts by dotted key, for `with_values`.

    Raises:
        CaseError: a text that is none.
    """
    values: dict[str, Any] = {}
    for override in overrides:
        key, equals, text = (part.strip() for part in override.partition("="))
        if not equals or not re.fullmatch(r"[\w-]+(\.[\w-]+)*", key, re.ASCII):
            expected = "KEY=VALUE with a dotted key, march.speed=1.2"
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
    """Say in faults raised inside where their key was set: by an override, or in the file.

    Args:
        file: that the case was read from.
        overrides: as given to `read_case`.
    """
    keys = [override.partition("=")[0].strip() for override in overrides]
    try:
        yield
    except CaseError as error:
        raise CaseError(_placed(fault, fspath(file), keys) for fault in error.faults) from None


def case_fault(case: Case, key: str, expected: str) -> Fault:
    """Return a fault at a dotted key of a valid case, found at a later stage.

    `faults_in` or `faults_from` names the file further up.
    """
    value: Any = case.model_dump()
    for part in key.split("."):
        value = value[part]
    return Fault(key=key, value=value, expected=expected)


def _find_beside(tables: dict[str, Any], folder: str) -> None:
    """Make the path of a mesh file, relative to the case file, one that leads there from here."""
    table: Any = tables
    for key in ("bladed_disk", "mesh"):
        table = table.get(key) if isinstance(table, dict) else None
    if isinstance(table, dict) and isinstance(table.get("file"), str):
        table["file"] = os.path.join(folder, table["file"])


def _placed(fault: Fault, file: str, overridden: list[str]) -> Fault:
    """Attribute a fault to the command line if it set the key, otherwise to the file."""
    place = f"{fault.key.partition('[')[0]}."
    keys = [f"{key}." for key in overridden]
    set_here = any(place.startswith(key) or key.startswith(place) for key in keys)
    return replace(fault, file=SET if set_here else file)


def _replace(tables: dict[str, Any], values: Mapping[str, Any]) -> None:
    """Set values in tables by dotted key; excitation.type first, for it drops other keys."""
    for key in sorted(values, key=LOAD_TYPE.__ne__):
        _set(tables, key, values[key])
    for key, other in (SPRINGS, SPRINGS[::-1]):
        if key in values and other not in values:
            _set(tables, other, None)


def _set(tables: dict[str, Any], key: str, value: Any) -> None:
    *parents, name = key.split(".")
    table: Any = tables
    for parent in parents:
        table = table.setdefault(parent, {})
        if not isinstance(table, dict):
            expected = f"a key of a table; {parent} is not a table"
            raise CaseError([Fault(key=key, value=value, expected=expected)])
    if value is None:
        table.pop(name, None)
    else:
        table[name] = value
    if key == LOAD_TYPE and isinstance(value, str) and value in EXCITATIONS:
        keys = EXCITATIONS[value].model_fields
        tables[parents[0]] = {each: given for each, given in table.items() if each in keys}

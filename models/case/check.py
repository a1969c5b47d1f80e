"""From nested tables, as TOML gives them, to a Case, or to all of their faults at once."""

from __future__ import annotations

import copy
import difflib
from collections.abc import Iterator, Mapping, MutableMapping
from functools import cache
from itertools import takewhile
from typing import Any, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EXCITATIONS
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.inputs.fields import EXPECTED
from bladewhirl.models.inputs.table import INCONSISTENT, Table
from bladewhirl.models.inputs.toml import toml_key

Path = tuple[str | int, ...]
"""Keys and row numbers from the root of the case on."""

TAG_ERRORS = ("union_tag_not_found", "union_tag_invalid")
"""pydantic's errors about the type of the excitation."""

NEAR = 0.5
"""Likeness, as difflib counts it, from which on a known key is offered for an unknown one."""


def case_from(tables: Mapping[str, Any]) -> Case:
    """Check nested tables, as a case file holds them, and make the case.

    Raises:
        CaseError: with every fault, also of values that contradict each other elsewhere.
    """
    try:
        return Case.model_validate(tables)
    except ValidationError as error:
        raise CaseError(_all_faults(tables, error)) from None


def _all_faults(tables: Mapping[str, Any], error: ValidationError) -> Iterator[Fault]:
    """Faults of ``error``, then those that show once the values found bad are left out.

    pydantic compares values only where each is right by itself. So what was found bad gives way
    to its default and the rest is checked again; what touches a default put in is not reported.
    """
    rest = copy.deepcopy(dict(tables))
    left_out: set[Path] = set()
    found: ValidationError | None = error
    while found is not None:
        errors = found.errors(include_url=False)
        paths = [_involved(details) for details in errors]
        for details, involved in zip(errors, paths, strict=True):
            if not any(_touches(path, left_out) for path in involved):
                yield _fault(details, tables)
        new = {path for involved in paths for path in involved} - left_out
        left_out |= new
        removed = [_remove(rest, path) for path in new]
        found = _check(rest) if any(removed) else None


def _check(tables: Mapping[str, Any]) -> ValidationError | None:
    try:
        Case.model_validate(tables)
    except ValidationError as error:
        return error
    return None


def _fault(details: ErrorDetails, tables: Mapping[str, Any]) -> Fault:
    path = _path(details)
    default = None if details["type"] in (*TAG_ERRORS, "missing") else details["input"]
    context = details.get("ctx", {})
    expected = _expected(details, path)
    if context.get("place"):
        return Fault(key=f"{_dotted(path)}: {context['place']}", expected=expected)
    value = context.get("value") or _value(tables, path, default)
    return Fault(key=_dotted(path), value=value, expected=expected)


def _expected(details: ErrorDetails, path: Path) -> str:
    context = details.get("ctx", {})
    match details["type"]:
        case kind if kind in (EXPECTED, INCONSISTENT):
            return str(context["expected"])
        case "extra_forbidden":
            return _known_instead(details["loc"], path, details["input"])
        case kind if kind in TAG_ERRORS:
            return " or ".join(f'"{name}"' for name in EXCITATIONS)
        case "literal_error":
            return str(context["expected"]).replace("'", '"')
        case "bool_type":
            return "true or false"
        case "missing":
            return f"a value of {path[-1]}"
        case "string_type":
            return "text"
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"a table, [{_dotted(path)}]"
    return details["msg"]


def _path(details: ErrorDetails) -> Path:
    """Place of an error; pydantic puts the type of the excitation into the location, if known."""
    location = details["loc"]
    if details["type"] in TAG_ERRORS:
        return (*location, "type")
    tagged = location[0] == "excitation" and len(location) > 1 and location[1] in EXCITATIONS
    return (location[0], *location[2:]) if tagged else location


def _involved(details: ErrorDetails) -> list[Path]:
    """Place of an error, and the keys that it disagrees with or was perhaps meant for."""
    path = _path(details)
    if details["type"] == "extra_forbidden":
        return [path, *_nearest(details["loc"], path, details["input"])]
    if details["type"] in TAG_ERRORS:
        return [path, path[:-1]]  # without its type the table can't be checked
    if details["type"] != INCONSISTENT:
        return [path]
    context = details["ctx"]
    table = path[: len(path) - len(context["key"].split("."))]
    return [path, *((*table, *other.split(".")) for other in context["others"])]


def _touches(path: Path, left_out: set[Path]) -> bool:
    return any(path[:depth] in left_out for depth in range(1, len(path) + 1))


def _value(tables: Mapping[str, Any], path: Path, default: object) -> Any:
    value: Any = tables
    for part in path:
        try:
            value = value[part]
        except (KeyError, IndexError, TypeError):
            return default
    return value


def _remove(tables: MutableMapping[str, Any], path: Path) -> bool:
    """Take out the key, or the whole array, that ``path`` leads to; False if there is none."""
    table: Any = tables
    keys = list(takewhile(lambda part: isinstance(part, str), path))
    for key in keys[:-1]:
        table = table.get(key) if isinstance(table, dict) else None
    return isinstance(table, dict) and table.pop(keys[-1], None) is not None


def _dotted(path: Path) -> str:
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{toml_key(part)}"
    return text.removeprefix(".")


def _known_instead(location: Path, path: Path, value: object) -> str:
    nearest = _nearest(location, path, value)
    if not nearest:
        table = f" of [{_dotted(path[:-1])}]" if path[:-1] else ""
        return f"a known key{table}: {', '.join(_table_at(location[:-1]).model_fields)}"
    if path not in nearest:
        return f"a known key; the nearest is {' or '.join(map(_dotted, nearest))}"
    owners = [f'"{kind}"' for kind, table in EXCITATIONS.items() if path[-1] in table.model_fields]
    return f'a key of excitation.type = "{location[1]}"; this one is of {" and ".join(owners)}'


def _nearest(location: Path, path: Path, value: object) -> list[Path]:
    """Known keys most like an unknown one: in its table and of its name elsewhere, else any.

    An unknown table of a single key may stand for a known one with that key: "nope.speed" for
    "march.speed". None where nothing is near; the key itself where another type of excitation has
    it.
    """
    name = str(path[-1])
    siblings = {key: (*path[:-1], key) for key in _table_at(location[:-1]).model_fields}
    everywhere = {str(known[-1]): known for known in _known_keys()}
    return (
        [siblings[key] for key in difflib.get_close_matches(name, siblings, n=1)] + _called(name)
        or _called(_last_key(value))
        or [everywhere[key] for key in difflib.get_close_matches(name, everywhere, n=1)]
        or [siblings[key] for key in difflib.get_close_matches(name, siblings, n=1, cutoff=NEAR)]
    )


def _called(name: str | None) -> list[Path]:
    return [known for known in _known_keys() if known[-1] == name]


def _last_key(value: object) -> str | None:
    """The key that tables of a single key lead to; None for other values."""
    name = None
    while isinstance(value, Mapping) and len(value) == 1:
        [(name, value)] = value.items()
    return name


def _table_at(location: Path) -> type[Table]:
    table: type[Table] = Case
    for part in location:
        if part in EXCITATIONS:
            table = EXCITATIONS[str(part)]
        elif isinstance(part, str) and part != "excitation":  # else a row of an array
            [table] = _tables_under(table, part) or [table]  # a section has no tables
    return table


@cache
def _known_keys() -> tuple[Path, ...]:
    """All keys of a case, each once."""
    return tuple(dict.fromkeys(_keys_of(Case)))


def _keys_of(table: type[Table]) -> Iterator[Path]:
    for name in table.model_fields:
        yield (name,)
        for inner in _tables_under(table, name):
            yield from ((name, *path) for path in _keys_of(inner))


def _tables_under(table: type[Table], name: str) -> list[type[Table]]:
    field = table.model_fields.get(name)
    return [] if field is None else list(_tables_in(field.annotation))


def _tables_in(annotation: Any) -> Iterator[type[Table]]:
    """Tables that a field of a type may hold: itself, or inside "or none" and arrays."""
    if isinstance(annotation, type) and issubclass(annotation, Table):
        yield annotation
    for inner in get_args(annotation):
        yield from _tables_in(inner)

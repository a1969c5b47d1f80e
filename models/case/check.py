"""Validation of nested tables from TOML: make a Case, or raise a `CaseError` with all faults."""

import difflib
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from bladewhirl.models.case.analysis import REMOVED_DEFAULTS, REMOVED_LAWS
from bladewhirl.models.case.excitation import EXCITATIONS, ONE, SEVERAL
from bladewhirl.models.case.sensors import SENSORS, Sensor, SensorList, sensor_faults
from bladewhirl.models.case.tables import Tables
from bladewhirl.models.inputs.errors import CaseError, Fault, toml_key
from bladewhirl.models.inputs.fields import EXPECTED
from bladewhirl.models.inputs.table import INCONSISTENT, Path, Table, path_of, value_at

TAG_ERRORS = ("union_tag_not_found", "union_tag_invalid")
"""pydantic's errors about the type of the excitation or of a sensor."""

UNKNOWN_KEY = "extra_forbidden"  #: pydantic's error about a key that a table does not have

KINDS: Mapping[str, Mapping[str, type[Table]]] = {"excitation": EXCITATIONS, "sensor": SENSORS}
"""Table class of each type, for the tables whose keys depend on the key `type`."""

FIXED_PHRASES = {"bool_type": "true or false", "string_type": "text"}
"""Text of the expected value for each type of pydantic error."""

REMOVED_KEYS = dict.fromkeys(
    (f"contact.{name}" for name in REMOVED_DEFAULTS),
    f"not allowed, because {REMOVED_LAWS}; remove this key",
)
"""Text of the fault of each key that earlier versions had."""

TABLE_ERRORS = ("model_type", "model_attributes_type", "dict_type")


def sensors_from(rows: Sequence[Any], blades: int) -> tuple[Sensor, ...]:
    """Make sensors from tables, for a bladed disk with a number of blades.

    Raises:
        CaseError: a sensor is invalid; the error lists all faults.
    """
    try:
        sensors = SensorList(sensor=rows).sensor
    except ValidationError as error:
        raise CaseError(faults_of(error, {"sensor": rows})) from None
    faults = [
        Fault(key=dotted(path_of(fault.key)), value=fault.value, expected=fault.expected)
        for fault in sensor_faults(sensors, blades)
    ]
    if faults:
        raise CaseError(faults)
    return sensors


def faults_of(
    error: ValidationError, tables: Mapping[str, Any], parent: str = "", only: str = ""
) -> list[Fault]:
    """Return the faults in pydantic's error on a case or a part of it.

    Args:
        error: error of the validation.
        tables: tables that were validated.
        parent: dotted key of the part of a case; empty for a case.
        only: type of the errors to return; empty for all.
    """
    found = error.errors(include_url=False)
    return [_fault(each, tables, parent) for each in found if only in ("", each["type"])]


def _fault(details: ErrorDetails, tables: Mapping[str, Any], parent: str) -> Fault:
    path = _path(details)
    key = ".".join(filter(None, [parent, dotted(path)]))
    default = None if details["type"] in (*TAG_ERRORS, "missing") else details["input"]
    context = details.get("ctx", {})
    expected = _expected(details, path)
    if context.get("place"):
        return Fault(key=f"{key}: {context['place']}", expected=expected)
    value = context.get("value") or value_at(tables, path, default)
    return Fault(key=key, value=value, expected=expected)


def _expected(details: ErrorDetails, path: Path) -> str:
    kind, context = details["type"], details.get("ctx", {})
    if kind in (EXPECTED, INCONSISTENT):
        return str(context["expected"])
    if kind == UNKNOWN_KEY:
        return REMOVED_KEYS.get(dotted(path)) or _known_key(_location(details), path)
    if kind in TAG_ERRORS:
        return " or ".join(f'"{name}"' for name in KINDS[str(path[0])])
    if kind == "literal_error":
        return str(context["expected"]).replace("'", '"')
    if kind == "missing":
        return f"a value for {path[-1]}"
    if kind in TABLE_ERRORS:
        return f"a table, [{dotted(path)}]"
    return FIXED_PHRASES.get(kind, details["msg"])


def _path(details: ErrorDetails) -> Path:
    """Return the path to a fault without the table type that pydantic inserts."""
    location = _location(details)
    if details["type"] in TAG_ERRORS:
        return (*location, "type")
    at = _place_of_type(location)
    return (*location[:at], *location[at + 1 :]) if at else location


def _location(details: ErrorDetails) -> Path:
    """Return the path to a fault, without the names `ONE` and `SEVERAL`."""
    location = details["loc"]
    tagged = location[:2] in (("excitation", ONE), ("excitation", SEVERAL))
    return (location[0], *location[2:]) if tagged else location


def _place_of_type(location: Path) -> int:
    """Return the place in a path at which pydantic inserts the type of a table; 0 if it inserts
    none."""
    at = 1 + len([part for part in location[1:2] if isinstance(part, int)])
    tagged = len(location) > at and location[at] in KINDS.get(str(location[0]), ())
    return at if tagged else 0


def dotted(path: Path) -> str:
    """Return a path as text, with numbers of rows in brackets."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{toml_key(part)}"
    return text.removeprefix(".")


def _known_key(location: Path, path: Path) -> str:
    """Return a text that suggests similar keys: keys of the table, or else keys of any table."""
    name, table = str(path[-1]), path[:-1]
    kinds = KINDS.get(str(path[0]), {})
    owners = [f'"{kind}"' for kind, table_of in kinds.items() if name in table_of.model_fields]
    if owners:
        given = location[_place_of_type(location)]
        return f'a key of {path[0]}.type = "{given}"; this key belongs to {" and ".join(owners)}'
    known = _known_keys()
    names = tuple(part for part in table if isinstance(part, str))  # without numbers of rows
    siblings = [key[-1] for key in known if key[:-1] == names]
    similar = [(*table, key) for key in difflib.get_close_matches(name, siblings, n=1)]
    similar += [key for key in known if key[-1] == name]
    if not similar:
        last = {key[-1]: key for key in known}
        similar = [last[key] for key in difflib.get_close_matches(name, last, n=1)]
    if similar:
        return f"a known key; the nearest is {' or '.join(map(dotted, similar))}"
    heading = f" of [{dotted(table)}]" if table else ""
    return f"a known key{heading}: {', '.join(siblings)}"


@cache
def _known_keys() -> tuple[tuple[str, ...], ...]:
    """Return all keys of a case, each once."""
    return tuple(dict.fromkeys(_keys_of(Tables)))


def _keys_of(table: type[Table]) -> Iterator[tuple[str, ...]]:
    for attribute, field in table.model_fields.items():
        name = field.alias or attribute
        yield (name,)
        for inner in tables_in(field.annotation):
            yield from ((name, *path) for path in _keys_of(inner))


def tables_in(annotation: Any) -> Iterator[type[Table]]:
    """Yield all table classes in a type: the type itself, or members of a union or an array."""
    if isinstance(annotation, type) and issubclass(annotation, Table):
        yield annotation
    for inner in get_args(annotation):
        yield from tables_in(inner)

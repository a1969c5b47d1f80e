"""Writing of a case as TOML: with all its keys, or as a template with comments."""

import textwrap
from collections.abc import Iterator

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EXCITATIONS, NoExcitation
from bladewhirl.models.case.joint import Joint
from bladewhirl.models.case.sensors import EXAMPLES
from bladewhirl.models.inputs.errors import toml_value
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.inputs.units import Speed

COLUMNS = 96

ROWS = ("sensor", "joint")
"""Keys whose rows have their own headings."""

_HEAD = """\
A case of bladewhirl. Every key below stands at its default and may be left out.
Numbers are SI; text carries its own unit: clearance = "1 mm", young_modulus = "210 GPa".
"""


def dumps_case(case: Case) -> str:
    """Return a case as TOML with every key and numbers at full precision; `loads` reads it back
    without change."""
    return _document(case, commented=False)


def template() -> str:
    """Return a case file with all keys at their defaults and their descriptions, for `bladewhirl
    new`."""
    return _comment(_HEAD) + "\n" + _document(Case(), commented=True)


def _document(case: Case, *, commented: bool) -> str:
    parts = ["".join(_keys(case, commented=commented))]
    written = case.model_dump()
    for name, table in case:
        if isinstance(table, Table) and name in written:
            summary = _comment(_summary(table)) if commented else ""
            keys = "".join(_keys(table, commented=commented))
            parts.append(f"{summary}[{name}]\n{keys}")
            if commented and name == "excitation":
                parts += [_alternative(kind()) for kind in EXCITATIONS.values()]
    for load in case.excitation if isinstance(case.excitation, tuple) else ():
        parts.append(f"[[excitation]]\n{''.join(_keys(load, commented=False))}")
    for name in ROWS:
        parts += [
            f"[[{name}]]\n{''.join(_keys(row, commented=False))}" for row in getattr(case, name)
        ]
    if commented:
        parts.append(_alternative(Joint(), "[[joint]]\n"))
        parts += [_alternative(sensor, "[[sensor]]\n") for sensor in EXAMPLES]
    return "\n".join(part for part in parts if part)


def _keys(table: Table, *, commented: bool) -> Iterator[str]:
    written = table.model_dump()
    descriptions = type(table).descriptions() if commented else {}
    for name, field in type(table).model_fields.items():
        value, key = getattr(table, name), field.alias or name
        if key not in written:
            continue
        if isinstance(table, Case) and isinstance(value, Table):
            continue  # has its own heading; nested tables are written inline
        if isinstance(table, Case) and name in ("excitation", *ROWS):
            continue  # each row has its own heading, at the end
        if commented:
            yield _comment(descriptions[name])
        if value is not None:
            yield f"{key} = {_value(value)}\n"
        elif commented:
            yield _comment(f"{key} = {(field.examples or [None])[0]}")


def _alternative(table: Table, heading: str = "") -> str:
    """Return the heading and the keys of a table of one type of excitation or sensor, commented out
    with "#"; comments on the keys begin with "##"."""
    if isinstance(table, NoExcitation):
        return ""
    lines = [_comment(_summary(table)), heading, *_keys(table, commented=True)]
    text = "".join(lines).splitlines()
    return "".join(f"#{line}\n" if line.startswith("#") else f"# {line}\n" for line in text)


def _value(value: object) -> str:
    if isinstance(value, Speed):
        return toml_value(value.given)
    if isinstance(value, Table):
        inner = value.model_dump(exclude_none=True)
        return toml_value({key: item for key, item in inner.items() if item != ()})
    if isinstance(value, tuple) and value and isinstance(value[0], tuple | Table):
        rows = (
            row.model_dump(exclude_none=True, exclude_defaults=True)
            if isinstance(row, Table)
            else tuple(item.given if isinstance(item, Speed) else item for item in row)
            for row in value
        )
        return "".join(["[\n", *(f"    {toml_value(row)},\n" for row in rows), "]"])
    return toml_value(value)


def _summary(table: Table) -> str:
    return str(type(table).__doc__).splitlines()[0]


def _comment(text: str) -> str:
    wrapper = textwrap.TextWrapper(width=COLUMNS - 2, break_on_hyphens=False)
    lines = [line for part in text.splitlines() for line in wrapper.wrap(part)]
    return "".join(f"# {line}\n" for line in lines)

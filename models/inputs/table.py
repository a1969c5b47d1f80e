"""Base class of the tables of a case: immutable, without unknown keys, checked for consistency."""

import ast
import inspect
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from itertools import pairwise
from textwrap import dedent
from typing import Any, ClassVar, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    SerializationInfo,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

from bladewhirl.models.inputs.errors import demand
from bladewhirl.models.inputs.rules import Inconsistency, broken

Path = tuple[str | int, ...]  #: keys and row numbers from a table to a value

INCONSISTENT = "inconsistent"
"""Type of the errors raised here; their context contains the fields of an `Inconsistency`."""


def path_of(key: str) -> Path:
    """Return the names and the row numbers of which a dotted key consists."""
    parts = key.split(".") if key else []
    return tuple(int(part) if part.isdigit() else part for part in parts)


def value_at(tables: object, path: Path, default: object = None) -> Any:
    """Return the value at a path in a `Table`, or in the mappings and lists of a case file; the
    default if there is none."""
    value: Any = tables
    for part in path:
        try:
            part = row_of(value, part)
            if isinstance(value, Table):
                names = {field.alias: name for name, field in type(value).model_fields.items()}
                value = getattr(value, names.get(str(part), str(part)))
            else:
                value = value[str(part) if isinstance(value, Mapping) else part]
        except (AttributeError, KeyError, IndexError, TypeError):
            return default
    return value


def row_of(value: object, part: str | int) -> str | int:
    """Return the number of the row with a name, if a value is a list of tables; otherwise the part
    of a key as it is."""
    if not isinstance(value, list | tuple) or not isinstance(part, str):
        return part
    names = [value_at(row, ("name",)) for row in value]
    return names.index(part) if part in names else part


class Table(BaseModel):
    """A table of the case file."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @classmethod
    def descriptions(cls) -> dict[str, str]:
        """Return the description of each key on one line: its docstring in the source, which is
        read only here, because pydantic would read it at each start of the program."""
        found: dict[str, str] = {}
        for table in reversed(cls.__mro__[: cls.__mro__.index(Table)]):
            (body,) = ast.parse(dedent(inspect.getsource(table))).body
            lines = body.body if isinstance(body, ast.ClassDef) else []
            for line, text in pairwise(lines):
                match line, text:
                    case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(
                        value=ast.Constant(value=str(words))
                    ):
                        found[name] = " ".join(words.split())
        return {name: found[name] for name in cls.model_fields if name in found}

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield the values of this table that contradict each other: those that break the rules
        under the names of its class and the bases of its class."""
        for kind in type(self).__mro__:
            yield from broken(kind.__name__, self, sys.modules[kind.__module__])

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        errors = [
            InitErrorDetails(
                type=PydanticCustomError(
                    INCONSISTENT, "{demand}", fault._asdict() | {"demand": demand(fault.expected)}
                ),
                loc=path_of(fault.key),
                input=self if fault.value or fault.place else value_at(self, path_of(fault.key)),
            )
            for fault in self.inconsistencies()
        ]
        if errors:
            raise ValidationError.from_exception_data(type(self).__name__, errors)
        return self


class ReplacedKeys(Table):
    """A table in which some keys replace others if they are given."""

    replacements: ClassVar[Mapping[str, Collection[str]]] = {}
    """Keys that a key replaces if it is given; an empty list is not given."""
    always: ClassVar[Collection[str]] = ()
    """Keys that are written even where those at their defaults are not."""

    def written(self) -> Iterable[str]:
        """Return the keys to write, without those that other keys replace."""
        given = [name for name in self.replacements if getattr(self, name) not in (None, ())]
        replaced = {each for name in given for each in self.replacements[name]}
        return [name for name in type(self).model_fields if name not in replaced]

    @model_serializer(mode="wrap")
    def _only_written(
        self, serialize: SerializerFunctionWrapHandler, info: SerializationInfo
    ) -> dict[str, Any]:
        return self.replaced(serialize(self), info)

    def replaced(self, tables: dict[str, Any], info: SerializationInfo) -> dict[str, Any]:
        """Return the serialised keys without those that are not written."""
        tables |= {name: getattr(self, name) for name in self.always}
        return {name: tables[name] for name in self.written() if name in tables}

    def given(self, kept: Collection[str] = ()) -> list[str]:
        """Return the keys that differ from their defaults, except `kept`."""
        return [
            name
            for name, field in type(self).model_fields.items()
            if name not in kept and getattr(self, name) != field.default
        ]

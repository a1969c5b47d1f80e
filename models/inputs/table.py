"""Base of the tables of a case: frozen, closed to unknown keys, checked for consistency."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterator
from itertools import pairwise
from operator import attrgetter
from typing import NamedTuple, Self

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

INCONSISTENT = "inconsistent"
"""Type of the errors raised here; their context holds the fields of an `Inconsistency`."""


class Inconsistency(NamedTuple):
    """Values that are right one by one but not together; keys are dotted from the table on."""

    key: str  #: the one to blame
    expected: str  #: completes "expected ..."
    others: tuple[str, ...] = ()  #: the keys it does not agree with
    value: object = None  #: to be shown instead of the key's own
    place: str = ""  #: part of the table that no key names, shown instead of a key


class Table(BaseModel):
    """A table of the case file."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @classmethod
    def descriptions(cls) -> dict[str, str]:
        """What each key means: its docstring in the source, on one line."""
        found: dict[str, str] = {}
        for table in reversed(cls.__mro__[: cls.__mro__.index(Table)]):
            body = ast.parse(textwrap.dedent(inspect.getsource(table))).body[0]
            for key, words in pairwise(ast.iter_child_nodes(body)):
                match key, words:
                    case (
                        ast.AnnAssign(target=ast.Name(id=name)),
                        ast.Expr(value=ast.Constant(value=str(text))),
                    ):
                        found[name] = " ".join(text.split())
        return found

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Values of this table that do not fit together."""
        yield from ()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        errors = [
            InitErrorDetails(
                type=PydanticCustomError(INCONSISTENT, "expected {expected}", found._asdict()),
                loc=tuple(found.key.split(".")) if found.key else (),
                input=self if found.value or found.place else attrgetter(found.key)(self),
            )
            for found in self.inconsistencies()
        ]
        if errors:
            raise ValidationError.from_exception_data(type(self).__name__, errors)
        return self

"""Base of the tables of a case: frozen, closed to unknown keys, checked for consistency."""

from __future__ import annotations

from collections.abc import Iterator
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
    others: tuple[str, ...]  #: the keys it does not agree with


class Table(BaseModel):
    """A table of the case file."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """What does not fit together in this table."""
        yield from ()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        errors = [
            InitErrorDetails(
                type=PydanticCustomError(INCONSISTENT, "expected {expected}", found._asdict()),
                loc=tuple(found.key.split(".")),
                input=attrgetter(found.key)(self),
            )
            for found in self.inconsistencies()
        ]
        if errors:
            raise ValidationError.from_exception_data(type(self).__name__, errors)
        return self

"""A verification case: a quantity with a known answer, and how it is computed here.

A case is a function that returns (reference, ours), and a row of data/cases.csv, which says what
is compared, within which tolerance, and where the reference comes from::

    @verifies("2", "3", "4")
    def nafems_ring(k: str) -> Pair:
        ...

Both may be arrays of one shape: the worst of their entries is told.
"""

from __future__ import annotations

import csv
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, Literal, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.studies.verification.references import FOLDER

Pair = tuple[ArrayLike, ArrayLike]
"""Reference and ours."""

Measure = Literal["relative", "of largest", "absolute"]
"""Error over the reference, over the largest entry of the reference, or in the unit."""

Function = TypeVar("Function", bound=Callable[..., Pair])


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Outcome of a case."""

    name: str
    subject: str
    quantity: str
    source: str
    unit: str  #: "1" for numbers without
    values: int  #: compared
    reference: float  #: of the worst value
    ours: float  #: of the worst value
    error: float  #: largest, NaN where a value is not finite
    tolerance: float
    measure: Measure
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance."""
        return bool(self.error <= self.tolerance)


@dataclass(frozen=True, kw_only=True)
class VerificationCase:
    """Row of the table before its computation."""

    name: str  #: "rings.nafems_ring[2]"
    quantity: str
    source: str
    unit: str
    tolerance: float
    measure: Measure
    long: bool  #: left out of the default set
    compute: Callable[[], Pair]

    @property
    def subject(self) -> str:
        """Module of the case."""
        return self.name.partition(".")[0]

    def run(self) -> Outcome:
        """Compute and compare.

        Raises:
            ValueError: reference and ours differ in shape.
        """
        began = time.perf_counter()
        reference, ours = (np.atleast_1d(np.asarray(v, dtype=float)) for v in self.compute())
        if reference.shape != ours.shape:
            shapes = f"{reference.shape} and {ours.shape}"
            raise ValueError(f"{self.name}: reference and ours have shapes {shapes}")
        scale: Any = {
            "relative": np.abs(reference),
            "of largest": np.abs(reference).max(),
            "absolute": 1.0,
        }[self.measure]
        error = np.abs(ours - reference) / scale
        worst = np.unravel_index(np.argmax(error), error.shape)  # a NaN counts as the largest
        return Outcome(
            name=self.name,
            subject=self.subject,
            quantity=self.quantity,
            source=self.source,
            unit=self.unit,
            values=reference.size,
            reference=float(reference[worst]),
            ours=float(ours[worst]),
            error=float(error[worst]),
            tolerance=self.tolerance,
            measure=self.measure,
            seconds=time.perf_counter() - began,
        )


CASES: list[VerificationCase] = []
"""All cases of the modules imported so far, in the order of the table."""


@cache
def rows() -> dict[str, dict[str, str]]:
    """Rows of data/cases.csv by the name of their function, "rings.nafems_ring"."""
    text = (FOLDER / "cases.csv").read_text(encoding="utf-8")
    return {row["case"]: row for row in csv.DictReader(text.splitlines())}


def verifies(*each: Hashable) -> Callable[[Function], Function]:
    """Make cases of a function that returns (reference, ours).

    Args:
        each: arguments, a case each, put in for "{}" of the quantity; without any the function
            takes none.
    """

    def register(function: Function) -> Function:
        name = f"{function.__module__.rpartition('.')[2]}.{function.__name__}"
        row = rows()[name]
        given = [(f"{name}[{value}]", value) for value in each] or [(name, None)]
        for own_name, value in given:
            CASES.append(
                VerificationCase(
                    name=own_name,
                    quantity=row["quantity"].format(value),
                    source=row["source"],
                    unit=row["unit"],
                    tolerance=float(row["tolerance"]),
                    measure=cast(Measure, row["measure"]),
                    long=row["long"] == "yes",
                    compute=partial(function, value) if each else function,
                )
            )
        return function

    return register

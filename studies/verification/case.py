"""A verification case: a quantity with a known answer, and its computation.

A case consists of a row of data/cases.csv, with the quantity, the tolerance and the source of the
reference, and a function with the name of the case that returns (reference, computed value)::

    @verifies("2", "3", "4")
    def nafems_ring(k: str) -> Pair:
        ...

Reference and computed value can be arrays of the same shape; the entry with the largest error is
reported. If one function computes several cases, the rows name the function, which returns a pair
for each case.
"""

import json
import time
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, fields
from functools import cache, partial
from importlib import resources
from typing import Any, Literal, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.files import packaged_rows

Pair = tuple[ArrayLike, ArrayLike]  #: reference value and computed value

Pairs = Mapping[str, Pair]  #: pairs of several cases, by name of the case

Measure = Literal["relative", "of largest", "absolute"]
"""Kind of error: divided by the reference, divided by the largest entry of the reference, or the
absolute error in the unit of the case."""

Function = TypeVar("Function", bound=Callable[..., Pair | Pairs])


@dataclass(frozen=True, kw_only=True)
class Row:
    """Row of data/cases.csv."""

    name: str  #: subject and name, such as "rings.nafems_ring[2]"
    subject: str  #: module of the case
    quantity: str
    source: str
    unit: str  #: "1" for dimensionless numbers
    tolerance: float
    measure: Measure


@dataclass(frozen=True, kw_only=True)
class Outcome(Row):
    """Outcome of a case."""

    values: int  #: number of values compared
    reference: float  #: reference of the value with the largest error
    ours: float  #: computed value with the largest error
    error: float  #: largest error, NaN if a value is not finite
    seconds: float

    @property
    def passed(self) -> bool:
        """True if the error is within the tolerance."""
        return bool(self.error <= self.tolerance)


@dataclass(frozen=True, kw_only=True)
class VerificationCase(Row):
    """A case before its computation."""

    long: bool  #: whether the case takes long and is left out by default
    compute: Callable[[], Pair]

    def run(self) -> Outcome:
        """Compute the case and compare it with the reference.

        Raises:
            ValueError: reference and computed values differ in shape.
        """
        began = time.perf_counter()
        reference, ours = (np.atleast_1d(np.asarray(v, dtype=float)) for v in self.compute())
        if reference.shape != ours.shape:
            shapes = f"{reference.shape} and {ours.shape}"
            raise ValueError(f"{self.name}: reference and computed values have shapes {shapes}")
        scale: Any = {
            "relative": np.abs(reference),
            "of largest": np.abs(reference).max(),
            "absolute": 1.0,
        }[self.measure]
        error = np.abs(ours - reference) / scale
        worst = np.unravel_index(np.argmax(error), error.shape)  # a NaN counts as the largest
        return Outcome(
            **{field.name: getattr(self, field.name) for field in fields(Row)},
            values=reference.size,
            reference=float(reference[worst]),
            ours=float(ours[worst]),
            error=float(error[worst]),
            seconds=time.perf_counter() - began,
        )


CASES: list[VerificationCase] = []  #: all cases of the modules imported so far

FOLDER = resources.files("bladewhirl.studies.verification") / "data"


@cache
def reference(name: str) -> Any:
    """Return the content of a file of reference values; the file also states the source of the
    values."""
    return json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))


@cache
def rows() -> dict[str, dict[str, str]]:
    """Return the rows of data/cases.csv by name, "rings.nafems_ring"."""
    return {row["case"]: row for row in packaged_rows(__package__, "data/cases.csv")}


def verifies(*values: Hashable) -> Callable[[Function], Function]:
    """Register the cases of a function.

    Args:
        values: arguments of the function, one for each case; an argument replaces "{}" in the text
            of the quantity. Without values, the function takes no argument.
    """

    def register(function: Function) -> Function:
        subject = function.__module__.rpartition(".")[2]
        shared = cache(function)
        for name, row in rows().items():
            case = name.removeprefix(f"{subject}.")
            if case == name or function.__name__ != (row["function"] or case):
                continue
            for value in values or [None]:
                arguments = () if value is None else (value,)
                CASES.append(
                    VerificationCase(
                        name=f"{name}[{value}]" if values else name,
                        subject=subject,
                        quantity=row["quantity"].format(value),
                        source=row["source"],
                        unit=row["unit"],
                        tolerance=float(row["tolerance"]),
                        measure=cast(Measure, row["measure"]),
                        long=row["long"] == "yes",
                        compute=partial(
                            _pair, shared if row["function"] else function, arguments, case
                        ),
                    )
                )
        return function

    return register


def _pair(
    function: Callable[..., Pair | Pairs], arguments: tuple[Hashable, ...], case: str
) -> Pair:
    """Return the pair of a case; the function returns one pair, or the pairs of several cases."""
    computed = function(*arguments)
    return computed[case] if isinstance(computed, Mapping) else computed

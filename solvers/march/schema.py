"""The schema of result.nc and sweep.nc: every variable, its dimensions, units and meaning.

The table itself is schema.csv beside this module. Recorder, reader and sweeps are laid out by it,
and `schema_table` prints it. `HISTORY` has the names of `Chunk`, `STATIC` those of `StageArrays`.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from importlib import resources
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

RESULT_NAME = "result.nc"
"""The result's file in the folder of a run."""

RESULT_FORMAT = 6
"""Of result.nc. 1 and 2 carry no number: 1 lacks what is marked since 2, and neither has the
coordinates marked since 3; these, recess and growth of tips, and frequencies of waves are added on
opening."""

SWEEP_FORMAT = 5
"""Of sweep.nc. 1 lacks what is marked since 2, and neither 1 nor 2 keeps swept values in the unit
that they were given in; 3 and 4 lack what is marked later. They can be read, but not resumed."""

TIME = "time"

OPTIONAL_DIMENSIONS = frozenset({"support", "rotor_link", "rotor_spring", "mass"})
"""Dimensions that may be zero. Their variables are left out of a file: netCDF treats a dimension of
length zero as unlimited."""


class Variable(NamedTuple):
    """Variable of a file."""

    dimensions: tuple[str, ...]  #: in a sweep they follow those of the swept keys
    kind: str  #: dtype, or "str"
    units: str
    long_name: str
    since: int  #: first format of the file that has it
    is_coordinate: bool  #: it names, counts or describes what is along a dimension
    values: str  #: "positive", "not negative", "rotor_node" for numbers of nodes; "" for any
    labels: tuple[str, ...]  #: names along a dimension, meanings of the numbers 0, 1, ..., or texts

    @property
    def attributes(self) -> dict[str, str]:
        """Units and long name, as attributes of the variable."""
        return {"units": self.units, "long_name": self.long_name}


def _read(table: str) -> dict[str, Variable]:
    text = resources.files(__package__).joinpath("schema.csv").read_text(encoding="utf-8")
    return {
        row["name"]: Variable(
            dimensions=tuple(row["dimensions"].split()),
            kind=row["kind"],
            units=row["units"],
            long_name=row["long_name"],
            since=int(row["since"]),
            is_coordinate=bool(row["coordinate"]),
            values=row["values"],
            labels=tuple(row["labels"].split()),
        )
        for row in csv.DictReader(text.splitlines())
        if row["table"] == table
    }


HISTORY: Mapping[str, Variable] = _read("history")
"""result.nc, recorded over time."""

STATIC: Mapping[str, Variable] = _read("stage")
"""result.nc, known before the march."""

INDICES: Mapping[str, Variable] = _read("index")
"""result.nc, names or numbers along a dimension."""

RESULT: Mapping[str, Variable] = {**HISTORY, **STATIC, **INDICES}
"""result.nc, all of it."""

SWEEP: Mapping[str, Variable] = _read("sweep")
"""sweep.nc, what is kept of every point."""


def index_values(name: str, size: int) -> NDArray[np.int64] | NDArray[np.object_]:
    """Values of one of `INDICES` along a dimension of that size: names, or numbers from 0."""
    labels = INDICES[name].labels
    return np.array(labels, dtype=object) if labels else np.arange(size)


def schema_table(file: Mapping[str, Variable]) -> str:
    """A page of documentation: one row of a Markdown table for each variable.

    Args:
        file: `RESULT` or `SWEEP`.
    """
    return "\n".join(_rows(file)) + "\n"


def _rows(file: Mapping[str, Variable]) -> Iterator[str]:
    yield "| variable | dimensions | units | kind | since format | meaning |"
    yield "|---|---|---|---|---|---|"
    for name, variable in file.items():
        meaning = ": ".join(filter(None, [variable.long_name, ", ".join(variable.labels)]))
        cells = (", ".join(variable.dimensions), variable.units, variable.kind, variable.since)
        yield f"| `{name}` | {' | '.join(map(str, cells))} | {meaning} |"

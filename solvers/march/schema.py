"""The schema of result.nc and sweep.nc: variables with their dimensions, units and meanings.

The schema is the table schema.csv in the folder of this module. The schema determines the files
that are written and read; `schema_table` returns it as text.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bladewhirl.files import packaged_rows

RESULT_NAME = "result.nc"
"""Name of the result file in the folder of a run."""

RESULT_FORMAT = 9
"""Current format of result.nc. Files of formats 1 and 2 contain no format number. A file of an
older format lacks variables with a higher number in the column "since"; coordinates,
`tip_recess` and `tip_growth`, and frequencies of waves are added when such a file is opened."""

SWEEP_FORMAT = 7
"""Current format of sweep.nc. A file of an older format lacks variables with a higher number in the
column "since"; formats 1 and 2 do not store swept values in the unit in which they were given. A
sweep of an older format can be read but not resumed."""

TIME = "time"

OPTIONAL_DIMENSIONS = frozenset(
    {"support", "rotor_link", "rotor_spring", "mass", "point", "triangle"}
)
"""Dimensions whose length may be zero. Their variables are then left out of a file, because netCDF
treats a dimension of length zero as unlimited."""


class Variable(NamedTuple):
    """Variable of a file."""

    dimensions: tuple[str, ...]  #: names of dimensions; swept keys precede them in a sweep
    kind: str  #: numpy dtype, or "str" for text
    units: str
    long_name: str
    since: int  #: first format of the file with this variable
    is_coordinate: bool  #: true if the values label the items along a dimension
    values: str
    """Allowed values: "positive", "not negative", "rotor_node" for numbers of nodes; "" for any."""
    labels: tuple[str, ...]
    """Names along a dimension, meanings of the numbers 0, 1, ..., or allowed texts."""

    @property
    def attributes(self) -> dict[str, str]:
        """Units and long name, as attributes of the variable."""
        return {"units": self.units, "long_name": self.long_name}


def _read(table: str) -> dict[str, Variable]:
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
        for row in packaged_rows(__package__, "schema.csv")
        if table in row["table"].split()
    }


class Tables(NamedTuple):
    """Variables of the results and the sweeps of one kind of model, by name."""

    history: Mapping[str, Variable]  #: recorded over time
    coating: Mapping[str, Variable]  #: of an abradable coating, if there is one
    stage: Mapping[str, Variable]  #: known before the march
    names: Mapping[str, Variable]  #: names or numbers along a dimension
    sweep: Mapping[str, Variable]  #: variables of sweep.nc, stored for every point of a sweep

    @property
    def result(self) -> dict[str, Variable]:
        """All variables of a result."""
        return {**self.history, **self.coating, **self.stage, **self.names}


PARTS = ("history", "coating", "stage", "index", "sweep")

BEAMS = Tables(*map(_read, PARTS))
"""Variables for stages of beams: `history` has the names of the fields of `Chunk`, `stage` those of
`StageArrays`."""

NODES = Tables(*(_read(f"node-{name}") for name in PARTS))
"""Variables for superelements."""

SCREENING: Mapping[str, Variable] = _read("screening")
"""Variables of sweep.nc if points are screened."""

MODEL, SUPERELEMENT = "model", "superelement"
"""Attribute of a result or a sweep with the kind of its model, and the value for a superelement."""


def tables_of(attributes: Mapping[str, Any]) -> Tables:
    """Return the variables of a result or a sweep with these attributes."""
    return NODES if attributes.get(MODEL) == SUPERELEMENT else BEAMS


def index_values(name: str, size: int) -> NDArray[np.int64] | NDArray[np.object_]:
    """Return the values of a variable of `Tables.names`: names, or numbers from 0 to size - 1."""
    labels = {**BEAMS.names, **NODES.names}[name].labels
    return np.array(labels, dtype=object) if labels else np.arange(size)


def schema_table(file: Mapping[str, Variable]) -> str:
    """Return a Markdown table with a row for each variable of a file, for the documentation.

    Args:
        file: `result` or `sweep` of `BEAMS` or `NODES`.
    """
    return "\n".join(_rows(file)) + "\n"


def _rows(file: Mapping[str, Variable]) -> Iterator[str]:
    yield "| variable | dimensions | units | kind | since format | meaning |"
    yield "|---|---|---|---|---|---|"
    for name, variable in file.items():
        meaning = ": ".join(filter(None, [variable.long_name, ", ".join(variable.labels)]))
        cells = (", ".join(variable.dimensions), variable.units, variable.kind, variable.since)
        yield f"| `{name}` | {' | '.join(map(str, cells))} | {meaning} |"

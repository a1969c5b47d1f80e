"""The schema of result.nc and sweep.nc: variables with their dimensions, units and meanings.

The schema is the table schema.csv in the folder of this module. The schema determines the files
that are written and read; `schema_table` returns it as text. `HISTORY` has the names of the fields
of `Chunk`, `STATIC` the names of the fields of `StageArrays`.
"""

import csv
from collections.abc import Iterator, Mapping
from importlib import resources
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

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
        if table in row["table"].split()
    }


HISTORY: Mapping[str, Variable] = _read("history")
"""Variables of result.nc that are recorded over time."""

STATIC: Mapping[str, Variable] = _read("stage")
"""Variables of result.nc that are known before the march."""

COATING: Mapping[str, Variable] = _read("coating")
"""Variables of result.nc if the casing has a coating."""

INDICES: Mapping[str, Variable] = _read("index")
"""Variables of result.nc with names or numbers along a dimension."""

NODE_HISTORY: Mapping[str, Variable] = _read("node-history")
"""Variables of the result of a superelement that are recorded over time."""

NODE_STATIC: Mapping[str, Variable] = _read("node-stage")
"""Variables of the result of a superelement that are known before the march."""

NODE_COATING: Mapping[str, Variable] = _read("node-coating")
"""Variables of the result of a superelement if the wall has a coating."""

NODE_INDICES: Mapping[str, Variable] = _read("node-index")
"""Names along the dimensions of the result of a superelement."""

NODE_RESULT: Mapping[str, Variable] = {
    **NODE_HISTORY,
    **NODE_COATING,
    **NODE_STATIC,
    **NODE_INDICES,
}
"""All variables of the result of a superelement."""

RESULT: Mapping[str, Variable] = {**HISTORY, **COATING, **STATIC, **INDICES}
"""All variables of result.nc."""

SWEEP: Mapping[str, Variable] = _read("sweep")
"""Variables of sweep.nc, which are stored for every point of a sweep."""

NODE_SWEEP: Mapping[str, Variable] = _read("node-sweep")
"""Variables of sweep.nc for every point of a sweep of a superelement."""

SCREENING: Mapping[str, Variable] = _read("screening")
"""Variables of sweep.nc if points are screened."""

MODEL, SUPERELEMENT = "model", "superelement"
"""Attribute of a result or a sweep with the kind of its model, and the value for a superelement."""


class Tables(NamedTuple):
    """Variables of the results and the sweeps of one kind of model."""

    history: Mapping[str, Variable]
    stage: Mapping[str, Variable]
    names: Mapping[str, Variable]
    coating: Mapping[str, Variable]
    sweep: Mapping[str, Variable]


BEAMS = Tables(HISTORY, STATIC, INDICES, COATING, SWEEP)
NODES = Tables(NODE_HISTORY, NODE_STATIC, NODE_INDICES, NODE_COATING, NODE_SWEEP)


def tables_of(attributes: Mapping[str, Any]) -> Tables:
    """Return the variables of a result or a sweep with these attributes."""
    return NODES if attributes.get(MODEL) == SUPERELEMENT else BEAMS


def index_values(name: str, size: int) -> NDArray[np.int64] | NDArray[np.object_]:
    """Return the values of a variable of `INDICES`: names, or numbers from 0 to size - 1."""
    labels = {**INDICES, **NODE_INDICES}[name].labels
    return np.array(labels, dtype=object) if labels else np.arange(size)


def schema_table(file: Mapping[str, Variable]) -> str:
    """Return a Markdown table with a row for each variable of a file, for the documentation.

    Args:
        file: `RESULT`, `NODE_RESULT`, `SWEEP` or `NODE_SWEEP`.
    """
    return "\n".join(_rows(file)) + "\n"


def _rows(file: Mapping[str, Variable]) -> Iterator[str]:
    yield "| variable | dimensions | units | kind | since format | meaning |"
    yield "|---|---|---|---|---|---|"
    for name, variable in file.items():
        meaning = ": ".join(filter(None, [variable.long_name, ", ".join(variable.labels)]))
        cells = (", ".join(variable.dimensions), variable.units, variable.kind, variable.since)
        yield f"| `{name}` | {' | '.join(map(str, cells))} | {meaning} |"

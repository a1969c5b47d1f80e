"""The schema of results, sweeps and summaries: names, dimensions, units and meanings.

The schema is the table schema.csv in the folder of this module. The schema determines the files
that are written and read; `schema_table` returns it as text.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bladewhirl.files import packaged_rows

RESULT_NAME = "result.nc"
"""Name of the result file in the folder of a run."""

RESULT_FORMAT = 16
"""Current format of result.nc. A file of an older format lacks variables with a higher number in
the column "since". Results before format 10, and before format 15 of 3D blades at a varying speed,
whose motion lacked a load, are refused."""

SWEEP_FORMAT = 10
"""Current format of sweep.nc. A file of an older format lacks variables with a higher number in the
column "since"; formats 1 and 2 do not store swept values in the unit in which they were given. A
sweep of an older format can be read but not resumed, that of a superelement before format 8 cannot
be read."""

TIME = "time"

DRAW, POINT = "draw", "point"
"""Names of the dimensions of the random draws of each point of a sweep, and of the points of its
table."""

OPTIONAL_DIMENSIONS = frozenset(
    {"support", "rotor_link", "rotor_spring", "mass", "point", "triangle", "further_triangle"}
)
"""Dimensions whose length may be zero. Their variables are then left out of a file, because netCDF
treats a dimension of length zero as unlimited."""


OF_WHEEL = frozenset({"contact_node", "wall_angle"})
"""Dimensions that a shaft line without a wheel does not have; the variables along them are left out
of its file."""


class Variable(NamedTuple):
    """Variable of a file."""

    dimensions: tuple[str, ...]  #: names of dimensions; swept keys precede them in a sweep
    kind: str  #: numpy dtype, or "str" for text
    units: str
    long_name: str
    since: int  #: first format of the file with this variable
    is_coordinate: bool  #: true if the values label the items along a dimension
    part: str
    """Part of a stage that has the variable: "families" of modes, "lines" of a mesh of beams,
    motion of the "centre", its "springs", "growth" of the tips, contact "nodes" whose motion is
    recorded, "points" for pictures, "gauges", "stress" at points, "waves" and "waves of stress" of
    equal sectors, from which the shapes of all points follow, a flexible "casing", a "coating",
    several "wheels" with walls, "rings" around them, "further wheels" of a shaft line and their
    "further points", a "speed" that varies, "critical" speeds in its range, a known "inertia" of
    the rotation, the "drive" of a free speed, sudden "changes", a shaft "line" and its "wheel",
    friction "joints", "dampers" in them; "" for all."""
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
            part=row["part"],
            values=row["values"],
            labels=tuple(row["labels"].split()),
        )
        for row in packaged_rows(__package__, "schema.csv")
        if table in row["table"].split()
    }


HISTORY: Mapping[str, Variable] = _read("history")
"""Variables of result.nc that are recorded over time, named as the fields of `Chunk`."""

COATING: Mapping[str, Variable] = _read("coating")
"""Variables of result.nc of an abradable coating, if there is one, named as the fields of
`CoatingRecords`."""

STAGE: Mapping[str, Variable] = _read("stage")
"""Variables of result.nc that are known before the march, named as the fields of `StageArrays`."""

NAMES: Mapping[str, Variable] = _read("index")
"""Variables of result.nc with names or numbers along a dimension."""

RESULT: Mapping[str, Variable] = {**HISTORY, **COATING, **STAGE, **NAMES}
"""All variables of result.nc."""

SWEEP: Mapping[str, Variable] = _read("sweep")
"""Variables of sweep.nc, stored for every point of a sweep."""

SCREENING: Mapping[str, Variable] = _read("screening")
"""Variables of sweep.nc if points are screened."""

SUMMARY: Mapping[str, Variable] = _read("summary")
"""Measures of a run in its summary, named as the fields of `Summary`; a "table" has several."""

CONVERGENCE: Mapping[str, Variable] = _read("convergence")
"""Measures of a run in a study of convergence."""


_PARTS = {name: each.part for name, each in {**SWEEP, **COATING, **STAGE}.items()}


def parts_of(names: Iterable[str]) -> set[str]:
    """Return the parts, see `Variable.part`, of a stage whose result or sweep has these names."""
    return {_PARTS[name] for name in names if name in _PARTS} | {""}


def index_values(name: str, size: int) -> NDArray[np.int64] | NDArray[np.object_]:
    """Return the values of a variable of `NAMES`: names, or numbers from 0 to size - 1."""
    labels = NAMES[name].labels if name in NAMES else ()
    return np.array(labels, dtype=object) if labels else np.arange(size)


def schema_table(file: Mapping[str, Variable]) -> str:
    """Return a Markdown table with a row for each variable of a file, for the documentation.

    Args:
        file: `RESULT`, `SWEEP` or `SUMMARY`.
    """
    return "\n".join(_rows(file)) + "\n"


def _rows(file: Mapping[str, Variable]) -> Iterator[str]:
    yield "| variable | part | dimensions | units | kind | since format | meaning |"
    yield "|---|---|---|---|---|---|---|"
    for name, variable in file.items():
        meaning = ": ".join(filter(None, [variable.long_name, ", ".join(variable.labels)]))
        over = ", ".join(variable.dimensions)
        cells = (variable.part, over, variable.units, variable.kind, variable.since)
        yield f"| `{name}` | {' | '.join(map(str, cells))} | {meaning} |"

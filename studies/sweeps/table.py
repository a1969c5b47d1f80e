"""Tables of the points of a sweep: a CSV file, a DataFrame, or a mapping of columns."""

import csv
import re
from collections.abc import Hashable, Iterable, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from bladewhirl.files import csv_rows
from bladewhirl.models.inputs.errors import UserError, shown
from bladewhirl.studies.sweeps.axes import NUMBER, PointTable, Value, case_value

_HEAD = re.compile(r"\s*([\w.-]+)\s*(?:\[\s*([^\]]+?)\s*\])?\s*")


class Columns(Protocol):
    """Columns by name, "casing.clearance [mm]": a mapping, or a DataFrame of pandas."""

    def items(self) -> Iterable[tuple[Hashable, Iterable[Any]]]:
        """Return names and values of the columns."""


def point_table(table: str | Path | Columns) -> PointTable:
    """Return the points of a CSV file, given by its path, or of columns by name.

    The name of a column is a key of the case, with a unit if the values are numbers in this unit:
    "casing.clearance [mm]". A CSV file has the names in its first line, and a point in every other
    line. Values of columns may also be text with a unit, "0.5 mm".

    Raises:
        UserError: the file cannot be read, rows or columns differ in length, a name occurs twice or
            is not of this form, a value is not a number, or the units of a column differ. The
            message names the file, the line and the column.
    """
    if isinstance(table, str | Path):
        head, cells, rows = _read(Path(table))
        source = f"{table}, line 1,"
    else:
        head = [str(name) for name, _ in table.items()]
        columns = [list(column) for _, column in table.items()]
        source = "table,"
        if len({len(column) for column in columns}) > 1:
            lengths = ", ".join(str(len(column)) for column in columns)
            raise UserError(f"{source} expected columns of equal length, not of {lengths} values")
        cells = list(zip(*columns, strict=True))
        rows = [f"table, row {number}," for number in range(len(cells))]
    if not head or not cells:
        raise UserError(f"{source} expected at least one key and one point")
    values: dict[str, tuple[Value, ...]] = {}
    for column, name in enumerate(head):
        match = _HEAD.fullmatch(name)
        if match is None:
            raise UserError(
                f'{source} column "{name}": expected a key of the case, with its unit in brackets'
                " if the values have one, such as casing.clearance [mm]"
            )
        if match[1] in values:
            raise UserError(f'{source} column "{name}": expected each key at most once')
        numbers = [
            _number(cell[column], match[2], f"{row} {match[1]} = {shown(cell[column])}")
            for row, cell in zip(rows, cells, strict=True)
        ]
        units = sorted({unit for _, unit in numbers})
        if len(units) > 1:
            raise UserError(f"{source} {match[1]}: expected one unit, not {units}")
        values[match[1]] = tuple(case_value(number, unit) for number, unit in numbers)
    return PointTable(values=values, head=source, rows=tuple(rows))


def _read(path: Path) -> tuple[list[str], list[Sequence[Any]], list[str]]:
    """Return the first line of a CSV file, its other lines, and their names for messages; empty
    lines are skipped."""
    try:
        lines = [(number, cells) for number, cells in csv_rows(path) if cells]
    except OSError as error:
        raise UserError(f"{path}: expected a readable file ({error.strerror})") from None
    except (ValueError, csv.Error) as error:
        raise UserError(f"{path}: expected a table as CSV, in UTF-8 ({error})") from None
    if not lines:
        raise UserError(f"{path}: expected a first line of keys, and a line for each point")
    (_, head), *rest = lines
    for number, cells in rest:
        if len(cells) != len(head):
            raise UserError(
                f"{path}, line {number}: expected {len(head)} values, one for each key in line 1,"
                f" not {len(cells)}"
            )
    return head, [cells for _, cells in rest], [f"{path}, line {number}," for number, _ in rest]


def _number(cell: Any, unit: str | None, place: str) -> tuple[Decimal, str]:
    """Return number and unit of a value; `place` names the value in the error."""
    text = str(cell.item() if isinstance(cell, np.generic) else cell)
    match = NUMBER.fullmatch(text)
    if match is None or (unit and match[2]):
        expected = f"a number in {unit}, as line 1 says" if unit else "a number"
        raise UserError(f"{place}: expected {expected}")
    return Decimal(match[1]), unit or match[2] or ""

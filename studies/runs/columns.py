"""Columns: each describes a value in Datasets, JSON documents and printed tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from rich.table import Table


@dataclass(frozen=True)
class Column:
    """Value of a row or a document: its variable, its key in JSON, its heading and format."""

    key: str  #: key in JSON; dots separate keys of nested tables
    heading: str = ""  #: heading with the unit; empty if the value is in JSON only
    form: str = ""  #: format specification of a number, such as ".4g"
    scale: float = 1.0  #: factor from the SI value to the unit of the heading
    variable: str = ""  #: variable of the Dataset, if its name is not the key

    def value(self, row: Mapping[str, Any]) -> Any:
        """Return the value in a row; None if it is missing."""
        value: Any = row
        for part in self.key.split("."):
            value = value.get(part) if isinstance(value, Mapping) else None
        return value

    def text(self, row: Mapping[str, Any]) -> str:
        """Return the text of a cell of a row: a dash for a missing value, "yes" or nothing for a
        flag."""
        return self._text(self.value(row))

    def _text(self, value: Any) -> str:
        if value is None or value != value:  # NaN
            return "–"
        if isinstance(value, bool):
            return "yes" if value else ""
        if isinstance(value, str):
            return value
        if isinstance(value, Mapping):
            return ", ".join(f"{name} {self._text(item)}" for name, item in value.items())
        if isinstance(value, Sequence):
            return ", ".join(map(self._text, value))
        return format(value if self.scale == 1.0 else self.scale * value, self.form)


def texts(document: Mapping[str, Any], columns: Sequence[Column]) -> dict[str, str]:
    """Return the texts of values by heading; values that the document lacks are left out."""
    present = [column for column in columns if column.value(document) is not None]
    return {column.heading: column.text(document) for column in present}


def table(rows: Iterable[Mapping[str, Any]], columns: Sequence[Column], title: str = "") -> Table:
    """Return a table with a line for each row; columns without a heading are left out.

    On a narrow terminal, headings and texts of the first column break between words; numbers do
    not break, and nothing is cut.
    """
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    printed = Table(
        title=escape(title) or None,
        box=box.SIMPLE_HEAD,
        title_justify="left",
        title_style="bold",
        pad_edge=False,
        collapse_padding=True,
    )
    columns = [column for column in columns if column.heading]
    cells = [[column.text(row) for column in columns] for row in rows]
    for place, column in enumerate(columns):
        whole = [*column.heading.split(), *(row[place] for row in cells if place)]
        justify: Literal["left", "right"] = "right" if column.form else "left"
        width = max(map(len, whole), default=1)
        printed.add_column(escape(column.heading), justify=justify, min_width=width)
    for row in cells:
        printed.add_row(*map(escape, row))
    return printed


def facts(values: Mapping[str, str]) -> Table:
    """Return a table of names and values without headings, in which the regime is bold."""
    from rich.markup import escape
    from rich.table import Table

    printed = Table(show_header=False, box=None, pad_edge=False)
    printed.add_column(style="cyan", no_wrap=True)
    printed.add_column(overflow="fold")
    for name, value in values.items():
        text = escape(value)
        printed.add_row(escape(name), f"[bold]{text}[/]" if name == "regime" else text)
    return printed


def rows_of(
    data: xr.Dataset | Mapping[str, np.ndarray[Any, Any]],
    columns: Sequence[Column],
    prefix: str = "",
) -> list[dict[str, Any]]:
    """Return variables over one dimension as rows; missing values (NaN) are None.

    Args:
        data: Dataset, or arrays by name, with the variables.
        columns: columns of the rows.
        prefix: prefix of the names of the variables.
    """
    names = [f"{prefix}{column.variable or column.key}" for column in columns]
    arrays = (getattr(data[name], "values", data[name]) for name in names)
    values = zip(*(each.tolist() for each in arrays), strict=True)
    keys = [column.key for column in columns]
    rows = (dict(zip(keys, row, strict=True)) for row in values)
    return [{key: v if v == v else None for key, v in row.items()} for row in rows]


def quantity(
    dims: str | tuple[str, ...], values: Any, unit: str, name: str = ""
) -> tuple[str | tuple[str, ...], Any, dict[str, str]]:
    """Return a variable of a Dataset with a unit and, if `name` is not empty, a long name."""
    return dims, values, {"units": unit} | ({"long_name": name} if name else {})

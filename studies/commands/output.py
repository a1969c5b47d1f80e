"""Output of the commands: one JSON document, or tables and lines."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from bladewhirl.studies.modal.columns import Column

if TYPE_CHECKING:
    from rich.table import Table


def table(rows: Iterable[Mapping[str, Any]], columns: Sequence[Column], title: str = "") -> Table:
    """Return a table with a line for each row; columns without a heading are left out."""
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
    for place, column in enumerate(columns):
        printed.add_column(
            escape(column.heading), justify="right" if column.form else "left", no_wrap=place > 0
        )
    for row in rows:
        printed.add_row(*(escape(column.text(row)) for column in columns))
    return printed


def facts(values: Mapping[str, str]) -> Table:
    """Return a table of names and values without headings."""
    from rich.markup import escape
    from rich.table import Table

    printed = Table(show_header=False, box=None, pad_edge=False)
    printed.add_column(style="cyan", no_wrap=True)
    printed.add_column(overflow="fold")
    for name, value in values.items():
        printed.add_row(escape(name), escape(value))
    return printed


def emit(
    document: Any, *parts: Table | str, json: bool, written: Sequence[Path | None] = ()
) -> None:
    """Print one JSON document, or tables and lines; then the names of written files.

    Args:
        document: document printed with --json. It must not contain NaN.
        parts: tables and lines printed without --json.
        json: whether --json is set.
        written: written files and folders, or None; with --json the names are printed on standard
            error.
    """
    from json import dumps

    from rich.console import Console

    if json:
        typer.echo(dumps(document, indent=2, allow_nan=False, ensure_ascii=False))
        parts = ()
    for part in parts:
        if isinstance(part, str):
            typer.echo(part)
        else:
            Console().print(part)
    for path in written:
        if path is not None:
            typer.echo(f"Wrote {path}.", err=json)

"""`bladewhirl new`: write a commented case file to start from."""

from pathlib import Path
from typing import Annotated

import typer

from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.studies.commands import options


def new(
    path: Annotated[Path, typer.Argument(help="File to write.")] = Path("case.toml"),
    force: options.Force = False,
) -> None:
    """Write a case file with every key, its default and its meaning."""
    from bladewhirl.files import write_atomically
    from bladewhirl.models.case.template import template

    if path.exists() and not force:
        raise UserError(f"{path}: already exists; --force overwrites it")
    with writing(path):
        path.parent.stat()  # an error if the folder does not exist
        write_atomically(path, template())
    typer.echo(f"Wrote {path}.")

"""Command line: registers the commands.

Each command is a function in a module of the same name. When such a module is imported, it may
import the standard library and typer only; the command imports other modules when it runs. Thus
``bladewhirl --help`` answers at once.
"""

import gc
import os
import warnings
from importlib import metadata
from typing import Annotated

import typer

from bladewhirl.models.inputs.errors import Hint
from bladewhirl.studies.commands.campbell import campbell
from bladewhirl.studies.commands.compare import compare
from bladewhirl.studies.commands.convergence import convergence
from bladewhirl.studies.commands.critical_speeds import critical_speeds
from bladewhirl.studies.commands.exits import UserErrorGroup, robust_output
from bladewhirl.studies.commands.export import export
from bladewhirl.studies.commands.import_ import import_
from bladewhirl.studies.commands.interaction import interaction
from bladewhirl.studies.commands.mesh import mesh
from bladewhirl.studies.commands.modes import modes
from bladewhirl.studies.commands.new import new
from bladewhirl.studies.commands.plot import plot
from bladewhirl.studies.commands.render import render
from bladewhirl.studies.commands.report import report
from bladewhirl.studies.commands.reproduce import reproduce
from bladewhirl.studies.commands.response import response
from bladewhirl.studies.commands.run import run
from bladewhirl.studies.commands.show import show
from bladewhirl.studies.commands.stability import stability
from bladewhirl.studies.commands.sweep import sweep
from bladewhirl.studies.commands.veering import veering
from bladewhirl.studies.commands.verify import verify

app = typer.Typer(
    name="bladewhirl",
    cls=UserErrorGroup,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


for command in (
    *(campbell, compare, convergence, critical_speeds, export, import_, interaction, mesh, modes),
    *(new, plot, render, report, reproduce, response, run, show, stability, sweep, veering, verify),
):
    # The terminal wraps each paragraph.
    paragraphs = (command.__doc__ or "").split("\n\n")
    name = command.__name__.strip("_").replace("_", "-")
    app.command(name, help="\n\n".join(" ".join(part.split()) for part in paragraphs))(command)


def _print_version(version: bool) -> None:
    if version:
        typer.echo(f"bladewhirl {metadata.version('bladewhirl')}")
        raise typer.Exit


@app.callback()
def bladewhirl(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    """Whirl of bladed disks in contact with flexible casings."""


GARBAGE_THRESHOLD = 50_000
"""Number of new objects between collections of cyclic garbage. With Python's default, 700,
collections take a tenth of the time of a short run, and free little."""


def main() -> None:
    """Entry point of the command ``bladewhirl``."""
    # Matrices of one sector are small: on a busy computer threads make their products wait for
    # each other, twenty times as long as one thread needs. This must precede the import of NumPy.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(GARBAGE_THRESHOLD)
    warnings.simplefilter("ignore", Hint)  # commands print hints themselves
    with robust_output():
        app()

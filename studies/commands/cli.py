"""Command line: registers the commands.

A command is a function. The section "Args" of its docstring describes its parameters in `--help`,
unless an option that several commands have, from `options`, has a description of its own. When a
module with commands is imported, it may import the standard library and typer only; a command
imports other modules when it runs. Thus ``bladewhirl --help`` answers at once.
"""

import gc
import re
import signal
import sys
import warnings
from importlib import metadata
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from bladewhirl.models.inputs.errors import Hint
from bladewhirl.studies.commands.checks import reproduce, verify
from bladewhirl.studies.commands.inputs import import_, mesh, new
from bladewhirl.studies.commands.marches import convergence, run
from bladewhirl.studies.commands.modal import (
    campbell,
    critical_speeds,
    modes,
    response,
    stability,
    veering,
)
from bladewhirl.studies.commands.periodic import periodic
from bladewhirl.studies.commands.render import render
from bladewhirl.studies.commands.results import export, plot, report
from bladewhirl.studies.commands.show import show
from bladewhirl.studies.commands.solids import mesh3d
from bladewhirl.studies.commands.sweep import sweep
from bladewhirl.studies.commands.terminal import UserErrorGroup, robust_output

app = typer.Typer(
    name="bladewhirl",
    cls=UserErrorGroup,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


class DocumentedCommand(TyperCommand):
    """Command described by the docstring of its function."""

    def __init__(self, *args: Any, **options: Any) -> None:
        """Take the help of the command and of its parameters from the docstring."""
        super().__init__(*args, **options)
        documented = re.sub(r"\[(?=[a-z])", r"\\[", self.help or "")  # typer reads [name] as markup
        text, _, arguments = documented.partition("\n\nArgs:\n")
        # The terminal wraps each paragraph.
        self.help = "\n\n".join(" ".join(part.split()) for part in text.split("\n\n"))
        parameters = {parameter.name: parameter for parameter in self.params}
        for name, words in re.findall(r"^ {4}(\w+): (.+(?:\n {8}.+)*)", arguments, re.MULTILINE):
            parameters[name].help = " ".join(words.split())  # type: ignore[attr-defined]


for command in (
    *(campbell, convergence, critical_speeds, export, import_, mesh, mesh3d, modes),
    *(
        new,
        periodic,
        plot,
        render,
        report,
        reproduce,
        response,
        run,
        show,
        stability,
        sweep,
        veering,
        verify,
    ),
):
    name = command.__name__.strip("_").replace("_", "-")
    app.command(name, cls=DocumentedCommand)(command)


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


def _interrupt(number: int, frame: Any) -> None:
    """End a command after SIGTERM as after Ctrl-C, which a command in the background ignores."""
    handler = signal.getsignal(signal.SIGINT)
    ignored = not callable(handler)
    signal.default_int_handler(number, frame) if ignored else signal.raise_signal(signal.SIGINT)


GARBAGE_THRESHOLD = 50_000
"""Number of new objects between collections of cyclic garbage. With Python's default, 700,
collections take a tenth of the time of a short run, and free little."""


def main() -> None:
    """Entry point of the command ``bladewhirl``."""
    gc.set_threshold(GARBAGE_THRESHOLD)
    if not any(each.startswith("--scheduler") for each in sys.argv):
        absent: Any = None  # as Python marks a module that cannot be imported
        sys.modules["dask"] = absent  # xarray loads it where it is installed, which takes long
    warnings.simplefilter("ignore", Hint)  # commands print hints themselves
    signal.signal(signal.SIGTERM, _interrupt)
    with robust_output():
        app()

"""`bladewhirl plot`: figures of a run or a sweep, by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from bladewhirl.postprocess.plotting.registry import (
    NODE_FIGURES,
    REPLACED,
    RUN_FIGURES,
    SWEEP_FIGURES,
    FigureKind,
    captions,
)
from bladewhirl.studies.commands import options

if TYPE_CHECKING:
    from bladewhirl.postprocess.reports.figures import AnyFigures
    from bladewhirl.postprocess.sweep.figures import SweepFigures

ALL = "all"
PLOTS = "plots"
"""Name of the folder of figures in the folder of the run or the sweep."""


def plot(
    directory: Annotated[
        Path,
        typer.Argument(
            metavar="DIR", help="Folder of a run or a sweep, or its result.nc or sweep.nc."
        ),
    ],
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME",
            # Rich would interpret brackets as markup.
            help="\n\n".join(
                [
                    "Names of figures, or all. Figures of a run:",
                    *captions(RUN_FIGURES),
                    "Figures of a sweep:",
                    *captions(SWEEP_FIGURES),
                    "Figures of a run of a superelement:",
                    *captions(NODE_FIGURES),
                ]
            ).replace("[", r"\["),
            show_default=False,
        ),
    ] = None,
    start: options.Start = None,
    end: options.End = None,
    output: Annotated[
        Path | None, options.output(f"Folder for the figures; by default DIR/{PLOTS}.")
    ] = None,
    format_name: Annotated[
        Literal["png", "pdf", "svg"] | None,
        typer.Option("--format", help="Format of the pictures. By default both png and pdf."),
    ] = None,
    width: Annotated[
        float | None,
        typer.Option(
            metavar="MM",
            min=40,
            max=500,
            help="Width of a figure [mm]: 85 for a column, 170 for a page.",
        ),
    ] = None,
    title: Annotated[
        str | None, typer.Option(help='Another title of the figure; "" for no title.')
    ] = None,
    overwrite: options.Replace = False,
) -> None:
    """Draw figures of a run or a sweep, with the data of each figure as netCDF.

    Without a NAME the available figures are listed. Without a time window, spectrum and
    contact-classes of a run show the last third of the time.
    """
    from bladewhirl.models.inputs.errors import UserError
    from bladewhirl.postprocess.fields.kinematics import ViewError
    from bladewhirl.postprocess.plotting.style import FORMATS
    from bladewhirl.postprocess.plotting.titles import refit
    from bladewhirl.studies.runs.figures_folder import save_figures

    of_sweep = _is_sweep(directory)
    figure_names = SWEEP_FIGURES if of_sweep else _figures_of_run(directory)
    if not names:
        typer.echo("\n".join(captions(figure_names)))
        return
    unknown = [name for name in names if name not in (*figure_names, ALL)]
    for name in unknown:
        if REPLACED.get(name) in figure_names:
            raise UserError(f"{name}: expected {REPLACED[name]}, which replaces it")
    if unknown:
        of_nodes = "of a superelement " if figure_names is NODE_FIGURES else ""
        kind = "a sweep has" if of_sweep else f"a run {of_nodes}has"
        raise UserError(
            f"{', '.join(unknown)}: {kind} the figures {', '.join(figure_names)}; or {ALL}"
        )
    if of_sweep and (start is not None or end is not None):
        raise UserError(f"{directory}: omit --from and --to, because a sweep has no time window")
    folder = output or (directory if directory.is_dir() else directory.parent) / PLOTS
    formats = [format_name] if format_name else FORMATS
    with _opened(directory, start, end) as figures:
        left_out: dict[str, list[str]] = {}
        for name in figures.names if ALL in names else dict.fromkeys(names):
            try:
                figure, drawn = figures.draw(name)
            except ViewError as error:
                if ALL not in names:
                    raise
                left_out.setdefault(str(error), []).append(name)
                continue
            refit(figure, title=title, width=width and width / 1000)
            save_figures(folder, {name: (figure, drawn)}, overwrite=overwrite, formats=formats)
            typer.echo(f"Wrote {folder / name}.{', .'.join(formats)} and .nc.")
        for reason, figures_without in left_out.items():
            typer.echo(f"{', '.join(figures_without)} left out: {reason}", err=True)


@contextmanager
def _opened(
    directory: Path, start: float | None, end: float | None
) -> Iterator[AnyFigures | SweepFigures]:
    """Yield the figures of a run or of a sweep; modules for the other kind are not loaded."""
    if _is_sweep(directory):
        from bladewhirl.postprocess.sweep.dataset import open_sweep
        from bladewhirl.postprocess.sweep.figures import SweepFigures

        with open_sweep(directory) as sweep:
            yield SweepFigures(sweep)
        return
    from bladewhirl.postprocess.fields.result import open_result
    from bladewhirl.postprocess.reports.figures import figures_of_run

    with open_result(directory) as result:
        yield figures_of_run(result, start, end)


def _figures_of_run(directory: Path) -> Mapping[str, FigureKind]:
    """Return the figures of a run of beams or of a superelement."""
    from bladewhirl.postprocess.fields.result import open_result
    from bladewhirl.solvers.march.schema import NODES, tables_of

    with open_result(directory) as result:
        return NODE_FIGURES if tables_of(result.attrs) is NODES else RUN_FIGURES


def _is_sweep(path: Path) -> bool:
    """Return whether a path is the folder of a sweep, or the file of its dataset."""
    from bladewhirl.postprocess.sweep.dataset import SWEEP_NAME

    return (path / SWEEP_NAME).is_file() if path.is_dir() else path.name == SWEEP_NAME

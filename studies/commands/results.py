"""Commands that draw and export results: figures, reports, series for ParaView."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.postprocess.plotting.registry import (
    BRANCH_FIGURES,
    REPLACED,
    RUN_FIGURES,
    SWEEP_FIGURES,
    FigureKind,
    captions,
)
from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.terminal import progress_bar

if TYPE_CHECKING:
    from bladewhirl.postprocess.plotting.figures import Figures

ALL = "all"
PLOTS, VTK = "plots", "vtk"
"""Names of the folders of figures and of the series in the folder of a run or a sweep."""


def plot(
    directory: options.Folder,
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
                    "Figures of a branch of periodic motions:",
                    *captions(BRANCH_FIGURES),
                ]
            ).replace("[", r"\["),
            show_default=False,
        ),
    ] = None,
    start: options.Start = None,
    end: options.End = None,
    others: Annotated[list[Path] | None, typer.Option("--with", metavar="DIR")] = None,
    output: options.Output = None,
    format_name: Annotated[
        Literal["png", "pdf", "svg", "html"] | None, typer.Option("--format")
    ] = None,
    width: Annotated[float | None, typer.Option(metavar="MM", min=40, max=500)] = None,
    title: str | None = None,
    overwrite: options.Replace = False,
) -> None:
    """Draw figures of a run, a sweep, or a branch of `bladewhirl periodic --over`, with the data of
    each figure as netCDF.

    Without a NAME the available figures are listed. If figures of several NAMEs cannot be drawn,
    the others are drawn first. Without a time window, spectrum and
    contact-classes of a run show the last third of the time.

    Args:
        directory: Folder of a run, a sweep or a branch, or its result.nc, sweep.nc or branch.nc.
        others: Folder to lay over the figures; may be given several times. A sweep over the key of
            a branch gives points over the figure branch, further branches give the figure
            backbone, and branches over one of the two keys of a sweep are lines in its maps.
        output: Folder for the figures; by default DIR/plots.
        format_name: Format of the pictures, png by default; html is a page that states the values
            under the pointer.
        width: Width of a figure [mm]: 85 for a column, 170 for a page.
        title: Another title of the figure; "" for no title.
    """
    from bladewhirl.postprocess.fields.kinematics import ViewError
    from bladewhirl.postprocess.plotting.style import FORMATS, at_width
    from bladewhirl.postprocess.plotting.titles import retitle
    from bladewhirl.studies.runs.figures_folder import save_figures

    formats = [format_name] if format_name else FORMATS
    folder = output or (directory if directory.is_dir() else directory.parent) / PLOTS
    with _opened(directory, start, end, others or []) as (kinds, figures):
        if not names:
            typer.echo("\n".join(captions(figures.kinds)))
            return
        unknown = [*_unknown(names, kinds)]
        left_out: dict[str, list[str]] = {}
        for name in figures.names if ALL in names else dict.fromkeys(names):
            try:
                if name not in kinds:
                    continue
                with at_width(width and width / 1000):
                    figure, drawn = figures.draw(name)
            except ViewError as error:
                if names == [name]:
                    raise
                left_out.setdefault(str(error), []).append(name)
                continue
            if title is not None:
                retitle(figure, title)
            save_figures(folder, {name: (figure, drawn)}, overwrite=overwrite, formats=formats)
            typer.echo(f"Wrote {folder / name}.{', .'.join(formats)} and .nc.")
    lines = [f"{', '.join(each)} left out: {reason}" for reason, each in left_out.items()]
    if unknown or (lines and ALL not in names):
        raise UserError(*unknown, *lines)
    for line in lines:
        typer.echo(line, err=True)


def _unknown(names: Sequence[str], kinds: Mapping[str, FigureKind]) -> Iterator[str]:
    """Yield an error for each replaced figure, and one for all names of which there is none."""
    unknown = [name for name in names if name not in (*kinds, ALL)]
    for name in [name for name in unknown if REPLACED.get(name) in kinds]:
        unknown.remove(name)
        yield f"{name}: expected {REPLACED[name]}, which replaces it"
    if unknown:
        kind = "a sweep has" if kinds is SWEEP_FIGURES else "a run has"
        kind = "a branch has" if kinds is BRANCH_FIGURES else kind
        yield f"{', '.join(unknown)}: {kind} the figures {', '.join(kinds)}; or {ALL}"


@contextmanager
def _opened(
    directory: Path, start: float | None, end: float | None, others: Sequence[Path]
) -> Iterator[tuple[Mapping[str, FigureKind], Figures]]:
    """Yield the registry and the figures of a run, a sweep or a branch, with other sweeps or
    branches laid over them; modules for the other kinds are not loaded."""
    from bladewhirl.postprocess.periodic.dataset import BRANCH_NAME, open_branch
    from bladewhirl.postprocess.sweep.dataset import SWEEP_NAME, open_sweep

    of_sweep, of_branch = (_holds(directory, name) for name in (SWEEP_NAME, BRANCH_NAME))
    if (of_sweep or of_branch) and (start is not None or end is not None):
        kind = "sweep" if of_sweep else "branch"
        raise UserError(f"{directory}: omit --from and --to, because a {kind} has no time window")
    with ExitStack() as stack:
        laid = [
            stack.enter_context(open_sweep(each)) if _holds(each, SWEEP_NAME) else open_branch(each)
            for each in others
        ]
        if of_sweep:
            from bladewhirl.postprocess.sweep.figures import SweepFigures

            sweep = stack.enter_context(open_sweep(directory))
            yield SWEEP_FIGURES, SweepFigures(sweep, laid)
        elif of_branch:
            from bladewhirl.postprocess.periodic.figures import BranchFigures

            yield BRANCH_FIGURES, BranchFigures(open_branch(directory), laid)
        elif others:
            raise UserError(f"{directory}: omit --with, which sweeps and branches have, not runs")
        else:
            from bladewhirl.postprocess.fields.result import open_result
            from bladewhirl.postprocess.run.figures import RunFigures

            result = stack.enter_context(open_result(directory))
            yield RUN_FIGURES, RunFigures(result, start, end)


def _holds(directory: Path, name: str) -> bool:
    """Return whether a path is a folder with a file of this name, or such a file."""
    return (directory / name).is_file() if directory.is_dir() else directory.name == name


def export(
    directory: options.RunFolder,
    frames: options.Number = 300,
    start: options.Start = None,
    end: options.End = None,
    surface: Annotated[bool, typer.Option("--surface")] = False,
    rotating: options.Rotating = False,
    exaggeration: float | None = None,
    output: options.Output = None,
    overwrite: options.Replace = False,
) -> None:
    """Write a series for ParaView: run its view.py, or open series.pvd and apply Warp By Vector.

    The parts are rotor, casing, contact, and if there are any coating and supports. Warp By Vector
    with warp and factor 1 shows the stage as bladewhirl render does. Fields: displacement,
    deformation, velocity, radial_displacement, gap; of beams and wall axial and bending strain and
    stress, of superelements von_mises_stress; wear, remaining_thickness; contact_force (for Glyph).
    An earlier series that bladewhirl wrote into the folder is replaced.

    Args:
        frames: Number of instants, evenly spaced.
        surface: Write beams as boxes of true thickness and width instead of lines.
        exaggeration: Factor on displacement and clearance in the field warp; automatic by default.
        output: Folder to write; by default DIR/vtk.
    """
    from bladewhirl.files import owned
    from bladewhirl.postprocess.fields.kinematics import frame_records, sampling_hint
    from bladewhirl.postprocess.fields.result import open_result
    from bladewhirl.postprocess.paraview.series import export_vtk

    folder = output or (directory if directory.is_dir() else directory.parent) / VTK
    with open_result(directory) as result:
        look: dict[str, Any] = {"surface": surface, "exaggeration": exaggeration}
        records = frame_records(result, frames, start, end)
        look |= {"rotating": rotating, "overwrite": overwrite}
        with progress_bar(folder.name) as update, writing(folder):
            index = export_vtk(result, folder, records=records, progress=update, **look)
        first, last = result["time"].values[records[[0, -1]]]
        hint = sampling_hint(result, records)
    size = sum(path.stat().st_size for path in owned(folder))
    span = f"{len(records)} instants from {first:.6g} s to {last:.6g} s"
    typer.echo(f"Wrote {index}: {span}, {size / 1e6:.3g} MB.")
    if hint:
        typer.echo(f"Hint: {hint}.", err=True)


def report(
    directory: options.Folder, output: options.OutputFile = None, overwrite: options.Replace = False
) -> None:
    """Write a report as one HTML file that any browser shows without a network.

    It contains the regime with its reasons, the figures of `bladewhirl plot` with explanations,
    interactive maps, the numbers, the resolved case and its provenance. An older report of the
    folder is replaced.

    Args:
        directory: Folder of a run or a sweep, finished or not; or the history of a point of a
            sweep, to whose report that of the sweep then links.
        output: File to write; by default DIR/report.html.
    """
    from bladewhirl.files import check_file
    from bladewhirl.studies.runs.report import report as write_report
    from bladewhirl.studies.runs.report import report_target

    target = report_target(directory, output)
    with writing(target):
        check_file(target, overwrite=overwrite)
    write_report(directory, target)
    options.claim_output(target, named=output is not None, overwrite=True)
    typer.echo(f"Wrote {target}.")

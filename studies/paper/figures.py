"""Figures like those of the paper, drawn from our runs: panels and functions that draw them."""

import base64
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from operator import itemgetter
from pathlib import Path

import numpy as np

from bladewhirl.files import packaged_rows
from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.postprocess.modal.stability import plot_chart, plot_spectrum
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.postprocess.reports.page import ReportFigure
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.sweep.figures import SweepFigures
from bladewhirl.solvers.stability.growth import is_unstable
from bladewhirl.studies.modal import campbell, veering
from bladewhirl.studies.modal.mode_pictures import draw_modes, plan_pictures
from bladewhirl.studies.modal.stability import fastest_mode
from bladewhirl.studies.modal.stability_chart import spectrum_along, stability_chart
from bladewhirl.studies.paper.claims_modal import EXAMPLE, RANGE
from bladewhirl.studies.paper.modal_numbers import OPERATING
from bladewhirl.studies.paper.trials import Evidence, NotTestableError

CHART_SPEEDS, CHART_KAPPAS = np.linspace(*RANGE, 241), np.linspace(0.0, 1000.0, 101)
"""Normalised speeds and stiffnesses [N/m] of the chart."""

Draw = Callable[[Evidence, Path], None]
"""Function that draws pictures into an existing folder, with their data."""


@dataclass(frozen=True, kw_only=True)
class FigurePart:
    """Part of a figure of the paper."""

    caption: str
    folder: str  #: folder of the pictures; all panels of a folder are drawn at once
    name: str  #: name of the picture, without suffix
    draw: Draw


@dataclass(frozen=True, kw_only=True)
class PaperFigure:
    """A figure of the paper, whose panels are side by side as in the paper."""

    caption: str
    panels: tuple[FigurePart, ...]


def draw_figures(
    evidence: Evidence, numbers: Iterable[str], directory: Path
) -> dict[str, list[ReportFigure]]:
    """Draw figures of the paper, with numbers as in `PAPER_FIGURES`, into folders in a directory;
    runs that the evidence lacks are made.

    Raises:
        UserError: the directory cannot be written.
    """
    obstacles: dict[tuple[str, Draw], str] = {}
    drawn: dict[str, list[ReportFigure]] = {}
    for number in numbers:
        figure = PAPER_FIGURES[number]
        drawn[number] = []
        for place, panel in enumerate(figure.panels, 1):
            folder, key = directory / panel.folder, (panel.folder, panel.draw)
            if key not in obstacles:
                obstacles[key] = _draw(evidence, panel, folder)
            file = folder / f"{panel.name}.png"
            content = b"" if obstacles[key] else file.read_bytes()
            drawn[number].append(
                ReportFigure(
                    name=f"figure-{number}-{place}",
                    title=f"Like Fig. {number}: {figure.caption}",
                    caption=panel.caption,
                    picture=base64.b64encode(content).decode("ascii"),
                    obstacle=obstacles[key],
                    wide=len(figure.panels) == 1,
                )
            )
    return drawn


def _draw(evidence: Evidence, panel: FigurePart, folder: Path) -> str:
    """Draw all panels of a folder; return an empty text, or the reason if this is impossible."""
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        try:
            panel.draw(evidence, folder)
        except (NotTestableError, UserError) as error:
            return str(error)
    return ""


def _draw_chart(evidence: Evidence, folder: Path) -> None:
    system = evidence.system
    omegas = CHART_SPEEDS * system.reference
    chart = stability_chart(system, omegas, CHART_KAPPAS)
    point = (EXAMPLE["speed"], EXAMPLE["kappa"])
    save_figure(plot_chart(chart, point), folder / "stability", chart)
    line = spectrum_along(system, omegas, EXAMPLE["kappa"])
    save_figure(plot_spectrum(line), folder / "spectrum", line)


def _draw_coupled_mode(evidence: Evidence, folder: Path) -> None:
    # slow to import
    from bladewhirl.studies.modal.coupled_mode_figures import draw_coupled_mode

    system = evidence.system
    omega, kappa = EXAMPLE["speed"] * system.reference, EXAMPLE["kappa"]
    if not is_unstable(fastest_mode(system, omega, kappa).eigenvalue.real, omega):
        raise NotTestableError("no mode grows at the paper's example point")
    draw_coupled_mode(system, omega, kappa, folder, films=False)


_MODAL: Mapping[str, Draw] = {
    "modes": lambda evidence, folder: draw_modes(
        evidence.stage, plan_pictures(evidence.stage, shapes=None, animate="", wave=None), folder
    ),
    "veering": lambda evidence, folder: veering.report(
        veering.veering(evidence.stage, families=5)
    ).draw(folder),
    "campbell": lambda evidence, folder: campbell.report(
        campbell.campbell(evidence.stage, families=2, operating=OPERATING)
    ).draw(folder),
    "stability": _draw_chart,
    "coupled-mode": _draw_coupled_mode,
}
"""Functions that draw all pictures of a folder, by name of the folder."""


def _draw_one(kind: str, source: str, name: str, evidence: Evidence, folder: Path) -> None:
    """Draw a figure of a march or a sweep."""
    figures = (
        RunFigures(evidence.motion(source).result)
        if kind == "run"
        else SweepFigures(evidence.sweep(source))
    )
    figure, data = figures.draw(name)
    save_figure(figure, folder / name, data)


def _panel(row: Mapping[str, str]) -> FigurePart:
    """Return the panel for a row of figures.csv.

    The column `picture` names a picture of modes, or a figure of a run or a sweep.
    """
    kind, source, name = row["kind"], row["source"], row["picture"]
    slug = "-".join(source.replace(",", "").split())
    folder = {"modal": source, "run": slug, "sweep": f"sweep-{slug}"}[kind]
    draw = _MODAL[source] if kind == "modal" else partial(_draw_one, kind, source, name)
    return FigurePart(caption=row["caption"], folder=folder, name=name, draw=draw)


PAPER_FIGURES: Mapping[str, PaperFigure] = {
    number: PaperFigure(caption=title, panels=tuple(map(_panel, rows)))
    for (number, title), rows in groupby(
        packaged_rows(__package__, "figures.csv"), itemgetter("figure", "title")
    )
}
"""Figures in figures.csv by their number in the paper."""

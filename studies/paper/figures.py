"""The paper's figures from our runs: which panels each has, and how they are drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.modal.stability import plot_chart, plot_spectrum
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.sweep.figures import SweepFigures
from bladewhirl.solvers.stability.growth import is_unstable
from bladewhirl.studies.modal.campbell import campbell, draw_campbell
from bladewhirl.studies.modal.coupled_mode import fastest_mode
from bladewhirl.studies.modal.mode_pictures import draw_modes, plan_pictures
from bladewhirl.studies.modal.stability_chart import spectrum_along, stability_chart
from bladewhirl.studies.modal.veering import draw_veering, veering
from bladewhirl.studies.paper.claims_modal import EXAMPLE, RANGE
from bladewhirl.studies.paper.claims_truncated import DISTORTED, DIVERGING, UNBALANCED
from bladewhirl.studies.paper.trials import Evidence, NotTestableError

CHART_SPEEDS, CHART_KAPPAS = np.linspace(*RANGE, 241), np.linspace(0.0, 1000.0, 101)
"""Normalised speeds and stiffnesses [N/m] of the chart."""

Draw = Callable[[Evidence, Path], None]
"""Leaves pictures with their data in a folder that is there."""


@dataclass(frozen=True, kw_only=True)
class Panel:
    """One picture of a figure of the paper."""

    caption: str
    folder: str  #: that its pictures are in; all panels of a folder are drawn at once
    name: str  #: of the picture, without suffix
    draw: Draw


@dataclass(frozen=True, kw_only=True)
class PaperFigure:
    """A figure of the paper, side by side as there."""

    caption: str
    panels: tuple[Panel, ...]


@dataclass(frozen=True, kw_only=True)
class DrawnPanel:
    """A picture, or why there is none."""

    caption: str
    picture: Path | None
    obstacle: str = ""


def draw_figures(
    evidence: Evidence, numbers: Iterable[str], directory: Path
) -> dict[str, list[DrawnPanel]]:
    """Draw figures of the paper into folders below a directory.

    Args:
        evidence: whose runs are drawn; those that are missing are made.
        numbers: of the figures, as in `PAPER_FIGURES`.
        directory: where to.

    Raises:
        UserError: the directory can't be written.
    """
    obstacles: dict[tuple[str, Draw], str] = {}
    drawn: dict[str, list[DrawnPanel]] = {}
    for number in numbers:
        drawn[number] = []
        for panel in PAPER_FIGURES[number].panels:
            folder, key = directory / panel.folder, (panel.folder, panel.draw)
            if key not in obstacles:
                obstacles[key] = _draw(evidence, panel, folder)
            picture = None if obstacles[key] else folder / f"{panel.name}.png"
            drawn[number].append(
                DrawnPanel(caption=panel.caption, picture=picture, obstacle=obstacles[key])
            )
    return drawn


def _draw(evidence: Evidence, panel: Panel, folder: Path) -> str:
    """Draw a panel, and all others that are drawn with it; returns what stood in the way."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        panel.draw(evidence, folder)
    except OSError as error:
        raise UserError(f"{folder}: cannot be written ({error.strerror})") from None
    except (NotTestableError, UserError) as error:
        return str(error)
    return ""


def _draw_modes(evidence: Evidence, folder: Path) -> None:
    draw_modes(
        evidence.stage, plan_pictures(evidence.stage, shapes=None, animate="", wave=None), folder
    )


def _draw_veering(evidence: Evidence, folder: Path) -> None:
    draw_veering(veering(evidence.stage, families=5), folder)


def _draw_campbell(evidence: Evidence, folder: Path) -> None:
    draw_campbell(campbell(evidence.stage, families=2), folder)


def _draw_chart(evidence: Evidence, folder: Path) -> None:
    system = evidence.system
    omegas = CHART_SPEEDS * system.reference
    chart = stability_chart(system, omegas, CHART_KAPPAS)
    point = (EXAMPLE["speed"], EXAMPLE["kappa"])
    save_figure(plot_chart(chart, point), folder / "stability", chart)
    line = spectrum_along(system, omegas, EXAMPLE["kappa"])
    save_figure(plot_spectrum(line), folder / "spectrum", line)


def _draw_coupled_mode(evidence: Evidence, folder: Path) -> None:
    # This takes long to load.
    from bladewhirl.studies.modal.coupled_mode_figures import draw_coupled_mode

    system = evidence.system
    omega, kappa = EXAMPLE["speed"] * system.reference, EXAMPLE["kappa"]
    if not is_unstable(fastest_mode(system, omega, kappa).eigenvalue.real, omega):
        raise NotTestableError("no mode grows at the paper's example point")
    draw_coupled_mode(system, omega, kappa, folder, films=False)


def _draw_run(trial: str, name: str, evidence: Evidence, folder: Path) -> None:
    figure, data = RunFigures(evidence.motion(trial).result).draw(name)
    save_figure(figure, folder / name, data)


def _draw_sweep(survey: str, name: str, evidence: Evidence, folder: Path) -> None:
    figure, data = SweepFigures(evidence.sweep(survey)).draw(name)
    save_figure(figure, folder / name, data)


def _slug(text: str) -> str:
    return "-".join(text.replace(",", "").split())


def _run(trial: str, name: str, caption: str) -> Panel:
    return Panel(
        caption=caption, folder=_slug(trial), name=name, draw=partial(_draw_run, trial, name)
    )


def _sweep(survey: str, name: str, caption: str) -> Panel:
    return Panel(
        caption=caption,
        folder=f"sweep-{_slug(survey)}",
        name=name,
        draw=partial(_draw_sweep, survey, name),
    )


def _figure(caption: str, *panels: Panel) -> PaperFigure:
    return PaperFigure(caption=caption, panels=panels)


def _modal(name: str, caption: str) -> Panel:
    folder = next(folder for folder, (_, names) in _MODAL.items() if name in names)
    return Panel(caption=caption, folder=folder, name=name, draw=_MODAL[folder][0])


_MODAL: Mapping[str, tuple[Draw, tuple[str, ...]]] = {
    "modes": (_draw_modes, ("bladed-disk-shapes", "standard-scenario", "inverted-scenario")),
    "veering": (_draw_veering, ("families", "first-families", "shaft")),
    "campbell": (_draw_campbell, ("campbell-rotating", "campbell-static")),
    "stability": (_draw_chart, ("stability", "spectrum")),
    "coupled-mode": (_draw_coupled_mode, ("shapes", "orbit", "phases")),
}
"""Function that draws the pictures of each folder, and their names."""

_A, _A_OTHER, _B = "distortion at 1.05", "distortion at 1.39", "imbalance at 1.05"
_B_HIGH = "imbalance at 1.6"

PAPER_FIGURES: Mapping[str, PaperFigure] = {
    "6": _figure(
        "Modes of the bladed disk",
        _modal("bladed-disk-shapes", "1F by nodal diameter, and the suspension"),
    ),
    "7": _figure(
        "Families over nodal diameter, centre free and clamped",
        _modal("families", "five families"),
        _modal("first-families", "the suspension pair between 1F and 2F"),
    ),
    "8": _figure(
        "Coincidence speeds",
        _modal("campbell-rotating", "rotating frame"),
        _modal("campbell-static", "static frame"),
    ),
    "9": _figure("Standard contact", _modal("standard-scenario", "casing moves less")),
    "10": _figure("Inverted contact", _modal("inverted-scenario", "casing moves more")),
    "11": _figure("Stability over speed and coupling", _modal("stability", "growth rate")),
    "12": _figure("Eigenvalues at 500 N/m", _modal("spectrum", "real and imaginary parts")),
    "13": _figure("Divergent mode in time", _modal("shapes", "bladed disk and casing")),
    "14": _figure(
        "Divergent mode at the centre",
        _modal("orbit", "orbits in both frames"),
        _modal("phases", "shaft and smallest clearance"),
    ),
    "15": _figure(
        "Response to casing distortion over speed",
        _sweep("distortion", "frequency-map", "spectrum of the shaft"),
        _sweep("distortion", "shaft-radius", "largest displacement"),
    ),
    "16": _figure("Casing distortion at 1.05: the shaft", _run(_A, "orbit", "orbits")),
    "17": _figure(
        "Casing distortion at 1.05: frequencies and energies",
        _run(_A, "spectrogram", "(a) spectrogram"),
        _run(_A, "energy", "(b) strain energy"),
    ),
    "18": _figure(
        "Casing distortion at 1.39",
        _run(_A_OTHER, "orbit", "(a), (b) orbits"),
        _run(_A_OTHER, "contact-phase", "(c) shaft and smallest clearance"),
    ),
    "19": _figure(
        "Response to imbalance over speed",
        _sweep("imbalance", "frequency-map", "spectrum of the shaft"),
        _sweep("imbalance", "shaft-radius", "largest displacement"),
    ),
    "20": _figure(
        "Imbalance at 1.05: the shaft",
        _run(_B, "orbit", "(a), (b) orbits"),
        _run(_B, "state-space", "(c), (d) state space and Poincaré map"),
        _run(_B, "energy", "(e) strain energy"),
    ),
    "21": _figure(
        "Imbalance at 1.05: contact",
        _run(_B, "gaps", "(a), (b) gaps"),
        _run(_B, "forces", "contact forces"),
        _run(_B, "contact-phase", "(c) shaft and smallest clearance"),
    ),
    "22": _figure("Imbalance at 1.6", _run(_B_HIGH, "energy", "strain energy")),
    "23": _figure(
        "Six modes, casing distortion at 1.05",
        _run(DISTORTED[0], "orbit", "(a), (b) orbits"),
        _run(DISTORTED[0], "energy", "(c) strain energy"),
    ),
    "24": _figure(
        "Six modes: largest displacement over speed and coupling",
        _sweep("six modes, distortion", "shaft-radius", "a line for each coupling"),
    ),
    "25": _figure(
        "Six modes, imbalance at 1.05",
        *(_run(name, "orbit", name.rsplit(", ", 1)[1] + " N/m") for name in UNBALANCED),
        _run(UNBALANCED[0], "energy", "(c) strain energy, kappa 0"),
    ),
    "26": _figure(
        "Six modes, imbalance",
        _run(DIVERGING, "energy", "strain energy at 1.65, kappa 0"),
        _sweep("six modes, imbalance", "shaft-radius", "a line for each coupling"),
    ),
}
"""By number in the paper."""

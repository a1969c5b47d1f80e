"""Drawings of frames and signs, and of the layers of the package."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, FancyBboxPatch

INK, BLUE, ORANGE, GREEN = "#1f2430", "#0072b2", "#d55e00", "#009e73"


def draw(folder: Path) -> None:
    """Write the drawings as SVG, once."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in (("frames", frames()), ("layers", layers())):
        figure.savefig(folder / f"{name}.svg", bbox_inches="tight", metadata={"Date": None})


def frames() -> Figure:
    """Static and rotating axes, one blade, its displacement and gap, forces in contact."""
    figure = Figure(figsize=(7.2, 5.6))
    axes = figure.add_subplot(aspect="equal")
    axes.axis("off")
    turned = np.deg2rad(25.0)
    _axes(axes, 0.0, "x static", "y static", INK)
    _axes(axes, turned, "x rotating: blade 0", "y rotating", BLUE)
    axes.add_patch(Arc((0, 0), 0.9, 0.9, theta1=0, theta2=25, color=BLUE))
    axes.text(0.5, 0.09, "Ω t", color=BLUE)
    around = np.linspace(-0.35, 2.2, 200)
    for radius, width in ((1.32, 3.0), (1.38, 1.0)):
        axes.plot(radius * np.cos(around), radius * np.sin(around), color=GREEN, lw=width)
    axes.text(1.36, -0.33, "casing, static", color=GREEN)
    angle = np.deg2rad(75.0)
    radial = np.array([np.cos(angle), np.sin(angle)])
    tangential = np.array([-np.sin(angle), np.cos(angle)])
    tip = 1.2 * radial
    axes.plot(*zip(0.2 * radial, tip, strict=True), color=BLUE, lw=5, solid_capstyle="butt")
    axes.text(0.62 * radial[0] + 0.04, 0.62 * radial[1], "blade i", color=BLUE)
    _arrow(axes, tip, tip + 0.34 * radial, "$u_r$, outward", ORANGE, (0.03, 0.0))
    _arrow(axes, tip, tip + 0.36 * tangential, "$u_t$, along the rotation", ORANGE, (-0.62, -0.09))
    _arrow(axes, tip, tip - 0.3 * tangential, "friction on the tip", INK, (0.02, -0.02))
    _arrow(axes, tip, tip - 0.34 * radial, "contact on the tip", INK, (0.05, 0.02))
    side = np.deg2rad(115.0)
    foot = 1.32 * np.array([np.cos(side), np.sin(side)])
    _arrow(axes, foot, 1.22 * foot, "w, outward", GREEN, (-0.1, 0.04))
    axes.add_patch(Arc((0, 0), 2.0, 2.0, theta1=150, theta2=195, color=INK))
    _arrow(axes, np.array([-0.962, -0.27]), np.array([-0.94, -0.34]), "Ω > 0", INK, (-0.3, 0.0))
    axes.plot(0, 0, "o", color=INK)
    axes.set(xlim=(-1.6, 2.0), ylim=(-0.55, 1.75))
    return figure


def _axes(axes: Axes, angle: float, first: str, second: str, colour: str) -> None:
    for turn, name in ((angle, first), (angle + np.pi / 2.0, second)):
        end = 1.02 * np.array([np.cos(turn), np.sin(turn)])
        _arrow(axes, np.zeros(2), end, name, colour, (0.02, 0.02))


def _arrow(
    axes: Axes,
    start: np.ndarray,
    end: np.ndarray,
    text: str,
    colour: str,
    offset: tuple[float, float],
) -> None:
    style = {"arrowstyle": "-|>", "color": colour, "lw": 1.4}
    axes.annotate("", xy=tuple(end), xytext=tuple(start), arrowprops=style)
    axes.text(end[0] + offset[0], end[1] + offset[1], text, color=colour, fontsize=9)


LAYERS = (
    ("studies", "commands, runs, sweeps, modal studies, convergence, the paper"),
    ("postprocess", "fields, figures, films, reports, ParaView: reads results only"),
    ("solvers", "kernel, march, stability: arrays only"),
    ("models", "case, geometry, elements, rotation, reduction, coupling, stage"),
    ("meshes", "line meshes, rings, mesh files"),
)


def layers() -> Figure:
    """The layers of the package, each importing only from those below."""
    figure = Figure(figsize=(7.2, 4.2))
    axes = figure.add_subplot()
    axes.axis("off")
    for row, (name, holds) in enumerate(reversed(LAYERS)):
        box = FancyBboxPatch(
            (0.0, row), 10.0, 0.62, boxstyle="round,pad=0.06", fc="#eef3f8", ec=INK
        )
        axes.add_patch(box)
        axes.text(0.25, row + 0.31, name, va="center", weight="bold", color=INK)
        axes.text(2.3, row + 0.31, holds, va="center", color=INK, fontsize=9)
        if row:
            style = {"arrowstyle": "-|>", "color": BLUE}
            axes.annotate("", xy=(5.0, row - 0.3), xytext=(5.0, row - 0.06), arrowprops=style)
    axes.set(xlim=(-0.2, 10.3), ylim=(-0.2, len(LAYERS)))
    return figure

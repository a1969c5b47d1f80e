"""Cases of the verification whose error falls with an order: their refinements, and a figure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from pictures_of_the_model import BLUE, GREEN, INK, ORANGE

from bladewhirl.models.case.schemes import SchemeName
from bladewhirl.studies.verification import march, modes, rings, rotation, schemes, stability, whirl
from bladewhirl.studies.verification.bodies import marched
from bladewhirl.studies.verification.case import Pair
from bladewhirl.studies.verification.contact import bars_in_impact, pad_on_a_wall
from bladewhirl.studies.verification.references import reference


@dataclass(frozen=True, kw_only=True)
class Refinement:
    """Errors of a quantity at several sizes of a model or a step."""

    subject: str
    name: str
    title: str
    error: Callable[[int], ArrayLike]  #: signed or not, one or a few, for a size
    sizes: tuple[int, ...]  #: ascending
    size: str  #: of the axis: "elements", "steps in 2 ms"
    measure: str = "relative error"
    curves: tuple[str, ...] = ("",)  #: names of the errors, if there are several
    order: float | None = None  #: expected; None where no theory gives one
    because: str  #: of the order, in a sentence

    def errors(self) -> NDArray[np.float64]:
        """Sizes of the errors, (sizes, curves)."""
        return np.array([np.atleast_1d(np.abs(self.error(size))) for size in self.sizes])


def measured(sizes: tuple[int, ...], errors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Slopes through the three finest sizes, (curves,)."""
    slopes = np.polyfit(np.log(sizes[-3:]), np.log(errors[-3:]), 1)[0]
    return np.asarray(-slopes)


def _largest(pair: Pair) -> float:
    exact, ours = map(np.asarray, pair)
    return float(np.abs(ours - exact).max() / np.abs(exact).max())


def _reduction(kept: int) -> float:
    return float(modes.reduction_error(kept).max())


def _rings(elements: int) -> ArrayLike:
    return rings.ring_errors(elements)[[0, 3, 8]]


def _blades_at_speed(elements: int) -> ArrayLike:
    exact, ours = map(np.asarray, rotation.coriolis_cantilevers(elements))
    return np.asarray(np.abs(ours / exact - 1.0).max(axis=0))


def _bars(elements: int) -> float:
    met = bars_in_impact("identical", elements)
    impulse = marched(met.given, met.dt, met.steps).contact_impulse.sum()
    return float(impulse / met.known["impulse"] - 1.0)


def _pad(steps: int, scheme: SchemeName) -> float:
    dt = 0.2 / steps
    chunk = marched(pad_on_a_wall(), dt, steps, scheme=scheme)
    at = [*(round(n * np.pi / 100.0 / dt) for n in range(4)), steps]
    known = reference("published")["coulomb_pad"]["extremes"]
    return float(np.abs(chunk.rotor_displacement[at, 1] - known).max())


def _coupled(steps: int) -> float:
    exact = stability.coupled_march(64_000)
    return float(np.linalg.norm(stability.coupled_march(steps) - exact) / np.linalg.norm(exact))


REFINEMENTS = (
    Refinement(
        subject="modes",
        name="bending",
        title="Bending of a cantilever",
        error=modes.bending_errors,
        sizes=(3, 6, 12, 24),
        size="elements",
        curves=("first frequency", "second", "third"),
        order=4,
        because="cubics in a fourth-order problem",
    ),
    Refinement(
        subject="modes",
        name="stretching",
        title="Stretching of a cantilever",
        error=modes.stretching_errors,
        sizes=(8, 16, 32, 64),
        size="elements",
        curves=("first frequency", "second", "third"),
        order=2,
        because="elements that are linear along the beam",
    ),
    Refinement(
        subject="modes",
        name="tapered",
        title="Tapered blade with a mass at its tip",
        error=modes.tapered_errors,
        sizes=(4, 8, 16, 32),
        size="elements",
        curves=("first frequency", "second", "third"),
        order=4,
        because="as that of a prismatic blade",
    ),
    Refinement(
        subject="modes",
        name="reduction",
        title="Reduction of the paper's stage",
        error=_reduction,
        sizes=(22, 44, 66, 110, 154, 220, 330),
        size="fixed-interface modes",
        measure="largest relative error\nof 22 frequencies",
        because="no theory gives an order; a family of blade modes more is 22 of them",
    ),
    Refinement(
        subject="rings",
        name="ring",
        title="Bending of a ring",
        error=_rings,
        sizes=(20, 40, 80, 160),
        size="elements",
        curves=("k = 2", "k = 5", "k = 10"),
        order=4,
        because="cubics in a fourth-order problem; with few nodal diameters errors fall faster, as"
        " that of translations does",
    ),
    Refinement(
        subject="rings",
        name="translations",
        title="Translations of a free ring",
        error=rings.translation_error,
        sizes=(10, 20, 40, 80),
        size="elements",
        measure="squared frequency, exactly 0 [rad²/s²]",
        order=5.7,
        because="measured once: the only rigid motions that cubics miss",
    ),
    Refinement(
        subject="contact",
        name="bars",
        title="Impulse of identical bars in impact",
        error=_bars,
        sizes=(25, 50, 100, 200, 400),
        size="elements of a bar, steps in proportion",
        order=2 / 3,
        because="linear elements spread a front in stress over a width that falls so",
    ),
    Refinement(
        subject="contact",
        name="pad",
        title="Coulomb pad: extremes of its swings",
        error=lambda steps: _pad(steps, "central-difference"),
        sizes=(1250, 2500, 5000, 10_000, 20_000),
        size="steps in 0.2 s",
        measure="largest error [m]",
        order=1,
        because="friction changes its sign within a step",
    ),
    Refinement(
        subject="schemes",
        name="stop",
        title="Two masses on a stop, by the penalty",
        error=lambda steps: _largest(schemes.masses_on_a_stop(0.7, steps)),
        sizes=(2500, 5000, 10_000),
        size="steps in ten periods",
        measure="largest error over largest motion",
        order=2,
        because="central differences; the force of a stop of finite stiffness has no jumps",
    ),
    Refinement(
        subject="march",
        name="free",
        title="Free motion of a coarse stage",
        error=march.free_motion_error,
        sizes=(4000, 8000, 16_000),
        size="steps in 2 ms",
        measure="error of all modes, norm [m kg½]",
        order=2,
        because="central differences, against the superposition of modes",
    ),
    Refinement(
        subject="march",
        name="hit",
        title="A mass that hits a stop",
        error=march.contact_error,
        sizes=(1000, 2000, 4000, 8000, 16_000, 32_000),
        size="steps in 0.53 s",
        measure="mean error just after the hit [m]",
        order=1,
        because="it hits somewhere within a step",
    ),
    Refinement(
        subject="stability",
        name="coupled",
        title="Six modes coupled by springs, the paper's point",
        error=_coupled,
        sizes=(1000, 2000, 4000, 8000),
        size="steps in 0.2 s",
        order=2,
        because="central differences, against 64 000 steps",
    ),
    Refinement(
        subject="rotation",
        name="chordwise",
        title="Rotating cantilevers with Coriolis forces",
        error=_blades_at_speed,
        sizes=(5, 10, 20),
        size="elements",
        measure="largest relative error of four cantilevers",
        curves=("first frequency", "second"),
        order=2,
        because="bending is coupled to stretching, whose elements are linear; at these"
        " sizes the first frequency still gains from bending",
    ),
    Refinement(
        subject="whirl",
        name="bearings",
        title="Unbalance on unequal bearings",
        error=lambda steps: _largest(whirl.unequal_bearings(0.95, steps)),
        sizes=(10_000, 20_000, 40_000, 80_000),
        size="steps in 2 s",
        order=2,
        because="central differences with Coriolis forces",
    ),
    Refinement(
        subject="whirl",
        name="internal",
        title="Growth of whirl by internal damping",
        error=lambda steps: _largest(whirl.internal_damping(1.3, steps)),
        sizes=(500, 1000, 2000, 4000),
        size="steps in 0.2 s",
        order=2,
        because="central differences with Coriolis forces",
    ),
)


def picture(one: Refinement, errors: NDArray[np.float64]) -> Figure:
    """Errors over the size on logarithmic axes, with the expected slope."""
    figure = Figure(figsize=(4.6, 3.6), layout="constrained")
    axes = figure.add_subplot()
    marks = zip(one.curves, errors.T, measured(one.sizes, errors), "osD", strict=False)
    for (name, error, order, mark), colour in zip(marks, (BLUE, ORANGE, GREEN), strict=False):
        label = f"{name}, order {order:.2f}" if name else f"measured order {order:.2f}"
        axes.loglog(one.sizes, error, marker=mark, color=colour, label=label)
    if one.order is not None:
        sizes = np.array(one.sizes, dtype=float)
        slope = 0.4 * errors.min(axis=1)[-1] * (sizes / sizes[-1]) ** -one.order
        text = "2/3" if one.order == 2 / 3 else f"{one.order:g}"
        axes.loglog(sizes, slope, color=INK, ls="--", lw=1, label=f"order {text}")
    axes.set_xticks(one.sizes, [f"{size:,}".replace(",", " ") for size in one.sizes], fontsize=8)
    axes.minorticks_off()
    axes.set_title(one.title, fontsize=10)
    axes.set(xlabel=one.size, ylabel=one.measure)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    return figure

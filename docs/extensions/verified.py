"""Sections of the verification manual: a table and figures of each subject, computed now.

`python verified.py PAGE FOLDER` draws into the folder and prints a JSON list with the Markdown.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

import bladewhirl as bw
from bladewhirl.studies.verification import march, modes, rings, rotation, schemes, stability, whirl
from bladewhirl.studies.verification.bodies import marched
from bladewhirl.studies.verification.case import Outcome, Pair, reference
from bladewhirl.studies.verification.contact import bars_in_impact, pad_on_a_wall
from bladewhirl.studies.verification.table import SUBJECTS, Verification

INK, COLOURS = "#1f2430", ("#0072b2", "#d55e00", "#009e73")

SMALLEST = 1e-8
"""Share of the tolerance at the edge of the figures; smaller errors are shown there."""


def _largest(pair: Pair) -> float:
    exact, ours = map(np.asarray, pair)
    return float(np.abs(ours - exact).max() / np.abs(exact).max())


def _blades_at_speed(elements: int) -> ArrayLike:
    exact, ours = map(np.asarray, rotation.coriolis_cantilevers(elements))
    return np.asarray(np.abs(ours / exact - 1.0).max(axis=0))


def _bars(elements: int) -> float:
    met = bars_in_impact("identical", elements)
    impulse = marched(met.given, met.dt, met.steps).contact_impulse.sum()
    return float(impulse / met.known["impulse"] - 1.0)


def _pad(steps: int) -> float:
    dt = 0.2 / steps
    chunk = marched(pad_on_a_wall(), dt, steps)
    at = [*(round(n * np.pi / 100.0 / dt) for n in range(4)), steps]
    known = reference("published")["coulomb_pad"]["extremes"]
    return float(np.abs(chunk.rotor_displacement[at, 1] - known).max())


ERRORS: Mapping[str, Callable[[int], ArrayLike]] = {
    "bending": modes.bending_errors,
    "stretching": modes.stretching_errors,
    "tapered": modes.tapered_errors,
    "reduction": lambda kept: modes.reduction_error(kept).max(),
    "ring": lambda elements: rings.ring_errors(elements)[[0, 3, 8]],
    "translations": rings.translation_error,
    "bars": _bars,
    "pad": _pad,
    "stop": lambda steps: _largest(schemes.masses_on_a_stop(0.7, steps)),
    "free": march.free_motion_error,
    "hit": march.contact_error,
    "coupled": lambda steps: (
        np.linalg.norm(stability.coupled_march(steps) - stability.coupled_march(64_000))
        / np.linalg.norm(stability.coupled_march(64_000))
    ),
    "chordwise": _blades_at_speed,
    "bearings": lambda steps: _largest(whirl.unequal_bearings(0.95, steps)),
    "internal": lambda steps: _largest(whirl.internal_damping(1.3, steps)),
}
"""Errors of a quantity, one or a few, by the size of a model or the number of steps."""


@dataclass(frozen=True, kw_only=True)
class Refinement:
    """A row of refinements.csv: a quantity whose error falls with an order."""

    subject: str
    name: str  #: in `ERRORS`
    title: str
    sizes: tuple[int, ...]  #: ascending
    size: str  #: label of the axis
    measure: str  #: of the error
    curves: tuple[str, ...]  #: names of the errors, if there are several
    order: float | None  #: expected; None where no theory gives one
    because: str  #: reason for the order

    def errors(self) -> NDArray[np.float64]:
        """Sizes of the errors, (sizes, curves)."""
        return np.array([np.atleast_1d(np.abs(ERRORS[self.name](size))) for size in self.sizes])


def _refinements() -> Iterator[Refinement]:
    text = Path(__file__).with_name("refinements.csv").read_text(encoding="utf-8")
    for row in csv.DictReader(text.splitlines()):
        sizes, curves, order = row.pop("sizes"), row.pop("curves"), row.pop("order")
        yield Refinement(
            sizes=tuple(map(int, sizes.split())),
            curves=tuple(curves.split("; ")),
            order=float(Fraction(order)) if order else None,
            **row,
        )


REFINEMENTS = tuple(_refinements())


def measured(sizes: tuple[int, ...], errors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Slopes through the three finest sizes, (curves,)."""
    slopes = np.polyfit(np.log(sizes[-3:]), np.log(errors[-3:]), 1)[0]
    return np.asarray(-slopes)


def sections(folder: Path) -> Iterator[str]:
    """Text of each subject; its figures go to the folder."""
    for subject, outcomes in bw.verify().by_subject().items():
        head, _, table = Verification(outcomes=tuple(outcomes)).to_markdown().partition("\n\n")
        _save(margins(SUBJECTS[subject], outcomes), folder, subject)
        drawn = f"![{SUBJECTS[subject]}: error over tolerance](built/verification/{subject}.svg)"
        yield f"{head}\n\n{drawn}\n\n{{.cases}}\n{table}"
        refined = [one for one in REFINEMENTS if one.subject == subject]
        if refined:
            yield f"### {SUBJECTS[subject]}: how errors fall\n\n{{.refinements}}"
            yield "\n".join(_refined(one, folder) for one in refined) + "\n"


def _refined(one: Refinement, folder: Path) -> str:
    errors = one.errors()
    name = f"{one.subject}-{one.name}"
    _save(picture(one, errors), folder, name)
    orders = ", ".join(f"{order:.2f}" for order in measured(one.sizes, errors))
    expected = "" if one.order is None else f", expected {one.order:.3g}"
    return (
        f"- ![{one.title}: error over {one.size}](built/verification/{name}.svg)"
        f" {one.title}: measured order {orders}{expected} ({one.because})."
    )


def margins(title: str, outcomes: Sequence[Outcome]) -> Figure:
    """A dot for each case at its error over what is allowed, a line for cases of one kind."""
    shares: dict[str, list[float]] = {}
    for outcome in outcomes:
        share = outcome.error / outcome.tolerance if outcome.error else 0.0
        kind = outcome.name.partition(".")[2].partition("[")[0].replace("_", " ")
        shares.setdefault(kind, []).append(share)
    figure = Figure(figsize=(6.0, 0.9 + 0.22 * len(shares)), layout="constrained")
    axes = figure.add_subplot()
    for row, values in enumerate(shares.values()):
        inside = [share for share in values if share > SMALLEST]
        axes.plot(inside, [row] * len(inside), "o", color=COLOURS[0], ms=5, alpha=0.7)
        if len(inside) < len(values):
            edge: dict[str, Any] = {"mfc": "white", "ms": 6, "clip_on": False, "zorder": 3}
            axes.plot(SMALLEST, row, "<", color=COLOURS[0], **edge)
    axes.axvline(1.0, color=INK, ls="--", lw=1)
    axes.set_yticks(range(len(shares)), list(shares), fontsize=8)
    axes.set(xscale="log", xlim=(SMALLEST, 10.0), ylim=(len(shares) - 0.4, -0.6))
    axes.set_xlabel("error over tolerance (1: what is allowed; ◁: smaller, or none)", fontsize=9)
    axes.set_title(f"{title}: {len(outcomes)} cases", fontsize=10)
    axes.grid(axis="x", alpha=0.3)
    return figure


def picture(one: Refinement, errors: NDArray[np.float64]) -> Figure:
    """Errors over the size on logarithmic axes, with the expected slope."""
    figure = Figure(figsize=(4.6, 3.6), layout="constrained")
    axes = figure.add_subplot()
    lines = zip(one.curves, errors.T, measured(one.sizes, errors), "osD", COLOURS, strict=False)
    for name, error, order, mark, colour in lines:
        label = f"{name}, order {order:.2f}" if name else f"measured order {order:.2f}"
        axes.loglog(one.sizes, error, marker=mark, color=colour, label=label)
    if one.order is not None:
        sizes = np.array(one.sizes, dtype=float)
        slope = 0.4 * errors.min(axis=1)[-1] * (sizes / sizes[-1]) ** -one.order
        axes.loglog(sizes, slope, color=INK, ls="--", lw=1, label=f"order {one.order:.2g}")
    axes.set_xticks(one.sizes, [f"{size:,}".replace(",", " ") for size in one.sizes], fontsize=8)
    axes.minorticks_off()
    axes.set_title(one.title, fontsize=10)
    axes.set(xlabel=one.size, ylabel=one.measure)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    return figure


def _save(figure: Figure, folder: Path, name: str) -> None:
    figure.savefig(folder / f"{name}.svg", metadata={"Date": None})


if __name__ == "__main__":
    built = Path(sys.argv[2])
    built.mkdir(parents=True, exist_ok=True)
    print(json.dumps(["\n".join(sections(built))]))

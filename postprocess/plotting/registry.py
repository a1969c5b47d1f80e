"""Registry of the figures of runs, sweeps and branches: names, captions, and functions.

A new figure needs a function that computes its dataset, a function that draws the dataset, and an
entry in `figures.toml`. The command line, its help, reports and `bladewhirl.plot` then contain the
figure. The entry only names the functions, so this module imports nothing but the standard library.
"""

import tomllib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from typing import Any


@dataclass(frozen=True, kw_only=True)
class FigureKind:
    """Entry of the registry: a kind of figure."""

    name: str
    title: str
    about: str  #: content of the figure, in one line
    reading: str = ""  #: help for reading the figure: units, signs, marks of dangerous motion
    shown: Mapping[str, str] = field(default_factory=dict)
    """Further help on what not every figure of this kind shows, by a variable of its dataset, or a
    text in it; "a or b" needs one of two."""
    only: str = ""  #: what a run must have for this figure, in words; empty for every run
    section: str = ""  #: section of the report that shows the figure; empty for no section
    needs: Sequence[str] = ()
    """Variables of a run or a sweep without which there is no figure; "a or b" needs one of two."""
    wide: bool = False  #: true for the width of the page of a report, false for half of it
    data: str  #: "module:function" that computes the dataset, or an attribute of `RunFigures`
    plot: str  #: "module:function" in postprocess that draws the dataset
    arguments: Sequence[str] = ()  #: attributes of `RunFigures`: arguments of the function `data`
    options: Mapping[str, Any] = field(default_factory=dict)  #: keyword arguments of `data`

    @property
    def caption(self) -> str:
        """Caption of figures of this kind, with all that they can show."""
        only = f"Only for {self.only}." if self.only else ""
        return " ".join(filter(None, [f"{self.about}.", only, self.reading, *self.shown.values()]))

    def caption_of(self, contents: Collection[str]) -> str:
        """Return the caption of one figure from the names of the variables of its dataset, and the
        texts in it."""
        shown = [
            text
            for names, text in self.shown.items()
            if any(name in contents for name in names.split(" or "))
        ]
        return " ".join(filter(None, [f"{self.about}.", self.reading, *shown]))


def captions(kinds: Mapping[str, FigureKind]) -> list[str]:
    """Return a line of text for each kind of figure: its name and content."""
    return [f"{name}: {kind.about}." for name, kind in kinds.items()]


def _figures(source: str) -> Mapping[str, FigureKind]:
    file = resources.files("bladewhirl.postprocess.plotting").joinpath("figures.toml")
    entries = tomllib.loads(file.read_text("utf-8"))[source]
    return {name: FigureKind(name=name, **entry) for name, entry in entries.items()}


RUN_FIGURES, SWEEP_FIGURES, BRANCH_FIGURES = map(_figures, ("run", "sweep", "branch"))
"""Figures of a run, of a sweep, and of a branch of periodic motions."""

REPLACED: Mapping[str, str] = {"energy-cyclic": "energy-families"}
"""Deprecated figure names and their replacements."""

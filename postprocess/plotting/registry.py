"""The figures of a run and of a sweep: their names, words, and the functions that make them.

A new figure is a function that computes its dataset, one that draws it, and an entry in
`figures.toml` beside this module: the command line, its help, reports and `bladewhirl.plot` then
have it. Functions are named, not imported, so that this module loads the standard library alone.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pkgutil import resolve_name
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

POSTPROCESS = "bladewhirl.postprocess"


@dataclass(frozen=True, kw_only=True)
class FigureKind:
    """A figure by name."""

    name: str
    title: str
    about: str  #: what it shows, in one line
    reading: str = ""  #: how to read it: units, signs, what to look for
    section: str = ""  #: of a report that has it
    wide: bool = False  #: across a report, not half of it
    data: str  #: "module:function" in postprocess that computes its dataset
    plot: str  #: "module:function" in postprocess that draws it from its dataset
    options: Mapping[str, str] = field(default_factory=dict)  #: further arguments of `data`

    @property
    def caption(self) -> str:
        """The words with it in a report."""
        return f"{self.about}. {self.reading}".strip()

    def draw(self, *source: object) -> tuple[Figure, xr.Dataset]:
        """The figure and the data behind it.

        Args:
            source: arguments of the function that computes its dataset: a `RunFigures`, or a sweep
                and the swept key to go along.

        Raises:
            ViewError: it can't be had, such as a Poincaré map of a rotor at rest.
        """
        data = resolve_name(f"{POSTPROCESS}.{self.data}")(*source, **self.options)
        return resolve_name(f"{POSTPROCESS}.{self.plot}")(data), data


def captions(kinds: Mapping[str, FigureKind]) -> list[str]:
    """A line for each figure: its name and what it shows."""
    return [f"{name}: {kind.about}." for name, kind in kinds.items()]


def _figures(source: str) -> Mapping[str, FigureKind]:
    text = resources.files(f"{POSTPROCESS}.plotting").joinpath("figures.toml").read_text("utf-8")
    return {name: FigureKind(name=name, **own) for name, own in tomllib.loads(text)[source].items()}


RUN_FIGURES, SWEEP_FIGURES = _figures("run"), _figures("sweep")

REPLACED: Mapping[str, str] = {"energy-cyclic": "energy-families"}
"""Names of figures that are no more, and of those that show the same."""

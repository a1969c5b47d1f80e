"""All figures of a sweep by name, each with the data behind it; histories are not read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import xarray as xr

from bladewhirl.postprocess.fields import ViewError
from bladewhirl.postprocess.frequency_map import frequency_map, plot_frequency_map
from bladewhirl.postprocess.run_figures import Drawn
from bladewhirl.postprocess.shaft_radius import plot_shaft_radius
from bladewhirl.postprocess.style import save_figure
from bladewhirl.postprocess.sweep_quantities import main_key, regimes, shaft_radius
from bladewhirl.postprocess.sweep_regimes import plot_regimes
from bladewhirl.postprocess.sweep_result import open_sweep


class SweepFigures:
    """Draws the figures of a sweep, along the speed if it is swept, else along the first key."""

    def __init__(self, dataset: xr.Dataset) -> None:
        """Look at a dataset from `open_sweep`, which must stay open."""
        self._sweep, self._key = dataset, main_key(dataset)

    def draw(self, name: str) -> Drawn:
        """One of `SWEEP_FIGURES`, with its data.

        Raises:
            KeyError: there is no such figure.
            ViewError: it can't be had, such as one of a sweep without a point that is done.
        """
        return SWEEP_FIGURES[name](self)

    def _draw_frequency_map(self) -> Drawn:
        maps = frequency_map(self._sweep, self._key)
        return plot_frequency_map(maps), maps

    def _draw_shaft_radius(self) -> Drawn:
        radius = shaft_radius(self._sweep, self._key)
        return plot_shaft_radius(radius), radius

    def _draw_regimes(self) -> Drawn:
        found = regimes(self._sweep, self._key)
        return plot_regimes(found), found


SWEEP_FIGURES: Mapping[str, Callable[[SweepFigures], Drawn]] = {
    "frequency-map": SweepFigures._draw_frequency_map,
    "shaft-radius": SweepFigures._draw_shaft_radius,
    "regimes": SweepFigures._draw_regimes,
}
"""The figures of a sweep."""

LEFT_BY_A_SWEEP = ("frequency-map", "shaft-radius", "regimes")
"""Figures that a sweep leaves in its folder."""


def leave_figures(directory: Path) -> dict[str, str]:
    """Write `LEFT_BY_A_SWEEP` into the folder of a sweep, as PNG and PDF with their data.

    Returns:
        why each figure that could not be drawn is not there.
    """
    left_out = {}
    with open_sweep(directory) as dataset:
        figures = SweepFigures(dataset)
        for name in LEFT_BY_A_SWEEP:
            try:
                figure, data = figures.draw(name)
            except ViewError as error:
                left_out[name] = str(error)
            else:
                save_figure(figure, directory / name, data)
    return left_out

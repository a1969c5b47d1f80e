"""The figures of a sweep by name (`plotting.registry`); histories are not read."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.plotting.registry import SWEEP_FIGURES
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.postprocess.sweep.dataset import open_sweep
from bladewhirl.postprocess.sweep.quantities import main_key

LEFT_BY_A_SWEEP = ("frequency-map", "shaft-radius", "regimes")
"""Figures that a sweep writes into its folder."""


class SweepFigures:
    """Figures of a sweep over the speed if it is swept, otherwise over the first key."""

    def __init__(self, dataset: xr.Dataset) -> None:
        """Use a dataset from `open_sweep`, which must stay open."""
        self._sweep = dataset

    def draw(self, name: str) -> tuple[Figure, xr.Dataset]:
        """Draw one of `SWEEP_FIGURES` and return it with its data.

        Raises:
            ViewError: the figure does not exist, or cannot be drawn for this sweep, such as a
                figure of a sweep without finished points.
        """
        if name not in SWEEP_FIGURES:
            raise ViewError(f"figure {name!r}: expected one of {', '.join(SWEEP_FIGURES)}")
        return SWEEP_FIGURES[name].draw(self._sweep, main_key(self._sweep))


def leave_figures(directory: Path) -> dict[str, str]:
    """Write `LEFT_BY_A_SWEEP` into the folder of a sweep, as PNG with their data.

    Returns:
        the figures that could not be drawn, with the reasons.
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
                save_figure(figure, directory / name, data, ["png"])
    return left_out

"""Figures of a sweep by name, see `plotting.registry`."""

from collections.abc import Sequence
from pathlib import Path

import xarray as xr

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.plotting.figures import Figures
from bladewhirl.postprocess.plotting.registry import SWEEP_FIGURES
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.postprocess.sweep.dataset import open_sweep
from bladewhirl.postprocess.sweep.quantities import main_key

LEFT_BY_A_SWEEP = ("frequency-map", "shaft-radius", "contact-nodes", "node-spectra", "regimes")
"""Names of the figures that a sweep writes into its folder, if the sweep has them."""


class SweepFigures(Figures):
    """Figures of a sweep against the speed or, if the speed is not swept, against the first key.

    Args:
        dataset: from `open_sweep`; it must stay open.
        branches: branches of periodic motions, which maps show, see `open_branch`.
    """

    def __init__(self, dataset: xr.Dataset, branches: Sequence[xr.Dataset] = ()) -> None:
        self.dataset, self.key, self.branches = dataset, main_key(dataset), branches
        super().__init__(SWEEP_FIGURES, dataset, self.key)


def leave_figures(directory: Path) -> dict[str, str]:
    """Write the figures `LEFT_BY_A_SWEEP` into the folder of a sweep, as PNG, with their data.

    Returns:
        names of the figures that could not be drawn, with the reasons.
    """
    left_out = {}
    with open_sweep(directory) as dataset:
        figures = SweepFigures(dataset)
        for name in (name for name in LEFT_BY_A_SWEEP if name in figures.names):
            try:
                figure, data = figures.draw(name)
            except ViewError as error:
                left_out[name] = str(error)
            else:
                save_figure(figure, directory / name, data, ["png"])
    return left_out

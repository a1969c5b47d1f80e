"""Figures of a branch by name, see `plotting.registry`."""

from collections.abc import Sequence

import xarray as xr

from bladewhirl.postprocess.plotting.figures import Figures
from bladewhirl.postprocess.plotting.registry import BRANCH_FIGURES


class BranchFigures(Figures):
    """Figures of a branch, with other data laid over it.

    Args:
        dataset: from `open_branch`.
        others: sweeps or branches to lay over it.
    """

    def __init__(self, dataset: xr.Dataset, others: Sequence[xr.Dataset] = ()) -> None:
        super().__init__(BRANCH_FIGURES, dataset, others)

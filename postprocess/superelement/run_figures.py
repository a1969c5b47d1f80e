"""Figures of a run of a superelement by name, see `plotting.registry`."""

import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.windows import time_window
from bladewhirl.postprocess.plotting.registry import NODE_FIGURES
from bladewhirl.postprocess.superelement.motion import check_superelement
from bladewhirl.postprocess.superelement.ring import is_flexible


class NodeFigures:
    """Figures of a run of a superelement.

    Args:
        dataset: result of a superelement, which must stay open.
        start, end: limits of the time window [s]; start and end of the run when None.

    Raises:
        ViewError: the window is invalid.
    """

    def __init__(
        self, dataset: xr.Dataset, start: float | None = None, end: float | None = None
    ) -> None:
        self.result = time_window(check_superelement(dataset), start, end)
        absent = {
            "wear": "coating_strain" not in dataset,
            "casing": not is_flexible(dataset),
        }
        #: names of the figures of this run
        self.names = [name for name in NODE_FIGURES if not absent.get(name)]

    def draw(self, name: str) -> tuple[Figure, xr.Dataset]:
        """Draw a figure of `NODE_FIGURES`; return the figure and its dataset.

        Raises:
            ViewError: this run has no figure of this name.
        """
        if name not in self.names:
            raise ViewError(f"figure {name!r}: expected one of {', '.join(self.names)}")
        return NODE_FIGURES[name].draw(self.result)

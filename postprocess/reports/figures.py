"""Figures of a run, of beams or of a superelement."""

import xarray as xr

from bladewhirl.postprocess.fields.nodes import is_flexible
from bladewhirl.postprocess.fields.windows import time_window
from bladewhirl.postprocess.plotting.figures import Figures
from bladewhirl.postprocess.plotting.registry import NODE_FIGURES
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.solvers.march.schema import NODES, tables_of


def figures_of_run(
    result: xr.Dataset, start: float | None = None, end: float | None = None
) -> Figures:
    """Return the figures of a run in the time window [start, end] [s]; by default the whole run.

    Raises:
        ViewError: the window is invalid.
    """
    if tables_of(result.attrs) is not NODES:
        return RunFigures(result, start, end)
    absent = {"wear": "coating_strain" not in result, "casing": not is_flexible(result)}
    kinds = {name: kind for name, kind in NODE_FIGURES.items() if not absent.get(name)}
    return Figures(kinds, time_window(result, start, end))

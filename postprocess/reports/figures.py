"""Figures of a run, of beams or of a superelement."""

import xarray as xr

from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.superelement.run_figures import NodeFigures
from bladewhirl.solvers.march.schema import NODES, tables_of

AnyFigures = RunFigures | NodeFigures
"""Figures of a run by name."""


def figures_of_run(
    result: xr.Dataset, start: float | None = None, end: float | None = None
) -> AnyFigures:
    """Return the figures of a run in the time window [start, end] [s]; by default the whole run.

    Raises:
        ViewError: the window is invalid.
    """
    kind = NodeFigures if tables_of(result.attrs) is NODES else RunFigures
    return kind(result, start, end)

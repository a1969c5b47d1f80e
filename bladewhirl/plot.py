"""Figures of runs, sweeps and modes: functions that take data and return a matplotlib Figure.

    import bladewhirl as bw

    with bw.open_result("runs/rub") as result:
        figure = bw.plot.orbit(result, start=0.2)
        bw.save_figure(figure, "orbit")

Most functions draw a result of `bw.open_result` in a time window [s], or a sweep of
`bw.open_sweep`, as their docstring says. Each draws the figure of the same name of
`bladewhirl plot`, with underscores for hyphens. `campbell`, `veering`, `critical_speeds` and
`response` draw datasets of the functions of `bw` with these names, `shaft_veering` draws a dataset
of `bw.veering`, and `branch` and `backbone` draw those of `bw.branch` or `bw.open_branch`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, Protocol

from bladewhirl.postprocess.plotting.registry import RUN_FIGURES, SWEEP_FIGURES

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


class Plot(Protocol):
    """Function that draws a figure of a run or a sweep."""

    def __call__(
        self, dataset: xr.Dataset, start: float | None = None, end: float | None = None
    ) -> Figure:
        """Draw the figure; the figure of a run shows the time window [start, end] [s]."""


def _plot(name: str) -> Plot:
    """Return the function that draws a figure of the registry; its docstring is the caption."""

    def draw(dataset: xr.Dataset, start: float | None = None, end: float | None = None) -> Figure:
        from bladewhirl.postprocess.fields.kinematics import ViewError
        from bladewhirl.postprocess.run.figures import RunFigures
        from bladewhirl.postprocess.sweep.figures import SweepFigures

        if "state" not in dataset:
            return RunFigures(dataset, start, end).draw(name)[0]
        if start is not None or end is not None:
            raise ViewError("omit start and end: a sweep has no time window")
        return SweepFigures(dataset).draw(name)[0]

    kinds = {"a run": RUN_FIGURES, "a sweep": SWEEP_FIGURES}
    draw.__doc__ = "\n\n".join(
        f"For {source}: {registry[name].caption}"
        for source, registry in kinds.items()
        if name in registry
    )
    draw.__name__ = draw.__qualname__ = name.replace("-", "_")
    return draw


_names = sorted({*RUN_FIGURES, *SWEEP_FIGURES})
_plots = {name.replace("-", "_"): _plot(name) for name in _names}
globals().update(_plots)
_of_modes = ("campbell", "critical_speeds", "response", "shaft_veering", "veering")
__all__ = sorted([*_plots, "backbone", "branch", *_of_modes])

if TYPE_CHECKING:

    def __getattr__(name: str) -> Plot: ...


def backbone(*branches: xr.Dataset) -> Figure:
    """Draw the amplitudes of branches over one key, and a line through their peaks."""
    from bladewhirl.postprocess.periodic.backbone import backbone as joined
    from bladewhirl.postprocess.periodic.backbone import plot_backbone

    return plot_backbone(joined(branches[0], branches[1:]))


def branch(data: xr.Dataset, *sweeps: xr.Dataset) -> Figure:
    """Draw a branch of periodic motions, with points of sweeps over its key."""
    from bladewhirl.postprocess.periodic.branch import plot_branch, with_marches

    return plot_branch(with_marches(data, sweeps))


def campbell(data: xr.Dataset, frame: Literal["rotating", "static"] = "rotating") -> Figure:
    """Draw the Campbell diagram of `bw.campbell(case)`, in the rotating or the static frame."""
    from bladewhirl.postprocess.modal.campbell import plot_campbell

    return plot_campbell(data, frame)


def critical_speeds(data: xr.Dataset) -> Figure:
    """Draw the map of critical speeds of `bw.critical_speeds(case)` against the shaft stiffness."""
    from bladewhirl.postprocess.modal.veering import plot_critical_speeds

    return plot_critical_speeds(data)


def response(data: xr.Dataset) -> Figure:
    """Draw the amplitudes of `bw.response(case)` against speed, by blade and nodal diameter."""
    from bladewhirl.postprocess.modal.response import plot_response

    return plot_response(data)


def veering(data: xr.Dataset, families: int | None = None) -> Figure:
    """Draw frequencies against nodal diameter, with a free and with a clamped centre of the disk.

    Args:
        data: result of `bw.veering`.
        families: number of families, or None for all.
    """
    from bladewhirl.postprocess.modal.veering import plot_families

    return plot_families(data, families)


def shaft_veering(data: xr.Dataset) -> Figure:
    """Draw the modes with k = 1 of `bw.veering(case)` against the stiffness of the shaft."""
    from bladewhirl.postprocess.modal.veering import plot_shaft_veering

    return plot_shaft_veering(data)

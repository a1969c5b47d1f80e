"""Shares of the regimes in the random draws of each point, with confidence intervals."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.plotting.legends import Group, entries_of
from bladewhirl.postprocess.plotting.style import FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.sweep import drawing
from bladewhirl.postprocess.sweep.quantities import LINE, along, main_key
from bladewhirl.postprocess.sweep.shares import settled, wilson
from bladewhirl.solvers.march.schema import DRAW


def probability(dataset: xr.Dataset, key: str | None = None) -> xr.Dataset:
    """Return the share of each regime in the random draws of every point, with its 95 % interval.

    Args:
        dataset: from `open_sweep`, of a sweep with random draws.
        key: swept key on the horizontal axis of a figure, as a dimension of the sweep; the speed,
            or the first key, if None.

    Returns:
        Dataset over (line, key, regime), with a line for each combination of values of the other
        swept keys: `share`, nan without a finished draw; `low` and `high`, the ends of the Wilson
        interval; and over (line, key): `draws`, the number of finished draws, and `uncertain`, true
        where the interval of a regime includes one half.

    Raises:
        ViewError: the sweep has no random draws, or no point is finished.
    """
    if DRAW not in dataset.dims:
        raise ViewError("probability: expected a sweep with random draws (--draws)")
    main = key or main_key(dataset)
    drawn = along(dataset, main, ["regime"])  # the draw varies fastest along the lines
    count = dataset.sizes[DRAW]
    regime = drawn["regime"].values.reshape(-1, count, drawn.sizes[main])
    data = drawn.isel({LINE: slice(None, None, count)}).drop_vars([DRAW, "regime", "state"])
    finished = np.isin(regime, list(drawing.REGIME_COLOURS)).sum(axis=1).astype(np.float64)
    hits = np.stack([(regime == name).sum(axis=1) for name in drawing.REGIME_COLOURS], axis=-1)
    low, high = wilson(hits.astype(np.float64), finished[..., None])
    with np.errstate(invalid="ignore"):
        share = hits / finished[..., None]
    over = (LINE, main, "regime")
    return (
        data.assign(
            share=(over, share, {"units": "1"}),
            low=(over, low, {"units": "1"}),
            high=(over, high, {"units": "1"}),
            draws=(over[:-1], finished, {"units": "1"}),
            uncertain=(over[:-1], ~settled(low, high)),
        )
        .assign_coords(regime=("regime", list(drawing.REGIME_COLOURS)))
        .assign_attrs(title=f"shares of the regimes in {count} random draws")
    )


@styled
def plot_probability(data: xr.Dataset) -> Figure:
    """Plot the share of each regime from `probability`, with 95 % intervals, in a panel for each
    line of the data."""
    data = drawing.in_handy_units(data)
    lines = drawing.lines_of(data)
    figure = new_figure(width=FULL_WIDTH, height=0.03 + 0.045 * len(lines))
    panels = figure.subplots(len(lines), sharex=True, squeeze=False)[:, 0]
    for axes, line in zip(panels, lines, strict=True):
        for name, colour in drawing.REGIME_COLOURS.items():
            one = line.data.sel(regime=name)
            if not (one["share"] > 0.0).any():
                continue
            axes.fill_between(line.place, one["low"], one["high"], color=colour, alpha=0.2, lw=0)
            mark, size = drawing.REGIME_MARKS[name], drawing.MARK_SIZE
            axes.plot(line.place, one["share"], color=colour, marker=mark, ms=size, label=name)
        axes.set(ylim=(-0.02, 1.02), ylabel="share of random draws [–]", title=line.label)
        axes.axhline(0.5, color="black", linewidth=0.5, linestyle=":")
    drawing.label_figure(figure, data, Group(entries_of(*panels), "Bands are 95 % intervals."))
    return figure

"""Figure of the regime and of the growth rate at each point of a sweep."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from bladewhirl.postprocess.energy.growth_rates import CERTAINTY
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.plotting.axes import draw_map
from bladewhirl.postprocess.plotting.legends import Group
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.sweep import drawing

NOT_JUDGED = "The marches are too short to judge growth; sustained means contact up to the end."

#: marks in the cells show the regimes if there are at most this many columns and rows
MOST_MARKED = 24
HATCH = "//////"  #: hatching of cells without a result
LEFT_OUT = "skipped, outcome known"  #: name of random draws that were skipped, in white cells

Names = NDArray[np.str_]


@styled
def plot_regimes(data: xr.Dataset) -> Figure:
    """Draw a strip of regimes for each line of the data from `quantities.regimes`, and below the
    strips the growth rates.

    Error bars show `CERTAINTY` standard errors. Points without a result are hatched.
    """
    data, judged = drawing.in_handy_units(data), bool(np.isfinite(data["growth_rate"].values).any())
    lines = drawing.lines_of(data)
    strips = 0.005 * len(lines) + 0.005
    groups = [Group(regime_entries(regime_names(data)), "" if judged else NOT_JUDGED)]
    figure = new_figure(width=FULL_WIDTH, height=strips + (0.08 if judged else 0.035))
    heights = (strips, 0.05) if judged else (1.0,)
    panels = figure.subplots(len(heights), sharex=True, height_ratios=heights, squeeze=False)[:, 0]
    at = np.arange(len(lines), dtype=np.float64)
    draw_regimes(panels[0], lines[0].place, at, np.array([regime_names(one.data) for one in lines]))
    panels[0].set(ylim=(len(lines) - 0.5, -0.5), yticks=at)
    panels[0].set_yticklabels([line.label or "regime" for line in lines])
    panels[0].set_ylabel(drawing.line_keys(data))
    if judged:
        rate, error = data["growth_rate"].values, data["growth_error"].values
        for line in lines:
            _draw_growth(panels[1], line)
        if threshold := linear_threshold(rate, error):
            groups.append(Group([_scale_change(panels[1], threshold)]))
        panels[1].axhline(0.0, color=COLOURS["total"], linewidth=0.6, zorder=1)
        panels[1].set_ylabel(f"growth rate\n± {CERTAINTY:g} errors [1/s]")
        groups.append(drawing.lines_group(lines, marked=False))
    drawing.label_figure(figure, data, *groups)
    return figure


def regime_names(data: xr.Dataset) -> Names:
    """Return the names of the regimes from data with `regime` and `state`; `LEFT_OUT` for
    random draws that were skipped because the outcome of their point was already known."""
    left_out = data["state"] == "not-needed"
    return np.asarray(data["regime"].where(~left_out, LEFT_OUT).values.astype(str))


def draw_regimes(axes: Axes, x: Array, y: Array, regime: Names) -> None:
    """Plot a map with a coloured cell for each entry of `regime` (rows, columns).

    Few cells also have marks. Hatched cells have no result. White cells are random draws that were
    skipped because the outcome of their point was already known. The cells fill the panel; their
    middles are at `x` (columns,) and `y` (rows,).
    """
    codes = np.full(regime.shape, -1)
    for number, name in enumerate(drawing.REGIME_COLOURS):
        codes[regime == name] = number
    axes.patch.set(hatch=HATCH, edgecolor=COLOURS["rest"])
    draw_map(
        axes,
        drawing.edges_of(x),
        drawing.edges_of(y),
        np.ma.masked_less(codes, 0),
        cmap=ListedColormap(list(drawing.REGIME_COLOURS.values())),
        vmin=-0.5,
        vmax=len(drawing.REGIME_COLOURS) - 0.5,
    )
    if (regime == LEFT_OUT).any():
        white = np.ma.masked_equal(regime != LEFT_OUT, True)
        draw_map(
            axes, drawing.edges_of(x), drawing.edges_of(y), white, cmap=ListedColormap(["white"])
        )
    if max(regime.shape) > MOST_MARKED:
        return
    for name, mark in drawing.REGIME_MARKS.items():
        row, column = np.nonzero(regime == name)
        axes.plot(
            x[column], y[row], mark, color="black", markersize=2.5, scalex=False, scaley=False
        )


def regime_entries(regime: Names) -> list[tuple[Patch | tuple[Patch, Line2D], str]]:
    """Return the legend entries of the regimes, each with the number of its points, from the names
    of the regimes of all points."""
    entries: list[tuple[Patch | tuple[Patch, Line2D], str]] = []
    for name, colour in drawing.REGIME_COLOURS.items():
        if count := int(np.count_nonzero(regime == name)):
            mark = Line2D(
                [], [], color="black", marker=drawing.REGIME_MARKS[name], linestyle="none", ms=4
            )
            entries.append(((Patch(color=colour), mark), f"{name}: {count}"))
    if left_out := int(np.count_nonzero(regime == LEFT_OUT)):
        entries.append((Patch(fc="white", ec=COLOURS["rest"]), f"{LEFT_OUT}: {left_out}"))
    if rest := int(np.count_nonzero(~np.isin(regime, [*drawing.REGIME_COLOURS, LEFT_OUT]))):
        hatched = Patch(fc="white", ec=COLOURS["rest"], hatch=HATCH)
        entries.append((hatched, f"no result: {rest}"))
    return entries


def linear_threshold(rate: Array, error: Array) -> float | None:
    """Return the power of ten [1/s] up to which an axis of growth rates is linear, and logarithmic
    above; None if the entire axis is linear.

    The returned rate exceeds the medians of rates and uncertainties, so that noise is in the linear
    part of the axis. `rate` contains growth rates [1/s], NaN for points without a growth rate, and
    `error` the standard error of each rate [1/s].
    """
    usual = max(np.nanmedian(np.abs(rate)), CERTAINTY * np.nanmedian(error), 1e-12)
    threshold = float(10.0 ** np.ceil(np.log10(usual)))
    return threshold if np.nanmax(np.abs(rate)) > threshold else None


def _scale_change(axes: Axes, threshold: float) -> tuple[Patch, str]:
    """Make an axis logarithmic beyond `threshold` [1/s] in both directions; shade its linear part,
    and return the legend entry of the shading."""
    axes.set_yscale("symlog", linthresh=threshold)
    look: dict[str, Any] = {"facecolor": COLOURS["casing"], "alpha": 0.25, "linewidth": 0.0}
    axes.axhspan(-threshold, threshold, zorder=0, **look)
    words = f"linear scale up to ±{threshold:g} 1/s, logarithmic scale beyond"
    return Patch(**look), words


def _draw_growth(axes: Axes, line: drawing.Line) -> None:
    rate, error = line.data["growth_rate"].values, line.data["growth_error"].values
    axes.plot(line.place, rate, color=line.colour, linestyle=line.dash)
    axes.errorbar(line.place, rate, CERTAINTY * error, fmt="none", ecolor=line.colour)
    for name, mark in drawing.REGIME_MARKS.items():
        here = line.data["regime"].values == name
        axes.plot(
            line.place[here], rate[here], mark, color=line.colour, markersize=drawing.MARK_SIZE
        )

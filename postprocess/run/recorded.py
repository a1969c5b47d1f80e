"""Figures of any recorded quantity over time."""

import textwrap

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.windows import span_means, span_starts
from bladewhirl.postprocess.plotting.style import new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.solvers.march.schema import HISTORY

MOST = 12  #: largest number of lines that are drawn

LETTERS = 30  #: largest number of letters in a line of the label of the vertical axis

SPANS = 300  #: largest number of drawn points of a line
HEIGHT = 0.06  #: height of a figure [m]


def recorded(result: xr.Dataset, *, name: str) -> xr.Dataset:
    """Return a recorded variable of a result over time; of more than `MOST` columns those with the
    largest values."""
    values, dimensions = result[name].values, tuple(map(str, result[name].dims))
    coordinates = {"time": result["time"].values}
    if values.ndim > 1:
        kept = np.sort(np.argsort(-np.abs(values).max(axis=0), kind="stable")[:MOST])
        values, coordinates[dimensions[1]] = values[:, kept], kept
    about = HISTORY[name]
    data = labelled(result, name, {name: (dimensions, values, about.units)}, coordinates)
    data[name].attrs["long_name"] = about.long_name
    return data


@styled
def plot_recorded(data: xr.Dataset) -> Figure:
    """Draw the only variable of a Dataset over time, a line for each column."""
    (name,) = data.data_vars
    values = data[name]
    figure = new_figure(height=HEIGHT)
    axes = figure.add_subplot()
    time, starts = values["time"].values, span_starts(values["time"].values, SPANS)
    lines = axes.plot(time[starts], span_means(1.0 * values.values, starts))
    if len(starts) < len(time):
        for line, column in zip(lines, np.atleast_2d(values.values.T), strict=True):
            low, high = (each.reduceat(column, starts) for each in (np.minimum, np.maximum))
            axes.fill_between(time[starts], low, high, color=line.get_color(), alpha=0.25, lw=0)
        span = handy(float(np.ptp(time)) / SPANS, "s", 2)
        axes.set_title(f"lines: means over {span}; areas: extremes")
    if values.ndim > 1:
        column = values.dims[1]
        title = str(column).replace("_", " ")
        axes.legend(lines, values[column].values, title=title, loc="upper right")
    text, unit = values.attrs["long_name"], values.attrs["units"]
    axes.set_ylabel(textwrap.fill(text if unit == "1" else f"{text} [{unit}]", LETTERS))
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=values.dtype.kind == "i"))
    time_axis(axes)
    head(figure, data)
    return figure

"""Haigh diagram: mean and alternating stress of every blade against the limits of its material."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.plotting.axes import AROUND, Labels
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.run.extremes import stress_split
from bladewhirl.postprocess.run.stresses import LIMITS, utilisation

NARROWEST = 0.1
"""Without limits the axis of the mean stress reaches at least this share of the largest alternating
stress on both sides, of von Mises stresses, which have no sign, on one."""
TOGETHER = 2.0  #: points at this distance or less share a label [points]
BESIDE = [*reversed(AROUND)]  #: offsets of a label: beside its point first
ROOM = 1.15  #: largest value of an axis, divided by the largest value drawn


def haigh(stresses: xr.Dataset) -> xr.Dataset:
    """Return mean and alternating stress of every blade, and their margin.

    Args:
        stresses: from `stresses.stress_history`.

    Returns:
        Dataset over blade: `mean` and `alternating` [Pa], nan for a lost blade; `margin` [1], the
        factor on both up to the straight line between `material.endurance` and
        `material.strength`, if the case gives both. The attribute `worst` is the number of the
        blade with the least margin or, without limits, the largest stress; -1 if all are lost.
    """
    blades = stresses.isel(member=stresses["member"].str.startswith("blade "))
    mean, alternating = blades["mean_stress"].values, blades["alternating_stress"].values
    values: dict[str, Any] = {
        "mean": ("blade", mean, "Pa"),
        "alternating": ("blade", alternating, "Pa"),
    }
    limits = {name: float(stresses.attrs[name]) for name in LIMITS if name in stresses.attrs}
    if len(limits) == len(LIMITS):
        with np.errstate(divide="ignore"):
            values["margin"] = ("blade", 1.0 / utilisation(mean, alternating, limits), "1")
    worst = stress_split(stresses)
    return labelled(
        stresses,
        "mean and alternating stress of the blades",
        values,
        {"blade": np.arange(len(mean))},
        measure=stresses.attrs["measure"],
        steady=stresses.attrs["steady"],
        worst=-1 if worst is None else int(worst["member"].removeprefix("blade ")),
        **limits,
    )


@styled
def plot_haigh(data: xr.Dataset) -> Figure:
    """Draw the Haigh diagram from `haigh`."""
    figure = new_figure(height=0.07)
    axes = figure.add_subplot()
    draw_haigh(axes, data)
    head(figure, data)
    number_blades(axes, data)
    return figure


def draw_haigh(axes: Axes, data: xr.Dataset) -> None:
    """Draw mean and alternating stress of every blade in a panel, and the line of the limits."""
    unit, scale = _unit(data)
    mean, alternating = scale * data["mean"].values, scale * data["alternating"].values
    left, right = float(np.nanmin(mean, initial=0.0)), float(np.nanmax(mean, initial=0.0))
    top = float(np.nanmax(alternating, initial=0.0))
    if "margin" in data:
        endurance, strength = (scale * float(data.attrs[name]) for name in LIMITS)
        line = [left, 0.0, strength], [endurance, endurance, 0.0]
        axes.plot(*line, color=COLOURS["k = 1"], clip_on=False)
        top, right = max(top, endurance), max(right, strength)
    else:
        signed = data.attrs["measure"] == "beam theory"
        left, right = min(left, -NARROWEST * top) * signed, max(right, NARROWEST * top)
    worst = data["blade"].values == data.attrs["worst"]
    for here, colour in ((~worst, "k = 0"), (worst, "total")):
        if here.any():  # an empty line that is not clipped would stretch the layout
            places = mean[here], alternating[here]
            axes.plot(*places, "o", color=COLOURS[colour], markersize=3.5, clip_on=False, zorder=4)
    axes.set(xlim=(ROOM * left, ROOM * (right or 1.0)), ylim=(0.0, ROOM * (top or 1.0)))
    of_what = "surface" if data.attrs["measure"] == "beam theory" else "von Mises"
    rotation = "with" if data.attrs["steady"] else "without"
    axes.set_xlabel(f"mean {of_what} stress [{unit}],\n{rotation} that of steady rotation")
    axes.set_ylabel(f"alternating stress [{unit}]")
    axes.locator_params(axis="x", nbins=5)
    axes.set_title(_worst(data))


def number_blades(axes: Axes, data: xr.Dataset) -> None:
    """Write the numbers of several blades beside their points, the worst first, where there is
    space; the figure must be complete except for them."""
    _, scale = _unit(data)
    mean, alternating = scale * data["mean"].values, scale * data["alternating"].values
    seen = np.flatnonzero(np.isfinite(alternating))
    if data.sizes["blade"] == 1 or not len(seen):
        return
    labels = Labels(axes)
    labels.keep_free(mean[seen], alternating[seen])
    places = axes.transData.transform(np.column_stack([mean, alternating]))
    near = TOGETHER * axes.figure.dpi / 72.0
    waiting = sorted(seen, key=lambda number: number != data.attrs["worst"])
    while waiting:
        apart = np.linalg.norm(places[waiting] - places[waiting[0]], axis=1)
        group = [blade for blade, far in zip(waiting, apart, strict=True) if far < near]
        text = ", ".join(str(blade) for blade in sorted(group))
        labels.add(mean[group[0]], alternating[group[0]], text, COLOURS["total"], BESIDE)
        waiting = [blade for blade in waiting if blade not in group]


def _unit(data: xr.Dataset) -> tuple[str, float]:
    """Return the unit of the axes, and the factor from Pa to it."""
    limits = [float(data.attrs[name]) for name in LIMITS if name in data.attrs]
    drawn = np.abs([*data["mean"].values, *data["alternating"].values, *limits])
    return handy_unit(float(np.nanmax(drawn, initial=0.0)), "Pa")


def _worst(data: xr.Dataset) -> str:
    """Return the worst blade with its margin, or what the case must give for a margin."""
    if data.attrs["worst"] < 0:
        return "all blades are lost"
    blade = f"blade {data.attrs['worst']}"
    if "margin" in data:
        return f"{blade}: margin {float(data['margin'][data.attrs['worst']]):.3g}"
    lacks = [f"material.{name}" for name in LIMITS if name not in data.attrs]
    return f"{blade}; no margin, as the case gives no\n{' and no '.join(lacks)}"

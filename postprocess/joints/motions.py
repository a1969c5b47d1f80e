"""Figure of periodic motions with joints: hysteresis loops, states over the period, amplitudes."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.joints.curves import DASHES, some_of
from bladewhirl.postprocess.plotting.axes import blade_axis, draw_states
from bladewhirl.postprocess.plotting.legends import Group, entries_of, legends_below
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    FULL_WIDTH,
    new_figure,
    side_by_side,
    styled,
)
from bladewhirl.postprocess.plotting.titles import set_title

TOP = 1.15  #: upper end of the axis of amplitudes, relative to the largest one
SHOWN = 5  #: largest number of speeds whose loops are drawn


@styled
def plot_joints(data: xr.Dataset) -> Figure:
    """Draw the tangential force over the tangential displacement at the first joint node, the
    states of this node on all blades over a period at one speed, and the amplitudes of points
    over speed, from `bladewhirl.periodic`."""
    figure = new_figure(width=FULL_WIDTH, height=0.07)
    loops, states, curve = side_by_side(figure, 3)
    order = np.argsort(data["rpm"].values, kind="stable")
    chosen = some_of(len(order), SHOWN)
    first = data.isel(joint_node=0)
    moved, force = first["relative_displacement"].values[..., 1:], first["tangential_force"].values
    around = [*range(data.sizes["instant"]), 0]
    shown = [int(order[place]) for place, _ in chosen]
    unit, scale = handy_unit(float(np.abs(moved[shown]).max()), "m")
    for n, (_, shade) in zip(shown, chosen, strict=True):
        main = int(np.ptp(moved[n], axis=0).argmax())
        place, label = scale * moved[n, around, main], f"{float(data['rpm'][n]):.6g} rpm"
        loops.plot(place, force[n, around, main], color=shade, label=label)
    loops.set(xlabel=f"tangential displacement [{unit}]", ylabel="tangential force [N]")
    loops.set_title(f"joint {first['name'].item()}")
    blades, largest = (
        int(data.attrs["blades"]),
        int(data["share_slipping"].max("joint").values.argmax()),
    )
    own = first["state"].values[largest]
    turn = 60.0 / abs(float(data["rpm"][largest]))
    ahead = turn / float(data["period"][largest]) * len(own) / blades
    rows = [np.roll(own, -round(ahead * blade)) for blade in range(blades)]
    edges = np.linspace(0.0, 1.0, len(own) + 1)
    meaning = draw_states(states, edges, np.arange(blades), rows)
    blade_axis(states, blades, of_y=True)
    states.set(xlabel="share of the period", ylabel="joint after blade")
    states.set_title(f"states at {float(data['rpm'][largest]):.6g} rpm")
    ordered, draw = data.isel(speed=order), _draw_amplitudes if has_points(data) else _draw_shares
    draw(curve, ordered, data["rpm"].values[order], ".-")
    curve.set_xlabel("speed [rpm]")
    curve.locator_params(axis="x", nbins=5)
    set_title(figure, str(data.attrs["case"]), "periodic motions of all blades")
    legends_below(figure, Group(entries_of(loops)), meaning, Group(entries_of(curve)))
    return figure


def _draw_amplitudes(axes: Axes, data: xr.Dataset, over: FloatArray, style: str) -> str:
    """Draw the amplitudes of points, the linear limits of the first one, and motions that are not
    stable, over a parameter; return the unit."""
    size = np.linalg.norm(data["point_amplitude"].values, axis=-1)
    unit, scale = handy_unit(float(size.max(initial=0.0)), "m")
    for number, values in zip(data["point"].values.tolist(), size.T, strict=True):
        axes.plot(over, scale * values, style, label=f"{data.attrs['points']} {number}")
    axes.set(ylabel=f"amplitude [{unit}]")
    limits = data["linear_limit"].isel(point=0)
    for name, dashes in zip(data["limit"].values.tolist(), DASHES, strict=True):
        values = scale * limits.sel(limit=name).values
        axes.plot(over, values, dashes, color=COLOURS["rest"], zorder=1, label=name)
    lost = ~data["stable"].values
    if lost.any():
        axes.plot(over[lost], scale * size[lost, 0], "x", color="black", ms=3, label="not stable")
    axes.set_ylim(0.0, TOP * scale * size.max())
    return unit


def _draw_shares(axes: Axes, data: xr.Dataset, over: FloatArray, style: str) -> None:
    """Draw the shares of the period in which the joints are open and slip over a parameter."""
    for name, label in (("share_open", "open"), ("share_slipping", "slipping")):
        axes.plot(over, data[name].max("joint").values, style, label=label)
    axes.set(ylabel="share of the period", ylim=(0.0, 1.0))


def has_points(data: xr.Dataset) -> bool:
    """Return whether the amplitudes of points are known."""
    return bool(data.sizes["point"])


@styled
def plot_joint_branch(data: xr.Dataset) -> Figure:
    """Draw the amplitudes of points over a key, with the smallest one of the first point, the
    linear limits, and the shares of the period in which the joints are open and slip."""
    figure = new_figure(width=FULL_WIDTH, height=0.07)
    *curves, shares = side_by_side(figure, 1 + has_points(data))
    over = data["parameter"].values
    for curve in curves:
        unit = _draw_amplitudes(curve, data, over, "-")
        size = np.linalg.norm(data["point_amplitude"].isel(point=0).values, axis=-1)
        least, scale = int(size.argmin()), handy_unit(float(size.max()), "m")[1]
        label = f"smallest: {scale * size[least]:.4g} {unit} at {over[least]:.4g}"
        curve.plot(over[least], scale * size[least], "o", color=COLOURS["k = 1"], ms=4, label=label)
    _draw_shares(shares, data, over, "-")
    for axes in (*curves, shares):
        axes.set_xlabel(f"{data.attrs['key']} [{data.attrs['unit'] or '–'}]")
        axes.locator_params(axis="x", nbins=5)
    set_title(figure, str(data.attrs["case"]), "periodic motions of all blades")
    legends_below(figure, *(Group(entries_of(axes)) for axes in (*curves, shares)))
    return figure

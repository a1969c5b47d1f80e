"""Figure of periodic motions with joints: hysteresis loops, states over angle, amplitudes."""

import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from bladewhirl.postprocess.plotting.style import FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title

SHOWN = 5  #: largest number of speeds whose loops are drawn
STATES = ("open", "stuck", "slipping")


@styled
def plot_joints(data: xr.Dataset) -> Figure:
    """Draw the tangential force over the tangential displacement at the first joint node, the
    states of this node on all blades over the angle at one speed, and the amplitudes of points
    over speed, from `bladewhirl.periodic`."""
    figure = new_figure(width=FULL_WIDTH, height=0.06)
    loops, states, curve = figure.subplots(1, 3)
    order = np.argsort(data["rpm"].values, kind="stable")
    chosen = np.unique(np.linspace(0, len(order) - 1, SHOWN).round().astype(int))
    for n in order[chosen].tolist():
        one = data.isel(speed=n, joint_node=0)
        moved = one["relative_displacement"].values[:, 1:]
        main = int(np.ptp(moved, axis=0).argmax())
        around = [*range(len(moved)), 0]
        force = one["tangential_force"].values[around, main]
        loops.plot(1e6 * moved[around, main], force, label=f"{float(one['rpm']):.6g} rpm")
    loops.set(xlabel="tangential displacement [µm]", ylabel="tangential force [N]")
    loops.legend(loc="best")
    largest = int(data["share_slipping"].max("joint").values.argmax())
    one = data.isel(speed=largest, joint_node=0)
    own = one["state"].values
    ahead = data.attrs["engine_order"] * len(own) / data.attrs["blades"]
    rows = [np.roll(own, -round(ahead * blade)) for blade in range(data.attrs["blades"])]
    colours = ListedColormap(["white", "0.75", "tab:red"])
    extent = (0.0, 1.0, data.attrs["blades"] - 0.5, -0.5)
    states.imshow(rows, aspect="auto", cmap=colours, vmin=0, vmax=2, extent=extent)
    states.set(
        xlabel="share of the period",
        ylabel="joint after blade",
        title=f"{float(one['rpm']):.6g} rpm: {', '.join(STATES)} (white, grey, red)",
    )
    size = np.linalg.norm(data["point_amplitude"].values, axis=-1)
    for place, number in enumerate(data["point"].values.tolist()):
        values = 1e3 * size[order, place]
        curve.plot(data["rpm"].values[order], values, ".-", label=f"point {number}")
    curve.set(xlabel="speed [rpm]", ylabel="amplitude [mm]")
    if data.sizes["point"]:
        curve.legend(loc="best")
    set_title(figure, data.attrs["case"], "periodic motions with joints")
    return figure

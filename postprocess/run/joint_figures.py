"""Friction joints between the blades of a run: hysteresis loops, and states over time by blade."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.plotting.axes import blade_axis, draw_states
from bladewhirl.postprocess.plotting.legends import Group, entries_of, legends_below
from bladewhirl.postprocess.plotting.style import (
    FULL_WIDTH,
    new_figure,
    side_by_side,
    styled,
)
from bladewhirl.postprocess.plotting.titles import head

TURNS = 2.0  #: number of revolutions at the end that are shown
LOOPS = 4  #: largest number of pairs of nodes whose loops are drawn


def joint_motion(result: xr.Dataset) -> xr.Dataset:
    """Compute forces and displacements of joints along the tangent of the largest motion, and their
    states, in the last revolutions.

    Returns:
        Dataset over (time, joint_pair): `displacement` [m], of the next blade relative to a blade,
        `force` [N], `normal` [N], and `state`, that of most steps since the last record: 0 open,
        1 stuck, 2 slipping; `turn`, the number of revolutions, (time,).

    Raises:
        ViewError: there are fewer than two records.
    """
    turned = rotation.turns(result)
    chosen = np.flatnonzero(turned >= turned[-1] - TURNS)
    if len(chosen) < 2:
        raise ViewError("joints: expected two records in the last revolutions")
    late = result.isel(time=chosen)
    moved, force = (late[f"joint_{name}"].values for name in ("displacement", "force"))
    main = np.ptp(moved[..., 1:], axis=0).argmax(axis=1)
    pairs, over = np.arange(len(main)), ("time", "joint_pair")
    return labelled(
        result,
        "friction joints",
        {
            "displacement": (over, moved[:, pairs, 1 + main], "m"),
            "force": (over, force[:, pairs, 1 + main], "N"),
            "normal": (over, force[..., 0], "N"),
            "state": (over, late["joint_steps"].values.argmax(axis=2), "1"),
            "turn": (("time",), turned[chosen], "1"),
            "name": (("joint_pair",), late["joint_name"].values, ""),
            "blade": (("joint_pair",), late["joint_blade"].values, "1"),
        },
        {"time": late["time"].values, "joint_pair": pairs},
    )


@styled
def plot_joint_motion(data: xr.Dataset) -> Figure:
    """Draw hysteresis loops of the pairs that move most, and the states of all pairs, from
    `joint_motion`."""
    figure = new_figure(width=FULL_WIDTH, height=0.08)
    loops, states = side_by_side(figure, 2)
    swing = np.ptp(data["displacement"].values, axis=0)
    unit, scale = handy_unit(float(np.abs(data["displacement"]).max()), "m")
    for pair in sorted(np.argsort(-swing, kind="stable")[:LOOPS].tolist()):
        one = data.isel(joint_pair=pair)
        label = f"{one['name'].item()}, after blade {int(one['blade'])}"
        loops.plot(scale * one["displacement"], one["force"], linewidth=0.8, label=label)
    loops.set(xlabel=f"tangential displacement [{unit}]", ylabel="tangential force [N]")
    loops.locator_params(nbins=6)
    turn, pairs = data["turn"].values, np.arange(data.sizes["joint_pair"])
    meaning = draw_states(states, turn, pairs, data["state"].values[1:].T)
    blade_axis(states, len(pairs), of_y=True)
    states.set(xlabel="revolutions", ylabel="pair of joint nodes")
    states.locator_params(axis="x", nbins=5)
    head(figure, data)
    legends_below(figure, Group(entries_of(loops)), meaning)
    return figure

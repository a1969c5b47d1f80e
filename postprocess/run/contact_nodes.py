"""Contact nodes over time and the motion of the casing around them: Datasets and figures."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.models.stage.coating import track_edges
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import has, need
from bladewhirl.postprocess.fields.nodes import DIRECTIONS, ring_displacement
from bladewhirl.postprocess.fields.wheels import of_wheel, wheel_numbers
from bladewhirl.postprocess.plotting.axes import draw_map
from bladewhirl.postprocess.plotting.legends import Group, entries_of, legends_below
from bladewhirl.postprocess.plotting.style import (
    COLOUR_MAPS,
    COLOURS,
    FULL_WIDTH,
    new_figure,
    side_by_side,
    styled,
    time_axis,
)
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.run.wear import draw_volume

FEW = 6
"""Up to this number of blades each blade has a line; for more blades, the largest and the mean
force are drawn."""

ALONE = 5e-4  #: half of the drawn width of the only track [m]
LINES = 6  #: largest number of nodal diameters drawn, those with the largest energy
RING = ("casing_angle", "casing_wheel")  #: coordinates of casing nodes


def contact_nodes(result: xr.Dataset) -> xr.Dataset:
    """Compute the mean contact forces between records, and the share of time in contact.

    Args:
        result: result of a run whose contact nodes are recorded.

    Returns:
        Dataset over (time, contact_node): `force` and `friction` [N], means of the normal and the
        tangential force of the wall since the last record; `share` [1]. `impulse` [N s] over
        (contact_node) is the sum of the normal impulses. Ends of joints are left out, unless there
        are no other nodes.
    """
    if has(result, "joints"):
        tips = np.setdiff1d(np.arange(result.sizes["contact_node"]), result["joint_end"])
        result = result.isel(contact_node=tips) if len(tips) else result
    spacing = np.diff(result["time"].values, prepend=-np.inf)[:, None]
    steps = spacing / float(result.attrs["time_step"])
    over = ("time", "contact_node")
    impulse = result["contact_impulse"].values
    computed = labelled(
        result,
        "contact forces by contact node",
        {
            "force": (over, impulse / spacing, "N"),
            "friction": (over, result["friction_impulse"].values / spacing, "N"),
            "share": (over, result["contact_steps"].values / steps, "1"),
            "impulse": (("contact_node",), impulse.sum(axis=0), "N s"),
        },
        {"time": result["time"].values},
    )
    places = ("blade", "node", "tip_angle", "axial_position")
    return computed.assign_coords({name: result[name] for name in places})


def tip_orbits(result: xr.Dataset, *, turns: float = 5.0, copy: int = 0) -> xr.Dataset:
    """Return the displacements of the contact nodes of a copy in the last revolutions.

    Args:
        result: result of a run whose contact nodes are recorded.
        turns: number of revolutions; at standstill the whole run is returned.
        copy: number of the copy.

    Returns:
        Dataset over (time, node): `radial`, `tangential` and `axial` [m], in rotating axes; `blade`
        (node,) is the number of its blade.
    """
    time, turned = result["time"].values, rotation.turns(result)
    last = turned >= turned[-1] - turns
    nodes = result.sizes["contact_node"] // result.sizes["copy"]
    moved = result["contact_displacement"][last, copy * nodes : (copy + 1) * nodes].values
    return labelled(
        result,
        f"displacements of the contact nodes of copy {copy}",
        {name: (("time", "node"), moved[:, :, i], "m") for i, name in enumerate(DIRECTIONS)},
        {"time": time[last]},
    ).assign_coords(blade=("node", result["blade"].values[copy * nodes : (copy + 1) * nodes]))


def ring_motion(result: xr.Dataset) -> xr.Dataset:
    """Compute displacement and strain energy of a flexible casing over time.

    Args:
        result: result of a run with a flexible casing.

    Returns:
        Dataset: `radial` and `tangential` [m] over (time, casing_node); `energy` [J] over (time,
        nodal_diameter), the strain energy of the casing and its supports; over (time, wheel,
        nodal_diameter) if several wheels of a shaft line have a ring.

    Raises:
        ResultError: the casing is rigid.
    """
    need(result, "casing_displacement")
    records = np.arange(result.sizes["time"])
    moved = ring_displacement(result, records)
    squares = result["casing_frequency"].values * result["casing_displacement"].values
    diameter, member = np.unique(result["casing_nodal_diameter"].values, return_inverse=True)
    numbers = wheel_numbers(result)
    energy = np.zeros((len(squares), len(numbers), len(diameter)))
    for place, number in enumerate(numbers):
        own = of_wheel(result, number)["casing_shape"].values.any(axis=(0, 1))
        energy[:, place] = 0.5 * squares[:, own] ** 2 @ np.eye(len(diameter))[member[own]]
    over, several = ("time", "casing_node"), len(numbers) > 1
    coordinates = {"time": result["time"].values, "nodal_diameter": diameter}
    return labelled(
        result,
        "motion of the casing",
        {
            "radial": (over, moved[:, :, 0], "m"),
            "tangential": (over, moved[:, :, 1], "m"),
            "energy": (("time", "wheel", "nodal_diameter"), energy, "J")
            if several
            else (("time", "nodal_diameter"), energy[:, 0], "J"),
        },
        coordinates | {"wheel": numbers} if several else coordinates,
    ).assign_coords({name: result[name] for name in RING if name in result})


@styled
def plot_contact_nodes(data: xr.Dataset) -> Figure:
    """Draw the normal force on each blade, and on each contact node, over time.

    Args:
        data: dataset from `contact_nodes`.
    """
    figure = new_figure(width=FULL_WIDTH, height=0.1)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, 1.3])
    time, force = data["time"].values, data["force"].values
    blades, number = np.unique(data["blade"].values, return_inverse=True)
    by_blade = np.array([force[:, number == n].sum(axis=1) for n in range(len(blades))])
    unit, scale = handy_unit(float(by_blade.max()), "N")
    if len(blades) <= FEW:
        for blade, line in zip(blades, by_blade, strict=True):
            above.plot(time, scale * line, linewidth=0.7, label=f"blade {blade}")
    else:
        above.plot(time, scale * by_blade.max(axis=0), linewidth=0.7, label="largest of all blades")
        above.plot(time, scale * by_blade.mean(axis=0), linewidth=0.7, label="mean of all blades")
    above.set_ylabel(f"normal force\nof a blade [{unit}]")
    look: dict[str, Any] = {"label": f"normal force [{unit}]", "cmap": COLOUR_MAPS["contact"]}
    shown = np.ma.masked_equal(scale * force.T, 0.0)  # white
    draw_map(below, _time_edges(time), np.arange(force.shape[1]), shown, vmin=0.0, **look)
    for first in np.flatnonzero(np.diff(number)) + 1:
        below.axhline(float(first) - 0.5, color=COLOURS["rest"], linewidth=0.3)
    below.set_ylabel("contact node" if len(blades) == 1 else "contact node, blade by blade")
    below.yaxis.set_major_locator(MaxNLocator(8, integer=True))
    time_axis(above, below)
    head(figure, data, f"mean over {handy(float(np.diff(time[:2])[0]), 's', 3)}")
    if len(blades) > 1:
        legends_below(figure, Group(entries_of(above)))
    return figure


@styled
def plot_tip_orbits(data: xr.Dataset) -> Figure:
    """Draw radial against tangential and against axial displacement of three contact nodes of the
    blade that moves most.

    Args:
        data: dataset from `tip_orbits`.
    """
    figure = new_figure(width=FULL_WIDTH, height=0.075)
    panels = side_by_side(figure, 2, sharey=True)
    largest = max(float(np.abs(data[name]).max()) for name in DIRECTIONS)
    unit, scale = handy_unit(largest, "m")
    moved = np.fmax.reduce([np.abs(data[name].values).max(axis=0) for name in DIRECTIONS])
    blade = int(data["blade"][int(moved.argmax())])
    own = np.flatnonzero(data["blade"].values == blade)
    shown = sorted({0, len(own) // 2, len(own) - 1})
    for axes, name in zip(panels, DIRECTIONS[1:], strict=True):
        for node in shown:
            axes.plot(
                scale * data[name].values[:, own[node]],
                scale * data["radial"].values[:, own[node]],
                linewidth=0.6,
                label=f"node {node}",
            )
        axes.set(xlabel=f"{name} displacement [{unit}]", ylabel=f"radial displacement [{unit}]")
        axes.locator_params(nbins=6)
    panels[-1].label_outer(remove_inner_ticks=False)
    span = float(data["time"][-1] - data["time"][0])
    head(figure, data, f"blade {blade}, last {handy(span, 's', 3)}")
    legends_below(figure, Group(entries_of(panels[0])))
    return figure


@styled
def plot_node_wear(data: xr.Dataset) -> Figure:
    """Draw the removed depth on the unrolled wall, and the removed volume over time, from
    `wear`."""
    figure = new_figure(width=FULL_WIDTH, height=0.1)
    above, below = figure.subplots(2, 1, height_ratios=[1.3, 1.0])
    recess, axial = np.atleast_2d(data["recess"].values[-1]), np.atleast_1d(data["axial"].values)
    unit, scale = handy_unit(float(np.abs(axial).max()), "m")
    depth_unit, depth_scale = handy_unit(float(recess.max()), "m")
    edges = scale * (track_edges(axial) if len(axial) > 1 else axial + np.array([-ALONE, ALONE]))
    degrees = np.linspace(0.0, 360.0, recess.shape[1] + 1)
    label = f"removed depth [{depth_unit}]"
    draw_map(above, degrees, edges, depth_scale * recess, cmap=COLOUR_MAPS["wall"], label=label)
    above.set(xticks=np.arange(0, 361, 45), xlabel="angle on the wall, static frame [°]")
    above.set_ylabel(f"axial position [{unit}]")
    draw_volume(below, data)
    time_axis(below)
    head(figure, data)
    return figure


@styled
def plot_ring(data: xr.Dataset) -> Figure:
    """Draw the radial displacement of the casing over time and angle, and its strain energy by
    nodal diameter.

    Args:
        data: dataset from `ring_motion`.
    """
    numbers = wheel_numbers(data)
    figure = new_figure(width=FULL_WIDTH, height=0.01 + 0.09 * len(numbers))
    ratios = [1.3, 1.0] * len(numbers)
    panels = figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios)
    time, largest = data["time"].values, float(np.abs(data["radial"].values).max())
    unit, scale = handy_unit(largest, "m")
    look: dict[str, Any] = {
        "cmap": COLOUR_MAPS["signed"],
        "label": f"radial\ndisplacement [{unit}]",
    }
    if largest > 0.0:
        look |= {"vmin": -scale * largest, "vmax": scale * largest}
    for above, number in zip(panels[::2], numbers, strict=True):
        ring = of_wheel(data, number)
        degrees = np.degrees(ring["casing_angle"].values)
        draw_map(above, _time_edges(time), degrees, scale * ring["radial"].values.T, **look)
        above.set_ylabel("angle, static frame [°]")
        above.set_yticks(np.arange(0, 361, 90))
        if len(numbers) > 1:
            above.set_title(f"wheel {number}", loc="left")
    diameter = data["nodal_diameter"].values
    energy = data["energy"].values.reshape(len(time), len(numbers), len(diameter))
    unit, scale = handy_unit(float(energy.max()), "J")
    shown = np.sort(np.argsort(-energy.max(axis=(0, 1)), kind="stable")[:LINES])
    for place, below in enumerate(panels[1::2]):
        for column in shown:
            label = f"{diameter[column]}"
            below.plot(time, scale * energy[:, place, column], linewidth=0.7, label=label)
        below.set_ylabel(f"strain energy [{unit}]")
    time_axis(*panels)
    head(figure, data, f"the {len(shown)} nodal diameters with the largest energy")
    legends_below(figure, Group(entries_of(below), "nodal diameter"))
    return figure


def _time_edges(time: Array) -> Array:
    """Return the limits of the intervals that end at each record [s], (time + 1,)."""
    return np.append(time[:1] - np.diff(time[:2]), time)

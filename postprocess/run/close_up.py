"""Close-up of one tip during one pass: its path against the wall, gap, forces, and the motion once
a revolution."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.models.stage.coating import axial_tracks
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.kinematics import (
    Array,
    ViewError,
    history,
    nearest_records,
)
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.wheels import of_wheel, wheel_numbers
from bladewhirl.postprocess.plotting.style import (
    COLOURS,
    FULL_WIDTH,
    INCH,
    is_narrow,
    new_figure,
    styled,
)
from bladewhirl.postprocess.plotting.titles import head

MOST_DOTS = 100  #: largest number of records that are drawn as dots
FEWEST = 12  #: smallest number of records on each side of the largest force
BESIDE = 0.5  #: time shown on each side of the contact, divided by the time in contact
BOXED: Mapping[str, Any] = {"frameon": True, "framealpha": 1.0, "edgecolor": "none"}
LEAST = 0.1  #: least end of the axis of the gap, by the change of the radius of the tip
LEAST_GAP = 1e-9  #: least end of this axis [m]
ROOM = 0.3  #: height of the drawn wall beyond its largest radius, by that of the path
COATING = "#E3C9A0"  #: colour of a coating
WALL = 720  #: smallest number of places on the wall


def close_up(result: xr.Dataset) -> xr.Dataset:
    """Return the pass of a contact node in which the force between two records is largest.

    Args:
        result: result of a run with contact.

    Returns:
        Dataset over time: `angle` [rad] in the static frame at which the march has the node, that
        of its undeformed blade; `radius` [m] of the node, and at this angle of the `wall`, the
        metal below a coating, and of the `coating`, all less the tip radius; `gap` [m], the
        smallest since the last record; `normal` and `friction` [N], means since the last record.
        Over revolution: `radial` and `tangential` [m], the displacement of the node in rotating
        axes at the record nearest to the angle of the largest force, and `passed` [s], its time.

    Raises:
        ViewError: the rotor does not turn, or no tip touches.
    """
    impulse = result["contact_impulse"].values
    record, node = np.unravel_index(impulse.argmax(), impulse.shape)
    if not impulse[record, node]:
        raise ViewError("no blade tip touches the casing")
    if len(wheel_numbers(result)) > 1:
        own = result["wheel"].values
        result = of_wheel(result, int(own[node]))
        node -= np.searchsorted(own, own[node])
    turned = rotation.turns(result)
    if turned[-1] == turned[0]:
        raise ViewError("a pass of a tip needs a rotor that turns")
    touching = result["contact_steps"].values[:, node] > 0
    free = np.flatnonzero(~touching)
    first = int(free[free < record].max(initial=0))
    last = int(free[free > record].min(initial=len(touching) - 1))
    beside = max(FEWEST, int(BESIDE * (last - first)))
    shown = np.arange(max(1, first - beside), min(len(touching), last + beside + 1))
    shown = shown[np.abs(turned[shown] - turned[record]) <= 0.5]
    per_element = -(-WALL // result.sizes.get("casing_node", 1))
    stage = EnlargedStage(result, shown, factor=1.0, pieces=1, per_element=per_element)
    places = np.array([stage.contact_nodes(index)[node, :2] for index in range(len(shown))])
    radius = np.hypot(*places.T)
    angle = float(result["tip_angle"][node]) + stage.turns
    angle -= 2 * np.pi * np.floor(angle.min() / (2 * np.pi))

    def facing(removed: Array | float) -> Array:
        """Return the radius of the wall that the node faces, less a removed depth (record, ...)."""
        depth = np.broadcast_to(removed, (len(shown), len(stage.angle)))
        found = np.empty(len(shown))
        for index in range(len(shown)):
            inner = stage.wall_edge(stage.inner(index, depth[index]), axial)[:, :2]
            at = np.arctan2(inner[:, 1], inner[:, 0])
            found[index] = np.interp(angle[index], at, np.hypot(*inner.T), period=2 * np.pi)
        return found

    axial = float(result["axial_position"][node])
    tip = float(result.attrs["tip_radius"])
    values = {"radius": radius - tip, "wall": facing(0.0) - tip}
    if stage.coating:
        values["wall"] = facing(stage.coating) - tip
        tracks = axial_tracks(result["axial_position"].values, result["contact_radius"].values)[1]
        values["coating"] = facing(stage.wear[:, tracks[node]]) - tip
    length = np.diff(result["time"].values)[shown - 1]
    passes = np.arange(
        int(np.ceil(turned[0] - turned[record])), int(turned[-1] - turned[record]) + 1
    )
    at = np.interp(turned[record] + passes, turned, result["time"].values)
    moved = history(result, "contact_displacement", nearest_records(result, at))[:, node]
    return labelled(
        result,
        "close-up of one pass of a tip",
        {
            "angle": ("time", angle, "rad"),
            **{name: ("time", each, "m") for name, each in values.items()},
            "gap": ("time", result["gap"].values[shown, node], "m"),
            "normal": ("time", impulse[shown, node] / length, "N"),
            "friction": ("time", result["friction_impulse"].values[shown, node] / length, "N"),
            "radial": ("revolution", moved[:, 0], "m"),
            "tangential": ("revolution", moved[:, 1], "m"),
            "passed": ("revolution", at, "s"),
        },
        {"time": result["time"].values[shown]},
        blade=int(result["blade"][node]),
        node=int(result["node"][node]),
        nodes=int((result["blade"].values == result["blade"].values[node]).sum()),
        instant=float(result["time"][record]),
        tip_radius=tip,
    )


@styled
def plot_close_up(data: xr.Dataset) -> Figure:
    """Draw the path of a tip against the wall, its gap and its forces by angle, and its motion once
    a revolution, from `close_up`."""
    figure = new_figure(width=FULL_WIDTH, height=0.12)
    if is_narrow(figure):
        figure.set_figheight(0.2 / INCH)
        path, gap, force, strobe = figure.subplots(4, 1, height_ratios=[1.5, 1.0, 1.0, 1.6])
    else:
        grid = figure.add_gridspec(3, 2, width_ratios=[1.7, 1.0], height_ratios=[1.6, 1.0, 1.0])
        path, gap, force = (figure.add_subplot(grid[row, 0]) for row in range(3))
        strobe = figure.add_subplot(grid[:, 1])
    angle = np.degrees(data["angle"].values)
    _draw_path(path, data, angle)
    smallest, words = data["gap"].values, "gap"
    if "coating" in data:
        smallest, words = smallest - (data["wall"] - data["coating"]).values, "gap to coating"
    # Zero looks like zero: rounding in a lasting contact is far below the motion of the tip.
    reach = max(float(smallest.max()), LEAST * float(np.ptp(data["radius"].values)), LEAST_GAP)
    unit, scale = handy_unit(reach, "m")
    gap.plot(angle, scale * smallest, ".-", color=COLOURS["total"])
    low = min(float(smallest.min()), 0.0)
    gap.set_ylim(scale * min(1.1 * low, -0.05 * reach), 1.05 * scale * reach)
    gap.axhline(0.0, color=COLOURS["rest"], linewidth=0.8)
    gap.set_ylabel(f"{words}\n[{unit}]")
    unit, scale = handy_unit(float(data["normal"].max()), "N")
    for name, colour, marks in (("normal", "k = 1", ".-"), ("friction", "k = 0", ".--")):
        force.plot(angle, scale * data[name].values, marks, color=COLOURS[colour], label=name)
    force.set(ylabel=f"force [{unit}]", xlabel="angle on the casing [°]")
    force.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.0)
    for axes in (path, gap, force):
        axes.set_xlim(*np.sort(angle[[0, -1]]))
        axes.xaxis.set_major_formatter(lambda at, _: f"{at % 360.0:g}")
        if len(angle) > MOST_DOTS:
            for line in axes.lines:
                line.set_marker("")
    _draw_strobe(strobe, data)
    head(figure, data)
    return figure


def _draw_path(axes: Axes, data: xr.Dataset, angle: Array) -> None:
    """Draw the radius of the tip, and of the surface that it meets, over the angle."""
    surface = "coating" if "coating" in data else "wall"
    drawn = {name: data[name].values for name in (surface, "radius")}
    low, high = (float(end(list(drawn.values()))) for end in (np.min, np.max))
    unit, scale = handy_unit(max(abs(low), abs(high)), "m")
    top = scale * (high + ROOM * (high - low))
    colour = {"coating": COATING, "wall": COLOURS["rest"]}[surface]
    axes.fill_between(angle, scale * drawn[surface], top, color=colour, linewidth=0, label=surface)
    axes.plot(angle, scale * drawn["radius"], ".-", color=COLOURS["total"], label="tip")
    axes.set(ylabel=f"radius less\nthat of the tip [{unit}]", ylim=(None, top))
    axes.legend(loc="best", **BOXED)
    several = f", contact node {data.attrs['node']}" if data.attrs["nodes"] > 1 else ""
    when = f"largest force at {handy(data.attrs['instant'], 's', 4)}"
    lasting = ", contact all around" * bool(data["normal"].values.all())
    axes.set_title(f"blade {data.attrs['blade']}{several}, {when}{lasting}")


def _draw_strobe(axes: Axes, data: xr.Dataset) -> None:
    """Draw the displacement once a revolution; that of the last third of the time is black."""
    unit, scale = handy_unit(
        max(float(np.abs(data[name]).max()) for name in ("radial", "tangential")), "m"
    )
    x, y = scale * data["tangential"].values, scale * data["radial"].values
    passed = data["passed"].values
    late = passed > passed[-1] - (passed[-1] - passed[0]) / 3.0
    axes.plot(x[~late], y[~late], ".", color=COLOURS["rest"], label="once a revolution")
    axes.plot(x[late], y[late], ".", color=COLOURS["total"], label="in the last third")
    here = int(np.abs(passed - data.attrs["instant"]).argmin())
    axes.plot(x[here], y[here], "o", mfc="none", color=COLOURS["k = 1"], label="largest force")
    axes.margins(0.15)
    axes.locator_params(nbins=5)
    axes.set_xlabel(f"tangential displacement [{unit}]")
    axes.set_ylabel(f"radial displacement [{unit}]")
    axes.legend(loc="best", **BOXED)

"""Card of a run on one page: what an engineer needs to judge a rub."""

import textwrap
import tomllib

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from bladewhirl.models.case.applied_orders import applied_orders
from bladewhirl.models.case.casing import Casing
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.shaft import Rotation
from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.postprocess.energy.regimes import classify, regime_title
from bladewhirl.postprocess.fields.by_blade import (
    aliased,
    blade_angles,
    blade_count,
    diameter_shares,
    of_blades,
)
from bladewhirl.postprocess.fields.kinematics import Array, table_of_result
from bladewhirl.postprocess.fields.lost_blades import lost_blades
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.wheels import of_first_wheel, wheel_numbers
from bladewhirl.postprocess.fields.windows import span_starts
from bladewhirl.postprocess.pictures.flat import MOST_NUMBERS, draw_flat, flat_stage
from bladewhirl.postprocess.plotting.style import COLOURS, INCH, styled, time_axis
from bladewhirl.postprocess.plotting.titles import about_run
from bladewhirl.postprocess.run.extremes import largest_force, mean_forces
from bladewhirl.postprocess.run.haigh import draw_haigh, haigh, number_blades
from bladewhirl.postprocess.run.histories import contact_force
from bladewhirl.postprocess.run.unrolled import unrolled, whole_run
from bladewhirl.postprocess.shaft_line.motion import line_bearing_forces

PAD = 0.08  #: distance of panels from each other and from the edges [inch]
PAGE = (0.297, 0.21)  #: width and height of the page, A4 [m]
LINE = 150  #: largest number of characters in a line of the verdict
COLUMNS = 1000  #: largest number of spans of time of a curve
FAMILY = 0.05  #: modes whose frequencies differ by less, relatively, are drawn as one band
ORDERS = 8  #: the Campbell diagram reaches at least this engine order
ABOVE = 1.35  #: and this multiple of the lowest frequency
MOST_ORDERS = 24  #: largest number of lines of engine orders
EXCITED = 0.1
"""An engine order excites modes in which the share of its nodal diameter is a larger fraction of
the largest share; the modes of separate blades have all nodal diameters."""
NEAR = 0.1  #: an engine order is near a frequency if they differ by less, relatively


def card(result: xr.Dataset, stresses: xr.Dataset | None, energies: xr.Dataset) -> xr.Dataset:
    """Compute what the card shows: a picture of the stage with all wheels, and figures, of several
    wheels with walls those of the first.

    Args:
        result: result of a run.
        stresses: from `stresses.stress_history`; None if the stage has no stresses.
        energies: from `strain.strain_energies`.

    Returns:
        Dataset with the variables of `flat.flat_stage` at the instant of the largest force on a
        blade, or of the largest energy without contact, of `haigh.haigh` and of
        `unrolled.whole_run`; over blade `largest_force` [N], the normal force on the blade in the
        mean over `extremes.FORCE_TIME`, and `blade_angle` [rad]; `force_history` (time,) [N], the
        largest normal force on a blade between two records; `mode_frequency` (mode,) [Hz],
        rotating axes, and `diameter_share` (mode, nodal_diameter) [1] of `diameter_shares`; with a
        shaft line `bearing_force` (time, bearing) [N], the magnitudes of `line_bearing_forces`.
    """
    whole, result = result, of_first_wheel(result)
    peak, force = largest_force(result), mean_forces(result).values
    between = contact_force(result)["normal"].max("blade")
    record = int((between if peak["force"] else result["energy"]).values.argmax())
    stage = flat_stage(whole, record, "displacement" if stresses is None else "stress")
    split = xr.Dataset() if stresses is None else haigh(stresses)
    seen = whole_run(unrolled(result))
    names = ["rotor_backward_frequency", "rotor_forward_frequency"]
    names = names if names[0] in result else ["rotor_frequency"]
    # The coordinates of a shaft line are modes without its bearings.
    names = names * (not has(result, "line"))
    frequency = np.abs(np.concatenate([np.zeros(0), *(result[name].values for name in names)]))
    ascending = np.argsort(frequency, kind="stable")
    own = diameter_shares(result)
    shares = np.concatenate([own[:0], *[own] * len(names)])
    regime, loss = classify(result, energies["total"].values), lost_blades(result)
    parts = [stage, split, seen]
    if has(result, "line"):
        bearings = line_bearing_forces(result)["force"].isel(time=slice(1, None))
        parts.append(bearings.to_dataset(name="bearing_force"))
    return (
        xr.merge(parts, combine_attrs="drop")
        .assign(
            largest_force=("blade", of_blades(result, force).max(axis=0), {"units": "N"}),
            blade_angle=("blade", blade_angles(result) % (2 * np.pi), {"units": "rad"}),
            force_history=("time", between.values[1:], {"units": "N"}),
            mode_frequency=("mode", frequency[ascending] / (2 * np.pi), {"units": "Hz"}),
            diameter_share=(("mode", "nodal_diameter"), shares[ascending], {"units": "1"}),
        )
        .assign_coords(time=result["time"].values[1:])
        .assign_attrs(
            {**stage.attrs, **split.attrs, **seen.attrs},
            regime=regime_title(regime.name, judged=regime.growth is not None),
            effects=table_of_result(result, "rotation", Rotation).effects,
            averaged_over=peak["averaged_over"],
            record_step=result.attrs["record_step"],
            blades=blade_count(result),
            wheels=len(wheel_numbers(whole)),
            shown_time=float(result["time"][record]),
            loss_time=loss.time if loss else np.inf,
            joints=int(has(result, "joints")),
            applied_orders=np.array(_applied_orders(result), dtype=np.int64),
            lost_blades=loss.blades if loss else np.zeros(0, dtype=np.int64),
        )
    )


@styled
def plot_card(data: xr.Dataset) -> Figure:
    """Draw the card from `card` on one page A4; its size does not follow `at_width`."""
    figure = Figure(figsize=(PAGE[0] / INCH, PAGE[1] / INCH))
    figure.set_layout_engine("constrained", w_pad=PAD, h_pad=PAD)
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(2, 3, width_ratios=[1.5, 1.0, 1.0])
    touched = bool(data["force_history"].values.any())
    left = grid[:, 0].subgridspec(1 + touched, 1, height_ratios=[3.6, 1.0][: 1 + touched])
    stage = figure.add_subplot(left[0])
    draw_flat(stage, data)
    stage.set_title(data.attrs["notes"])
    if touched:
        _draw_history(figure.add_subplot(left[1]), data)
    _draw_clock(figure.add_subplot(grid[0, 1], projection="polar"), data, touched=touched)
    stress = figure.add_subplot(grid[0, 2])
    if "mean" in data:
        draw_haigh(stress, data)
        stress.set_title(f"stress of each blade\n{stress.get_title()}")
    else:
        stress.set_axis_off()
        stress.set_title("no stress: the file of the superelement\nhas no stress_recovery")
    _draw_casing(figure.add_subplot(grid[1, 1]), data)
    below = figure.add_subplot(grid[1, 2])
    (_draw_bearings if "bearing_force" in data else _draw_campbell)(below, data)
    about = [data.attrs["case_title"], *about_run(data)]
    if (wheels := data.attrs["wheels"]) > 1:
        about.append(f"diagrams of the first of {wheels} wheels with walls")
    lines = [
        ", ".join(map(str, about)),
        *textwrap.wrap(verdict(data), LINE),
    ]
    figure.suptitle("\n".join(lines), parse_math=False, x=0.02, ha="left", fontsize=10)
    if "mean" in data:
        number_blades(stress, data)
    return figure


def verdict(data: xr.Dataset) -> str:
    """Return what the card says in one sentence: regime, force, stress, wear, resonance."""
    force = data["largest_force"].values
    regime = data.attrs["regime"].replace("-", " ")
    parts = []
    if force.any():
        time = handy(data.attrs["averaged_over"], "s", 3)
        pushed = handy(float(force.max()), "N", 3)
        parts.append(f"blade {force.argmax()} is pushed by up to {pushed} (mean over {time})")
    elif "wear" not in data:
        parts.append(f"the smallest gap is {handy(float(data['gap'].min()), 'm', 3)}")
    if data.attrs.get("worst", -1) >= 0:
        one = data.isel(blade=data.attrs["worst"])
        sizes = [float(one[name]) for name in ("alternating", "mean")]
        unit, scale = handy_unit(max(np.abs(sizes)), "Pa")
        both = [f"{scale * size:.3g} {unit}" for size in sizes]
        text = f"the stress of blade {data.attrs['worst']} alternates by {both[0]} about {both[1]}"
        if not data.attrs["steady"]:
            text += " (without steady rotation)"
        if "margin" in data:
            margin = float(one["margin"])
            sense = "within" if margin >= 1.0 else "beyond"
            text += f", {sense} the limits of its material (margin {margin:.3g})"
        parts.append(text)
    if "wear" in data and data["wear"].values.any():
        parts.append(f"up to {handy(float(data['wear'].max()), 'm', 3)} of the coating are removed")
    near = nearest_order(data)
    if near is not None and near[2] < NEAR:
        order = f"order {near[0]}"
        if near[0] not in data.attrs["applied_orders"]:
            order += ", which neither a load nor the wall has,"
        parts.append(f"engine {order} is {100 * near[2]:.2g} % from {near[1]:.4g} Hz")
    return f"{regime[:1].upper()}{regime[1:]}: {'; '.join(parts)}."


def nearest_order(data: xr.Dataset) -> tuple[int, float, float] | None:
    """Return the engine order of the Campbell diagram that is nearest to the natural frequency of a
    mode with its nodal diameter, this frequency [Hz], and their relative difference; None at
    standstill, or if no order excites a mode. Orders of the loads and of the wall that are `NEAR` a
    frequency come before all others."""
    turns, top = _reach(data)
    frequency = data["mode_frequency"].values
    shown = (frequency > 0.0) & (frequency <= top)
    if not turns or not shown.any():
        return None
    frequency, orders = frequency[shown], np.arange(1, max(2, int(top / turns) + 1))
    shares = data["diameter_share"].values[shown]
    excited = (
        shares[:, aliased(orders, data.attrs["blades"])] > EXCITED * shares.max(axis=1)[:, None]
    )
    apart = np.where(excited.T, np.abs(orders[:, None] * turns / frequency - 1.0), np.inf)
    applied = np.isin(orders, data.attrs["applied_orders"])
    if apart[applied].min(initial=np.inf) < NEAR:
        apart[~applied] = np.inf
    order, mode = np.unravel_index(apart.argmin(), apart.shape)
    if np.isinf(apart[order, mode]):
        return None
    return int(orders[order]), float(frequency[mode]), float(apart[order, mode])


def _applied_orders(result: xr.Dataset) -> list[int]:
    """Return the orders of the loads and of the wall of a run."""
    given = tomllib.loads(result.attrs["case"]).get("excitation", [])
    rows = given if isinstance(given, list) else [given]
    loads = [EngineOrder(**row) for row in rows if row.get("type") == "engine-order"]
    return [*applied_orders(table_of_result(result, "casing", Casing), loads)]


def _reach(data: xr.Dataset) -> tuple[float, float]:
    """Return the speed [1/s], and the highest frequency of the Campbell diagram [Hz]."""
    turns = abs(float(data.attrs["speed"])) / (2 * np.pi)
    frequency = data["mode_frequency"].values
    lowest = float(frequency[frequency > 0.0].min(initial=np.inf))
    return turns, max(ORDERS * turns, ABOVE * (lowest if np.isfinite(lowest) else 0.0)) or 1.0


def _draw_forces(axes: Axes, data: xr.Dataset, force: Array) -> list[Line2D]:
    """Draw forces (time, curve) [N] over time, the largest value in each span."""
    time = data["time"].values
    starts = span_starts(time, COLUMNS)
    unit, scale = handy_unit(float(force.max()), "N")
    curves = axes.plot(time[starts], scale * np.maximum.reduceat(force, starts))
    axes.set(xlim=time[[0, -1]], ylim=(0, 1.05 * scale * force.max() or 1.0))
    axes.set_ylabel(f"force [{unit}]")
    time_axis(axes)
    return curves


def _draw_bearings(axes: Axes, data: xr.Dataset) -> None:
    """Draw the force of each bearing of a shaft line over time."""
    force = data["bearing_force"].values
    curves = _draw_forces(axes, data, force)
    axes.legend(curves, data["bearing"].values.tolist(), title="bearing", fontsize=7)
    axes.set_title(f"force of each bearing,\nat most {handy(float(force.max()), 'N', 4)}")


def _draw_history(axes: Axes, data: xr.Dataset) -> None:
    """Draw the largest force on a blade over time, with the instant of the drawn stage."""
    time = data["time"].values
    (curve,) = _draw_forces(axes, data, data["force_history"].values[:, None])
    curve.set_color(COLOURS["total"])
    axes.axvline(data.attrs["shown_time"], color=COLOURS["k = 1"], linewidth=0.9)
    over = handy(data.attrs["record_step"], "s", 3)
    title = f"largest force on a blade, mean over {over};\norange: the instant drawn above"
    if data.attrs["loss_time"] <= time[-1]:
        axes.axvline(data.attrs["loss_time"], color=COLOURS["total"], linestyle="--", linewidth=0.7)
        title += "; dashed: the loss"
    axes.set_title(title)


def _draw_clock(axes: Axes, data: xr.Dataset, *, touched: bool) -> None:
    """Draw the largest force on each blade around the axis, or the smallest gap if no blade
    touches; of a single blade by its place on the casing."""
    force = data["largest_force"].values if touched else data["blade_gap"].min("axial").values
    if len(force) == 1:
        at = (data["force"].max("axial") if touched else data["gap"].min("axial")).values
        unit, scale = handy_unit(float(np.nanmax(at)), "N" if touched else "m")
        axes.stairs(scale * np.nan_to_num(at), data["sector_edge"].values, color=COLOURS["total"])
        what = "largest force on a contact node" if touched else "smallest gap"
        axes.set_title(f"{what} [{unit}],\nby place on the casing")
    else:
        unit, scale = handy_unit(float(np.nanmax(force)), "N" if touched else "m")
        worst = force == (force.max() if touched else np.nanmin(force))
        colours = np.where(worst, COLOURS["k = 1"], COLOURS["k = 0"])
        width = 0.8 * 2 * np.pi / len(force)
        axes.bar(data["blade_angle"].values, scale * force, width, color=colours)
        numbered = data["blade"].values[:: -(-len(force) // MOST_NUMBERS)]
        axes.set_xticks(data["blade_angle"].values[numbered], map(str, numbered))
        title = f"smallest gap of each blade [{unit}]"
        if touched:
            title = f"largest force on each blade [{unit}],\n"
            title += f"mean over {handy(data.attrs['averaged_over'], 's', 3)}"
        if len(lost := data["blade_angle"].values[data.attrs["lost_blades"]]):
            rim = axes.get_xaxis_transform()  # the rim is at 1
            axes.plot(lost, np.full(len(lost), 0.93), "x", color=COLOURS["total"], transform=rim)
            title += ", ×: lost"
        axes.set_title(title)
    axes.set(xlim=(0, 2 * np.pi), ylim=(0.0, None if axes.dataLim.ymax > 0 else 1.0))
    axes.set_yticks(axes.get_yticks()[1::2])
    axes.set(rlabel_position=180.0 / len(force) if len(force) > 1 else 22.5)
    axes.set_axisbelow(False)  # the radii are read on the bars
    for text in axes.get_yticklabels():
        text.set_path_effects([withStroke(linewidth=2.0, foreground="white")])


def _draw_casing(axes: Axes, data: xr.Dataset) -> None:
    """Draw the wear around the casing; without a coating the largest force or, if no blade touches,
    the smallest gap."""
    name, words = "gap", "smallest gap"
    if "wear" in data:
        name, words = "wear", "largest removed depth"
    elif data["force"].any():
        name, words = "force", "largest force on a contact node"
    values = data[name].min("axial") if name == "gap" else data[name].max("axial")
    edges = np.degrees(data["rod_edge" if name == "wear" else "sector_edge"].values)
    unit, scale = handy_unit(float(values.max()), "N" if name == "force" else "m")
    axes.stairs(scale * values.values, edges, color=COLOURS["total"], baseline=None)
    top = 1.05 * scale * float(values.max()) or 1.0
    axes.set(xlim=(0, 360), xticks=np.arange(0, 361, 90), ylim=(0, top))
    axes.set(xlabel="angle on the casing [°]", ylabel=f"{words} [{unit}]")
    several = data.sizes["axial"] > 1
    axes.set_title(words + (" of all axial positions" if several else "") + ",\naround the casing")


def _draw_campbell(axes: Axes, data: xr.Dataset) -> None:
    """Draw the natural frequencies in rotating axes over the speed, with lines of engine orders and
    the speed of the run. Frequencies that depend on the speed are drawn at this speed only."""
    turns, top = _reach(data)
    last = ABOVE * 60.0 * turns or 1.0
    fixed = data.attrs["effects"] == "none"
    span = (0.0, last) if fixed else (0.93 * 60.0 * turns, 1.07 * 60.0 * turns)
    frequency = data["mode_frequency"].values
    frequency = frequency[(frequency > 0.0) & (frequency <= top)]
    starts = np.flatnonzero(np.diff(np.log(frequency), prepend=-np.inf) > FAMILY)
    for band in np.split(frequency, starts[1:]):
        if len(band):
            axes.fill_between(
                span, band[0], band[-1], color=COLOURS["k = 0"], alpha=0.3, linewidth=0
            )
            axes.hlines(band, *span, color=COLOURS["k = 0"], linewidth=0.7)
    if turns:
        orders = np.arange(1, min(MOST_ORDERS, int(top / turns)) + 1)
        for order in orders[:: -(-len(orders) // ORDERS)]:
            axes.plot([0.0, last], [0.0, order * last / 60.0], ":", color="#777777", linewidth=0.6)
            right = order * last <= 60.0 * top
            axes.annotate(
                f"{order}Ω",
                (last, order * last / 60.0) if right else (60.0 * top / order, top),
                (2, 0) if right else (0, 1),
                textcoords="offset points",
                ha="left" if right else "center",
                va="center" if right else "bottom",
                fontsize=7,
            )
        axes.axvline(60.0 * turns, color=COLOURS["total"], linewidth=0.9)
    near, title = nearest_order(data), "natural frequencies, rotating axes, and the speed"
    if data.attrs["joints"]:
        title = title.replace("rotating axes", "without joints, rotating axes")
    if data.sizes["blade"] > 1:
        title += "\nbands: families with all nodal diameters"
    if near is not None:
        axes.plot(60.0 * turns, near[1], "o", color=COLOURS["k = 1"], markersize=5, mfc="none")
        title += f"\norder {near[0]} is {100 * near[2]:.2g} % from {near[1]:.4g} Hz"
    axes.set_title(title, pad=11)
    axes.set(xlim=(0, last), ylim=(0, top), xlabel="speed [rpm]", ylabel="frequency [Hz]")

"""Campbell diagrams (the paper's Fig. 8) in the rotating and in the static frame."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.postprocess.modal.operating_range import operating_range
from bladewhirl.postprocess.plotting.axes import AROUND, Labels, frequency_axis, speed_axis
from bladewhirl.postprocess.plotting.legends import complete
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled

Frame = Literal["rotating", "static"]

#: families of the bladed disk that are drawn even if they have no coincidence
DRAWN_FAMILIES = ("1F", "suspension")
#: mark of a coincidence
RING: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 4.0,
    "mfc": "white",
    "clip_on": False,
    "zorder": 5,
}
#: mark of a critical speed
CROSS: dict[str, Any] = {"linestyle": "none", "marker": "X", "markersize": 6.0, "mec": "white"}
#: mark of a resonance in a rub
BAND: dict[str, Any] = {"linewidth": 4.0, "alpha": 0.35, "solid_capstyle": "round", "zorder": 1}
FINE = 2001  #: number of speeds at which the frequency of a wave is computed
MOST_ORDERS = 10  #: highest engine order of a single blade, which all orders excite
ENDS = np.linspace(0.95, 0.98, 3)
"""Places of the labels of engine orders, divided by the part of the line within the axes."""
HEADROOM = 1.18  #: highest frequency shown divided by the highest coincidence or mode drawn


@dataclass(frozen=True, kw_only=True)
class Wave:
    """Frequencies of a wave at many speeds, divided by the reference frequency.

    The frequency is positive while the wave travels backward, negative while it travels forward.
    """

    body: str  #: "bladed-disk" or "casing"
    family: str
    nodal_diameter: int
    direction: str  #: direction of travel at rest
    speed: FloatArray
    rotating: FloatArray  #: frequency in the rotating frame
    #: speeds at which the wave grows because it coincides with another wave
    grows: BoolArray | Literal[False] = False

    @property
    def static(self) -> FloatArray:
        """Normalised frequency in the static frame."""
        return self.rotating - self.nodal_diameter * self.speed


def waves(data: xr.Dataset, points: int) -> Iterator[Wave]:
    """Yield all waves from `campbell` at `points` speeds: backward and forward waves on the bladed
    disk, forward waves on the casing."""
    hertz = float(data.attrs["reference_frequency_hz"])
    first, last = data.attrs["speeds"]
    speed = np.linspace(first, last, points)
    for branch in range(data.sizes.get("branch", 0)):
        row = data.isel(branch=branch)
        frequency, grows = (
            np.interp(speed, row["line_speed"].values, values)
            for values in (row["branch_frequency"].values, row["branch_growth"].values > 0.0)
        )
        yield Wave(
            body="bladed-disk",
            family=str(row["branch_family"].values),
            nodal_diameter=int(row["branch_nodal_diameter"]),
            direction=str(row["branch_direction"].values),
            speed=speed,
            rotating=frequency / hertz,
            grows=grows == 1.0,
        )
    for mode in range(data.sizes["mode"]):
        row = data.isel(mode=mode)
        body, k = str(row["mode_body"].values), int(row["mode_nodal_diameter"])
        frequency = np.full_like(speed, float(row["normalised_mode_frequency"]))
        if body == "casing":
            directions = {"forward": k * speed - frequency}
        elif "branch" in data.dims:
            continue
        else:
            directions = {"backward": frequency, **({"forward": -frequency} if k else {})}
        for direction, rotating in directions.items():
            yield Wave(
                body=body,
                family=str(row["mode_family"].values),
                nodal_diameter=k,
                direction=direction,
                speed=speed,
                rotating=rotating,
            )


def drawn_part(data: xr.Dataset) -> xr.Dataset:
    """Select the modes and coincidences from `campbell` that a diagram shows.

    Families of the bladed disk are drawn if they coincide with the casing in the operating range,
    or in the diagram if there is no such range; `DRAWN_FAMILIES` are always drawn, and all families
    in a rigid wall. Of the casing, the lowest mode of each nodal diameter is
    drawn, from 1 to the highest nodal diameter of these families.
    """
    operated = in_diagram(data)
    if operating_range(data) is not None:
        operated &= data["in_operating_range"].values.astype(bool)
    on_rotor = data["mode_body"].values == "bladed-disk"
    families = [*DRAWN_FAMILIES, *data["family"].values[operated]]
    if on_rotor.all():
        families += [*data["mode_family"].values]
    k, frequency = data["mode_nodal_diameter"].values, data["mode_frequency"].values
    rotor = on_rotor & np.isin(data["mode_family"].values, families)
    lowest = {
        int(number): frequency[~on_rotor & (k == number)].min()
        for number in np.unique(k[~on_rotor])
        if 1 <= number <= k[rotor].max()
    }
    casing = ~on_rotor & [frequency[i] == lowest.get(int(k[i])) for i in range(len(k))]
    met = [lowest.get(int(number)) for number in data["nodal_diameter"].values]
    shown = {
        "mode": rotor | casing,
        "coincidence": np.isin(data["family"].values, families)
        & (data["casing_frequency"].values == met),
    }
    if "branch" in data.dims:
        shown["branch"] = np.isin(data["branch_family"].values, families)
    if "resonance" in data.dims:
        shown["resonance"] = np.isin(data["resonance_family"].values, families)
    return data.isel(shown)


def in_diagram(data: xr.Dataset) -> BoolArray:
    """Return true for each coincidence inside the speed range of the diagrams."""
    first, last = data.attrs["speeds"]
    speed = data["normalised_speed"].values
    return np.asarray((first <= speed) & (speed <= last), dtype=np.bool_)


def frames_of(data: xr.Dataset) -> tuple[Frame, ...]:
    """Return the frames in which there is a diagram: a single blade has no travelling waves."""
    return ("rotating",) if data.attrs["blades"] == 1 else ("rotating", "static")


@styled
def plot_campbell(data: xr.Dataset, frame: Frame) -> Figure:
    """Draw a Campbell diagram from `campbell`: frequencies of waves on bladed disk and casing
    against the speed. Only the `drawn_part` of the data is drawn.

    In the rotating frame the frequencies of the bladed disk are horizontal lines. A wave that
    travels forward on the casing has the frequency k Omega - omega in this frame, a rising line. In
    the static frame, whose frequency axis is logarithmic, the frequencies of the casing are
    horizontal and the rising lines are waves that travel backward on the rotor. Where k Omega is
    below omega the rising wave travels in the other direction and is left out. Circles labelled
    with k mark coincidences; the note below the diagram gives their number.

    With rotation effects the frequencies of the bladed disk depend on the speed. Waves that are
    backward at rest are full lines, waves that are forward at rest dashed lines; the diagram in the
    static frame shows only waves with one nodal diameter. Dotted lines are multiples of the speed,
    crosses mark critical speeds.
    """
    count, data = np.count_nonzero(in_diagram(data)), drawn_part(data)
    figure = new_figure(width=FULL_WIDTH, height=0.105)
    axes = figure.subplots()
    reference = float(data.attrs["reference_frequency_hz"])
    meets, shown = met_frequencies(data, frame), in_diagram(data)
    if (operated := operating_range(data)) is not None:
        axes.axvspan(*operated, color="#F0F0F0", zorder=0, label="operating range")
    low, high = data.attrs["speeds"]
    if low < (own := abs(float(data.attrs["case_speed"]))) < high:
        axes.axvline(own, color=COLOURS["total"], linewidth=0.6, label="speed of the case")
    axes.set(xlim=(low, high), yscale="log" if frame == "static" else "linear")
    axes.set_ylim(*frequency_limits(data, frame))
    named = [*_draw_engine_orders(axes, data, frame), *_draw_waves(axes, data, frame)]
    if "branch" in data.dims and data["critical_speed"].size:
        critical, k = data["critical_speed"].values, data["critical_nodal_diameter"].values
        height = critical * k if frame == "static" else np.zeros(len(critical))
        label = f"critical speed, {', '.join(f'{speed:.4g}' for speed in critical)} ω₁"
        colour = COLOURS["contact"]
        axes.plot(critical, height, clip_on=False, zorder=6, color=colour, label=label, **CROSS)
    if frame == "rotating":
        _draw_resonances(axes, data)
    speeds, k = data["normalised_speed"].values, data["nodal_diameter"].values
    for here, colour in ((shown & (k != 1), "other k"), (shown & (k == 1), "k = 1")):
        if here.any():  # an empty line that is not clipped would stretch the layout
            label = "coincidence of waves with k"
            axes.plot(speeds[here], meets[here], color=COLOURS[colour], label=label, **RING)
    speed_axis(axes, reference)
    frequency_axis(axes, reference, f"frequency / ω₁, {frame} frame [–]")
    note = f"{np.count_nonzero(shown)} of {count} coincidences at these speeds are shown."
    if (data["mode_body"].values == "bladed-disk").all():
        note = ""  # a rigid wall has no waves
    complete(figure, data, f"Campbell diagram, {frame} frame", note)
    labels = Labels(axes)
    labels.keep_free(speeds[shown], meets[shown])
    for number, speed, frequency in zip(k[shown], speeds[shown], meets[shown], strict=True):
        labels.add(speed, frequency, str(number), COLOURS["total"], AROUND)
    for x, y, name, colour in named:
        labels.add(x[::-1], y[::-1], name, colour)
    return figure


def met_frequencies(data: xr.Dataset, frame: Frame) -> FloatArray:
    """Return the normalised frequency at which the waves of each coincidence meet, in a frame."""
    met = data["rotor_frequency" if frame == "rotating" else "casing_frequency"].values
    return np.asarray(met / data.attrs["reference_frequency_hz"], dtype=np.float64)


def frequency_limits(data: xr.Dataset, frame: Frame) -> tuple[float, float]:
    """Return the limits of the frequency axis, normalised, for data from `drawn_part`."""
    level = "bladed-disk" if frame == "rotating" else "casing"
    modes, met = data["normalised_mode_frequency"].values, met_frequencies(data, frame)
    frequencies = modes[(data["mode_body"].values == level) & (modes > 0.0)]
    highest = float(met[in_diagram(data)].max(initial=1.0))
    if frame == "static":
        return 0.6 * float(frequencies.min(initial=1.0)), 1.5 * highest
    return 0.0, HEADROOM * max(float(frequencies.max(initial=1.0)), highest)


NamedLine = tuple[FloatArray, FloatArray, str, str]
"""Points of a line, x and y, with its name and the colour of the name."""


def _draw_waves(axes: Axes, data: xr.Dataset, frame: Frame) -> Iterator[NamedLine]:
    """Draw the waves of bladed disk and casing; yield the lines that are to be named."""
    turning, alone = "branch" in data.dims, data.attrs["blades"] == 1
    low, high = axes.get_ylim()
    for wave in sorted(waves(data, FINE), key=lambda wave: wave.body != "casing"):
        on_casing, first = wave.body == "casing", wave.nodal_diameter == 1
        forward, signed = wave.direction == "forward", getattr(wave, frame)
        y = np.abs(signed)
        if on_casing and frame == "rotating":
            y = np.where(signed > 0.0, y, np.nan)
        elif not on_casing and forward and not (turning and (first or frame == "rotating")):
            continue  # without rotation effects backward and forward wave have the same line
        elif not on_casing and frame == "static" and not (turning and first):
            y = np.where(signed < 0.0, y, np.nan)
        colour = wave_colour(wave.body, wave.family, wave.nodal_diameter)
        if alone:
            colour, label = COLOURS["k = 0"], "blade"
        elif wave.family == "suspension" and not on_casing:
            label = "suspension"
        else:
            label = f"{wave.body.replace('-', ' ')}, {'k = 1' if first else 'other k'}"
        axes.plot(
            wave.speed,
            y,
            color=colour,
            linestyle="--" if on_casing else (0, (5, 2)) if forward else "-",
            linewidth=1.2 if first else 0.6,
            zorder=3 if first else 2,
            gid=f"{wave.body.replace('-', ' ')}, {wave.family}, k = {wave.nodal_diameter}"
            + f", {wave.direction}" * (turning or on_casing),
            label=label if np.any((low <= y) & (y <= high)) and (on_casing or not forward) else "_",
        )
        if np.any(wave.grows):
            y_growing = np.where(wave.grows, y, np.nan)
            axes.plot(wave.speed, y_growing, color=COLOURS["contact"], linewidth=4.0, alpha=0.5)
            if not forward:
                yield wave.speed, y_growing, "met: unstable", "black"
        if on_casing:
            yield wave.speed, y, f"k = {wave.nodal_diameter}", COLOURS["k = 0"]
        elif first or alone:
            way = f", {wave.direction}" if turning else ""
            yield wave.speed, y, f"{wave.family}{way}", colour
    if turning:
        axes.plot([], [], color=COLOURS["total"], linestyle=(0, (5, 2)), label="forward wave")


def _draw_engine_orders(axes: Axes, data: xr.Dataset, frame: Frame) -> Iterator[NamedLine]:
    """Draw the lines of engine orders: of those that excite a mode most, of the lowest orders on a
    single blade, and of resonances; in the static frame only order 1. Yield places for the name of
    each line, the name and its colour."""
    k, (first, last) = data["mode_nodal_diameter"].values, data.attrs["speeds"]
    speed = np.linspace(first, last, 201)  # a curve on a logarithmic axis
    orders = np.arange(1, MOST_ORDERS + 1) if data.attrs["blades"] == 1 else k[k > 0]
    if "resonance" in data.dims:
        orders = np.concatenate([orders, data["resonance_order"].values])
    drawn = np.unique(orders).tolist() if frame == "rotating" else [1]
    top, label = axes.get_ylim()[1], f"engine order{'s' * (len(drawn) > 1)} {ranges_of(drawn)}"
    for order in drawn:
        look: dict[str, Any] = {"color": "#777777", "linewidth": 0.6, "zorder": 1, "label": label}
        name, places = f"{order}Ω" if order > 1 else "Ω", ENDS * min(last, top / order)
        axes.plot(speed, order * speed, ":", gid=name, **look)
        yield places, order * places, name, "#555555"


def ranges_of(numbers: list[int]) -> str:
    """Return ascending numbers as text, such as "1 to 4, 8"; three or more in turn are a range."""
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
    return ", ".join(
        f"{run[0]} to {run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs
    )


def _draw_resonances(axes: Axes, data: xr.Dataset) -> None:
    """Draw where the lines of the wall and of engine orders excite waves in a rub: between the
    resonance with free and that with held tips."""
    for n in range(data.sizes.get("resonance", 0)):
        row = data.isel(resonance=n)
        order, speed = int(row["resonance_order"]), float(row["resonance_free"])
        ends = np.array([speed, float(np.nan_to_num(row["resonance_held"], nan=speed))])
        label = "resonance with free to held tips"
        axes.plot(ends, order * ends, color=COLOURS["contact"], label=label, **BAND)


def wave_colour(body: str, family: str, k: int) -> str:
    """Return the colour of a wave: one for the suspension; on each body one for k = 1, one for
    other k."""
    if family == "suspension":
        return COLOURS["suspension"]
    if body == "bladed-disk":
        return COLOURS["k = 1" if k == 1 else "other k"]
    return COLOURS["k = 0" if k == 1 else "casing"]

"""Contact scenarios of modes with one nodal diameter (the paper's Figs 9 and 10)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import directions
from bladewhirl.postprocess.plotting.legends import Group, entries_of, legends_below
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title

DRAWN_CLEARANCE = 0.16  #: drawn clearance, divided by the tip radius
SCHEMATIC = (
    "Schematic: clearance and displacements are enlarged by one factor. Right: phases of the mode."
)

ZONE = np.radians(40.0)  #: half of the angle over which blades are drawn in contact [rad]


@styled
def plot_scenario(data: xr.Dataset) -> Figure:
    """Draw the position of contact, and the phases of shaft and smallest clearance.

    These are the paper's Figs 9 and 10. The left panel shows rotor and casing as rings, with
    clearance and displacements enlarged by one factor; the displacement of the shaft; and the
    blades in contact with the friction on them. The right panel shows the phases over one turn.

    Args:
        data: one turn of two modes that move with the same frequency.
    """
    figure = new_figure(width=FULL_WIDTH, height=0.078)
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.1))
    _draw_rings(left, data)
    turns = data["time"].values * data.attrs["speed"] / (2.0 * np.pi)
    for name, key, style, width in (
        ("shaft", "shaft_phase", "-", 1.2),
        ("smallest clearance", "smallest_clearance_phase", "--", 1.8),
    ):
        colour = COLOURS["k = 0" if name == "shaft" else "contact"]
        phase = broken(np.degrees(data[key].values))
        known = "_" if name == "shaft" else name  # the arrow on the left is labelled
        right.plot(turns, phase, style, color=colour, linewidth=width, label=known)
    right.set(
        xlim=(0.0, 1.0),
        ylim=(-190.0, 190.0),
        yticks=(-180, -90, 0, 90, 180),
        xlabel="turns of the rotor [–]",
        ylabel="phase, rotating frame [°]",
    )
    kind, reference = data.attrs["scenario"], float(data.attrs["reference_frequency"])
    driven = "backward" if kind == "standard" else "forward"
    ratio, rpm = data.attrs["speed"] / reference, 30.0 * data.attrs["speed"] / np.pi
    title = f"{kind.capitalize()} contact scenario of {data.attrs['mode']}, k = 1"
    opposed = "" if kind == "standard" else ", although the wave of the mode travels backward"
    words = f"friction on the blades drives {driven} whirl{opposed}"
    words += f"; where the waves coincide, Ω/ω₁ = {ratio:.4g} ({rpm:.0f} rpm)"
    set_title(figure, data.attrs["case"], f"{title}: {words}")
    legends_below(figure, Group(entries_of(left), SCHEMATIC), Group(entries_of(right)))
    return figure


def _draw_rings(axes: Axes, data: xr.Dataset) -> None:
    """Draw the rings, the shaft displaced towards +x, and the blades in contact with friction."""
    clearance = float(data.attrs["clearance"])
    drawn = DRAWN_CLEARANCE / clearance
    sense = np.sign(data.attrs["shaft_amplitude"])
    centre, wall, shaft = (
        sense * drawn * float(data.attrs[f"{name}_amplitude"])
        for name in ("rotor", "casing", "shaft")
    )
    side = np.sign(centre - wall)
    rings: tuple[tuple[float, float, Mapping[str, Any]], ...] = (
        (0.0, 1.0, {"color": COLOURS["rest"], "linestyle": "--", "label": "tips at rest"}),
        (centre, 1.0, {"color": COLOURS["rotor"], "linewidth": 1.2, "label": "tips, displaced"}),
        (
            wall,
            1.0 + DRAWN_CLEARANCE,
            {"color": COLOURS["casing"], "linewidth": 2.0, "label": "casing, displaced"},
        ),
    )
    for middle, radius, look in rings:
        axes.plot(*_arc(middle, radius, np.pi), **look)
    contact: Mapping[str, Any] = {"linewidth": 3.0, "solid_capstyle": "round", "label": "contact"}
    axes.plot(*_arc(centre, side, ZONE), color=COLOURS["contact"], **contact)
    zone = np.linspace(-ZONE, ZONE, 5)
    outward = side * directions(zone)
    for normal in outward:
        tip = normal + np.array([centre, 0.0])
        axes.plot(*np.stack([[shaft, 0.0], tip]).T, color=COLOURS["total"], linewidth=0.5)
        drag = np.array([normal[1], -normal[0]])  # towards -theta
        start = tip - 0.12 * normal - 0.1 * drag
        _arrow(axes, start, start + 0.28 * drag, COLOURS["suspension"])
    axes.plot([], [], color=COLOURS["total"], linewidth=0.5, label="blades in contact")
    axes.plot([], [], color=COLOURS["suspension"], label="friction")
    _arrow(axes, (0.0, 0.0), (shaft, 0.0), COLOURS["k = 0"], width=1.4)
    axes.plot([], [], color=COLOURS["k = 0"], linewidth=1.4, label="shaft")
    axes.plot(0.0, 0.0, "x", color=COLOURS["total"], markersize=3.0, label="centre at rest")
    reach = 1.03 * max(1.0 + DRAWN_CLEARANCE + abs(wall), 1.0 + abs(centre))
    axes.set(aspect="equal", xlim=(-reach, reach), ylim=(-reach, reach))
    axes.set_axis_off()
    axes.text(reach, -reach, "rotation ↺", ha="right", va="bottom")


def _arc(middle: float, radius: float, half_angle: float) -> FloatArray:
    """Return points (2, angles) of an arc about the point (middle, 0). The arc is centred on the
    direction +x, or on -x if the radius is negative."""
    angle = np.linspace(-half_angle, half_angle, 240)
    return np.stack([middle + radius * np.cos(angle), radius * np.sin(angle)])


def _arrow(
    axes: Axes,
    start: FloatArray | tuple[float, float],
    end: FloatArray | tuple[float, float],
    colour: str,
    width: float = 0.9,
) -> None:
    axes.add_patch(
        FancyArrowPatch(
            tuple(start),
            tuple(end),
            arrowstyle="-|>",
            mutation_scale=5.0,
            color=colour,
            linewidth=width,
            shrinkA=0.0,
            shrinkB=0.0,
            zorder=4,
        )
    )


def broken(degrees: FloatArray) -> FloatArray:
    """Return angles with nan at jumps between 180 and -180 degrees, which are not a motion."""
    jump = np.abs(np.diff(degrees, prepend=degrees[0])) > 180.0
    return np.where(jump, np.nan, degrees)

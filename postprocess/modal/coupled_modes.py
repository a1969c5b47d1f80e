"""Figures of a coupled mode in time: deformed shapes (Fig. 13) and phases (Fig. 14)."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.modal.scenarios import broken
from bladewhirl.postprocess.pictures.drawing import Drawing, Ribbon
from bladewhirl.postprocess.plotting import style
from bladewhirl.postprocess.plotting.legends import complete
from bladewhirl.postprocess.plotting.titles import speed_label

MILLI = 1e3


@style.styled
def plot_phases(data: xr.Dataset) -> Figure:
    """Draw the phases of shaft and smallest clearance in the static frame, and their difference,
    from `motion_dataset`.

    This is the paper's Fig. 14(c). In waves with a nodal diameter other than one the shaft is at
    rest, and only the phase of the smallest clearance is drawn.
    """
    moves = data.attrs["nodal_diameter"] == 1
    figure = style.new_figure(height=0.085 if moves else 0.06)
    rows: dict[str, Any] = {"nrows": 2, "height_ratios": (2, 1)} if moves else {}
    panels = np.atleast_1d(figure.subplots(sharex=True, **rows))
    time = MILLI * data["time"].values
    curves = (("shaft", "rotor", "-"), ("smallest clearance", "casing", "--"))
    for name, key, dashes in curves if moves else curves[1:]:
        phase = data[f"{name.replace(' ', '_')}_phase"].values
        degrees = broken(np.degrees(np.angle(np.exp(1j * phase))))
        panels[0].plot(time, degrees, dashes, color=style.COLOURS[key], label=name, linewidth=1.2)
    panels[0].set_ylabel("phase, static frame [°]")
    if moves:
        panels[1].plot(time, np.degrees(data["shaft_lead"]), color=style.COLOURS["k = 1"])
        panels[1].set_ylabel("shaft ahead of\nclearance [°]")
    for axes in panels:
        axes.set(ylim=(-190, 190), yticks=(-180, -90, 0, 90, 180), xlim=(time[0], time[-1]))
    panels[-1].set_xlabel("time [ms]")
    complete(figure, data, f"Phases of a growing coupled mode\n{_at_speed(data)}")
    return figure


@style.styled
def plot_shapes(dataset: xr.Dataset, records: IntArray) -> Figure:
    """Draw the deformed stage at some records side by side in static axes (the paper's Fig. 13).

    Displacements and clearance are multiplied by the same factor (see `drawing`), so the bodies
    touch in the picture where they touch in the model. A dot marks the shaft, an open dot the
    smallest clearance, a cross the axis of rotation. `dataset` is a result, or a coupled mode with
    the variables of a result; up to four records are legible.
    """
    figure = style.new_figure(width=style.FULL_WIDTH, height=0.068)
    panels = np.atleast_1d(figure.subplots(1, len(records)))
    drawing = Drawing(dataset, records)
    size = 1.02 * drawing.reach()[0]
    norm = Normalize(0.0, MILLI * drawing.largest_displacement)
    gaps = dataset["gap"].values[records]
    for index, axes in enumerate(panels):
        picture = drawing.picture(index)
        for ribbon in (picture.casing, picture.rotor):
            shown = _draw_ribbon(axes, ribbon, norm)
        near = picture.tips[int(np.argmin(gaps[index]))]
        axes.plot(0.0, 0.0, "k+", markersize=4, markeredgewidth=0.7, label="axis of rotation")
        axes.plot(*picture.shaft, "o", color=style.COLOURS["k = 1"], markersize=5.5, label="shaft")
        look: dict[str, Any] = {"color": style.COLOURS["contact"], "markerfacecolor": "none"}
        axes.plot(*near, "o", markersize=5, label="smallest clearance", **look)
        axes.set(aspect="equal", xlim=(-size, size), ylim=(-size, size))
        axes.set_axis_off()
        axes.set_title(f"{MILLI * picture.time:.4g} ms")
    figure.colorbar(shown, ax=panels, label="displacement [mm]", shrink=0.7)
    words = "Growing coupled mode, exaggerated; static frame, rotation ↺"
    complete(figure, dataset, f"{words}\n{_at_speed(dataset)}")
    return figure


def _at_speed(data: xr.Dataset) -> str:
    """Return the speed and the coupling stiffness as text for the title."""
    kappa = f", κ = {handy(data.attrs['kappa'], 'N/m', 4)}" if "kappa" in data.attrs else ""
    return f"{speed_label(data)}{kappa}"


def _draw_ribbon(axes: Axes, ribbon: Ribbon, norm: Normalize) -> PolyCollection:
    """Draw quads between the stations of a ribbon, coloured by displacement in mm."""
    sides = ribbon.sides
    corners: Array = np.stack(
        [sides[:, :-1, 0], sides[:, 1:, 0], sides[:, 1:, 1], sides[:, :-1, 1]], axis=-2
    )
    value = 0.5 * MILLI * (ribbon.values[:, :-1, 0] + ribbon.values[:, 1:, 0])
    quads = PolyCollection(
        [*corners.reshape(-1, 4, 2)],
        cmap=style.COLOUR_MAPS["magnitude"],
        norm=norm,
        linewidth=0.3,
        edgecolor="face",
    )
    quads.set_array(value.ravel())
    axes.add_collection(quads)
    return quads

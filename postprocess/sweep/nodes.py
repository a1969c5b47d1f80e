"""Figures of sweeps with contact nodes: contact, displacement and spectra against a swept key."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.nodes import DIRECTIONS
from bladewhirl.postprocess.plotting.axes import Labels, cell_edges, draw_decades
from bladewhirl.postprocess.plotting.style import COLOURS, OUTLINE, styled
from bladewhirl.postprocess.sweep.dataset import DIRECTION
from bladewhirl.postprocess.sweep.drawing import in_handy_units, key_edges, plot_quantities
from bladewhirl.postprocess.sweep.quantities import LINE, along, need_a_grid
from bladewhirl.postprocess.sweep.resonances import NATURAL_MODES, excited, resonances
from bladewhirl.postprocess.sweep.rows import plot_rows

DECADES = 3  #: number of decades below the largest amplitude in a map

VISIBLE = 1e-2
"""The frequency range shown contains all amplitudes of at least this fraction of the largest
amplitude."""

ABOVE = 1.3
"""Highest frequency shown, divided by the highest frequency with an amplitude above `VISIBLE`."""

ORDERS = range(1, 13)  #: engine orders that are drawn as lines
FIRST, MEET = "engine orders", "order and diameter meet"  #: labels of the first order and of rings
AROUND = ((0, 4), (0, -4), (5, 0), (-5, 0))  #: offsets of the labels of rings

CONTACT: Mapping[str, tuple[float | None, str]] = {
    "impulse_per_revolution": (1.0, "impulse per\nrevolution [N s]"),
    "contact_force_max": (None, "largest normal\nforce"),
    **{name: (None, f"{name}\ndisplacement") for name in DIRECTIONS},
}
"""Factor and label of each panel, see `plot_quantities`."""


def contact_quantities(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Load contact and displacement of contact nodes of a sweep along a key.

    Returns:
        Dataset over (line, key), see `quantities.along`: `impulse_per_revolution` [N s],
        `contact_force_max` [N], `radial`, `tangential` and `axial` [m], the largest displacements
        of a contact node over the last third of each march, and `regime`.
    """
    names = ["impulse_per_revolution", "contact_force_max", "late_displacement", "regime"]
    data = along(dataset, key, names)
    moved = data["late_displacement"]
    parts = {str(name): moved.sel({DIRECTION: name}, drop=True) for name in moved[DIRECTION].values}
    return (
        data.assign(parts)
        .drop_dims(DIRECTION)
        .assign_attrs(title="contact, and displacement over the last third of each march")
    )


@styled
def plot_contact_quantities(data: xr.Dataset) -> Figure:
    """Draw impulse, force and displacements from `contact_quantities`."""
    return plot_quantities(data, CONTACT)


def node_spectra(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Load spectra of contact nodes of a sweep along a key.

    Returns:
        Dataset over (line, key), see `quantities.along`: `contact_spectrum` [m] over
        `frequency` [Hz], which is not negative, `natural_frequency` [Hz] and its
        `natural_diameter`, and `rotation_speed` [rad/s]; over resonance the variables of
        `resonances`.

    Raises:
        ViewError: no point is finished, the sweep is over a table of points, or the marches have
            too few records.
    """
    need_a_grid(dataset)
    data = along(dataset, key, ["contact_spectrum", *NATURAL_MODES, "rotation_speed"])
    data = data.isel(frequency=data["frequency"].values >= 0.0)
    frequency, amplitude = data["frequency"].values, data["contact_spectrum"].values
    if not np.isfinite(amplitude).any():
        raise ViewError("the marches have too few records for spectra")
    seen = (amplitude >= VISIBLE * np.nanmax(amplitude)).any(axis=(0, 1))
    inside = frequency <= ABOVE * frequency[seen].max(initial=0.0)
    resolution = float(np.diff(frequency[:2]).sum())
    return (
        data.isel(frequency=inside)
        .assign(resonances(data, key, dataset.sizes["blade"], ORDERS))
        .assign_attrs(
            title=f"spectra of the tangential displacement, resolution {resolution:.3g} Hz",
            blades=dataset.sizes["blade"],
            window=dataset.attrs["window"],
        )
    )


@styled
def plot_node_spectra(data: xr.Dataset) -> Figure:
    """Draw the amplitude against the swept key and the frequency from `node_spectra`; dotted lines
    are engine orders, dashed lines natural frequencies of the nodal diameters that they excite,
    circles are where the two meet."""
    largest = float(data["contact_spectrum"].max().fillna(0.0))
    unit, scale = handy_unit(largest, "m")
    handy, key = in_handy_units(data), str(data.attrs["along"])
    units = handy["frequency"].attrs["units"]
    hertz = 1e-3 if units == "kHz" else 1.0
    to_axis = float(handy[key].values[-1] / data[key].values[-1])
    drawn = {
        "natural_frequency": hertz * data["natural_frequency"],
        "turns": hertz * np.abs(data["rotation_speed"]) / (2.0 * np.pi),
        "resonance_at": to_axis * data["resonance_at"],
        "resonance_frequency": hertz * data["resonance_frequency"],
        "number": (LINE, np.arange(data.sizes[LINE])),
    }
    draw = partial(_draw_spectra, scale=scale, top=scale * largest or 1.0)
    figure = plot_rows(
        data.assign(drawn),
        [draw],
        label=f"tangential amplitude [{unit}]",
        left=f"frequency [{units}]",
    )
    for axes in figure.axes:
        lines = {str(line.get_label()): np.array(line.get_xydata()) for line in axes.lines}
        places = lines.get(MEET, np.zeros((0, 2)))
        if len(places):
            labels = Labels(axes)
            labels.keep_free(*places.T)
            for x, y in places.tolist():
                order = round(y / np.interp(x, *lines[FIRST].T))
                labels.add(x, y, f"{order}Ω", COLOURS["total"], AROUND)
    return figure


def _draw_spectra(axes: Axes, one: xr.Dataset, scale: float, top: float) -> QuadMesh:
    place = one[str(one.attrs["along"])].values
    heights = cell_edges(one["frequency"].values, logarithmic=False)
    amplitude = scale * one["contact_spectrum"].values.T
    picture = draw_decades(axes, key_edges(one), heights, amplitude, (top, DECADES))
    axes.set_ylim(0.0, float(heights[-1]))
    look: dict[str, Any] = {"color": "black", "linewidth": 0.6, "path_effects": OUTLINE}
    for order in ORDERS:
        axes.plot(
            place, order * one["turns"].values, ":", label=FIRST if order == 1 else "", **look
        )
    frequency, diameter = (one[name].values for name in NATURAL_MODES)
    lines = excited(frequency, diameter, int(one.attrs["blades"]), ORDERS)
    for line in lines[:, np.isfinite(lines).any(axis=0)].T:
        axes.plot(place, line, "--", label="natural frequencies without contact", **look)
    met = one.isel(resonance=one["resonance_line"].values == int(one["number"]))
    ring: dict[str, Any] = look | {"markersize": 4, "markerfacecolor": "none"}
    names = "resonance_at", "resonance_frequency"
    axes.plot(*(met[name].values for name in names), "o", label=MEET, **ring)
    return picture

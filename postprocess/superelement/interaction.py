"""Interaction map of a superelement: reduction of a march, and figure."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.plotting.axes import draw_decades
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title
from bladewhirl.postprocess.superelement.motion import DIRECTIONS
from bladewhirl.solvers.march.boundary import BoundaryChunk

ORDERS = 12
"""Highest engine order that is drawn in the spectra."""


def point_of_map(chunk: BoundaryChunk, omega: float, per_turn: int, node: int) -> dict[str, Any]:
    """Return the data of an interaction map at one speed.

    Args:
        chunk: records of a march.
        omega: speed of rotation [rad/s].
        per_turn: number of records in a revolution.
        node: contact node whose tangential displacement gives the spectrum.
    """
    turns = (chunk.records - 1) // per_turn
    late = max(1, (turns + 1) // 2) * per_turn  # records in the second half
    spacing = 2.0 * np.pi / abs(omega) / per_turn
    part = slice(max(0, chunk.records - late), None)
    moved = chunk.contact_displacement[part]
    window = np.hanning(2 * len(moved) + 1)[1::2]
    spectrum = np.fft.rfft(moved[:, node, 1] * window) * 2.0 / window.sum()
    frequency = np.fft.rfftfreq(len(moved), spacing)
    steps = chunk.step[1] - chunk.step[0] if chunk.records > 1 else 1
    share = chunk.contact_steps[part].sum(axis=0) / (len(moved) * steps)
    return {
        "contact_impulse": float(chunk.contact_impulse[part].sum() * per_turn / len(moved)),
        "contact_force_max": float(chunk.contact_impulse.max() / spacing),
        "contact_share": float(share.max()),
        **{name: float(np.abs(moved[:, :, i]).max()) for i, name in enumerate(DIRECTIONS)},
        "turns": float(chunk.time[-1] * abs(omega) / (2.0 * np.pi)),
        "amplitude": np.abs(spectrum),
        "frequency": frequency,
    }


@styled
def plot_interaction(data: xr.Dataset) -> Figure:
    """Draw impulse, displacements and spectra against the speed.

    Args:
        data: dataset from `bladewhirl.interaction_map`.
    """
    figure = new_figure(width=FULL_WIDTH, height=0.15)
    impulse, motion, spectra = figure.subplots(3, 1, sharex=True, height_ratios=[1, 1, 1.8])
    rpm = data["speed"].values * 30.0 / np.pi
    order = np.argsort(rpm)
    rpm, data = rpm[order], data.isel(speed=order)
    look: dict[str, Any] = {"markersize": 2, "linewidth": 0.7}
    impulse.plot(rpm, data["contact_impulse"], ".-", color=COLOURS["total"], **look)
    impulse.set_ylabel("normal impulse\nper revolution [N s]")
    largest = max(float(data[name].max()) for name in DIRECTIONS)
    unit, scale = handy_unit(largest, "m")
    for name in DIRECTIONS:
        motion.plot(rpm, scale * data[name], ".-", label=name, **look)
    motion.set_ylabel(f"largest\ndisplacement [{unit}]")
    if data["divergent"].any():
        bad = rpm[data["divergent"].values]
        motion.plot(bad, 0.0 * bad, "x", color="black", markersize=3, label="divergent")
    motion.legend(loc="upper left", ncols=4)
    amplitude = np.ma.masked_invalid(scale * data["amplitude"].values)
    amplitude[data["divergent"].values] = np.ma.masked  # their spectra are those of shorter motions
    if len(rpm) > 1 and amplitude.count() and amplitude.max() > 0.0:
        edges = np.concatenate([rpm[:1], 0.5 * (rpm[1:] + rpm[:-1]), rpm[-1:]])
        spacing = np.abs(edges) / 60.0 / ((data.attrs["turns"] + 1) // 2)
        lines = np.arange(amplitude.shape[1] + 1) - 0.5
        rows = spacing[:, None] * lines
        columns = np.broadcast_to(edges[:, None], rows.shape)
        levels = float(amplitude.max()), 3.0
        mesh = draw_decades(spectra, columns, rows, amplitude, levels)
        figure.colorbar(mesh, ax=spectra, label=f"tangential amplitude [{unit}]", aspect=15)
    top = ORDERS * np.abs(rpm).max() / 60.0
    for order_number in range(1, ORDERS + 1):
        spectra.plot(rpm, order_number * np.abs(rpm) / 60.0, ":", color="white", linewidth=0.5)
    for line in np.asarray(data.attrs["natural_frequencies"]):
        if line < top:
            spectra.axhline(float(line), color="white", linewidth=0.5, linestyle="--")
    spectra.set_ylim(0.0, top)
    spectra.set_ylabel("frequency [Hz]")
    spectra.set_xlabel("speed [rpm]")
    words = (
        f"second half of {data.attrs['turns']} revolutions; spectrum of node {data.attrs['node']};"
        " dotted: engine orders, dashed: natural frequencies"
    )
    set_title(figure, str(data.attrs["case_title"]), words)
    return figure

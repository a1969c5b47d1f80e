"""Figures of sweeps with a row of panels for each line: contact of the blades, strain energies.

A line is one combination of values of the swept keys that are not on the horizontal axis.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from bladewhirl.postprocess.energy import strain
from bladewhirl.postprocess.plotting.axes import draw_decades, draw_map
from bladewhirl.postprocess.plotting.legends import Group, entries_of
from bladewhirl.postprocess.plotting.style import COLOURS, styled
from bladewhirl.postprocess.run import blade_contact
from bladewhirl.postprocess.sweep import drawing
from bladewhirl.postprocess.sweep.dataset import GROUP
from bladewhirl.postprocess.sweep.quantities import LINE, along
from bladewhirl.postprocess.sweep.regimes import HATCH

DIAMETER = "nodal_diameter"


def plot_rows(
    data: xr.Dataset,
    columns: Sequence[Callable[[Axes, xr.Dataset], QuadMesh | None]],
    *,
    label: str,
    left: str = "",
    lines: int = 0,
) -> Figure:
    """Draw a row of panels for each of up to `MOST_ROWS` lines: a map with a colour bar and, in two
    columns, a plot.

    Args:
        data: Dataset over (line, key).
        columns: functions that draw a line in a panel, one or two; that of the map returns a mesh.
        label: label of the colour bar.
        left: common label of the vertical axes.
        lines: number of lines of the sweep; the number of lines in `data` by default.
    """
    data = drawing.in_handy_units(data)
    count = min(data.sizes[LINE], drawing.MOST_ROWS)
    height, share, pad = 0.02 + 0.05 * count, 0.5, 0.02
    if len(columns) == 1:
        height, share, pad = max(0.1, 0.065 * count), 0.9, 0.01
    figure, shown, panels = drawing.grid_of_panels(data, [1.0] * len(columns), height)
    figure.set_layout_engine("constrained", wspace=0.08)
    for number, row in zip(shown, panels, strict=True):
        drawn = [
            draw(axes, data.isel({LINE: number})) for axes, draw in zip(row, columns, strict=True)
        ]
    drawing.label_grid(data, panels, share)
    for mesh, column in zip(drawn, panels.T, strict=True):
        if mesh is not None:
            figure.colorbar(mesh, ax=column.tolist(), label=label, pad=pad)
    if left:
        figure.supylabel(left, fontsize="medium")
    entries = Group(entries_of(*panels.flat))
    drawing.title_figure(figure, data, entries, most=drawing.MOST_ROWS, lines=lines)
    return figure


def blade_contacts(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Return the share of the time that each blade is in contact, and the number of blades in each
    contact class, for the last third of each march, against a swept key (see `quantities`).

    Returns:
        Dataset over (line, key): `late_contact_share` (line, key, blade), nan for blades that do
        not exist at a point; numbers of blades `permanent` (in contact for 99 % of the time or
        more), `intermittent` (less than 99 %) and `free` (never in contact).
    """
    data = along(dataset, key, ["late_contact_share", "regime"])
    share = data["late_contact_share"]
    classes = {
        "permanent": share >= blade_contact.PERMANENT,
        "intermittent": (share > 0) & (share < blade_contact.PERMANENT),
        "free": share == 0,
    }
    counts = {
        name: members.sum("blade").where(data["state"] == "done").assign_attrs(units="1")
        for name, members in classes.items()
    }
    return data.assign(counts).assign_attrs(
        title="contact of the blades in the last third of each march"
    )


@styled
def plot_blade_contacts(data: xr.Dataset) -> Figure:
    """Draw the share of the time in contact of each blade, and the number of blades of each class,
    from `blade_contacts`."""
    if data.sizes["blade"] == 1:
        percent = (100.0 * data["late_contact_share"].isel(blade=0)).assign_attrs(units="%")
        share = {"share": (1.0, "time in contact [%]")}
        return drawing.plot_quantities(data.assign(share=percent), share)
    limit = blade_contact.share_limit(data["late_contact_share"])
    label = blade_contact.share_label("time in contact [%]", limit)
    shares = partial(_draw_shares, limit=limit)
    return plot_rows(data, [shares, _draw_counts], label=label)


def _draw_shares(axes: Axes, one: xr.Dataset, limit: float) -> QuadMesh:
    edges, blades = drawing.key_edges(one), np.arange(one.sizes["blade"])
    axes.set(ylabel="blade")
    axes.locator_params(axis="y", integer=True)
    free = np.ma.masked_not_equal(one["late_contact_share"].values.T, 0.0)
    draw_map(axes, edges, blades, free, cmap=ListedColormap(["white"]))
    # The hatching remains visible where there is no result.
    axes.patch.set(hatch=HATCH, edgecolor=blade_contact.CLASS_COLOURS["free"])
    return blade_contact.draw_share(axes, edges, blades, one["late_contact_share"], limit)


def _draw_counts(axes: Axes, one: xr.Dataset) -> None:
    """Draw stacked bars: how many blades are in each contact class at each point. A point without
    a result has no bar."""
    edges = drawing.key_edges(one)
    below = np.zeros(len(edges) - 1)
    for name, colour in blade_contact.CLASS_COLOURS.items():
        count = one[name].fillna(0.0).values
        axes.bar(
            edges[:-1],
            count,
            np.diff(edges),
            below,
            align="edge",
            color=colour,
            hatch=blade_contact.CLASS_HATCHES[name],
            edgecolor="white",
            linewidth=0.0,
            label=name,
        )
        below = below + count
    axes.set(ylabel="number of blades", ylim=(0, one.sizes["blade"]))
    axes.locator_params(axis="y", integer=True)
    axes.grid(False)


def point_energies(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Return the mean strain energy [J] of the bladed disk in the time window of the spectra,
    against a swept key (see `quantities`).

    Returns:
        Dataset over (line, key): `suspension`; `first_family` (line, key, nodal_diameter), nan for
        nodal diameters that the stage of a point does not have; `rest`, all other modes; `total`.
    """
    data = along(dataset, key, ["energy_mean"])
    energy = data["energy_mean"]
    names = energy[GROUP].values.astype(str)
    family = np.char.startswith(names, f"{strain.FIRST_FAMILY} k=")
    diameters = [int(name.partition("=")[2]) for name in names[family]]
    first = energy.isel({GROUP: family}).rename({GROUP: DIAMETER})
    done = data["state"] == "done"
    parts = {
        "suspension": energy.sel({GROUP: "suspension"}, drop=True),
        "first_family": first.assign_coords({DIAMETER: diameters}),
        "rest": energy.sel({GROUP: "rest"}, drop=True),
        "total": energy.sum(GROUP).where(done),
    }
    joule = {"units": "J"}
    return (
        data.drop_vars(["energy_mean", GROUP])
        .assign({name: values.assign_attrs(joule) for name, values in parts.items()})
        .assign_attrs(
            title="mean strain energy of the bladed disk with its shaft springs",
            window=dataset.attrs["window"],
        )
    )


@styled
def plot_point_energies(data: xr.Dataset) -> Figure:
    """Draw the energies of suspension, first family and all other modes, and a map of the energy of
    the first family by nodal diameter, from `point_energies`."""
    top = float(data["total"].max()) or 1.0
    diameters, lines = partial(_draw_diameters, top=top), partial(_draw_lines, top=top)
    return plot_rows(data, [lines, diameters], label=f"{strain.FIRST_FAMILY} [J]")


def _draw_lines(axes: Axes, one: xr.Dataset, top: float) -> None:
    place = one[str(one.attrs["along"])].values
    for (name, energy), dash, mark in zip(
        strain.energy_terms(one).items(), drawing.DASHES, drawing.MARKS, strict=False
    ):
        axes.plot(
            place,
            energy.where(energy > 0),
            linestyle=dash,
            marker=mark,
            color=COLOURS[name],
            linewidth=2.0 if name == "total" else 1.0,
            markersize=3,
            label=strain.term_label(name),
        )
    axes.set_yscale("log")
    axes.set(ylim=(top * 10**-strain.PLOT_DECADES, 3 * top), ylabel="strain energy [J]")


def _draw_diameters(axes: Axes, one: xr.Dataset, top: float) -> QuadMesh:
    axes.set(ylabel="nodal diameter k")
    axes.locator_params(axis="y", integer=True)
    energy, scale = one["first_family"].values.T, (top, strain.PLOT_DECADES)
    return draw_decades(axes, drawing.key_edges(one), one[DIAMETER].values, energy, scale)

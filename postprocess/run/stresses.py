"""Stresses in blades, disk and casing over time, and their extremes.

The stress of beams and of the casing is Young's modulus times the strain, see `strains`. It does
not include yielding, stress concentration where beams meet, and centrifugal stress. The stress at a
surface is the axial stress plus or minus the bending stress. That of superelements is the von Mises
stress, see `point_stresses`.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.postprocess.fields.blades import member_names
from bladewhirl.postprocess.fields.by_blade import blade_count
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.lost_blades import Lost, lost_beams, lost_blades
from bladewhirl.postprocess.fields.point_stresses import has_stresses
from bladewhirl.postprocess.fields.result import portions
from bladewhirl.postprocess.fields.strains import (
    Strains,
    casing_strain_rows,
    rotor_sections,
    rotor_strain_rows,
)
from bladewhirl.postprocess.fields.windows import in_window, span_starts
from bladewhirl.postprocess.plotting.style import COLOURS, FULL_WIDTH, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.run.surface_stresses import SurfaceStresses, surface_stresses

CASING_PIECES = 4
"""Number of pieces of a casing element. Strains are computed at the ends of the pieces, because
they are not linear in the element."""

PORTION_BYTES = 4e6  #: size of the strains computed in one matrix product [bytes]
CACHED_BYTES = 1e6
"""Size of the strains whose extremes are computed together [bytes]; it fits into the cache of a
processor core."""

COLUMNS = 1000  #: largest number of time spans of a curve; the largest value of a span is drawn
UNITS = {
    "axial_strain": "1",
    "axial_stress": "Pa",
    "bending_strain": "1",
    "bending_stress": "Pa",
    "largest_stress": "Pa",
    "smallest_stress": "Pa",
}
"""Histories of every member, with their units."""

PEAKS = {"peak_stress": "Pa", "peak_time": "s", "peak_radius": "m"}
"""Extremes of every member, with their units."""


class _Body(NamedTuple):
    """Rotor or casing; points are the stations along its elements, which are sorted by members."""

    history: str  #: name of the variable with the modal displacements
    axial: Array  #: axial strains for unit modal coordinates (point, mode)
    bending: Array  #: bending strains for unit modal coordinates (point, mode)
    modulus: Array  #: (point, 1) [Pa]
    radius: Array  #: radius in the undeformed body (point,) [m]
    starts: IntArray  #: first point of each member
    columns: slice  #: range of the members of this body among the members of both bodies
    lost: Lost | None = None  #: blades that are lost, if any; their stress is then zero
    lost_points: IntArray = np.zeros(0, dtype=np.int64)  #: points that are lost with them


def stress_history(
    result: xr.Dataset, *, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Compute the largest stresses and strains in every blade, every other part of the rotor and
    the casing.

    Args:
        result: result of a run.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset over (time, member); members are "blade 0" and so on, the other parts of the rotor,
        and "casing" if it is flexible. `axial_stress` [Pa] and `axial_strain` [1]: the value of
        largest magnitude in the member, signed. `bending_stress` [Pa] and `bending_strain` [1]: the
        largest magnitude at a surface. `largest_stress` and `smallest_stress` [Pa]: extremes at the
        surfaces. Over
        member only: `peak_stress` [Pa], the surface stress of largest magnitude at any time,
        signed, the time `peak_time` [s], and the radius of the point in the undeformed body,
        `peak_radius` [m]. Blades of a superelement whose file gives the recovery of stress have
        the von Mises stress at the surface as `largest_stress` and `peak_stress`, at points whose
        distance from contact nodes is more than a tenth of the length of a blade, with the stress
        of steady rotation if the case has effects of rotation; the other variables are nan.

    Example:
        ``stress_history(result)["largest_stress"].sel(member="blade 3").plot()``
    """
    dataset = in_window(result, start, end)
    names, bodies = _bodies(dataset)
    time = dataset["time"].values
    out = {name: np.full((len(time), len(names)), np.nan) for name in UNITS}
    peak = {name: np.zeros(len(names)) for name in PEAKS}
    for body, portion, axial, bending in _strains(dataset, bodies):
        stress, bent = body.modulus * axial, body.modulus * bending
        extremes = {
            "axial_strain": _largest(axial, body.starts),
            "axial_stress": _largest(stress, body.starts),
            "bending_strain": _maximum(bending, body.starts),
            "bending_stress": _maximum(bent, body.starts),
            "largest_stress": _maximum(stress + bent, body.starts),
            "smallest_stress": -_maximum(bent - stress, body.starts),
        }
        for name, values in extremes.items():
            out[name][portion, body.columns] = values.T
        _note_peaks(peak, body, time[portion], axial, bending)
    if has_stresses(dataset):
        surface = surface_stresses(dataset)
        out["largest_stress"][:, : len(surface.peak)] = surface.largest
        _add_surface(peak, surface)
    plane = ("time", "member")
    return labelled(
        dataset,
        f"stresses, linear, {measure_of(dataset)}",
        {
            **{name: (plane, values, UNITS[name]) for name, values in out.items()},
            **{name: ("member", values, PEAKS[name]) for name, values in peak.items()},
        },
        {"time": time, "member": names},
        blades=blade_count(dataset),
        measure=measure_of(dataset),
        steady=int("steady_stress" in dataset),
    )


def peak_stresses(dataset: xr.Dataset) -> xr.Dataset:
    """Compute only `peak_stress`, `peak_time` and `peak_radius` of `stress_history`."""
    names, bodies = _bodies(dataset)
    peak = {name: np.zeros(len(names)) for name in PEAKS}
    for body, portion, axial, bending in _strains(dataset, bodies):
        _note_peaks(peak, body, dataset["time"].values[portion], axial, bending)
    if has_stresses(dataset):
        _add_surface(peak, surface_stresses(dataset))
    variables = {name: ("member", values) for name, values in peak.items()}
    about = {"measure": measure_of(dataset), "steady": int("steady_stress" in dataset)}
    return xr.Dataset(variables, {"member": names}, about)


def measure_of(dataset: xr.Dataset) -> str:
    """Return the measure of the largest stress of the bladed disk: that of beam theory, or the von
    Mises stress at the surface of a superelement, see `surface_stresses`."""
    return "von Mises stress away from contact nodes" if has_stresses(dataset) else "beam theory"


def _add_surface(peak: dict[str, Array], surface: SurfaceStresses) -> None:
    blades = slice(len(surface.peak))
    for name, values in zip(PEAKS, surface[1:], strict=True):
        peak[name][blades] = values


def _bodies(dataset: xr.Dataset) -> tuple[list[str], list[_Body]]:
    if has_stresses(dataset):
        names = [f"blade {number}" for number in range(blade_count(dataset))]
        if "casing_displacement" not in dataset:
            return names, []
        return [*names, "casing"], [_casing(dataset, len(names))]
    names, member = member_names(dataset)
    order = np.argsort(member, kind="stable")
    present = np.unique(member)
    ends = dataset["rotor_point"].values[dataset["rotor_line"].values]
    rotor = _body(
        "rotor_displacement",
        Strains(*(row[order] for row in rotor_strain_rows(dataset))),
        rotor_sections(dataset, "young_modulus", 1)[order],
        np.linalg.norm(ends[order], axis=-1),
        member[order],
        first=0,
    )
    lost = lost_blades(dataset)
    if lost is not None:
        stations = len(rotor.radius) // len(order)
        gone = np.flatnonzero(np.isin(order, lost_beams(dataset, lost).lines))
        points = (stations * gone[:, None] + np.arange(stations)).ravel()
        rotor = rotor._replace(lost=lost, lost_points=points)
    rotor_names = [names[number] for number in present]
    if "casing_displacement" not in dataset:  # a rigid wall
        return rotor_names, [rotor]
    return [*rotor_names, "casing"], [rotor, _casing(dataset, len(present))]


def _casing(dataset: xr.Dataset, first: int) -> _Body:
    """Return the flexible casing; `first` is its position among the members."""
    nodes = dataset.sizes["casing_node"]
    return _body(
        "casing_displacement",
        casing_strain_rows(dataset, CASING_PIECES),
        dataset["casing_young_modulus"].values[:, None],
        np.full((nodes, CASING_PIECES + 1), dataset.attrs["casing_radius"]),
        np.zeros(nodes, dtype=np.int64),
        first=first,
    )


def _body(
    history: str, rows: Strains, modulus: Array, radius: Array, member: IntArray, *, first: int
) -> _Body:
    """Return the rotor or the casing from values at the points of each element, (element, point).

    `member` is the number of the member (such as a blade) of each element, `first` the position of
    the first member of this body among the members of both bodies.
    """
    stations = rows.axial.shape[1]
    starts = stations * np.flatnonzero(np.diff(member, prepend=-1))
    return _Body(
        history,
        rows.axial.reshape(-1, rows.axial.shape[-1]),
        rows.bending.reshape(-1, rows.bending.shape[-1]),
        np.broadcast_to(modulus, radius.shape).reshape(-1, 1),
        radius.ravel(),
        starts,
        slice(first, first + len(starts)),
    )


def _strains(
    dataset: xr.Dataset, bodies: list[_Body]
) -> Iterator[tuple[_Body, slice, Array, Array]]:
    """Yield axial strain and magnitude of the bending strain, (point, record), for a few records at
    a time."""
    for body in bodies:
        together, cached = (
            max(1, int(size / (8 * len(body.radius)))) for size in (PORTION_BYTES, CACHED_BYTES)
        )
        for read in portions(dataset, together):
            coordinates = dataset[body.history].isel(time=read).values.T
            axial, bending = body.axial @ coordinates, body.bending @ coordinates
            if body.lost is not None:
                gone = np.flatnonzero(body.lost.gone(dataset["time"].values[read]))
                axial[np.ix_(body.lost_points, gone)] = 0.0
                bending[np.ix_(body.lost_points, gone)] = 0.0
            for first in range(0, axial.shape[1], cached):
                part = slice(first, first + cached)
                portion = slice(read.start + first, min(read.start + part.stop, read.stop))
                yield body, portion, axial[:, part], np.abs(bending[:, part])


def _maximum(values: Array, starts: IntArray) -> Array:
    """Return the largest value in each member (member, record), from values (point, record)."""
    return np.asarray(np.maximum.reduceat(values, starts, axis=0))


def _largest(values: Array, starts: IntArray) -> Array:
    """Return the value of largest magnitude in each member, signed, (member, record)."""
    high, low = _maximum(values, starts), np.minimum.reduceat(values, starts, axis=0)
    return np.where(high >= -low, high, low)


def _note_peaks(
    peak: dict[str, Array], body: _Body, time: Array, axial: Array, bending: Array
) -> None:
    """Update the peak stresses of the members of a body with a portion of records."""
    size = body.modulus * (np.abs(axial) + bending)
    ranges = pairwise([*body.starts, len(size)])
    for column, (first, end) in enumerate(ranges, body.columns.start):
        stress = size[first:end]
        point, record = np.unravel_index(int(stress.argmax()), stress.shape)
        if stress[point, record] <= abs(peak["peak_stress"][column]):
            continue
        sign = 1.0 if axial[first + point, record] >= 0 else -1.0
        peak["peak_stress"][column] = sign * stress[point, record]
        peak["peak_time"][column] = time[record]
        peak["peak_radius"][column] = body.radius[first + point]


@styled
def plot_stress(history: xr.Dataset) -> Figure:
    """Draw the largest stress in blades, other parts and casing over time, and the extremes of the
    stress in every blade, from `stress_history`."""
    figure = new_figure(width=FULL_WIDTH, height=0.065)
    over_time, over_blades = figure.subplots(1, 2, gridspec_kw={"wspace": 0.12})
    blades = int(history.attrs["blades"])
    size = np.fmax(history["largest_stress"].values, -history["smallest_stress"].values)
    unit, scale = handy_unit(float(size.max()), "Pa")
    _draw_time(over_time, history, scale * size, blades)
    over_time.set(ylabel=f"largest stress [{unit}]", ylim=(0, None))
    over_time.set_title("largest at any place")
    time_axis(over_time)
    _draw_blades(over_blades, history.isel(member=slice(0, blades)), scale)
    over_blades.set(xlabel="blade", ylabel=f"stress [{unit}]", title="extremes of each blade")
    figure.legend(*over_time.get_legend_handles_labels(), loc="outside lower left", ncols=4)
    figure.legend(*over_blades.get_legend_handles_labels(), loc="outside lower right", ncols=2)
    what = "stress at surfaces by beam theory"
    if history.attrs["measure"] != "beam theory":
        what = f"{history.attrs['measure']} of blades"
        what += ", with that of steady rotation" if history.attrs["steady"] else ""
    head(figure, history, what)
    return figure


LINES = (
    (COLOURS["k = 1"], "--"),
    (COLOURS["suspension"], "-."),
    (COLOURS["k = 0"], ":"),
    (COLOURS["contact"], (0, (5, 1, 1, 1, 1, 1))),
    (COLOURS["other k"], (0, (1, 1))),
)


def _draw_time(axes: Axes, history: xr.Dataset, size: Array, blades: int) -> None:
    """Draw the largest stress in each span of time, for all blades together and for each other
    member."""
    time = history["time"].values
    starts = span_starts(time, COLUMNS)
    shown = np.maximum.reduceat(size, starts, axis=0)
    at = time[np.append(starts[1:], len(time)) - 1]
    names = history["member"].values.astype(str)[blades:].tolist()
    for number, name in enumerate(name for name in names if name != "casing"):
        colour, dashes = LINES[number % len(LINES)]
        axes.plot(at, shown[:, blades + number], color=colour, linestyle=dashes, label=name)
    if "casing" in names:
        axes.plot(at, shown[:, -1], color=COLOURS["casing"], label="casing")
    axes.plot(at, shown[:, :blades].max(axis=1), color=COLOURS["rotor"], label="blades")


def _draw_blades(axes: Axes, history: xr.Dataset, scale: float) -> None:
    """Draw for every blade a bar from the smallest to the largest surface stress, and dashes at the
    smallest and largest axial stress."""
    blade = np.arange(history.sizes["member"])
    ends = [
        (scale * history[low].min("time").values, scale * history[high].max("time").values)
        for low, high in (("smallest_stress", "largest_stress"), ("axial_stress", "axial_stress"))
    ]
    bottom, top = np.fmin(ends[0][0], 0.0), np.fmax(ends[0][1], 0.0)
    axes.bar(blade, top - bottom, 0.8, bottom, color=COLOURS["rest"], label="at a surface")
    if history.attrs["measure"] != "beam theory":
        axes.set_ylim(0.0, 1.1 * top.max() or 1.0)
        axes.locator_params(axis="x", integer=True)
        axes.grid(axis="x", visible=False)
        return
    for axial, label in zip(ends[1], ("axial alone", None), strict=True):
        axes.plot(blade, axial, "_", markersize=4.0, color=COLOURS["k = 0"], label=label)
    reach = 1.1 * scale * float(abs(history["peak_stress"]).max()) or 1.0
    axes.set_ylim(-reach, reach)
    axes.axhline(0.0, color="black", linewidth=0.6)
    axes.locator_params(axis="x", integer=True)
    axes.grid(axis="x", visible=False)

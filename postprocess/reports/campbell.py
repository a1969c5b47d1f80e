"""Page of interactive Campbell diagrams: frequency, speed and direction of every wave."""

from collections.abc import Iterator

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.postprocess.modal import campbell
from bladewhirl.postprocess.modal.operating_range import operating_range
from bladewhirl.postprocess.plotting.style import COLOURS
from bladewhirl.postprocess.reports.interactive import plot
from bladewhirl.postprocess.reports.page import Explorer, Page, PageSection, PageTable

POINTS = 121  #: number of speeds along a line

COINCIDENT = ("family", "casing_family")

CAPTION = (
    "Point at a line to see its wave and the directions of travel in both frames; click in the"
    " legend to show or hide a family, drag to zoom in, double-click to reset. Circles are"
    " coincidences of a wave that travels forward on the casing with a wave that travels backward"
    " on the bladed disk; crosses are critical speeds."
)

POINTED = (
    "%{customdata[0]:.5g} Hz, %{y:.5g} ω₁<br>Ω = %{x:.4g} ω₁, %{customdata[1]:.0f} rpm<br>"
    "rotating frame: %{customdata[2]}<br>static frame: %{customdata[3]}"
)


def campbell_page(data: xr.Dataset) -> Page:
    """Return a page with the Campbell diagrams in both frames and a table of the coincidences, from
    `campbell`."""
    inside = campbell.in_diagram(data)
    name, operated = "operating", inside & data["in_operating_range"].values.astype(bool)
    if (ends := operating_range(data)) is None:
        name, operated, ends = "speed", inside, data.attrs["speeds"]
    count = int(operated.sum())
    return Page(
        title=f"{data.attrs['case']}, Campbell diagram",
        subject=f"Rotation effects: {data.attrs.get('rotation_effects', 'none')}",
        verdict=f"Coincidences in the {name} range: {count}",
        tone="fair" if count else "good",
        reason=(
            "Where k Ω = ω of the casing + ω of the bladed disk, the waves of both bodies travel at"
            f" the same speed and contact can drive them. The {name} range is"
            f" {ends[0]:.4g} to {ends[1]:.4g} ω₁."
        ),
        warnings=[],
        figures=[*_glance(data)],
        sections=[
            PageSection(
                name="diagrams",
                title="Campbell diagrams",
                blocks=[_explorer(data, "rotating"), _explorer(data, "static")],
            ),
            PageSection(name="coincidences", title="Coincidences", blocks=[_table(data, inside)]),
        ],
    )


def _glance(data: xr.Dataset) -> Iterator[tuple[str, str, str]]:
    hertz = float(data.attrs["reference_frequency_hz"])
    yield "ω₁", f"{hertz:.5g} Hz", "lowest frequency of the bladed disk, free centre"
    if "branch" not in data.dims:
        return
    parts = (data[f"critical_{part}"].values for part in ("speed", "nodal_diameter", "family"))
    for speed, k, family in zip(*parts, strict=True):
        remark = f"{60 * hertz * speed:.1f} rpm, {family}, k = {k}"
        yield "critical speed", f"{speed:.4f} ω₁", remark
    gone = float(data.attrs["clearance_gone"])
    yield "clearance at rest used up", f"{gone:.4f} ω₁", f"{60.0 * hertz * gone:.1f} rpm"


def _table(data: xr.Dataset, inside: BoolArray) -> PageTable:
    names = ("nodal_diameter", *COINCIDENT, "normalised_speed", "speed", "in_operating_range")
    columns = (data[name].values[inside] for name in names)
    shown = len(names) - (operating_range(data) is None)
    return PageTable(
        name="all-coincidences",
        title="Coincidences by speed",
        head=("k", "bladed disk", "casing", "Ω / ω₁", "rpm", "operating range")[:shown],
        rows=[
            (str(k), family, casing, f"{ratio:.4f}", f"{rpm:.1f}", "inside" if operated else "")[
                :shown
            ]
            for k, family, casing, ratio, rpm, operated in zip(*columns, strict=True)
        ],
        numbers=True,
    )


def _explorer(data: xr.Dataset, frame: campbell.Frame) -> Explorer:
    traces = [_line(wave, frame, data) for wave in campbell.waves(data, POINTS)]
    first_of = {trace.legendgroup: trace for trace in reversed(traces)}
    for trace in traces:  # one entry of the legend for each family
        trace.showlegend = trace is first_of[trace.legendgroup]
    low, high = campbell.frequency_limits(campbell.drawn_part(data), frame)
    if frame == "static":
        axis = {"type": "log", "exponentformat": "power", "range": [np.log10(low), np.log10(high)]}
    else:
        axis = {"range": [low, high]}
    figure = plot(
        [*traces, _coincidences(data, frame), *_critical(data, frame)],
        xaxis={"title_text": "speed Ω / ω₁", "range": data.attrs["speeds"]},
        yaxis={"title_text": f"frequency / ω₁, {frame} frame", **axis},
        hovermode="closest",
    )
    if (ends := operating_range(data)) is not None:
        shade = {"fillcolor": "#f0f0f0", "line_width": 0, "layer": "below"}
        figure.add_vrect(x0=ends[0], x1=ends[1], **shade)
    return Explorer(
        name=f"{frame}-frame",
        title=f"{frame.capitalize()} frame",
        caption=CAPTION if frame == "rotating" else "",
        plots=[figure],
    )


def _line(wave: campbell.Wave, frame: campbell.Frame, data: xr.Dataset) -> go.Scatter:
    hertz = float(data.attrs["reference_frequency_hz"])
    on_casing = wave.body == "casing"
    frequency = np.abs(getattr(wave, frame))
    columns = (
        (hertz * frequency).tolist(),
        (60.0 * hertz * wave.speed).tolist(),
        _directions(wave.rotating),
        _directions(wave.static),
    )
    group = f"casing {wave.family}" if on_casing else wave.family
    lowest = ("rigid", "1F") if on_casing else campbell.DRAWN_FAMILIES
    return go.Scatter(
        x=wave.speed,
        y=frequency,
        customdata=[*zip(*columns, strict=True)],
        hovertemplate=f"{POINTED}<extra>{group}, k = {wave.nodal_diameter}</extra>",
        mode="lines",
        line_color=campbell.wave_colour(wave.body, wave.family, wave.nodal_diameter),
        line_width=2.2 if wave.nodal_diameter == 1 else 1.1,
        line_dash="dot" if on_casing else "solid" if wave.direction == "backward" else "dash",
        name=group,
        legendgroup=group,
        visible=True if wave.family in lowest else "legendonly",
    )


def _directions(signed: FloatArray) -> list[str]:
    return ["backward" if w > 0.0 else "forward" if w < 0.0 else "standing" for w in signed]


def _coincidences(data: xr.Dataset, frame: campbell.Frame) -> go.Scatter:
    shown = data.isel(coincidence=campbell.in_diagram(data))
    columns = (shown[name].values.tolist() for name in ("nodal_diameter", *COINCIDENT, "speed"))
    return go.Scatter(
        x=shown["normalised_speed"].values,
        y=campbell.met_frequencies(shown, frame),
        customdata=[*zip(*columns, strict=True)],
        hovertemplate="%{customdata[1]} meets casing %{customdata[2]}<br>%{x:.4f} ω₁,"
        " %{customdata[3]:.1f} rpm<extra>k = %{customdata[0]}</extra>",
        mode="markers",
        marker={"size": 9, "color": "#ffffff", "line_color": COLOURS["total"], "line_width": 1.5},
        name="coincidence",
    )


def _critical(data: xr.Dataset, frame: campbell.Frame) -> Iterator[go.Scatter]:
    if "branch" not in data.dims:
        return
    speed, k = data["critical_speed"].values, data["critical_nodal_diameter"].values
    families = data["critical_family"].values
    yield go.Scatter(
        x=speed,
        y=speed * k if frame == "static" else np.zeros(len(speed)),
        text=[f"{family}, k = {number}" for number, family in zip(k, families, strict=True)],
        hovertemplate="critical speed %{x:.5f} ω₁<extra>%{text}</extra>",
        mode="markers",
        marker={"size": 11, "symbol": "x", "color": COLOURS["contact"]},
        name="critical speed",
        cliponaxis=False,
    )

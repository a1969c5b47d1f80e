"""Campbell diagrams to point at, as a page: frequency, speed and whirl direction of every wave."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.postprocess.modal.campbell import (
    DRAWN_FAMILIES,
    Frame,
    drawn_part,
    frequency_limits,
    in_diagram,
    met_frequencies,
    wave_colour,
)
from bladewhirl.postprocess.plotting.style import COLOURS
from bladewhirl.postprocess.reports.interactive import LEGEND_BELOW, Plot, plain_layout
from bladewhirl.postprocess.reports.page import Explorer, Page, Section, Table

POINTS = 121
"""Speeds along a line."""

CAPTION = (
    "Point at a line for its wave and the way that this travels in both frames; click in the legend"
    " to show or hide a family, drag to zoom in, double-click to see all. Circles are coincidences"
    " of a wave that travels forward on the casing with one that travels backward on the bladed"
    " disk; crosses are critical speeds."
)

POINTED = (
    "%{customdata[0]:.5g} Hz, %{y:.5g} ω₁<br>Ω = %{x:.4g} ω₁, %{customdata[1]:.0f} rpm<br>"
    "rotating frame: %{customdata[2]}<br>static frame: %{customdata[3]}"
)


@dataclass(frozen=True, kw_only=True)
class _Wave:
    """A wave over the speed; frequencies are normalised, positive backward."""

    body: str
    family: str
    nodal_diameter: int
    way: str  #: at rest
    speed: FloatArray
    rotating: FloatArray

    @property
    def static(self) -> FloatArray:
        """Its frequency as seen from the casing."""
        return self.rotating - self.nodal_diameter * self.speed


def campbell_page(data: xr.Dataset) -> Page:
    """Both Campbell diagrams to point at, and all coincidences inside them.

    Args:
        data: from `campbell`.
    """
    inside = in_diagram(data)
    operated = inside & data["in_operating_range"].values.astype(bool)
    low, high = data.attrs["operating_range"]
    count = int(operated.sum())
    return Page(
        title=f"{data.attrs['case']}, Campbell diagram",
        subject=f"Rotation effects: {data.attrs.get('rotation_effects', 'none')}",
        verdict=f"{count or 'No'} coincidence{'' if count == 1 else 's'} in the operating range",
        tone="fair" if count else "good",
        reason=(
            "Where k Ω = ω of the casing + ω of the bladed disk, waves of both keep pace and"
            f" contact feeds them. The operating range is {low:.4g} to {high:.4g} ω₁."
        ),
        warnings=[],
        figures=[*_glance(data)],
        sections=[
            Section(
                name="diagrams",
                title="Campbell diagrams",
                blocks=[_explorer(data, "rotating"), _explorer(data, "static")],
            ),
            Section(name="coincidences", title="Coincidences", blocks=[_table(data, inside)]),
        ],
    )


def _glance(data: xr.Dataset) -> Iterator[tuple[str, str, str]]:
    hertz = float(data.attrs["reference_frequency_hz"])
    yield "ω₁", f"{hertz:.5g} Hz", "lowest of the bladed disk, free centre"
    if "branch" not in data.dims:
        return
    for speed, k, family in zip(
        *(data[f"critical_{part}"].values for part in ("speed", "nodal_diameter", "family")),
        strict=True,
    ):
        yield (
            "critical speed",
            f"{speed:.4f} ω₁",
            f"{60 * hertz * speed:.1f} rpm, {family}, k = {k}",
        )
    gone = float(data.attrs["clearance_gone"])
    yield "cold clearance gone", f"{gone:.4f} ω₁", f"{60.0 * hertz * gone:.1f} rpm"


def _table(data: xr.Dataset, inside: BoolArray) -> Table:
    columns = ("nodal_diameter", "family", "casing_family", "normalised_speed", "speed")
    rows = zip(*(data[name].values[inside] for name in columns), strict=True)
    operated = data["in_operating_range"].values[inside]
    return Table(
        name="all-coincidences",
        title="Inside the diagrams, by speed",
        head=("k", "bladed disk", "casing", "Ω / ω₁", "rpm", "operating range"),
        rows=[
            (str(k), family, casing, f"{ratio:.4f}", f"{rpm:.1f}", "inside" if there else "")
            for (k, family, casing, ratio, rpm), there in zip(rows, operated, strict=True)
        ],
        numbers=True,
    )


def _explorer(data: xr.Dataset, frame: Frame) -> Explorer:
    traces = [_line(wave, frame, data) for wave in _waves(data)]
    first: set[str] = set()
    for trace in traces:  # one entry of the legend for each family
        trace["showlegend"] = trace["legendgroup"] not in first
        first.add(trace["legendgroup"])
    axis: dict[str, Any] = {"title": {"text": f"frequency / ω₁, {frame} frame"}}
    limits = frequency_limits(drawn_part(data), frame)
    if frame == "static":
        axis |= {"type": "log", "exponentformat": "power", "range": np.log10(limits).tolist()}
    else:
        axis |= {"range": [*limits]}
    layout = plain_layout(
        xaxis={"title": {"text": "speed Ω / ω₁"}, "range": [*data.attrs["speeds"]]},
        yaxis=axis,
        legend=LEGEND_BELOW,
        hovermode="closest",
    )
    low, high = data.attrs["operating_range"]
    layout["shapes"] = [
        {
            "type": "rect",
            "x0": low,
            "x1": high,
            "y0": 0,
            "y1": 1,
            "yref": "paper",
            "fillcolor": "#f0f0f0",
            "line": {"width": 0},
            "layer": "below",
        }
    ]
    marks = [_coincidences(data, frame), *_critical(data, frame)]
    return Explorer(
        name=f"{frame}-frame",
        title=f"Seen in the {frame} frame",
        caption=CAPTION if frame == "rotating" else "",
        plots=[Plot(traces=[*traces, *marks], layout=layout)],
    )


def _waves(data: xr.Dataset) -> Iterator[_Wave]:
    """All waves: both ways on the bladed disk, forward on the casing."""
    hertz = float(data.attrs["reference_frequency_hz"])
    turning = "branch" in data.dims
    if turning:
        for branch in range(data.sizes["branch"]):
            own = data.isel(branch=branch)
            yield _Wave(
                body="bladed-disk",
                family=str(own["branch_family"].values),
                nodal_diameter=int(own["branch_nodal_diameter"]),
                way=str(own["branch_direction"].values),
                speed=own["line_speed"].values,
                rotating=own["branch_frequency"].values / hertz,
            )
    first, last = data.attrs["speeds"]
    speed = np.linspace(first, last, POINTS)
    for body, family, k, frequency in zip(
        *(data[f"mode_{part}"].values for part in ("body", "family", "nodal_diameter")),
        data["normalised_mode_frequency"].values,
        strict=True,
    ):
        wave: dict[str, Any] = {
            "body": str(body),
            "family": str(family),
            "nodal_diameter": int(k),
            "speed": speed,
        }
        if body == "casing":
            yield _Wave(way="forward", rotating=k * speed - frequency, **wave)
        elif not turning:
            yield _Wave(way="backward", rotating=np.full_like(speed, frequency), **wave)
            if k:
                yield _Wave(way="forward", rotating=np.full_like(speed, -frequency), **wave)


def _line(wave: _Wave, frame: Frame, data: xr.Dataset) -> dict[str, Any]:
    hertz = float(data.attrs["reference_frequency_hz"])
    on_casing, first = wave.body == "casing", wave.nodal_diameter == 1
    here = np.abs(getattr(wave, frame))
    numbers = np.column_stack([hertz * here, 60.0 * hertz * wave.speed]).tolist()
    ways = zip(_ways(wave.rotating), _ways(wave.static), strict=True)
    group = f"casing {wave.family}" if on_casing else wave.family
    lowest = ("rigid", "1F") if on_casing else DRAWN_FAMILIES
    return {
        "type": "scatter",
        "x": wave.speed,
        "y": here,
        "customdata": [[*pair, *both] for pair, both in zip(numbers, ways, strict=True)],
        "hovertemplate": f"{POINTED}<extra>{group}, k = {wave.nodal_diameter}</extra>",
        "mode": "lines",
        "line": {
            "color": wave_colour(wave.body, wave.family, wave.nodal_diameter),
            "width": 2.2 if first else 1.1,
            "dash": "dot" if on_casing else "solid" if wave.way == "backward" else "dash",
        },
        "name": group,
        "legendgroup": group,
        "visible": True if wave.family in lowest else "legendonly",
    }


def _ways(signed: FloatArray) -> list[str]:
    return [
        "backward" if each > 0.0 else "forward" if each < 0.0 else "standing" for each in signed
    ]


def _coincidences(data: xr.Dataset, frame: Frame) -> dict[str, Any]:
    shown = data.isel(coincidence=in_diagram(data))
    return {
        "type": "scatter",
        "x": shown["normalised_speed"].values,
        "y": met_frequencies(shown, frame),
        "customdata": [
            [int(k), str(family), str(casing), round(float(rpm), 1)]
            for k, family, casing, rpm in zip(
                *(shown[n].values for n in ("nodal_diameter", "family", "casing_family", "speed")),
                strict=True,
            )
        ],
        "hovertemplate": (
            "%{customdata[1]} meets casing %{customdata[2]}<br>%{x:.4f} ω₁,"
            " %{customdata[3]} rpm<extra>k = %{customdata[0]}</extra>"
        ),
        "mode": "markers",
        "marker": {
            "size": 9,
            "color": "#ffffff",
            "line": {"color": COLOURS["total"], "width": 1.5},
        },
        "name": "coincidence",
    }


def _critical(data: xr.Dataset, frame: Frame) -> Iterator[dict[str, Any]]:
    if "branch" not in data.dims:
        return
    speed, k = data["critical_speed"].values, data["critical_nodal_diameter"].values
    yield {
        "type": "scatter",
        "x": speed,
        "y": speed * k if frame == "static" else np.zeros(len(speed)),
        "text": [
            f"{family}, k = {n}"
            for n, family in zip(k, data["critical_family"].values, strict=True)
        ],
        "hovertemplate": "critical speed %{x:.5f} ω₁<extra>%{text}</extra>",
        "mode": "markers",
        "marker": {"size": 11, "symbol": "x", "color": COLOURS["contact"]},
        "name": "critical speed",
        "cliponaxis": False,
    }

"""Campbell diagrams (Fig. 8): in the rotating frame, and as seen from the casing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled
from bladewhirl.solvers.stability.coincidence import Coincidences, frequency_in_other_frame

Frame = Literal["rotating", "static"]

SPEED_AXIS = "rotational speed Ω / ω$_1$ [–]"
SHADE = "#F0F0F0"
"""Of the operating range."""

MOST_NUMBERED = 12
"""Highest nodal diameter whose coincidences get their number."""

DIGIT_ROOM, NUMBER_ROOM = 0.014, np.array([0.02, 0.05])
"""Shares of the axes that a number takes, width by the digit; one that would cover another is
left out."""

HEADROOM = 1.15
"""Highest frequency shown over the highest coincidence or mode of interest."""


def campbell_dataset(
    rotor: LabelledModes,
    casing: LabelledModes,
    found: Coincidences,
    *,
    reference: float,
    speeds: tuple[float, float],
    operating: tuple[float, float],
) -> xr.Dataset:
    """Everything behind a Campbell diagram; normalised values are multiples of the reference.

    Args:
        rotor: modes of the bladed disk, a pair given once.
        casing: modes of the casing, a pair given once.
        found: their coincidences.
        reference: frequency that speeds and frequencies are multiples of [rad/s].
        speeds: first and last speed of the diagram, normalised.
        operating: first and last speed of the operating range, normalised.
    """
    one = {"units": "1"}
    return xr.Dataset(
        {
            "rotor_frequency": ("rotor_mode", rotor.frequency / reference, one),
            "rotor_nodal_diameter": ("rotor_mode", rotor.nodal_diameter),
            "rotor_family": ("rotor_mode", np.array(rotor.family, dtype=object)),
            "casing_frequency": ("casing_mode", casing.frequency / reference, one),
            "casing_nodal_diameter": ("casing_mode", casing.nodal_diameter),
            "casing_family": ("casing_mode", np.array(casing.family, dtype=object)),
            "coincidence_speed": (
                "coincidence",
                found.speed / reference,
                {"units": "1", "long_name": "coincidence speed, Eq. (14)"},
            ),
            "coincidence_rotor": ("coincidence", found.rotor),
            "coincidence_casing": ("coincidence", found.casing),
            "coincidence_nodal_diameter": ("coincidence", found.nodal_diameter),
        },
        attrs={
            "title": "Campbell diagram",
            "reference_frequency": reference,
            "speeds": speeds,
            "operating_range": operating,
        },
    )


@styled
def plot_campbell(data: xr.Dataset, frame: Frame) -> Figure:
    """Draw a Campbell diagram: the modes of one body as levels, the other's waves as rays.

    In the rotating frame the bladed disk's frequencies are constant and a wave that travels
    forward on the casing has k Omega - omega, backward where that is positive, as drawn. In the
    static frame it is the other way round: rays are waves that travel backward on the rotor.
    Where a ray would fall below zero, its wave travels the other way: that part is left out in the
    rotating frame, as in Fig. 8, and faint in the static one. Circles mark coincidences, those of
    the first family and the suspension with their k.

    Args:
        data: from `campbell_dataset`.
        frame: whose view.
    """
    figure = new_figure(height=0.088)
    axes = figure.subplots()
    first, last = data.attrs["speeds"]
    axes.axvspan(*data.attrs["operating_range"], color=SHADE, zorder=0)
    level, ray = ("rotor", "casing") if frame == "rotating" else ("casing", "rotor")
    meeting = _coincidence_frequency(data, level)
    seen = (data["coincidence_speed"].values >= first) & (data["coincidence_speed"].values <= last)
    top = HEADROOM * _highest(data, level, meeting[seen])
    axes.set(xlim=(first, last), ylim=(0.0, top))
    speed = np.linspace(first, last, 2001)
    for body in (ray, level):
        for mode in _drawn_last_first(data, body):
            if body == level:
                y = np.full_like(speed, data[f"{body}_frequency"].values[mode])
            else:
                y = frequency_in_other_frame(
                    data[f"{body}_frequency"].values[mode],
                    data[f"{body}_nodal_diameter"].values[mode],
                    speed,
                )
            _draw_mode(axes, speed, y, data, body, int(mode), turned=frame == "static")
    _mark_coincidences(axes, data, meeting, seen & (meeting <= top))
    axes.set(xlabel=SPEED_AXIS, ylabel=f"frequency / ω$_1$, {frame} frame [–]")
    figure.legend(handles=_legend(data), loc="outside upper center", ncols=3, columnspacing=1.0)
    return figure


def _mark_coincidences(axes: Axes, data: xr.Dataset, meeting: FloatArray, shown: BoolArray) -> None:
    speeds, k = data["coincidence_speed"].values, data["coincidence_nodal_diameter"].values
    family = data["rotor_family"].values[data["coincidence_rotor"].values]
    ring: Mapping[str, Any] = {
        "markersize": 3.6,
        "markerfacecolor": "white",
        "linestyle": "none",
        "zorder": 5,
    }
    for here, colour in ((shown & (k != 1), "other k"), (shown & (k == 1), "k = 1")):
        axes.plot(speeds[here], meeting[here], "o", color=COLOURS[colour], clip_on=False, **ring)
    numbered = shown & (k <= MOST_NUMBERED) & np.isin(family, ("1F", "suspension"))
    size = np.array([np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())])
    placed: dict[bool, FloatArray] = {}  # the last number above a level, and below one
    for i in np.flatnonzero(numbered):
        here = np.array([speeds[i], meeting[i]])
        width, height = NUMBER_ROOM
        room = size * np.array([width + DIGIT_ROOM * len(str(k[i])), height])
        # Number 1 stands below, where its neighbours have none, if there is room.
        below = bool(k[i] == 1 and meeting[i] > room[1])
        if below in placed and (np.abs(here - placed[below]) < room).all():
            continue
        placed[below] = here
        offset = (3.0, -9.0) if below else (-4.0, 3.5)
        axes.annotate(str(k[i]), tuple(here), xytext=offset, textcoords="offset points")


def _draw_mode(
    axes: Axes,
    speed: FloatArray,
    y: FloatArray,
    data: xr.Dataset,
    body: str,
    mode: int,
    *,
    turned: bool,
) -> None:
    colour = _colour(data, body, mode)
    first = int(data[f"{body}_nodal_diameter"].values[mode]) == 1
    look: Mapping[str, Any] = {
        "color": colour,
        "linestyle": "-" if body == "rotor" else "--",
        "linewidth": 1.2 if first else 0.7,
        "zorder": 3 if first else 2,
    }
    axes.plot(speed, np.where(y >= 0.0, y, np.nan), **look)
    if turned:
        axes.plot(speed, np.where(y < 0.0, -y, np.nan), **{**look, "linewidth": 0.4}, alpha=0.35)


def _colour(data: xr.Dataset, body: str, mode: int) -> str:
    if str(data[f"{body}_family"].values[mode]) == "suspension":
        return COLOURS["suspension"]
    first = int(data[f"{body}_nodal_diameter"].values[mode]) == 1
    if body == "rotor":
        return COLOURS["k = 1"] if first else COLOURS["other k"]
    return COLOURS["k = 0"] if first else COLOURS["casing"]


def _legend(data: xr.Dataset) -> list[Line2D | Patch]:
    disk: Mapping[str, Any] = {"linestyle": "-"}
    wall: Mapping[str, Any] = {"linestyle": "--"}
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=COLOURS["k = 1"], linewidth=1.2, label="disk, k = 1", **disk),
        Line2D([], [], color=COLOURS["other k"], linewidth=0.7, label="disk, other k", **disk),
        Line2D([], [], color=COLOURS["k = 0"], linewidth=1.2, label="casing, k = 1", **wall),
        Line2D([], [], color=COLOURS["casing"], linewidth=0.7, label="casing, other k", **wall),
    ]
    if "suspension" in data["rotor_family"].values:
        handles.insert(
            2,
            Line2D([], [], color=COLOURS["suspension"], linewidth=1.2, label="suspension", **disk),
        )
    ring: Mapping[str, Any] = {
        "linestyle": "none",
        "marker": "o",
        "markersize": 3.6,
        "markerfacecolor": "white",
    }
    handles.append(Line2D([], [], color=COLOURS["total"], label="coincidence of k", **ring))
    handles.append(Patch(color=SHADE, label="operating range"))
    return handles


def _coincidence_frequency(data: xr.Dataset, level: str) -> FloatArray:
    """Frequency of each coincidence in the frame where a body's modes are levels."""
    return np.asarray(
        data[f"{level}_frequency"].values[data[f"coincidence_{level}"].values.astype(np.int64)]
    )


def _highest(data: xr.Dataset, level: str, meeting: FloatArray) -> float:
    """Highest frequency worth showing: of the rotor's modes, or of the coincidences seen."""
    if level == "rotor":
        return float(data["rotor_frequency"].values.max())
    return float(meeting.max(initial=1.0))


def _drawn_last_first(data: xr.Dataset, body: str) -> IntArray:
    """Numbers of a body's modes, those with one nodal diameter last, so that they lie on top."""
    return np.argsort(data[f"{body}_nodal_diameter"].values == 1, kind="stable")

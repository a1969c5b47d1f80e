"""The unrolled casing as a block of a report that plays: gap, force and wear in spans of time."""

import base64

import numpy as np
import xarray as xr

from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.plotting.style import COLOUR_MAPS
from bladewhirl.postprocess.reports.page import Player
from bladewhirl.postprocess.run.unrolled import MAPS, QUANTITIES

MOST_CELLS = 360  #: largest number of cells around the casing
SHADES = 254  #: largest shade; the next one has no value

CAPTION = (
    "The casing unrolled, by angle from 0° to 360° and axial position, in spans of time of a"
    " revolution or more: the smallest gap, the largest force between two records, and the depth"
    " removed. White is zero, grey is where no blade passed. Point at a place for its value."
)


def player(data: xr.Dataset) -> Player:
    """Return the block from `unrolled.unrolled`."""
    rows = []
    for name, words in QUANTITIES.items():
        if name not in data:
            continue
        values = data[name].values
        group = -(-values.shape[2] // MOST_CELLS)
        starts = np.arange(0, values.shape[2], group)
        choice = np.fmin if name == "gap" else np.fmax
        values = choice.reduceat(values, starts, axis=2)[:, ::-1]  # the first row is at the top
        top = float(np.nanmax(values, initial=0.0))
        unit, scale = handy_unit(top, str(data[name].attrs["units"]))
        shades = COLOUR_MAPS[MAPS[name]](np.linspace(0.0, 1.0, SHADES + 1))
        shades[0, :3] = 1.0  # zero is white
        rows.append(
            {
                "label": f"{words} [{unit}]",
                "top": scale * top,
                "shape": list(values.shape),
                "shades": _packed(_shades(values, top)),
                "colours": _packed(np.round(255 * shades[:, :3])),
            }
        )
    axial = data["axial"].values
    low, high = (handy(float(end), "m", 3) for end in (axial.min(), axial.max()))
    tracks = (
        f" Rows are the axial positions of contact nodes, {low} at the bottom to {high} at the top."
    )
    return Player(
        name="casing-film",
        title="Casing over time",
        caption=CAPTION + tracks * (len(axial) > 1),
        rows=rows,
        times=[f"to {handy(float(time), 's', 4)}" for time in data["time"].values],
        start=int(np.argmax(data["force"].max(("axial", "sector")).values)),
    )


def _shades(values: Array, top: float) -> Array:
    """Return values as shades from 0 to `SHADES`, and the next one for nan."""
    shares = np.round(SHADES * values / (top or 1.0))
    return np.where(np.isnan(values), SHADES + 1, shares)


def _packed(values: Array) -> str:
    """Return numbers from 0 to 255 as base64."""
    return base64.b64encode(values.astype(np.uint8).tobytes()).decode("ascii")

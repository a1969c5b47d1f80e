"""The way of the shaft's centre, as insets of pictures show it: in units of a circle around it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.fields import Array, IntArray, history, rotate, turn
from bladewhirl.postprocess.pictures.colouring import scale_end
from bladewhirl.postprocess.pictures.drawing import Frame
from bladewhirl.postprocess.plotting.units import length_unit


class ShaftTrail(NamedTuple):
    """Where the centre was."""

    places: Array  #: in units of the circle's radius (record, 2)
    title: str  #: which says how large the circle is


def shaft_trail(dataset: xr.Dataset, records: IntArray, frame: Frame) -> ShaftTrail:
    """The centre at records, in static or rotating axes."""
    rows = dataset["rotor_shape"].values[int(dataset["centre_node"]), :2]
    way = history(dataset, "rotor_displacement", records) @ rows.T
    if frame == "static":
        way = rotate(way, turn(dataset, records))
    reach = float(np.linalg.norm(way, axis=1).max())
    unit, scale = length_unit(reach)
    end = scale_end(1.1 * scale * reach)  # the orbit stays clear of the circle
    title = f"shaft\N{RIGHT SINGLE QUOTATION MARK}s orbit, circle {end:g} {unit}"
    return ShaftTrail(scale / end * way, title)

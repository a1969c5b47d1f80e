"""Blades that end short of the tip radius, or beyond it: by how much, and how they are drawn."""

from __future__ import annotations

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.blades import line_blades
from bladewhirl.postprocess.fields.fields import Array

ROUNDING = 1e-12  #: relative differences of radii below this are none


def tip_recess(dataset: xr.Dataset) -> Array:
    """How much nearer to the centre than the tip radius each tip ends at rest (blade,) [m]."""
    radius = float(dataset.attrs["tip_radius"])
    tips = np.linalg.norm(dataset["rotor_point"].values[dataset["tip_node"].values], axis=1)
    recess: Array = np.where(np.abs(radius - tips) > ROUNDING * radius, radius - tips, 0.0)
    return recess


def recessed(dataset: xr.Dataset, stations: Array, recess: Array) -> tuple[Array, Array]:
    """Nodes and stations of beams with every tip nearer to the centre by `recess` (blade,) [m],
    its blade shortened evenly, and what hangs on the blade moved along.
    """
    nodes, lines = dataset["rotor_point"].values, dataset["rotor_line"].values
    blade, radius = line_blades(dataset), np.linalg.norm(nodes, axis=1)
    shift = np.zeros(len(nodes))
    for number in np.flatnonzero(recess):
        own = np.unique(lines[blade == number])
        root, tip = radius[own].min(), radius[dataset["tip_node"].values[number]]
        shift[own] = recess[number] * (radius[own] - root) / (tip - root)
    x = np.linspace(0.0, 1.0, stations.shape[1])
    along = np.outer(shift[lines[:, 0]], 1.0 - x) + np.outer(shift[lines[:, 1]], x)
    return _drawn_in(nodes, shift), _drawn_in(stations, along)


def _drawn_in(points: Array, shift: Array) -> Array:
    """Points (..., 2) nearer to the centre by `shift` (...) [m]."""
    radius = np.linalg.norm(points, axis=-1)
    share = np.divide(shift, radius, out=np.zeros_like(radius), where=radius > 0)
    return np.asarray(points * (1.0 - share[..., None]))

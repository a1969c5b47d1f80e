"""The motion of the blade tips along and across their own radius."""

from __future__ import annotations

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.result import reduce_modes


def tip_displacement(dataset: xr.Dataset) -> xr.Dataset:
    """Displacement of every blade tip at every record, read portion by portion.

    Args:
        dataset: a result, or a window of one.

    Returns:
        `radial` (outward) and `tangential` (counter-clockwise) over (time, blade) [m], in the
        rotating frame, along the axes of the undeformed tip.
    """
    angle = dataset["tip_angle"].values
    outward = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    shapes = dataset["rotor_shape"].values[dataset["tip_node"].values, :2]
    rows = np.concatenate(
        [np.einsum("bd,bdm->bm", axis, shapes) for axis in (outward, across)], axis=0
    )
    moved = reduce_modes(dataset, "rotor_displacement", rows)
    blades = dataset.sizes["blade"]
    metre = {"units": "m"}
    return xr.Dataset(
        data_vars={
            "radial": (("time", "blade"), moved[:, :blades], metre),
            "tangential": (("time", "blade"), moved[:, blades:], metre),
        },
        coords={"time": dataset["time"], "blade": np.arange(blades)},
        attrs={"title": "displacement of the blade tips, rotating frame"},
    )

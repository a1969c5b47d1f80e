"""A rigid wall as a casing that does not move, for ParaView."""

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.netcdf import has

NODES = 128  #: number of nodes of the drawn wall

THICKNESS = 0.02  #: thickness of the drawn wall, divided by its radius


def with_wall(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result whose rigid wall is a casing with one mode, in which nothing moves, and whose
    width is zero, as it is not known; a result with a flexible casing is returned unchanged."""
    if has(dataset, "casing"):
        return dataset
    records = dataset.sizes["time"]
    size = THICKNESS * float(dataset.attrs["casing_radius"])
    along, still = np.full(NODES, size), np.zeros((records, 1))
    return dataset.assign(
        casing_angle=("casing_node", 2.0 * np.pi / NODES * np.arange(NODES)),
        casing_shape=(("casing_node", "casing_component", "casing_mode"), np.zeros((NODES, 4, 1))),
        casing_displacement=(("time", "casing_mode"), still),
        casing_velocity=(("time", "casing_mode"), still),
        casing_thickness=("casing_node", along),
        casing_width=("casing_node", 0.0 * along),
        casing_young_modulus=("casing_node", np.zeros(NODES)),
        casing_curvature=((), "exact"),
    )

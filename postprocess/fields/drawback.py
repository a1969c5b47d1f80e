"""Distance by which the tips of bent blades draw back, from a result."""

import numpy as np
import xarray as xr

from bladewhirl.models.elements.foreshortening import slope_form
from bladewhirl.postprocess.fields.blades import blade_chain
from bladewhirl.postprocess.fields.kinematics import line_shapes

RECORDS = 1000
"""Largest number of records that are looked at."""


def largest_drawback(dataset: xr.Dataset) -> float:
    """Return the largest distance by which a tip draws back towards its root, to second order [m].

    The distance is measured along the radius of the tip, relative to axes that turn with the root;
    see `models.elements.foreshortening`.

    Raises:
        ViewError: the beams of a blade are not a chain that ends at its tip.
    """
    points = dataset["rotor_point"].values
    _, span, axes, local, rotation = line_shapes(dataset)
    length = np.linalg.norm(span, axis=1)
    every = -(-dataset.sizes["time"] // RECORDS)
    coordinates = dataset["rotor_displacement"].values[::every]
    largest = 0.0
    for blade, tip in enumerate(dataset["tip_node"].values):
        out, drawn = points[tip] / np.linalg.norm(points[tip]), np.zeros(len(coordinates))
        chain = blade_chain(dataset, blade)
        first, forward = chain[0]
        root = rotation[first, 0 if forward else 1]
        for line, forward in chain:
            rise = local[line, 1, 1] - local[line, 0, 1] - length[line] * root
            moved = coordinates @ np.array([rise, *(rotation[line] - root)]).T
            along = axes[line, 0] @ out * (1.0 if forward else -1.0)
            form = along * slope_form(float(length[line]))
            drawn += 0.5 * np.einsum("ri,ij,rj->r", moved, form, moved)
        largest = max(largest, float(drawn.max()))
    return largest

"""Wear of the coating against a swept key."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.plotting.style import styled
from bladewhirl.postprocess.sweep.drawing import plot_quantities
from bladewhirl.postprocess.sweep.quantities import along

PANELS = {
    "wear_volume": (1e6, "removed volume [cm³]"),
    "wear_strain_max": (100.0, "deepest cut [% of thickness]"),
    "wear_lobes": (1.0, "lobes"),
}
"""Factor and label of each panel."""


def wear_quantities(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Load the quantities of the wear of a sweep along a key, see `quantities.along`.

    Raises:
        ViewError: no point has a coating.
    """
    data = along(dataset, key, [*PANELS, "wear_dissipated", "regime"])
    if not np.isfinite(data["wear_volume"]).any():
        raise ViewError("no point of this sweep has a casing.coating, so nothing can be worn")
    return data.assign_attrs(title="wear of the coating")


@styled
def plot_wear_quantities(data: xr.Dataset) -> Figure:
    """Draw removed volume, deepest cut and number of lobes against the swept key, from
    `wear_quantities`. Divergent points have open marks."""
    return plot_quantities(data, PANELS)

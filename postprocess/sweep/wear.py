"""Wear of the coating over a swept key."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.plotting.legends import Group
from bladewhirl.postprocess.plotting.style import FULL_WIDTH, new_figure, styled
from bladewhirl.postprocess.sweep import drawing
from bladewhirl.postprocess.sweep.axes import in_handy_units, key_axis
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
    """Draw removed volume, deepest cut and number of lobes over the swept key, from
    `wear_quantities`. Divergent points have open marks."""
    data = in_handy_units(data)
    lines = drawing.lines_of(data)
    figure = new_figure(width=FULL_WIDTH, height=0.14)
    panels = figure.subplots(len(PANELS), sharex=True)
    for axes, (name, (scale, label)) in zip(panels, PANELS.items(), strict=True):
        for line in lines:
            size = scale * line.data[name].values
            axes.plot(line.place, size, color=line.colour, linestyle=line.dash)
            drawing.draw_marks(axes, line, size, filled=line.data["regime"].values != "divergent")
        axes.margins(y=0.1)
        axes.set_ylim(bottom=0.0)
        axes.set_ylabel(label)
    key_axis(panels[-1], data)
    divergent = (data["regime"] == "divergent").any()
    marks = [drawing.open_mark("divergent (open marks)")] if divergent else []
    drawing.label_figure(figure, data, Group(marks), drawing.lines_group(lines))
    return figure

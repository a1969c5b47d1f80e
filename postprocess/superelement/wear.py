"""Wear of the coating under the contact nodes of a superelement."""

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.models.stage.node_coating import axial_tracks
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.plotting.axes import draw_map
from bladewhirl.postprocess.plotting.style import FULL_WIDTH, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.run.wear import write_columns
from bladewhirl.postprocess.superelement.motion import check_superelement


def node_wear(result: xr.Dataset) -> xr.Dataset:
    """Compute the wear of the coating under contact nodes.

    Args:
        result: result of a superelement whose wall has a coating.

    Returns:
        Dataset with `recess` [m] over (track, rod), the removed depth at the end; `wear_volume`
        [m3], `wear_dissipated` [J] and `coating_energy` [J] over time; coordinates `axial` [m] of
        each track and `angle` [rad] of each rod.

    Raises:
        ViewError: the wall has no coating.
    """
    check_superelement(result)
    if "coating_strain" not in result:
        raise ViewError("this run has no casing.coating, so nothing can be worn")
    recess = float(result.attrs["coating_thickness"]) * result["coating_strain"].values[-1]
    axial, _ = axial_tracks(result["contact_axial"].values, result["contact_radius"].values)
    return labelled(
        result,
        "wear of the coating",
        {
            "recess": (("track", "rod"), recess, "m"),
            **{
                name: (("time",), result[name].values, result[name].attrs["units"])
                for name in ("wear_volume", "wear_dissipated", "coating_energy")
            },
        },
        {"time": result["time"].values},
    ).assign_coords(
        axial=("track", axial, {"units": "m"}),
        angle=("rod", result["rod_angle"].values, {"units": "rad"}),
    )


def write_tracks(data: xr.Dataset, path: Path) -> None:
    """Write the removed depth of each track, from `node_wear`, as a CSV file, which
    `casing.coating.profile` reads."""
    tracks = zip(data["axial"].values.tolist(), data["recess"].values, strict=True)
    columns = {f"recess at {axial!r} m [m]": depth for axial, depth in tracks}
    write_columns(path, {"angle [rad]": data["angle"].values, **columns})


@styled
def plot_node_wear(data: xr.Dataset) -> Figure:
    """Draw the removed depth on the unrolled wall, and the removed volume over time, from
    `node_wear`."""
    figure = new_figure(width=FULL_WIDTH, height=0.1)
    above, below = figure.subplots(2, 1, height_ratios=[1.3, 1.0])
    recess, axial = data["recess"].values, data["axial"].values
    unit, scale = handy_unit(float(np.abs(axial).max()), "m")
    depth_unit, depth_scale = handy_unit(float(recess.max()), "m")
    half = 0.5 * (np.diff(axial).mean() if len(axial) > 1 else 1e-3)
    middles = 0.5 * (axial[1:] + axial[:-1])
    edges = scale * np.concatenate([axial[:1] - half, middles, axial[-1:] + half])
    degrees = np.linspace(0.0, 360.0, recess.shape[1] + 1)
    drawn = draw_map(above, degrees, edges, depth_scale * recess, cmap="magma_r")
    figure.colorbar(drawn, ax=above, label=f"removed depth [{depth_unit}]")
    above.set(xticks=np.arange(0, 361, 45), xlabel="angle on the wall, static frame [°]")
    above.set_ylabel(f"axial position [{unit}]")
    below.plot(data["time"], 1e9 * data["wear_volume"])
    below.set_ylabel("removed volume [mm³]")
    time_axis(below)
    head(figure, data)
    return figure

"""Wear of the coating under the contact nodes of a superelement."""

from pathlib import Path

import xarray as xr

from bladewhirl.models.stage.coating import axial_tracks
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.run.wear import coating_of, write_columns
from bladewhirl.postprocess.superelement.motion import check_superelement


def node_wear(result: xr.Dataset) -> xr.Dataset:
    """Compute the wear of the coating under contact nodes.

    Args:
        result: result of a superelement whose wall has a coating.

    Returns:
        Dataset with `recess` [m] over (track, rod), the removed depth at the end; a track is a ring
        of rods at one axial position; `wear_volume` [m3], `wear_dissipated` [J] and
        `coating_energy` [J] over time; coordinates `axial` [m] of each track and `angle` [rad] of
        each rod.

    Raises:
        ViewError: the wall has no coating.
    """
    check_superelement(result)
    recess = coating_of(result).thickness * result["coating_strain"].values[-1]
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

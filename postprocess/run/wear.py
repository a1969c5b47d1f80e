"""Wear of an abradable coating: profile around the casing, its lobes, volume and forces."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.files import write_atomically
from bladewhirl.models.case.casing import Casing
from bladewhirl.models.case.coating import Coating
from bladewhirl.postprocess.fields.kinematics import Array, ViewError, table_of_result
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.plotting.axes import draw_map
from bladewhirl.postprocess.plotting.style import new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head

MOST_LOBES = 60  #: largest number of lobes in the spectrum of a profile

METAL_SHARE = 1e-9
"""A tip touches the metal under the coating if the metal's part of the impulse exceeds this
fraction of the largest impulse; smaller parts are rounding errors."""


def coating_of(dataset: xr.Dataset) -> Coating:
    """Return the coating of the casing in the case of a result.

    Raises:
        ViewError: the casing has no coating.
    """
    casing = table_of_result(dataset, "casing", Casing)
    coating = casing.coating if "coating_strain" in dataset else None
    if coating is None:
        raise ViewError("this run has no casing.coating, so nothing can be worn")
    return coating


def wear(result: xr.Dataset) -> xr.Dataset:
    """Compute the wear of the coating in a run.

    Args:
        result: result of a run whose casing has a coating.

    Returns:
        Dataset with `recess` [m] over (wear_time, rod), the removed depth of the rods of the
        coating at the times of the stored profiles; `lobe_share` [1] over lobes, the share of each
        harmonic in the variance of the last profile; `wear_volume` [m3], `wear_dissipated` [J] and
        `coating_energy` [J] over time. Attributes: `lobes`, the number of lobes with the largest
        share, and `metal_time` [s], at which a tip first touches the metal wall under the coating;
        nan if no tip touches the metal.

    Raises:
        ViewError: the casing has no coating.
    """
    coating = coating_of(result)
    recess = coating.thickness * result["coating_strain"].values
    share = lobe_shares(recess[-1])
    return labelled(
        result,
        "wear of the coating",
        {
            "recess": (("wear_time", "rod"), recess, "m"),
            "lobe_share": ("lobes", share[:MOST_LOBES], "1"),
            **{
                name: ("time", result[name].values, result[name].attrs["units"])
                for name in ("wear_volume", "wear_dissipated", "coating_energy")
            },
        },
        {
            "time": result["time"].values,
            "wear_time": result["wear_time"].values,
            "lobes": np.arange(1, len(share) + 1)[:MOST_LOBES],
        },
        lobes=_lobes(share),
        metal_time=_metal_time(result),
        thickness=coating.thickness,
    ).assign_coords(angle=("rod", result["rod_angle"].values, {"units": "rad"}))


def lobe_shares(recess: Array) -> Array:
    """Return the share of each harmonic, from 1 on, in the variance of a profile (rod,); zero for a
    uniform profile."""
    waves = np.abs(np.fft.rfft(recess)[1:]) ** 2
    variance = len(recess) * float(((recess - recess.mean()) ** 2).sum()) / 2.0  # of all harmonics
    return np.asarray(waves / variance if variance > 0.0 else np.zeros(len(waves)))


def _lobes(share: Array) -> int:
    """Return the number of lobes with the largest share; 0 for a uniform profile."""
    return int(share.argmax()) + 1 if share.any() else 0


def _metal_time(result: xr.Dataset) -> float:
    impulse = result["contact_impulse"].values
    metal = impulse - result["coating_impulse"].values
    touching = (metal > METAL_SHARE * impulse.max(initial=0.0)).any(axis=1)
    return float(result["time"].values[touching.argmax()]) if touching.any() else np.nan


def wear_summary(result: xr.Dataset) -> dict[str, Any]:
    """Return the key figures of the wear for `summary.json`; an empty dict without a coating."""
    if "coating_strain" not in result:
        return {}
    strain = result["coating_strain"].values[-1]
    tracks = strain.reshape(-1, strain.shape[-1])  # one, or those under a superelement
    share = lobe_shares(tracks.mean(axis=0))
    lobes = _lobes(share)
    metal = _metal_time(result)
    return {
        "wear_volume": float(result["wear_volume"][-1]),
        "wear_strain_max": float(strain.max()),
        "wear_strain_mean": float(strain.mean()),
        "wear_dissipated": float(result["wear_dissipated"][-1]),
        "coating_impulse": result["coating_impulse"].sum("time").values.tolist(),
        "lobes": lobes,
        "lobes_share": float(share[lobes - 1]) if lobes else 0.0,
        "metal_time": metal if np.isfinite(metal) else None,
    }


def write_profile(result: xr.Dataset, path: Path) -> None:
    """Write the last profile of the coating as a CSV file, which `casing.coating.profile` reads."""
    recess = coating_of(result).thickness * result["coating_strain"].values[-1]
    write_columns(path, {"angle [rad]": result["rod_angle"].values, "recess [m]": recess})


def write_columns(path: Path, columns: Mapping[str, Array]) -> None:
    """Write columns at full precision as a CSV file, with their headings."""
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows)]
    write_atomically(path, "\n".join(lines) + "\n")


@styled
def plot_wear_map(data: xr.Dataset) -> Figure:
    """Draw the removed depth by casing angle and revolution, from `wear`."""
    figure = new_figure(height=0.06)
    axes = figure.subplots()
    turns = abs(float(data.attrs["speed"])) / (2 * np.pi)
    time, angle = (turns or 1.0) * data["wear_time"].values, np.degrees(data["angle"].values)
    depth, label = 1e3 * data["recess"].values.T, "removed depth [mm]"
    draw_map(axes, time, angle, depth, cmap="magma_r", label=label)
    axes.set(yticks=(0, 90, 180, 270, 360), ylabel="casing angle [°]", ylim=(0, 360))
    axes.set_xlabel("revolutions of the rotor")
    if not turns:
        time_axis(axes)
    head(figure, data)
    return figure


@styled
def plot_wear_profile(data: xr.Dataset) -> Figure:
    """Draw the last profile of the coating from `wear`, polar and against the casing angle."""
    figure = new_figure(height=0.11)
    around = figure.add_subplot(2, 1, 1, projection="polar")
    unrolled = figure.add_subplot(2, 1, 2)
    angle, depth = data["angle"].values, 1e3 * data["recess"].values[-1]
    around.plot(np.append(angle, angle[0]), np.append(depth, depth[0]))
    around.set(rlabel_position=90, ylim=(0, 1.05 * float(depth.max()) or 1.0))
    around.set_yticks(around.get_yticks()[:: max(1, len(around.get_yticks()) // 3)])
    unrolled.plot(np.degrees(angle), depth)
    unrolled.set(xticks=(0, 90, 180, 270, 360), xlabel="casing angle [°]", xlim=(0, 360))
    unrolled.set_ylabel("removed depth [mm]")
    head(figure, data)
    return figure


@styled
def plot_wear_lobes(data: xr.Dataset) -> Figure:
    """Draw the share of each number of lobes in the variance of the last profile, from `wear`."""
    figure = new_figure(height=0.05)
    axes = figure.subplots()
    axes.bar(data["lobes"].values, 100 * data["lobe_share"].values)
    axes.set(xlabel="lobes", ylabel="share of the variance [%]", ylim=(0, 100))
    head(figure, data)
    return figure


@styled
def plot_wear_volume(data: xr.Dataset) -> Figure:
    """Draw removed volume and dissipated energy over time, from `wear`."""
    figure = new_figure(height=0.08)
    upper, lower = figure.subplots(2, sharex=True)
    upper.plot(data["time"], 1e9 * data["wear_volume"])
    upper.set_ylabel("removed volume [mm³]")
    lower.plot(data["time"], data["wear_dissipated"])
    lower.set_ylabel("dissipated energy [J]")
    time_axis(lower)
    head(figure, data)
    return figure

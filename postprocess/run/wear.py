"""Wear of an abradable coating: profile around the casing, its lobes, volume and forces."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bladewhirl.files import write_atomically
from bladewhirl.models.case.casing import Casing
from bladewhirl.models.case.coating import Coating
from bladewhirl.models.inputs.units import handy_unit
from bladewhirl.models.stage.coating import axial_tracks, spacing
from bladewhirl.postprocess.fields.kinematics import (
    Array,
    IntArray,
    ViewError,
    table_of_result,
    track_strains,
    turn,
)
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.plotting.axes import draw_map
from bladewhirl.postprocess.plotting.style import COLOUR_MAPS, new_figure, styled, time_axis
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
    coating = casing.coating if has(dataset, "coating") else None
    if coating is None:
        raise ViewError("this run has no casing.coating, so nothing can be worn")
    return coating


def coating_left(dataset: xr.Dataset, records: IntArray) -> Array:
    """Return the thickness of the coating above the metal that each contact node faces at records,
    (record, contact_node) [m]; the metal is where the march has it, at the share `limit`."""
    coating = coating_of(dataset)
    angle = dataset["tip_angle"].values + turn(dataset, records)[:, None]
    track = axial_tracks(dataset["axial_position"].values, dataset["contact_radius"].values)[1]
    strain = [
        track_strains(dataset, records[[n]], at)[0, track, np.arange(len(track))]
        for n, at in enumerate(angle)
    ]
    return np.asarray(coating.thickness * np.maximum(coating.limit - np.array(strain), 0.0))


def wear(result: xr.Dataset) -> xr.Dataset:
    """Compute the wear of the coating in a run.

    Args:
        result: result of a run whose casing has a coating.

    Returns:
        Dataset with `recess` [m] over (wear_time, track, rod), the removed depth of the rods of the
        coating at the times of the stored profiles, with the axial position `axial` [m] of each
        track; over (wear_time, rod) for a single track. Lobes are those of the mean of all tracks,
        by their widths.
        `lobe_share` [1] over lobes is the share of each harmonic in the variance of the last
        profile that the shape of the wall does not explain, see `lobes_of`; `wear_volume` [m3],
        `wear_dissipated` [J] and `coating_energy` [J] are over time. Attributes: `shape_share`, the
        share of the variance that the shape of the wall explains; `lobes`, the number of lobes with
        the largest `lobe_share`; and `metal_time` [s], at which a tip first touches the metal wall
        under the coating; nan if no tip touches the metal.

    Raises:
        ViewError: the casing has no coating.
    """
    coating = coating_of(result)
    recess = coating.thickness * result["coating_strain"].values
    shape, share = lobes_of(result, _mean_of_tracks(result, recess[-1]))
    worn = labelled(
        result,
        "wear of the coating",
        {
            "recess": (tuple(map(str, result["coating_strain"].dims)), recess, "m"),
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
        shape_share=shape,
        lobes=_lobes(share),
        metal_time=_metal_time(result),
        thickness=coating.thickness,
    ).assign_coords(angle=("rod", result["rod_angle"].values, {"units": "rad"}))
    axial = _axial(result)
    worn = worn.assign_coords(axial=("track", axial, {"units": "m"}))
    return worn.squeeze("track") if len(axial) == 1 else worn


def _axial(result: xr.Dataset) -> Array:
    """Return the axial position of each track [m], (tracks,)."""
    return axial_tracks(result["axial_position"].values, result["contact_radius"].values)[0]


def _mean_of_tracks(result: xr.Dataset, values: Array) -> Array:
    """Return the mean over all tracks by their widths, (rods,), of values, (tracks, rods)."""
    weights = spacing(_axial(result)) if len(values) > 1 else None
    return np.asarray(np.average(values, axis=0, weights=weights))


def lobe_shares(recess: Array) -> Array:
    """Return the share of each harmonic, from 1 on, in the variance of a profile (rod,); zero for a
    uniform profile."""
    waves = np.abs(np.fft.rfft(recess)[1:]) ** 2
    variance = len(recess) * float(((recess - recess.mean()) ** 2).sum()) / 2.0  # of all harmonics
    return np.asarray(waves / variance if variance > 0.0 else np.zeros(len(waves)))


def lobes_of(result: xr.Dataset, recess: Array) -> tuple[float, Array]:
    """Return the share of the variance of a profile (rod,) that the shape of the wall explains, and
    the share of each harmonic, from 1 on, in the rest of the variance.

    A wall that is not round is cut deeper where its clearance is smaller, even if no blade
    vibrates: a tip on a circle removes max(d - c, 0), where c is the clearance above its smallest
    value, and d is such that the volume is that of the profile. The shape explains this cut, or the
    part of it that leaves the smallest rest.
    """
    angle = result["rod_angle"].values
    node, height = result["wall_angle"].values, result["clearance"].values
    height = np.interp(angle, node, height, period=2 * np.pi)
    closure = table_of_result(result, "casing", Casing).closure
    if closure is not None:
        height -= float(closure.value(result["time"].values[-1])) * closure.around.value(angle)
    height -= height.min()
    ascending = np.sort(height)
    below = np.cumsum(ascending) - ascending
    mean = (np.arange(len(ascending)) * ascending - below) / len(ascending)  # cut to each height
    depth = np.interp(recess.mean(), mean, ascending) + max(0.0, recess.mean() - mean[-1])
    cut, worn = np.maximum(depth - height, 0.0), recess - recess.mean()
    cut -= cut.mean()
    variance = float(worn @ worn)
    if np.ptp(height) == 0.0 or not variance > 0.0 or not (cut @ cut) > 0.0:
        return 0.0, lobe_shares(recess)
    rest = worn - float(np.clip((worn @ cut) / (cut @ cut), 0.0, 1.0)) * cut
    return 1.0 - float(rest @ rest) / variance, lobe_shares(rest)


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
    if not has(result, "coating"):
        return {}
    strain = result["coating_strain"].values[-1]
    mean = _mean_of_tracks(result, strain)
    shape, share = lobes_of(result, coating_of(result).thickness * mean)
    lobes = _lobes(share)
    metal = _metal_time(result)
    return {
        "wear_volume": float(result["wear_volume"][-1]),
        "wear_strain_max": float(strain.max()),
        "wear_strain_mean": float(mean.mean()),
        "wear_dissipated": float(result["wear_dissipated"][-1]),
        "coating_impulse": result["coating_impulse"].sum("time").values.tolist(),
        "shape_share": shape,
        "lobes": lobes,
        "lobes_share": float(share[lobes - 1]) if lobes else 0.0,
        "metal_time": metal if np.isfinite(metal) else None,
    }


def lobes_text(wear: Mapping[str, Any]) -> str:
    """Return the lobes in the key figures of the wear as text."""
    shape = wear["shape_share"]
    lobes = "no lobes"
    if wear["lobes"]:
        count = "1 lobe has" if wear["lobes"] == 1 else f"{wear['lobes']} lobes have"
        of_what = "the rest" if shape else "the profile's variance"
        lobes = f"{count} {wear['lobes_share']:.0%} of {of_what}"
    return (
        f"{shape:.0%} of the profile's variance follow the wall's shape, {lobes}"
        if shape
        else lobes
    )


def write_profile(result: xr.Dataset, path: Path) -> None:
    """Write the last profile of the coating as a CSV file, which `casing.coating.profile` reads."""
    last = wear(result).isel(wear_time=-1)
    columns = {"recess [m]": last["recess"].values}
    if "track" in last.dims:
        tracks = zip(last["axial"].values.tolist(), last["recess"].values, strict=True)
        columns = {f"recess at {axial!r} m [m]": depth for axial, depth in tracks}
    columns = {"angle [rad]": last["angle"].values, **columns}
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows)]
    write_atomically(path, "\n".join(lines) + "\n")


def _depth(data: xr.Dataset) -> tuple[Array, str]:
    """Return the removed depth, (wear_time, rod), the largest of all tracks, and its label."""
    recess, words = data["recess"].values, "removed depth"
    if recess.ndim > 2:
        recess, words = recess.max(axis=1), "largest removed depth"
    unit, scale = handy_unit(float(recess.max()), "m")
    return scale * recess, f"{words} [{unit}]"


@styled
def plot_wear_map(data: xr.Dataset) -> Figure:
    """Draw the removed depth by casing angle and revolution, the largest of all tracks."""
    figure = new_figure(height=0.06)
    axes = figure.subplots()
    turns = abs(float(data.attrs["speed"])) / (2 * np.pi)
    time, angle = (turns or 1.0) * data["wear_time"].values, np.degrees(data["angle"].values)
    depth, label = _depth(data)
    draw_map(axes, time, angle, depth.T, cmap=COLOUR_MAPS["wall"], label=label)
    axes.set(yticks=(0, 90, 180, 270, 360), ylabel="casing angle [°]", ylim=(0, 360))
    axes.set_xlabel("revolutions of the rotor")
    if not turns:
        time_axis(axes)
    head(figure, data)
    return figure


@styled
def plot_wear_profile(data: xr.Dataset) -> Figure:
    """Draw the last profile of the coating from `wear`, the largest depth of all tracks, polar and
    against the casing angle."""
    figure = new_figure(height=0.11)
    around = figure.add_subplot(2, 1, 1, projection="polar")
    unrolled = figure.add_subplot(2, 1, 2)
    angle, ((depth,), label) = data["angle"].values, _depth(data.isel(wear_time=[-1]))
    around.plot(np.append(angle, angle[0]), np.append(depth, depth[0]))
    between = np.arange(22.5, 360.0, 45.0)  # labels of the radii where the profile is lowest
    lowest = np.interp(np.radians(between), angle, depth, period=2 * np.pi).argmin()
    around.set(rlabel_position=between[lowest], ylim=(0, 1.05 * float(depth.max()) or 1.0))
    around.set_yticks(around.get_yticks()[:: max(1, len(around.get_yticks()) // 3)])
    unrolled.plot(np.degrees(angle), depth)
    unrolled.set(xticks=(0, 90, 180, 270, 360), xlabel="casing angle [°]", xlim=(0, 360))
    unrolled.set_ylabel(label)
    head(figure, data)
    return figure


@styled
def plot_wear_lobes(data: xr.Dataset) -> Figure:
    """Draw the share of each number of lobes in the variance of the last profile that the shape of
    the wall does not explain, from `wear`."""
    figure = new_figure(height=0.05)
    axes = figure.subplots()
    share = 100 * data["lobe_share"].values
    axes.bar(data["lobes"].values, share)
    top = 1.1 * float(share.max()) or 1.0
    axes.set(xlabel="lobes", ylabel="share of the variance [%]", ylim=(0, min(top, 102)))
    shape = float(data.attrs["shape_share"])
    words = [f"without the {shape:.0%} of the variance that follow the wall's shape"]
    head(figure, data, *words[: shape > 0.0])
    return figure


def draw_volume(axes: Axes, data: xr.Dataset) -> None:
    """Draw the removed volume over time in a panel, from `wear`."""
    unit, scale = ("cm³", 1e6) if data["wear_volume"].max() >= 1e-6 else ("mm³", 1e9)
    axes.plot(data["time"], scale * data["wear_volume"])
    axes.set_ylabel(f"removed volume [{unit}]")


@styled
def plot_wear_volume(data: xr.Dataset) -> Figure:
    """Draw removed volume and dissipated energy over time, from `wear`."""
    figure = new_figure(height=0.08)
    upper, lower = figure.subplots(2, sharex=True)
    draw_volume(upper, data)
    lower.plot(data["time"], data["wear_dissipated"])
    lower.set_ylabel("dissipated energy [J]")
    time_axis(lower)
    head(figure, data)
    return figure

"""Forces of the rotor on its bearings: of the springs and dampers at the shaft's centre."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.shaft import Shaft
from bladewhirl.models.inputs.units import handy, handy_unit
from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.kinematics import Array, ViewError, table_of_result
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.shaft.orbits import shaft_orbit


def bearing_forces(result: xr.Dataset, orbit: xr.Dataset | None = None) -> xr.Dataset:
    """Compute the forces of the rotor on its bearings, without its weight.

    Springs act on the displacement of the shaft's centre in the axes in which they are fixed,
    dampers on its velocity in theirs; after the support has fused the springs have the stiffness
    `shaft.fused_stiffness`.

    Args:
        result: result of a run.
        orbit: from `shaft_orbit`; computed when None.

    Returns:
        Dataset over (time, axis): `static`, the components of the force in static axes [N]; over
        time: `force`, its magnitude [N].

    Raises:
        ViewError: the shaft's centre is clamped, does not move in the model, or is that of a wheel
            on a shaft line.
    """
    if has(result, "line"):
        raise ViewError(
            "bearing forces: expected no shaft line; line-bearing-forces has its forces"
        )
    shaft = table_of_result(result, "shaft", Shaft)
    if shaft.clamped or not has(result, "centre"):
        raise ViewError("bearing forces: expected a shaft on springs; its centre does not move")
    orbit = shaft_orbit(result) if orbit is None else orbit
    stiffness = np.tile(result["shaft_stiffness"].values, (orbit.sizes["time"], 1))
    fused = orbit["time"].values > float(result.attrs.get("fuse_time", np.inf))
    stiffness[fused] = shaft.fused_stiffness
    angle = rotation.angles(result)

    def in_static_axes(frame: str, vectors: Array) -> Array:
        return vectors if frame == "static" else np.asarray(rotate(vectors, angle))

    force = in_static_axes(shaft.frame, stiffness * orbit[shaft.frame].values)
    damped = orbit[f"{shaft.damping_frame}_velocity"].values
    force = force + in_static_axes(shaft.damping_frame, np.array(shaft.dampings) * damped)
    return labelled(
        result,
        "forces on the bearings",
        {"static": (("time", "axis"), force, "N"), "force": ("time", np.hypot(*force.T), "N")},
        {"time": orbit["time"].values, "axis": ["x", "y"]},
    )


@styled
def plot_bearing_forces(data: xr.Dataset) -> Figure:
    """Draw the force on the bearings and its components over time, from `bearing_forces`."""
    figure = new_figure(height=0.07)
    axes = figure.subplots()
    time, force = data["time"].values, data["force"].values
    unit, scale = handy_unit(float(force.max()), "N")
    for name, colour in (("x", COLOURS["k = 0"]), ("y", COLOURS["other k"])):
        component = scale * data["static"].sel(axis=name).values
        axes.plot(time, component, color=colour, label=f"along {name}")
    axes.plot(time, scale * force, color=COLOURS["rotor"], label="magnitude")
    axes.set_ylabel(f"force on the bearings [{unit}]")
    figure.legend(loc="outside lower center", ncols=3)
    time_axis(axes)
    worst = int(force.argmax())
    head(figure, data, f"at most {handy(force[worst], 'N', 4)} at {handy(time[worst], 's', 4)}")
    return figure

"""Friction joints between the blades of a run: forces, states, slip and work of each joint."""

from typing import TypedDict

import numpy as np
import xarray as xr

from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.windows import late_part


class JointFigures(TypedDict):
    """Key figures of a joint on all blades."""

    largest_normal_force: float  #: of a pair of nodes at the records of the last third [N]
    largest_tangential_force: float  #: likewise [N]
    share_open: float  #: share of the steps of the last third in which pairs are open
    share_stuck: float  #: share in which they stick
    share_slipping: float  #: share in which they slip
    slip: float  #: largest distance that a pair slipped since the start [m]
    work: float  #: energy that the joint took from the blades since the start [J]
    wear_energy: float  #: energy that slip dissipated since the start [J]


def joint_figures(dataset: xr.Dataset) -> dict[str, JointFigures]:
    """Return the key figures of the joints of a result by name."""
    if not has(dataset, "joints"):
        return {}
    late, last, found = late_part(dataset), dataset.isel(time=-1), {}
    names = dataset["joint_name"].values
    for name in dict.fromkeys(names.tolist()):
        own = np.flatnonzero(names == name)
        force = late["joint_force"].values[:, own]
        steps = late["joint_steps"].values[:, own].sum(axis=(0, 1), dtype=np.float64)
        shares = (steps / max(steps.sum(), 1.0)).tolist()
        found[name] = JointFigures(
            largest_normal_force=float(force[..., 0].max()),
            largest_tangential_force=float(np.hypot(force[..., 1], force[..., 2]).max()),
            share_open=shares[0],
            share_stuck=shares[1],
            share_slipping=shares[2],
            slip=float(last["joint_slip"].values[own].max()),
            work=float(last["joint_work"].values[own].sum()),
            wear_energy=float(last["joint_wear"].values[own].sum()),
        )
    return found


def joint_hints(dataset: xr.Dataset) -> list[str]:
    """Return hints about joints that do not touch or do not slip over the last third."""
    hints = []
    for name, own in joint_figures(dataset).items():
        gap = float(dataset["joint_gap"].values[dataset["joint_name"].values == name].max())
        if own["share_open"] == 1.0:
            width = f" with a gap of {handy(gap, 'm', 3)}" if gap > 0.0 else ""
            hints.append(f"joint {name} stays open{width}: a preload or an overclosure closes it")
        elif own["share_stuck"] == 1.0:
            hints.append(
                f"joint {name} sticks all the time and does not damp: its preload or friction is"
                " beyond that of the smallest amplitude"
            )
    return hints

"""Values of friction joints at the contact nodes that they join."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError
from bladewhirl.postprocess.fields.netcdf import has


class JointField(NamedTuple):
    """A field of joints."""

    name: str
    unit: str  #: "" for the number of a state


JOINT_FIELDS = {
    "joint-force": JointField("normal force of joints", "N"),
    "joint-slip": JointField("slip of joints since the start", "m"),
    "joint-state": JointField("state of joints", ""),
}
"""Fields of joints, as named in `choices.Field`."""


def at_joint_nodes(dataset: xr.Dataset, field: str, records: IntArray) -> Array:
    """Return the values of a field of joints at the contact nodes of both surfaces of each pair,
    the largest where a node has several, NaN at all other nodes, (record, contact_node).

    The state is the one of most steps since the last record: 0 open, 1 stuck, 2 slipping; NaN at
    the first record.

    Raises:
        ViewError: the run has no joints.
    """
    if not has(dataset, "joints"):
        raise ViewError(f'colour = "{field}": the run has no [[joint]]')
    chosen = dataset.isel(time=records)
    if field == "joint-force":
        values = chosen["joint_force"].values[..., 0]
    elif field == "joint-slip":
        values = chosen["joint_slip"].values
    else:
        steps = chosen["joint_steps"].values
        values = np.where(steps.any(axis=2), steps.argmax(axis=2), np.nan)
    nodes = np.full((dataset.sizes["contact_node"], len(records)), np.nan)
    for side in dataset["joint_end"].values.T:
        held = side >= 0  # the other surface of a damper is not a node
        np.fmax.at(nodes, side[held], values.T[held])
    return nodes.T

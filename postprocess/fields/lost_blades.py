"""Blades that are lost during a run: when they are gone, and what is gone with them."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import BoolArray
from bladewhirl.meshes.lost_part import BladedMesh
from bladewhirl.models.case.blade_loss import BladeLoss
from bladewhirl.models.case.file import optional_table_of
from bladewhirl.postprocess.fields.kinematics import Array, IntArray


@dataclass(frozen=True, kw_only=True)
class Lost:
    """Lost blades of a run."""

    time: float  #: time of the loss [s]
    blades: IntArray  #: numbers of the blades, (blades,)
    share: float  #: share of their length beyond which they are lost

    def gone(self, time: Array) -> BoolArray:
        """Return whether the blades are gone at times [s], in the shape of the times."""
        return np.asarray(time >= self.time)


class LostBeams(NamedTuple):
    """Nodes and beams that are lost."""

    nodes: IntArray  #: lost nodes, (nodes,)
    lines: IntArray  #: lost beams, (beams,)
    node_cuts: IntArray  #: node of the fracture that is nearest to each lost node, (nodes,)
    line_cuts: IntArray  #: that nearest to each lost beam, (beams,)


def lost_blades(dataset: xr.Dataset) -> Lost | None:
    """Return the blades that are lost in a run; None if there are none."""
    text = str(dataset.attrs.get("case", "")) if "time_step" in dataset.attrs else ""
    loss = optional_table_of(text, "blade_loss", BladeLoss, unread="damaged")
    if loss is None:
        return None
    blades, step = np.array(loss.blade), float(dataset.attrs["time_step"])
    time = (round(loss.time / step) - 0.5) * step
    return Lost(time=time, blades=blades, share=loss.share)


def lost_beams(dataset: xr.Dataset, loss: Lost) -> LostBeams:
    """Return the nodes and beams that are lost with the blades of a run."""
    lines, points = dataset["rotor_line"].values, dataset["rotor_point"].values
    pairs = [dataset[name].values for name in ("rotor_link", "rotor_spring") if name in dataset]
    joints = np.concatenate([lines, *(each[(each >= 0).all(axis=1)] for each in pairs)])
    mesh = BladedMesh(
        points=points,
        lines=lines,
        parts=dataset["rotor_part"].values.astype(str),
        joints=joints,
        tips=dataset["tip_node"].values,
        centre=int(dataset["centre_node"]),
    )
    lost = mesh.lost_with(loss.blades, loss.share)
    cuts = points[lost.cuts]

    def nearest(places: Array) -> IntArray:
        away = np.linalg.norm(places[:, None] - cuts, axis=-1)
        return np.asarray(lost.cuts[away.argmin(axis=1)])

    return LostBeams(
        nodes=lost.nodes,
        lines=lost.lines,
        node_cuts=nearest(points[lost.nodes]),
        line_cuts=nearest(points[lines[lost.lines]].mean(axis=1)),
    )


def masked(dataset: xr.Dataset, values: Array) -> Array:
    """Return values of contact nodes (time, contact_node, ...) with nan for lost blades."""
    lost = lost_blades(dataset)
    if lost is None:
        return values
    gone = lost.gone(dataset["time"].values)
    values = np.array(values, dtype=np.float64)
    values[np.ix_(gone, np.isin(dataset["blade"].values, lost.blades))] = np.nan
    return values

"""Which beams make a blade: found from the mesh, whatever its geometry."""

import numpy as np
import scipy.sparse as sp
import xarray as xr
from scipy.sparse.csgraph import dijkstra

from bladewhirl.postprocess.fields.fields import Array, IntArray


def line_blades(dataset: xr.Dataset) -> IntArray:
    """Number of the blade that each beam belongs to, -1 for none, (rotor_line,).

    A blade's beams are those of the part that its tip ends (where several parts meet at a tip, as
    under a shroud, the part of the beam that points most outward), reached from the tip through
    that part. Where one part joins several tips, a beam goes to the tip nearest along the beams.
    """
    lines, part = dataset["rotor_line"].values, dataset["rotor_part"].values.astype(str)
    tips, points = dataset["tip_node"].values, dataset["rotor_point"].values
    own = np.isin(part, np.unique([part[_outward_line(points, lines, tip)] for tip in tips]))
    length = np.linalg.norm(points[lines[:, 1]] - points[lines[:, 0]], axis=1)
    nodes = len(points)
    graph = sp.csr_array((length[own], (lines[own, 0], lines[own, 1])), shape=(nodes, nodes))
    distance, _, source = dijkstra(
        graph, directed=False, indices=tips, min_only=True, return_predecessors=True
    )
    blade_of_node = np.full(nodes, -1)
    reached = np.isfinite(distance)
    number = np.full(nodes, -1)
    number[tips] = np.arange(len(tips))
    blade_of_node[reached] = number[source[reached]]
    far = np.argmax(distance[lines], axis=1)  # half way between two tips either end will do
    blade: IntArray = np.where(own, blade_of_node[lines[np.arange(len(lines)), far]], -1)
    return blade


def member_names(dataset: xr.Dataset) -> tuple[list[str], IntArray]:
    """Names of what the rotor consists of, blade by blade and then part by part, and the number of
    the one that each beam belongs to (rotor_line,).
    """
    blade = line_blades(dataset)
    part = dataset["rotor_part"].values.astype(str)
    rest = list(dict.fromkeys(part[blade < 0]))  # in the order of the mesh
    names = [f"blade {number}" for number in range(dataset.sizes["blade"])]
    place = {name: len(names) + index for index, name in enumerate(rest)}
    member: IntArray = np.array(
        [number if number >= 0 else place[name] for number, name in zip(blade, part, strict=True)]
    )
    return [*names, *(name or "other beams" for name in rest)], member


def _outward_line(points: Array, lines: IntArray, tip: int) -> int:
    """The beam at a tip that points most along its radius."""
    at_tip = np.flatnonzero(np.any(lines == tip, axis=1))
    span = points[lines[at_tip, 1]] - points[lines[at_tip, 0]]
    along = np.abs(span @ points[tip]) / np.linalg.norm(span, axis=1)
    return int(at_tip[np.argmax(along)])

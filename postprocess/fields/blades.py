"""Beams of each blade, determined from a mesh of any geometry."""

import numpy as np
import scipy.sparse as sp
import xarray as xr
from scipy.sparse.csgraph import dijkstra

from bladewhirl.meshes.line_mesh import Chain, chain_to, outward_line
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.postprocess.fields.kinematics import IntArray, ViewError


def line_blades(dataset: xr.Dataset) -> IntArray:
    """Return the number of the blade that each beam belongs to, -1 for no blade, (rotor_line,).

    A blade consists of the beams that are connected to its tip by beams of the same part of the
    mesh. If several parts meet at a tip, as under a shroud, the blade is the part whose beam points
    most outward. If one part joins several tips, each of its beams belongs to the nearest tip, with
    distances measured along the beams.
    """
    lines, part = dataset["rotor_line"].values, dataset["rotor_part"].values.astype(str)
    tips, points = dataset["tip_node"].values, dataset["rotor_point"].values
    blades = np.isin(
        part, [part[line] for tip in tips for line in outward_line(points, lines, tip)]
    )
    length = np.linalg.norm(points[lines[:, 1]] - points[lines[:, 0]], axis=1)
    graph = sp.csr_array((length[blades], tuple(lines[blades].T)), shape=2 * (len(points),))
    distance, _, source = dijkstra(
        graph, directed=False, indices=tips, min_only=True, return_predecessors=True
    )
    number = np.full(len(points), -1)
    number[tips] = np.arange(len(tips))
    blade_of_node = np.full(len(points), -1)
    reached = np.isfinite(distance)
    blade_of_node[reached] = number[source[reached]]
    far = np.argmax(distance[lines], axis=1)  # the end of each beam that is farther from a tip
    return np.where(blades, blade_of_node[lines[np.arange(len(lines)), far]], -1)


def blade_chain(dataset: xr.Dataset, blade: int) -> Chain:
    """Return the beams of a blade.

    Raises:
        ViewError: the beams of the blade are not a chain that ends at the tip.
    """
    among = line_blades(dataset) == blade
    chain = chain_to(dataset["tip_node"].values[blade], dataset["rotor_line"].values, among)
    if not 0 < len(chain.lines) == np.count_nonzero(among):
        expected = f"beams of blade {blade} that form one chain from root to tip"
        raise ViewError(Fault(expected=expected))
    return chain


def member_names(dataset: xr.Dataset) -> tuple[list[str], IntArray]:
    """Return the names of the members of the rotor, and the number of the member that each beam
    belongs to (rotor_line,). The members are all blades, and then all other parts.
    """
    blade = line_blades(dataset)
    part = dataset["rotor_part"].values.astype(str)
    rest = list(dict.fromkeys(part[blade < 0]))  # in the order of the mesh
    names = [f"blade {number}" for number in range(dataset.sizes["contact_node"])]
    member = blade.copy()
    for number, name in enumerate(rest, len(names)):
        member[(blade < 0) & (part == name)] = number
    return [*names, *(name or "other beams" for name in rest)], member

"""Engine-order forces of unit amplitude on blades of beams and on those of a superelement.

The force on blade n at the angle theta_n is F cos(r (Omega t + theta_n) + phase). The direction of
the force turns with the blade. The force depends only on the static angle Omega t + theta_n: around
the circle it has r maxima, which are at rest in the static frame.
"""

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import Chain, FloatArray, IntArray, chain_to
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.elements.bladed_disk import (
    COMPONENTS,
    FIRST,
    ROTATION,
    SECOND,
    BladedDiskModel,
    nodal_to_line_axes,
)
from bladewhirl.models.inputs.errors import CaseError

BLADES = "blades"  #: name of the set of lines of the blades

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)
"""Gauss points and weights on -1 to 1, which integrate a uniform load on a beam exactly."""


def unit_forces(case: Case, disk: BladedDiskModel, load: EngineOrder) -> FloatArray:
    """Return the force of unit amplitude on each blade, on the free DoF, (blades, size).

    Raises:
        CaseError: the position of the forces does not exist on the blades.
    """
    model = disk.model
    if load.position == "tip":
        return _at_nodes(disk, model.tips, load)
    if isinstance(load.position, str):
        return _at_nodes(disk, _one_per_blade(case, disk, load), load)
    places = [(load.position, 1.0)] if isinstance(load.position, float) else []
    forces = np.zeros((len(model.tips), COMPONENTS * len(model.mesh.points)))
    lengths = model.mesh.lengths
    for blade, chain in enumerate(_blade_chains(case, disk, load)):
        if isinstance(load.position, tuple):
            places = _gauss_points(chain.ends(lengths), *load.position)
        for share, weight in places:
            number, xi = chain.place(share, lengths)
            nodes, values = _on_line(disk, int(chain.lines[number]), xi, load)
            np.add.at(forces[blade].reshape(-1, COMPONENTS), nodes, weight * values)
    return np.asarray(forces @ disk.expansion)


def _blade_chains(case: Case, disk: BladedDiskModel, load: EngineOrder) -> list[Chain]:
    """Return the lines of each blade.

    Raises:
        CaseError: the blades are not chains of lines.
    """
    mesh = disk.mesh
    among = np.zeros(len(mesh.lines), dtype=np.bool_)
    among[mesh.line_sets.get(BLADES, [])] = True
    chains = [chain_to(tip, mesh.lines, among) for tip in disk.model.tips.tolist()]
    if any(np.count_nonzero(mesh.lines[among] == chain.root) != 1 for chain in chains):
        expected = f'"tip" or a node set: the lines of "{BLADES}" do not form one chain per blade'
        raise CaseError([case_fault(case, f"{case.key_of(load)}.position", expected)])
    return chains


def _one_per_blade(case: Case, disk: BladedDiskModel, load: EngineOrder) -> IntArray:
    """Return for each blade a node of the set that the load names: the nearest in angle to the
    tip."""
    name, blades = str(load.position), len(disk.model.tips)
    nodes = disk.mesh.node_sets.get(name)
    if nodes is None or len(nodes) != blades:
        has = f"{len(nodes)} nodes" if nodes is not None else "no nodes"
        sets = ", ".join(sorted(disk.mesh.node_sets))
        expected = (
            f"a node set with one node on each of the {blades} blades; {name} has {has}"
            f" (sets: {sets})"
        )
        raise CaseError([case_fault(case, f"{case.key_of(load)}.position", expected)])
    x, y = disk.mesh.points[nodes].T
    apart = np.exp(1j * np.arctan2(y, x)) * np.exp(-1j * disk.tip_angles)[:, None]
    nearest = np.abs(np.angle(apart)).argmin(axis=1)
    return np.asarray(nodes[nearest])


def _along(load: EngineOrder, axis: FloatArray, polar: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the components of unit forces along the first and the second axis of each point.

    Args:
        load: the forces, whose direction is used.
        axis: angle of the first axis from +x [rad], (points,).
        polar: polar angle of the points [rad], (points,).
    """
    turned = polar + load.inclination - axis
    return np.cos(turned), np.sin(turned)


def _at_nodes(disk: BladedDiskModel, nodes: IntArray, load: EngineOrder) -> FloatArray:
    mesh = disk.mesh
    x, y = mesh.points[nodes].T
    first, second = _along(load, mesh.node_axes[nodes], np.arctan2(y, x))
    forces = np.zeros((len(nodes), len(mesh.points), COMPONENTS))
    each = np.arange(len(nodes))
    forces[each, nodes, FIRST], forces[each, nodes, SECOND] = first, second
    return np.asarray(forces.reshape(len(nodes), -1) @ disk.expansion)


def _on_line(
    disk: BladedDiskModel, line: int, xi: float, load: EngineOrder
) -> tuple[IntArray, FloatArray]:
    """Return the end nodes of a line, and the forces on them (2, 3) by the shape functions of a
    Bernoulli beam, for a unit force at the position xi, 0 to 1, along the line."""
    mesh = disk.mesh
    ends, length = mesh.lines[line], float(mesh.lengths[line])
    x, y = (1.0 - xi) * mesh.points[ends[0]] + xi * mesh.points[ends[1]]
    axial, lateral = _along(load, mesh.line_axes[line], np.arctan2(y, x))
    rest = 1.0 - xi
    in_line = np.zeros(2 * COMPONENTS)
    in_line[[FIRST, COMPONENTS + FIRST]] = axial * rest, axial * xi
    in_line[[SECOND, COMPONENTS + SECOND]] = (
        lateral * rest**2 * (1.0 + 2.0 * xi),
        lateral * xi**2 * (3.0 - 2.0 * xi),
    )
    in_line[[ROTATION, COMPONENTS + ROTATION]] = (
        lateral * length * xi * rest**2,
        -lateral * length * xi**2 * rest,
    )
    return ends, (in_line @ nodal_to_line_axes(mesh)[line]).reshape(2, COMPONENTS)


def _gauss_points(ends: FloatArray, first: float, last: float) -> list[tuple[float, float]]:
    """Return shares of the length and weights [m] that integrate along a part of a blade.

    Args:
        ends: distance of the ends of the lines from the root [m], (lines + 1,).
        first: share of the length at which the part begins.
        last: share of the length at which the part ends.
    """
    whole = ends[-1]
    cuts = np.unique(np.clip(ends, first * whole, last * whole))
    middle, half = 0.5 * (cuts[1:] + cuts[:-1]), 0.5 * np.diff(cuts)
    places = (middle[:, None] + half[:, None] * POINTS).ravel() / whole
    weights = (half[:, None] * WEIGHTS).ravel()
    return list(zip(places.tolist(), weights.tolist(), strict=True))


def mean_along(
    load: EngineOrder, blade: IntArray, angle: FloatArray, number: IntArray, count: int
) -> sp.csr_array:
    """Return the mean displacement of the places of each blade of a copy along the direction of a
    load, as rows on the displacements of nodes or points, (blades, 3 * count).

    Args:
        load: the excitation.
        blade: blade of each place, (places,).
        angle: angle of the radial direction of each place in the axes of the displacements [rad],
            (places,).
        number: number of the node or the point at each place, (places,).
        count: number of nodes or points.
    """
    direction = [np.cos(load.inclination), np.sin(load.inclination), 0.0]
    shares = rotate(direction, angle) / np.bincount(blade)[blade][:, None]
    places = np.repeat(blade, 3), (3 * number[:, None] + np.arange(3)).ravel()
    return sp.csr_array((shares.ravel(), places), shape=(int(blade.max()) + 1, 3 * count))

"""A shaft line and its wheels of solids as one structure in rotating axes.

The displacements of the hub of a wheel are those of its node of the shaft, so that the structure
has the coordinates of the wheels without their hubs, and then six of each node of the shaft: the
displacements along x, y and z and the rotations about x, y and z. Bearings are left out. In a plane
of the shaft, with the matrices of `line` for its deflections and slopes,

    Coriolis forces 2 M - P between the planes,      change of the stiffness P - M

for 1 rad/s, as in `reduced`. Along and about its axis the shaft consists of rods, which the
rotation does not change.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.shaft_line.axial import held_along, rods
from bladewhirl.models.shaft_line.line import LineModel
from bladewhirl.models.shaft_line.wheel import WheelOnLine
from bladewhirl.models.superelements.hub import (
    check_hub,
    hub_freed,
    hub_of,
    inner_dofs,
    rigid_motions,
)
from bladewhirl.models.superelements.reduction import root_at_rest
from bladewhirl.models.superelements.superelement import FIXED, HUB, Superelement
from bladewhirl.models.superelements.wheel import whole_wheel

X, Y, Z, ABOUT_X, ABOUT_Y, ABOUT_Z = range(HUB)

SMALL = 800  #: number of coordinates up to which all modes of a wheel are computed for its damping

FREE = {"two": (X, Y), "four": (X, Y, ABOUT_X, ABOUT_Y), "six": tuple(range(HUB))}
"""Displacements of a hub that follow the shaft, by `Wheel.unknowns`."""


@dataclass(frozen=True, kw_only=True, repr=False)
class LineRotor(Superelement):
    """A shaft line with its wheels in rotating axes, without bearings. Its contact nodes are those
    of the first wheel, then those of further wheels with a wall, whose positions are in the axes of
    the first; its points and its centre are those of the first wheel."""

    wheel_nodes: tuple[int, ...]  #: number of contact nodes of each wheel that has a wall
    line_rows: sp.csr_array  #: the six displacements of each node of the shaft, (6 * nodes, n)
    weight_rows: FloatArray
    """Mass matrix times uniform displacements along x and along y [kg], (2, n)."""


class Damped(NamedTuple):
    """Modal damping of a wheel with a fixed hub."""

    wheel: Superelement
    relative: sp.csr_array
    """Displacements of the coordinates of the wheel without its hub, relative to the rigid motion
    with the hub, as rows on the coordinates of the rotor."""
    ratio: float  #: damping ratio


class OnLine(NamedTuple):
    """The rotor of a line, and what is needed to reduce it."""

    rotor: LineRotor
    damped: tuple[Damped, ...]
    forces: FloatArray
    """Forces of unit size by bearings, unbalances and at the hubs of wheels that touch a wall on
    the coordinates, (n, forces)."""
    rigid: FloatArray | None
    """Rigid motions of a rotor of equal blades: along x and y, and tilts towards x and y about the
    start of the shaft, the latter if all wheels tilt, (n, 2 or 4)."""

    @property
    def damping(self) -> Callable[[FloatArray], FloatArray] | None:
        """Function from shapes (n, m) to the modal damping of all wheels on them [1/s], (m, m);
        None without damping."""
        if not self.damped:
            return None
        roots = [(root_at_rest(one.wheel, SMALL), one) for one in self.damped]

        def on(shapes: FloatArray) -> FloatArray:
            each = (2.0 * one.ratio * root(one.relative @ shapes) for root, one in roots)
            return np.asarray(sum(each))

        return on


def wheel_with_hub(part: Superelement, sectors: int) -> Superelement:
    """Return a wheel with its hub from the superelement of a file, which may be a sector."""
    if part.left_dofs is None:
        return replace(part, blade_stiffness=None)
    assert part.right_dofs is not None
    hub, position = hub_of(part), part.hub_position
    kept = np.setdiff1d(np.arange(part.size), part.right_dofs)
    free = replace(part, hub_dofs=None, hub_position=None, blade_stiffness=None)
    loose = whole_wheel(free, sectors)
    own = np.searchsorted(kept, hub) + len(kept) * np.arange(sectors)[:, None]
    others = np.setdiff1d(np.arange(loose.size), own)
    angle = 2.0 * np.pi / sectors * np.arange(sectors)
    turned = np.zeros((sectors, HUB, HUB))  # the hub in the axes of each sector
    for first in (X, ABOUT_X):
        turned[:, first, first] = turned[:, first + 1, first + 1] = np.cos(angle)
        turned[:, first, first + 1] = np.sin(angle)
        turned[:, first + 1, first] = -np.sin(angle)
        turned[:, first + 2, first + 2] = 1.0
    every = sp.csr_array(sp.eye_array(loose.size))
    basis = sp.csr_array(
        sp.hstack([every[:, others], every[:, own.ravel()] @ turned.reshape(-1, HUB)])
    )
    place = np.full(loose.size + 1, FIXED)  # the last entry is that of a fixed component
    place[others] = np.arange(len(others))
    return replace(
        loose,
        **loose.projected(basis),
        contact_dofs=place[loose.contact_dofs],
        hub_dofs=len(others) + np.arange(HUB),
        hub_position=position,
        sectors=None,
    )


def line_rotor(line: LineModel, wheels: Sequence[Superelement]) -> OnLine:
    """Return the rotor of a line.

    Args:
        line: the shaft line.
        wheels: wheels with hubs in the order of `line.wheels`.

    Raises:
        SuperelementError: a hub does not hold its wheel, or its matrices are not those of a rigid
            body on its motions.
    """
    nodes, tables = len(line.position), line.table.every_wheel
    shaft, along = _shaft(line), any(one.unknowns == "six" for one in tables)
    held = [HUB * (row % nodes) + (ABOUT_Z if row >= nodes else Z) for row in held_along(line)]
    if not along:
        held = [HUB * node + way for node in range(nodes) for way in (Z, ABOUT_Z)]
    free = np.setdiff1d(np.arange(HUB * nodes), held)
    inner = [wheel.size - HUB for wheel in wheels]
    starts = np.concatenate([[0], np.cumsum(inner)])
    size = int(starts[-1]) + len(free)
    number = np.full(HUB * nodes, FIXED)
    number[free] = starts[-1] + np.arange(len(free))
    on_shaft = sp.csr_array((np.ones(len(free)), (free, number[free])), shape=(HUB * nodes, size))
    bases = wheel_bases(line, wheels, on_shaft)
    forms = {name: on_shaft.T @ (form @ on_shaft) for name, form in shaft.forms.items()}
    loads = {name: on_shaft.T @ load for name, load in shaft.loads.items()}
    held_upright = any(one.unknowns == "two" for one in tables)
    rigid = on_shaft.T @ (shaft.rigid[:, :2] if held_upright else shaft.rigid)
    weight = np.array([on_shaft.T @ (shaft.forms["mass"] @ way) for way in shaft.rigid.T[:2]])
    damped = list[Damped]()
    for start, wheel, basis, table in zip(starts, wheels, bases, tables, strict=False):
        motions, own = rigid_motions(wheel), inner_dofs(wheel)
        check_hub(wheel, motions)
        rigid[start : start + len(own)] = motions[own] @ (basis[hub_of(wheel)] @ rigid)
        for name, form in wheel.projected(basis, wheel.FORMS).items():
            forms[name] = forms[name] + form if name in forms else form
        for name, load in wheel.projected(basis, wheel.LOADS).items():
            loads[name] = loads[name] + load if name in loads else load
        weight += np.asarray((wheel.mass @ motions[:, :2]).T @ basis)
        if table.damping_ratio:
            of_hub = basis[hub_of(wheel)]
            relative = basis[own] - sp.csr_array(motions[own]) @ of_hub
            damped.append(Damped(hub_freed(wheel), sp.csr_array(relative), table.damping_ratio))
    first, basis = wheels[0], bases[0]
    hub_node, positions, dofs = HUB * line.wheels[0].node, list[FloatArray](), list[IntArray]()
    for start, wheel, table, place in zip(starts, wheels, tables, line.wheels, strict=False):
        if wheel is not first and getattr(table, "casing", None) is None:
            continue
        number_of = np.append(np.arange(wheel.size), FIXED)
        number_of[inner_dofs(wheel)] = start + np.arange(wheel.size - HUB)
        dofs.append(number_of[wheel.contact_dofs])
        ahead = wheel_start(line, place, wheel) - wheel_start(line, line.wheels[0], first)
        positions.append(wheel.contact_position + np.array([0.0, 0.0, ahead]))
    rotor = LineRotor(
        **{each.name: getattr(first, each.name) for each in fields(Superelement)}
        | {name: form for name, form in forms.items()}
        | loads
        | first.projected(basis, Superelement.ROWS)
        | {
            "contact_position": np.concatenate(positions),
            "contact_dofs": np.concatenate(dofs),
            "centre_dofs": number[[hub_node + X, hub_node + Y]],
            "hub_dofs": None,
            "hub_position": None,
        },
        line_rows=on_shaft,
        weight_rows=weight,
        wheel_nodes=tuple(map(len, dofs)),
    )
    return OnLine(rotor, tuple(damped), _forces(line, number, size), rigid)


def wheel_bases(
    line: LineModel, wheels: Sequence[Superelement], line_rows: sp.csr_array
) -> list[sp.csr_array]:
    """Return the coordinates of each wheel as rows on those of the rotor, (n of the wheel, n).

    Args:
        line: the shaft line.
        wheels: wheels with hubs in the order of `line.wheels`.
        line_rows: see `LineRotor`.
    """
    displacements, size = line_rows.shape
    starts = np.cumsum([0, *(wheel.size - HUB for wheel in wheels)]).tolist()
    bases, tables = list[sp.csr_array](), line.table.every_wheel
    for start, wheel, table, place in zip(starts, wheels, tables, line.wheels, strict=False):
        hub = np.zeros((HUB, displacements))
        ways = np.array(FREE[table.unknowns])
        hub[ways, HUB * place.node + ways] = 1.0
        bases.append(_basis(wheel, start, size, sp.csr_array(hub) @ line_rows))
    return bases


def wheel_start(line: LineModel, place: WheelOnLine, wheel: Superelement) -> float:
    """Return the position along the line at which the file of a wheel begins to count z [m]."""
    assert wheel.hub_position is not None
    return float(line.position[place.node] - wheel.hub_position[2])


def linearised(rotor: LineRotor, omega: float) -> LineRotor:
    """Return a rotor whose stiffness changes with the square of the speed only, as near a speed
    [rad/s]: the energy and the momentum of a free speed need such a rotor."""
    if rotor.stiffness_speed4 is None:
        return rotor
    slope = rotor.slope(omega)
    stiffness = rotor.stiffness_at(omega) - omega**2 * slope
    return replace(rotor, stiffness=stiffness, stiffness_speed=slope, stiffness_speed4=None)


class _Shaft(NamedTuple):
    forms: dict[str, Any]
    loads: dict[str, FloatArray]
    rigid: FloatArray  #: rigid motions along x and y, and tilts towards x and y, (6 * nodes, 4)


def _shaft(line: LineModel) -> _Shaft:
    """Return the matrices of the shaft and its disks on all displacements of its nodes."""
    nodes, table = len(line.position), line.table
    in_x, in_y, axial = (np.zeros((2 * nodes, HUB * nodes)) for _ in range(3))
    node = np.arange(nodes)
    in_x[2 * node, HUB * node + X] = in_x[2 * node + 1, HUB * node + ABOUT_Y] = 1.0
    in_y[2 * node, HUB * node + Y] = 1.0
    in_y[2 * node + 1, HUB * node + ABOUT_X] = -1.0
    axial[node, HUB * node + Z] = axial[nodes + node, HUB * node + ABOUT_Z] = 1.0
    rows = 2 * nodes
    mass, polar = line.bare_mass, line.polar[:rows, :rows]
    bending, (rod_mass, rod_stiffness) = line.shaft_stiffness[:rows, :rows], rods(line)

    def both(form: FloatArray) -> FloatArray:
        return in_x.T @ form @ in_x + in_y.T @ form @ in_y

    elastic = both(bending) + axial.T @ rod_stiffness @ axial
    across = in_y.T @ (2.0 * mass - polar) @ in_x
    forms = {
        "mass": both(mass) + axial.T @ rod_mass @ axial,
        "stiffness": elastic,
        "gyroscopic": across - across.T,
        "stiffness_speed": both(polar - mass),
    }
    if table.loss_time:
        forms["damping"] = table.loss_time * elastic
    if table.axial is not None:
        spring = HUB * line.node(table.axial.position) + Z
        forms["stiffness"] = elastic.copy()
        forms["stiffness"][spring, spring] += table.axial.stiffness
    turned = np.zeros(2 * nodes)
    turned[nodes:] = 1.0
    plane = np.zeros((2 * nodes, 2))  # deflections and slopes of the rigid motions in a plane
    plane[0::2] = np.stack([np.ones(nodes), line.position - line.position[0]], axis=1)
    plane[1::2, 1] = 1.0
    return _Shaft(
        forms={name: sp.csr_array(form) for name, form in forms.items()},
        loads={
            "centrifugal_load": np.zeros(HUB * nodes),
            "euler_load": -axial.T @ (rod_mass @ turned),
        },
        rigid=np.hstack([in_x.T @ plane, in_y.T @ plane])[:, [0, 2, 1, 3]],
    )


def _basis(wheel: Superelement, start: int, size: int, hub: Any) -> sp.csr_array:
    """Return the coordinates of a wheel as rows on those of the rotor, (n, size): those without the
    hub follow a number, those of the hub are given rows, (6, size)."""
    own = inner_dofs(wheel)
    entries = np.ones(len(own)), (own, start + np.arange(len(own)))
    basis = sp.csr_array(entries, shape=(wheel.size, size))
    every = sp.csr_array(sp.eye_array(wheel.size))
    return sp.csr_array(basis + every[:, hub_of(wheel)] @ hub)


def _forces(line: LineModel, number: IntArray, size: int) -> FloatArray:
    """Return unit forces and moments across the axis by bearings and unbalances where they act, and
    on the hubs of wheels that touch a wall, whose static displacements under contact forces are
    then exact."""
    places = dict[int, None]()
    for hub in (line.table.every_wheel[0], *line.table.walls.values()):
        places |= _across(line, hub.position, hub.unknowns != "two")
    for bearing in line.table.bearings:
        places |= _across(line, bearing.position, bool(np.any(bearing.tilt_stiffness)))
    for unbalance in line.table.unbalance:
        places |= _across(line, unbalance.position, bool(unbalance.couple))
    rows = number[list(places)]
    forces = np.zeros((size, len(rows)))
    forces[rows, np.arange(len(rows))] = 1.0
    return forces


def _across(line: LineModel, position: float, tilts: bool) -> dict[int, None]:
    """Return the numbers of the displacements across the axis at a position [m], and, if forces
    tilt the shaft there, of the rotations."""
    first = HUB * line.node(position)
    return dict.fromkeys(first + way for way in [X, Y] + [ABOUT_X, ABOUT_Y] * tilts)

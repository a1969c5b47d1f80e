"""Loss of blades of a wheel on a shaft line.

What remains has matrices of its own, with its own tension and reaction of the bore, and is reduced
as the whole rotor is. The coordinates of its modes V' follow at the loss from those q of the modes
V of the whole rotor as (V'^T M' V')^-1 V'^T M' V q. Displacements count from the steady state u of
the whole rotor at the speed b of the stage, in which what remains feels the force

    b^2 F' - K'(b) u + (Omega^2 - b^2) (F' - K1' u) - (Omega^4 - b^4) K2' u + Omega' (E' - G' u / 2)

with the symbols of `structure.rotating`: the pull of the lost blades and its moment with the
opposite sign. Its static displacement is among the modes V'.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.shaft_line.line import LineModel
from bladewhirl.models.shaft_line.rotor import OnLine, line_rotor
from bladewhirl.models.superelements.hub import hub_of, inner_dofs, remaining_dofs, rigid_motions
from bladewhirl.models.superelements.reduction import ReducedSuperelement, modes_and_static
from bladewhirl.models.superelements.superelement import (
    FIXED,
    HUB,
    Superelement,
    SuperelementError,
    dense,
)

ROUNDING = 1e-6  #: relative difference of equal entries of matrices from two meshes

FEW = 8  #: number of modes that are computed with the steady state


@dataclass(frozen=True, kw_only=True)
class DamagedRotor:
    """What remains of a rotor after the loss of blades."""

    on_line: OnLine  #: the rotor at rest; lost contact nodes have no coordinates
    kept: IntArray  #: numbers of its coordinates among those of the whole rotor, (n,)
    lost: BoolArray  #: which contact nodes are lost, (nodes,)
    steady: FloatArray  #: steady state of the whole rotor at the speed on its coordinates [m], (n,)
    inertia: float
    """Moment of inertia of the wheel about the axis with that of the steady state [kg m2]."""

    def release(self, omega: float) -> dict[str, FloatArray]:
        """Return the forces that it feels in the steady state of the whole rotor, (n,): "constant"
        that at a speed [rad/s], others by the names of their factors, see `Load`."""
        u = self.steady
        rotor: Any = self.on_line.rotor
        found = {
            "constant": omega**2 * rotor.centrifugal_load - rotor.stiffness_at(omega) @ u,
            "by_square": rotor.centrifugal_load - rotor.stiffness_speed @ u,
            "by_acceleration": rotor.euler_load - rotor.coriolis @ u,
        }
        if rotor.stiffness_speed4 is not None:
            found["by_fourth"] = -rotor.stiffness_speed4 @ u
        return {name: np.asarray(force) for name, force in found.items()}

    def with_lost_nodes(
        self, reduced: ReducedSuperelement, whole: ReducedSuperelement
    ) -> ReducedSuperelement:
        """Return a reduction of it that also has the lost contact nodes, which do not move with the
        modes and have the flexibility that they had in the whole rotor."""
        rows = np.repeat(~self.lost, 3)
        contact = np.zeros((len(rows), reduced.size))
        contact[rows] = reduced.contact
        compliance = np.where(rows[:, None] | rows, 0.0, whole.compliance)
        compliance[np.ix_(rows, rows)] = reduced.compliance
        return replace(reduced, contact=contact, compliance=compliance, stress=None)


def damaged_rotor(
    line: LineModel,
    whole: OnLine,
    wheels: tuple[Superelement, ...],
    damaged: Superelement,
    sectors: int,
    omega: float,
    prepared: Callable[[OnLine], OnLine],
) -> DamagedRotor:
    """Return what remains of a rotor whose first wheel loses blades.

    Args:
        line: the shaft line.
        whole: its whole rotor.
        wheels: its wheels.
        damaged: superelement of the first wheel after the loss, on the coordinates of the whole.
        sectors: number of sectors of which the first wheel was assembled; 1 for a wheel in one
            piece.
        omega: speed of the stage [rad/s].
        prepared: function by which the rotor at rest was changed.

    Raises:
        SuperelementError: the damaged wheel does not have the coordinates and the hub of the whole
            one, or lacks matrices.
    """
    first, *others = wheels
    if damaged.size != first.size or not np.array_equal(hub_of(damaged), hub_of(first)):
        expected = (
            f"the {first.size} coordinates of the whole wheel with its hub_dofs, got {damaged.size}"
        )
        raise SuperelementError(Fault(expected=expected))
    if sectors > 1:
        damaged = in_sector_axes(damaged, first, sectors)
    for name in ("mass", "stiffness"):  # what is lost only takes from them
        own, left = (getattr(part, name).diagonal() for part in (first, damaged))
        if (left > (1.0 + ROUNDING) * own).any():
            expected = f"the coordinates of the whole wheel in their order: some {name} is larger"
            raise SuperelementError(Fault(expected=expected))
    needed = ("gyroscopic", "stiffness_speed", *first.LOADS)
    if missing := [name for name in needed if getattr(damaged, name) is None]:
        raise SuperelementError(Fault(expected=f"{' and '.join(missing)} of the damaged wheel"))
    remaining = np.union1d(remaining_dofs(damaged), hub_of(damaged))
    number = np.full(first.size + 1, FIXED)  # the last entry is that of a fixed component
    number[remaining] = np.arange(len(remaining))
    select = sp.csr_array(sp.eye_array(first.size))[:, remaining]
    matrices = {name: getattr(damaged, name) for name in (*first.FORMS, *first.LOADS)}
    rest = replace(first, **matrices | {"blade_stiffness": None})
    rest = replace(
        rest,
        **rest.projected(select),
        contact_dofs=number[first.contact_dofs],
        hub_dofs=number[hub_of(first)],
    )
    lost = np.zeros(whole.rotor.contacts, dtype=bool)  # none of further wheels
    lost[: first.contacts] = np.all(rest.contact_dofs == FIXED, axis=1)
    lost[: first.contacts] &= np.any(first.contact_dofs != FIXED, axis=1)
    inner = np.searchsorted(inner_dofs(first), np.setdiff1d(remaining, hub_of(first)))
    kept = np.concatenate([inner, np.arange(first.size - HUB, whole.rotor.size)])
    damaged_line = line_rotor(line, [rest, *others])._replace(rigid=None)
    on_line, u = prepared(damaged_line), _steady(whole, omega)[kept]
    rotor: Any = on_line.rotor
    turned = rigid_motions(rest)[:, -1]
    grown = (2.0 * rotor.centrifugal_load - rotor.stiffness_speed @ u) @ u
    return DamagedRotor(
        on_line=on_line,
        kept=kept,
        lost=lost,
        steady=u,
        inertia=float(turned @ (rest.mass @ turned) + grown),
    )


def in_sector_axes(damaged: Superelement, first: Superelement, sectors: int) -> Superelement:
    """Return a wheel on the coordinates of one that was assembled of sectors: except at contact
    nodes and hub, displacements of a node are in the axes of its sector, see `whole_wheel`."""
    inner = damaged.size - HUB
    node = np.setdiff1d(np.arange(inner), first.contact_dofs)
    if inner % sectors or len(node) % 3:
        expected = "displacements along x, y and z of each node, sector by sector, and of the hub"
        raise SuperelementError(Fault(expected=expected))
    x, y, _ = node.reshape(-1, 3).T
    angle = 2.0 * np.pi / sectors * (x // (inner // sectors))
    turn = sp.lil_array(sp.eye_array(damaged.size))
    turn[x, x] = turn[y, y] = np.cos(angle)
    turn[y, x], turn[x, y] = np.sin(angle), -np.sin(angle)
    return replace(damaged, **damaged.projected(sp.csr_array(turn), (*first.FORMS, *first.LOADS)))


def _steady(whole: OnLine, omega: float) -> FloatArray:
    """Return the steady state at a speed [rad/s], (n,)."""
    part = whole.rotor.at(omega)
    assert part.centrifugal_load is not None
    load = omega**2 * part.centrifugal_load[:, None]
    if not load.any():
        return np.zeros(part.size)
    own, lowest, moved = modes_and_static(part, min(FEW, part.size - 1), load)
    return np.asarray((moved + lowest @ (lowest.T @ load / own[:, None]))[:, 0])


def changes_of_coordinates(
    mass: Any, before: FloatArray, after: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the modal coordinates after the loss for unit ones before, and the reverse.

    Args:
        mass: mass matrix of what remains [kg], (n, n).
        before: modes of the whole rotor at what remains, (n, modes).
        after: modes of what remains, (n, modes after).
    """
    cross, own = after.T @ (mass @ before), dense(after.T @ (mass @ after))
    inertia = before.T @ (mass @ before)
    return np.linalg.solve(own, cross), np.linalg.pinv(inertia, rcond=1e-10) @ cross.T

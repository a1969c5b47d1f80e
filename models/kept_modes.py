"""The modes that a march of a stage has, and the springs that couple them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.case import Case
from bladewhirl.models.case_file import case_fault
from bladewhirl.models.contact_problem import ReducedCasing, ReducedRotor
from bladewhirl.models.faults import CaseError
from bladewhirl.models.mode_choice import NamedModes, chosen_modes
from bladewhirl.models.stage_coupling import CoupledEntries, RadialModes, coupled_entries

Labels = tuple[IntArray, tuple[str, ...]]
"""Nodal diameter and family of each mode of a body."""


@dataclass(frozen=True, kw_only=True)
class KeptModes:
    """Modes that a march has, by their numbers among all modes of a stage, ascending."""

    rotor: IntArray  #: (rotor modes kept,)
    casing: IntArray  #: (casing modes kept,)
    coupled: CoupledEntries | None
    """All modes of the stage that springs could couple; None without cyclic symmetry."""


def kept_modes(
    case: Case,
    rotor: tuple[ReducedRotor, IntArray, tuple[str, ...]],
    casing: tuple[ReducedCasing, IntArray, tuple[str, ...]],
) -> KeptModes:
    """Find the modes that `reduction.modes` asks for.

    Args:
        case: the case.
        rotor: the bladed disk in all its modes, their nodal diameters and families.
        casing: the same for the casing.

    Raises:
        CaseError: the stage does not have them.
    """
    coupled = _coupled(rotor, casing)
    radial: dict[int, IntArray] = {}
    if coupled is not None:
        for entry in np.flatnonzero(coupled.modes.on_casing):
            first, paired = coupled.number[entry], bool(coupled.modes.paired[entry])
            radial[int(coupled.modes.nodal_diameter[entry])] = first + np.arange(1 + paired)
    named = [NamedModes(nodal_diameter=k, family=family) for _, k, family in (rotor, casing)]
    try:
        on_rotor, on_casing = chosen_modes(case.reduction.modes, named[0], named[1], radial)
    except ValueError as error:
        raise CaseError(
            [case_fault(case, "reduction.modes", f"modes of the stage ({error})")]
        ) from None
    return KeptModes(rotor=on_rotor, casing=on_casing, coupled=coupled)


def _coupled(
    rotor: tuple[ReducedRotor, IntArray, tuple[str, ...]],
    casing: tuple[ReducedCasing, IntArray, tuple[str, ...]],
) -> CoupledEntries | None:
    disk, disk_diameter, disk_family = rotor
    wall, wall_diameter, wall_family = casing
    if disk.column.min(initial=0) < 0 or wall.column.min(initial=0) < 0:
        return None
    return coupled_entries(
        RadialModes(
            frequency=disk.frequency,
            nodal_diameter=disk_diameter,
            column=disk.column,
            family=disk_family,
            angles=disk.tip_angle - disk.tip_angle[0],
            radial=lambda numbers: disk.tip_radial[:, numbers],
        ),
        RadialModes(
            frequency=wall.frequency,
            nodal_diameter=wall_diameter,
            column=wall.column,
            family=wall_family,
            angles=2.0 * np.pi * np.arange(len(wall.nodal)) / len(wall.nodal),
            radial=lambda numbers: wall.nodal[:, 0, numbers],
        ),
        damping_ratio=float(disk.damping_ratio.max(initial=0.0)),
    )

"""The structure of a superelement in its case, and what is kept of it for many speeds.

Points of a sweep share what does not depend on the speed: superelements that are condensed for a
range of speeds, and the modes at rest of the damping.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import faults_at
from bladewhirl.models.case.shaft import Rotation
from bladewhirl.models.case.superelement import SOURCE
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.superelements.condensed import condensed
from bladewhirl.models.superelements.joined import range_of
from bladewhirl.models.superelements.kept_reduction import (
    Arrays,
    arrays_of,
    kept_reduction,
    restored,
)
from bladewhirl.models.superelements.mistuned import mistuned_wheel
from bladewhirl.models.superelements.nodal_blocks import Blocks, NodalBlock, sector_blocks
from bladewhirl.models.superelements.reduction import (
    ReducedSuperelement,
    Root,
    root_at_rest,
)
from bladewhirl.models.superelements.superelement import (
    FIXED,
    IndefiniteError,
    Superelement,
    SuperelementError,
)
from bladewhirl.models.superelements.wheel import WheelOverSpeeds, whole_wheel

LARGE = 2000
"""Number of coordinates from which a blade or a wheel is condensed for a range of speeds."""

FEWEST = 4  #: number of modes of each nodal diameter that are computed first

REMEMBERED = 4  #: number of the last structures of which results are kept in memory

Kept = TypeVar("Kept")


def assembled(case: Case, part: Superelement) -> Superelement:
    """Return a superelement on the springs of the shaft; a sector as a wheel."""
    table = case.bladed_disk.matrices
    if part.centre_dofs is not None:
        part = on_springs(case, part)
    if table.kind != "sector":
        return part
    part, mistuning = whole_wheel(part, table.copies), case.bladed_disk.mistuning
    if not mistuning.is_given(table.copies):
        return part
    return mistuned_wheel(part, mistuning.factors("stiffness", table.copies))


class Listed(NamedTuple):
    """Modes of sectors that are listed, for which no other motions are needed."""

    speed: float  #: speed at which they are listed, besides those at rest [rad/s]
    coupled: int  #: see `WheelOverSpeeds`


def structure_of(case: Case) -> Superelement:
    """Return the superelement of a case; a wheel has the stiffness of its mistuned blades.

    Raises:
        CaseError: the file does not give the stiffness of each blade.
    """
    table = case.bladed_disk.matrices
    part = table.part
    if table.kind == "sector" or part.blade_stiffness is None:
        return part
    mistuning = case.bladed_disk.mistuning
    if table.kind == "blade" or not mistuning.is_given(table.copies):
        return replace(part, blade_stiffness=None)
    try:
        return mistuned_wheel(part, mistuning.factors("stiffness", table.copies))
    except SuperelementError as error:
        raise CaseError(faults_at(case, f"{SOURCE}.file", error)) from None


_small: dict[str, Superelement] = {}
_roots: dict[str, Root] = {}
"""Condensed superelements and damping at rest of the last cases, by all they depend on."""


def remembered(kept: dict[str, Kept], key: str, compute: Callable[[], Kept]) -> Kept:
    """Return what is kept under a key, computed if it is not; the oldest of `REMEMBERED` goes."""
    if key not in kept:
        made = compute()
        while len(kept) >= REMEMBERED:
            del kept[next(iter(kept))]
        kept[key] = made
    return kept[key]


def over_speeds(case: Case, part: Superelement, omega: float, least: int = LARGE) -> Superelement:
    """Return a blade or wheel of at least so many coordinates condensed for the `range_of` a speed
    [rad/s]; other superelements as they are."""
    table, modes = case.bladed_disk.matrices, case.reduction.free_interface_modes
    massless_ends = case.reduction.boundary == "massless"
    if part.size < least or table.kind == "sector" or not massless_ends or omega == 0.0:
        return part
    highest = range_of(omega)
    key = f"{structure_key(case)} {highest}"
    return remembered(_small, key, lambda: _condensed(case, part, highest, modes))


def damping_root(case: Case, at_rest: Superelement, omega: float) -> Root | None:
    """Return the function from shapes to `ReducedSuperelement.root`; None if the damping is not
    that of the structure at rest.

    Args:
        case: the case.
        at_rest: what `over_speeds` returns.
        omega: speed [rad/s].
    """
    if case.rotation.effects != "full":
        return None
    key = f"{structure_key(case)} {range_of(omega)} {at_rest.size}"
    return remembered(_roots, key, lambda: root_at_rest(assembled(case, at_rest)))


def wheel_of_sectors(
    case: Case,
    part: Superelement,
    speeds: tuple[float, float],
    factor: FloatArray,
    others: Sequence[float] = (),
    *,
    blades: bool = False,
    listed: Listed | None = None,
    diameters: Collection[int] | None = None,
) -> tuple[Superelement, ReducedSuperelement]:
    """Return a wheel of sectors with a massless boundary, and its reduction.

    Args:
        case: the case.
        part: the sector.
        speeds: speed, and the highest speed at which the wheel is reduced [rad/s].
        factor: factor on the stiffness of each blade, (sectors,).
        others: other speeds [rad/s], whose modes and static displacements are added, see
            `further_modes.further`.
        blades: whether the stiffness of equal blades is needed, see `wheel_over_speeds`.
        listed: see `wheel_over_speeds`.
        diameters: see `WheelOverSpeeds.at`.
    """
    table = case.bladed_disk.matrices
    mistuned = case.bladed_disk.mistuning.is_given(table.copies)
    if not (mistuned or blades):
        part = replace(part, blade_stiffness=None)
    omega, highest = speeds
    wheel = wheel_over_speeds(case, part, highest, listed)
    return wheel.at(omega, factor if mistuned else None, others, diameters)


def wheel_over_speeds(
    case: Case, part: Superelement, omega: float, listed: Listed | None = None
) -> WheelOverSpeeds:
    """Return a wheel of sectors for the `range_of` a speed [rad/s]; with `blade_stiffness` it has
    the stiffness of each blade. If modes are `listed`, it has only these in place of it."""
    table, effects = case.bladed_disk.matrices, case.rotation.effects
    if effects == "centrifugal":
        part = replace(part, gyroscopic=None)
    highest = 0.0 if effects == "none" else range_of(omega)
    if listed is not None:
        highest = listed.speed
    return WheelOverSpeeds(
        *(part, table.copies, case.reduction.free_interface_modes, highest, table.file),
        mistuned=case.bladed_disk.mistuning.is_given(table.copies),
        static=listed is None,
        coupled=0 if listed is None else listed.coupled,
    )


def blocks_of_sectors(
    case: Case,
    part: Superelement,
    count: int,
    highest: float,
    *,
    between: bool = True,
    static: bool = True,
    diameters: Sequence[int] | None = None,
) -> Blocks:
    """Return the `sector_blocks` of a sector, or what is kept of them beside the file of a case."""
    table = case.bladed_disk.matrices
    own = (*(range(table.copies // 2 + 1) if diameters is None else diameters),)

    def compute() -> list[Arrays]:
        chosen: dict[str, Any] = {"between": between, "static": static, "diameters": own}
        found = sector_blocks(part, table.copies, count, highest, **chosen)
        return [arrays_of(each) for each in found.values()]

    settings = (table.copies, count, highest, between, static, *own)
    parts = kept_reduction(table.file, part, settings, compute)
    return {k: restored(NodalBlock, each) for k, each in zip(own, parts, strict=True)}


def _condensed(case: Case, part: Superelement, highest: float, modes: int) -> Superelement:
    held = part if part.centre_dofs is None else on_springs(case, part)
    file = case.bladed_disk.matrices.file

    def compute() -> list[Arrays]:
        small = vars(condensed(held, highest, modes)).items()
        return [{key: one for key, one in small if one is not getattr(held, key)}]

    try:
        (changed,) = kept_reduction(file, held, (1, modes, highest), compute)
    except IndefiniteError:  # at the highest speed: reduced at each speed by itself
        return part
    small = replace(held, **dict[str, Any](changed))
    return small if part.centre_dofs is None else on_springs(case, small, -1.0)


def structure_key(case: Case) -> str:
    """Return text that is the same for cases with the same structure."""
    table = case.bladed_disk.matrices
    return repr((table, table.stamp, case.shaft, case.reduction, case.bladed_disk.mistuning))


def without_rotation(case: Case) -> Case:
    """Return a case whose bladed disk has no effects of the rotation."""
    return case.model_copy(update={"rotation": Rotation()})


def is_of_equal_sectors(case: Case) -> bool:
    """Return whether a wheel has equal sectors with a massless boundary, which are reduced by nodal
    diameter."""
    table = case.bladed_disk.matrices
    mistuned = case.bladed_disk.mistuning.is_given(table.copies)
    return table.kind == "sector" and not mistuned and case.reduction.boundary == "massless"


def with_modes(case: Case, each: int) -> Case:
    """Return a case whose part is reduced to some modes, those of a sector of each nodal diameter;
    or to all but one of them."""
    table = case.bladed_disk.matrices
    part = table.part
    most = part.size - 1
    if part.right_dofs is not None:
        most -= int(np.count_nonzero(part.right_dofs != FIXED))
    reduction = case.reduction.model_copy(update={"free_interface_modes": min(each, most)})
    return case.model_copy(update={"reduction": reduction})


def on_springs(case: Case, part: Superelement, sign: float = 1.0) -> Superelement:
    """Return a wheel with the springs of the shaft at its centre, or without them for a sign -1."""
    if case.shaft.clamped:
        raise SuperelementError("a wheel without centre_dofs for shaft.clamped = true")
    assert part.centre_dofs is not None
    springs = sp.csr_array(
        (case.shaft.stiffnesses, (part.centre_dofs, part.centre_dofs)), shape=(part.size, part.size)
    )
    added = springs if sp.issparse(part.stiffness) else springs.toarray()
    return replace(part, stiffness=part.stiffness + sign * added)

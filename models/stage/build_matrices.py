"""Build the stage of a case with a superelement: structure at the speed, reduction, wall."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.analysis import MODES
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault, faults_at
from bladewhirl.models.case.superelement import SOURCE
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.imports.inspection import NEGATIVE
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.stage.kept_modes import KeptModes
from bladewhirl.models.stage.loads import blade_means
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.ring import Ring, stage_casing
from bladewhirl.models.stage.superelement_springs import coupling_springs
from bladewhirl.models.stage.superelement_structure import (
    FEWEST,
    LARGE,
    Listed,
    assembled,
    damping_root,
    is_of_equal_sectors,
    over_speeds,
    remembered,
    structure_key,
    structure_of,
    wheel_of_sectors,
    with_modes,
    without_rotation,
)
from bladewhirl.models.superelements.condensed import FURTHER_MODES
from bladewhirl.models.superelements.points import with_fewer_points
from bladewhirl.models.superelements.reduction import (
    ReducedSuperelement,
    boundary_size,
    consistent,
    massless,
    rigid_limit,
)
from bladewhirl.models.superelements.superelement import (
    COMPONENTS,
    IndefiniteError,
    Superelement,
    SuperelementError,
)

POINT_NUMBERS, FEWEST_POINTS = 50_000_000, 200
"""Largest number of displacements and stresses of points in all modes of a wheel from a sector; and
number of points of a sector that are always kept."""

HIGHEST = 1e5  #: highest plausible first natural frequency [Hz]


def build_matrices(
    case: Case,
    ring: Ring | None = None,
    *,
    blades: bool = False,
    listed: Listed | None = None,
    diameters: Collection[int] | None = None,
    condensed_from: int = LARGE,
) -> Matrices:
    """Return the stage of a case with a superelement.

    Args:
        case: the case.
        ring: its casing, if it is known.
        blades: whether the stiffness of each of the equal blades of sectors is needed.
        listed: the modes of sectors that are needed, if no others are.
        diameters: the only nodal diameters that are needed of equal sectors; all by default.
        condensed_from: least number of coordinates of a blade or a wheel that is condensed, see
            `over_speeds`.

    Raises:
        CaseError: the superelement cannot be reduced as the case demands.
    """
    table = case.bladed_disk.matrices
    part, at_rest, omega = structure_of(case), None, 0.0
    factor = case.bladed_disk.mistuning.factors("stiffness", table.copies)
    shown = np.arange(part.point_count)
    if table.kind == "sector":
        fields = case.reduction.free_interface_modes
        if case.rotation.effects != "none":  # those of three speeds
            fields = 3 * (fields + FURTHER_MODES + 3 * part.contacts)
        values = 3 if part.stress_recovery is None else 3 + COMPONENTS
        most = max(POINT_NUMBERS // (values * table.copies**2 * fields), FEWEST_POINTS)
        loads = case.excitations.values()
        needed = {point for load in loads for point in getattr(load, "points", ())}
        gauges = (getattr(sensor, "point", None) for sensor in case.sensor)
        needed |= {point for point in gauges if point is not None and point < part.point_count}
        part, shown = with_fewer_points(part, most, needed)
    key = "bladed_disk.superelement.file"
    if case.rotation.effects != "none":
        at_rest = _reference_at_rest(case)
        omega = case.march.speed.rad_per_s(at_rest)
    of_waves = table.kind == "sector" and case.reduction.boundary == "massless"
    if not of_waves:
        name = "free" if case.reduction.boundary == "massless" else "fixed"
        key = f"reduction.{name}_interface_modes"
    reduced_at = partial(
        _reduced_at, case, part, factor, omega, blades, listed, diameters, condensed_from
    )
    try:
        given, part, reduced = reduced_at(omega, others=other_speeds(case, at_rest))
    except SuperelementError as error:
        if at_rest is not None and isinstance(error, IndefiniteError):
            expected = "a speed at which the structure keeps its stiffness in spite of the rotation"
            raise CaseError([case_fault(case, "march.speed", expected)]) from None
        raise CaseError(faults_at(case, key, error)) from None
    if table.kind == "blade":
        rigid = int((reduced.frequency <= np.sqrt(rigid_limit(part))).sum())
        if rigid:
            expected = f"a blade that is clamped at its root; the matrices have {rigid} rigid modes"
            raise CaseError([Fault(key=f"{SOURCE}.file", expected=expected)])
    if reduced.damping is not None:
        rates = np.linalg.eigvalsh(0.5 * (reduced.damping + reduced.damping.T))
        if rates[0] < -NEGATIVE * abs(rates).max():
            expected = "a damping matrix without negative eigenvalues, which feed energy"
            raise CaseError([Fault(key=f"{SOURCE}.file", expected=expected)])
    per_blade = part.contacts if table.kind == "blade" else part.contacts // table.copies
    reference = at_rest
    if reference is None:
        elastic = reduced.frequency > np.sqrt(rigid_limit(part))
        frequency = reduced.frequency
        reference = float(frequency[elastic].min() if elastic.any() else frequency.max())
    hertz = reference / (2.0 * np.pi)
    if hertz > HIGHEST:
        expected = (
            f"matrices in SI units, or length_unit and mass_unit in the file: the first natural"
            f" frequency would be {hertz:.3g} Hz"
        )
        raise CaseError([Fault(key=f"{SOURCE}.file", expected=expected)])
    ring, copies = stage_casing(case) if ring is None else ring, factor
    if table.kind != "blade":
        copies = np.ones(1)
    stage = Matrices(
        case=case.in_seconds(reference),
        casing=ring.casing,
        casing_modes=ring.casing_modes,
        reduced_casing=ring.reduced_casing,
        reference_frequency=reference,
        part=part,
        given=given,
        shown=shown,
        reduced=reduced,
        factor=copies,
        blade=np.arange(part.contacts) // per_blade,
        reduced_at=lambda speed: reduced_at(speed)[2],
        build=partial(
            build_matrices,
            blades=blades,
            listed=listed,
            diameters=diameters,
            condensed_from=condensed_from,
        ),
        kept=KeptModes(
            rotor=np.arange(len(copies) * len(reduced.frequency)),
            casing=np.arange(len(ring.reduced_casing.frequency)),
            coupled=None,
            springs=None,
        ),
    )
    return replace(stage, kept=replace(stage.kept, springs=_springs(stage)))


def _springs(stage: Matrices) -> CouplingSprings | None:
    """Return the springs between blades and casing; None without them."""
    if not stage.case.coupling.stiffness:
        return None
    radial = blade_means(stage.blade) @ stage.rotor.tip_radial
    moved = sp.block_diag([radial] * stage.copies)
    outward = np.asarray(moved.toarray(), dtype=np.float64)
    return coupling_springs(stage.case, outward, stage.blade_angle.ravel(), stage)


def _reduced_at(
    case: Case,
    part: Superelement,
    factor: FloatArray,
    highest: float,
    blades: bool,
    listed: Listed | None,
    diameters: Collection[int] | None,
    condensed_from: int,
    omega: float,
    others: Sequence[float] = (),
) -> tuple[Superelement, Superelement, ReducedSuperelement]:
    """Return a superelement at a speed, its structure with its supports, and its reduction.

    Args:
        case: case of the superelement.
        part: superelement at rest.
        factor: factor on the stiffness of each blade, (blades,).
        highest: highest speed [rad/s], on whose `range_of` the reduction depends.
        blades: whether the stiffness of equal blades is needed.
        listed: see `wheel_over_speeds`.
        diameters: see `build_matrices`.
        condensed_from: see `build_matrices`.
        omega: speed [rad/s].
        others: other speeds [rad/s], whose modes and static displacements are added, see
            `massless` and `consistent`.

    Raises:
        SuperelementError: as for `massless` and `consistent`.
    """
    table, reduction = case.bladed_disk.matrices, case.reduction
    if table.kind == "sector" and reduction.boundary == "massless":
        speeds = omega, highest
        found = wheel_of_sectors(
            *(case, part, speeds, factor, others),
            blades=blades,
            listed=listed,
            diameters=diameters,
        )
        return part, *found
    root, slower, effects = None, list[Superelement](), case.rotation.effects
    if effects != "none":
        still = over_speeds(case, part, highest, condensed_from)
        part = still.at(omega, effects)
        root = damping_root(case, still, highest)
        slower = [assembled(case, still.at(each, effects)) for each in others]
    held = assembled(case, part)
    if reduction.boundary == "massless":
        return part, held, massless(held, reduction.free_interface_modes, root, slower)
    kept = reduction.fixed_interface_modes
    if kept == MODES:  # the default: all modes of a small superelement
        kept = min(kept, held.size - boundary_size(held))
    return part, held, consistent(held, kept, kept, root, slower)


def other_speeds(case: Case, at_rest: float | None) -> tuple[float, ...]:
    """Return the lowest speed of a case whose speed varies, and one between it and the highest
    [rad/s]; none if the speed is constant, or if the rotation does not act on the structure.

    Args:
        case: the case.
        at_rest: reference frequency at rest, if the rotation acts on the structure [rad/s].
    """
    course = None if at_rest is None else case.march.course(at_rest)
    if course is None or np.ptp(course.range) == 0.0:
        return ()
    low, high = sorted(map(abs, course.range))
    low = 0.0 if np.prod(course.range) < 0.0 else low
    return low, float(np.sqrt(0.5 * (low**2 + high**2)))


_at_rest: dict[str, float] = {}
"""Reference frequencies of the last cases, by all they depend on."""


def _reference_at_rest(case: Case) -> float:
    """Return the reference frequency of the structure at rest [rad/s], computed once for all points
    of a sweep; of equal sectors from few modes without static displacements."""
    key, still, listed = structure_key(case), without_rotation(case), None
    if is_of_equal_sectors(case):
        still, listed = with_modes(still, FEWEST), Listed(0.0, 0)
    at_rest = partial(build_matrices, still, listed=listed)
    return remembered(_at_rest, key, lambda: at_rest().reference_frequency)

"""Build the stage of a case with beams: finite elements, reduction, modes and their labels."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.analysis import MODES
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.coupling.stage_modes import tip_motion, wall_motion
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.build import (
    case_bladed_disk,
    lowest_frequency,
    numbers_within_reach,
    tip_in_sector,
)
from bladewhirl.models.elements.cost import stage_cost, tell_cost
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.modal.frequencies import Frequencies, lowest_frequencies
from bladewhirl.models.modal.labels import mode_families
from bladewhirl.models.modal.reduction import craig_bampton
from bladewhirl.models.modal.suspension import with_sized_shaft
from bladewhirl.models.rotation.at_speed import turning_disk
from bladewhirl.models.stage.beam_rotor import boundary_sets
from bladewhirl.models.stage.beams import Beams
from bladewhirl.models.stage.kept_modes import kept_modes
from bladewhirl.models.stage.ring import stage_casing

FULL_FREQUENCIES = 7
"""Number of frequencies of the full model that are computed per nodal diameter: five families, the
suspension pair, and one more mode."""

MOST_ENTRIES = 5e8  #: largest number of entries in the mode shapes of a reduced model (4 GB)


def build_beams(case: Case) -> Beams:
    """Build the stage of a case with beams.

    Raises:
        CaseError: there are more fixed-interface modes than internal degrees of freedom, the stage
            is too large for the memory, selected modes do not exist, no springs give the
            suspension frequency, or values are too extreme for finite elements in double
            precision.
    """
    case = with_sized_shaft(case)
    with numbers_within_reach(case):
        tell_cost(stage_cost(case))
        at_rest = case_bladed_disk(case, clamped=case.shaft.clamped)
        case = _with_possible_modes(case, at_rest)
        tip = tip_in_sector(at_rest)
        full = lowest_frequencies(at_rest.structure, FULL_FREQUENCIES)
        reference = _reference_frequency(case, at_rest, full)
        case = case.in_seconds(reference)
        disk = turning_disk(case, at_rest, reference)
        if disk.rotates:
            full = lowest_frequencies(disk.structure, FULL_FREQUENCIES)
        reduction = craig_bampton(
            disk.structure,
            np.concatenate([*boundary_sets(disk).values()]),
            case.reduction.fixed_interface_modes,
            tip,
        )
        lowest_frequency(disk, np.abs(reduction.modes.frequency))  # check against rounding
        ring = stage_casing(case)
        disk_family = mode_families(disk.structure, reduction.modes, tip, "bladed-disk")
    stage = Beams(
        **vars(ring),
        disk=disk,
        disk_frequencies=full,
        reference_frequency=reference,
        reduction=reduction,
        disk_family=disk_family,
        blade=np.arange(len(disk.tip_radial)),
        kept=kept_modes(
            case,
            tip_motion(disk, reduction.modes, disk_family, lambda i: reduction.modes.shapes[:, i]),
            wall_motion(ring.casing, ring.casing_modes),
        ),
    )
    if disk.rotates:
        _check_clearance(case, stage.rotor.tip_recess)
    return stage


def _reference_frequency(case: Case, disk: BladedDiskModel, full: Frequencies) -> float:
    """Return the lowest natural frequency of the full bladed disk with a free centre [rad/s].

    Raises:
        FloatingPointError: the frequency is lost in rounding.
    """
    if case.shaft.clamped:
        free = case_bladed_disk(case, clamped=False)
        disk, full = free, lowest_frequencies(free.structure, FULL_FREQUENCIES)
    return lowest_frequency(disk, (frequencies[0] for frequencies in full.values()))


def _check_clearance(case: Case, recess: FloatArray) -> None:
    """Check that the static growth of the tips at speed closes no gap to the casing.

    Raises:
        CaseError: a tip touches the casing; the error names the blade and the overlap.
    """
    smallest_gap = case.casing.clearance_profile.smallest + recess
    if not smallest_gap.min() > 0.0:
        blade = int(smallest_gap.argmin())
        expected = (
            f"room for the growth of the tips at march.speed: the tip of blade {blade} would be"
            f" {-smallest_gap[blade]:.3g} m beyond the casing where it is narrowest"
        )
        raise CaseError([case_fault(case, "casing.clearance", expected)])


def _with_possible_modes(case: Case, disk: BladedDiskModel) -> Case:
    """Return the case with as many fixed-interface modes as the bladed disk has, if the default
    number is larger.

    Raises:
        CaseError: there are more fixed-interface modes than internal degrees of freedom, or the
            model is too large.
    """
    boundary = sum(map(len, boundary_sets(disk).values()))
    internal = disk.structure.size - boundary
    key, requested = "reduction.fixed_interface_modes", case.reduction.fixed_interface_modes
    if MODES == requested > internal:
        requested = internal
        reduction = case.reduction.model_copy(update={"fixed_interface_modes": internal})
        case = case.model_copy(update={"reduction": reduction})
    elif requested > internal:
        expected = (
            f"at most {internal}, the number of internal degrees of freedom of the bladed disk"
        )
        raise CaseError([case_fault(case, key, expected)])
    if disk.structure.size * (boundary + requested) > MOST_ENTRIES:
        expected = (
            f"a bladed disk of fewer degrees of freedom than {disk.structure.size}, or fewer "
            f"fixed-interface modes: at most {MOST_ENTRIES:g} entries in the matrix of mode shapes"
        )
        raise CaseError([Fault(key="bladed_disk", expected=expected)])
    nodal = 4 * case.casing.elements
    if nodal**2 > MOST_ENTRIES:
        expected = f"at most {int(MOST_ENTRIES**0.5) // 4} elements"
        raise CaseError([case_fault(case, "casing.elements", expected)])
    return case

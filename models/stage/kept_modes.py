"""Selection of the modes for time integration, and of the springs between these modes."""

from dataclasses import dataclass, replace

import numpy as np

from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.coupling.springs import CoupledEntries, CouplingSprings
from bladewhirl.models.coupling.stage_modes import RadialModes, coupled_entries
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.inputs.mode_names import NamedModes, chosen_modes


@dataclass(frozen=True, kw_only=True)
class KeptModes:
    """Numbers of the selected modes among all modes of a stage, ascending, and their springs."""

    rotor: IntArray  #: modes of the bladed disk, (rotor modes kept,)
    casing: IntArray  #: modes of the casing, (casing modes kept,)
    coupled: CoupledEntries | None  #: selected modes that springs couple; None without stiffness
    springs: CouplingSprings | None  #: the springs between them


def kept_modes(case: Case, rotor: RadialModes, casing: RadialModes) -> KeptModes:
    """Return the modes selected by `reduction.modes` and the springs selected by `coupling`.

    Args:
        case: the case.
        rotor: all modes of the bladed disk.
        casing: all modes of the casing.

    Raises:
        CaseError: the stage does not have the selected modes, or springs have no modes to couple.
    """
    coupled = None
    if rotor.is_cyclic and casing.is_cyclic and len(casing.frequency):
        coupled = coupled_entries(rotor, casing, damping_ratio=case.damping.ratio)
    bodies = [NamedModes(nodal_diameter=b.nodal_diameter, family=b.family) for b in (rotor, casing)]

    def named(key: str, choice: str) -> tuple[IntArray, IntArray]:
        try:
            return chosen_modes(choice, bodies[0], bodies[1], coupled.radial if coupled else {})
        except ValueError as error:
            raise CaseError([case_fault(case, key, f"modes of the stage ({error})")]) from None

    on_rotor, on_casing = named("reduction.modes", case.reduction.modes)
    held, springs, kappa = None, None, case.coupling.stiffness
    if kappa:
        if coupled is None:
            expected = "0, or a stage with cyclic symmetry"
            raise CaseError([case_fault(case, "coupling.stiffness", expected)])
        chosen = named("coupling.modes", case.coupling.modes)
        held = _coupled_modes(case, coupled, (on_rotor, on_casing), chosen)
        springs = held.springs(kappa, len(on_rotor), len(on_casing))
    return KeptModes(rotor=on_rotor, casing=on_casing, coupled=held, springs=springs)


def _coupled_modes(
    case: Case,
    coupled: CoupledEntries,
    kept: tuple[IntArray, IntArray],
    chosen: tuple[IntArray, IntArray],
) -> CoupledEntries:
    """Return the modes that belong to `reduction.modes` and to `coupling.modes`, numbered among
    those of `reduction.modes`.

    Args:
        case: case with the stiffness of the springs.
        coupled: all modes that springs may couple.
        kept: numbers of the modes of `reduction.modes`, of bladed disk and casing.
        chosen: numbers of the modes of `coupling.modes`, of bladed disk and casing.

    Raises:
        CaseError: no modes belong to both.
    """
    here = coupled.among(*(np.intersect1d(*pair) for pair in zip(kept, chosen, strict=True)))
    if not here.size:
        expected = (
            "modes that are coupled by springs and are also kept by reduction.modes ="
            f" {case.reduction.modes!r}"
        )
        raise CaseError([case_fault(case, "coupling.modes", expected)])
    entries = coupled.take(here)
    if case.coupling.amplitude != "physical":
        entries = entries.with_unit_amplitudes()
    rotor, casing = (np.searchsorted(numbers, entries.number) for numbers in kept)
    return CoupledEntries(
        modes=replace(entries.modes, with_pi=case.coupling.pi),
        number=np.where(entries.modes.on_casing, casing, rotor),
    )

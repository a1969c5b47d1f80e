"""Estimate of the memory and time of a stage before anything is assembled."""

import logging
from dataclasses import dataclass

from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.build import case_beam_model
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.inputs.machine import memory

logger = logging.getLogger(__name__)

DOFS_PER_NODE = 3  #: two displacements and a rotation

FIELDS = 3  #: largest number of copies of the shapes of a reduced stage that are in memory at once

BYTES_PER_ENTRY = 64
"""Memory of the complex mass, stiffness and shapes of a sector, for each entry of one matrix
[bytes]."""

SECONDS_PER_ENTRY, SECONDS_PER_CUBE = 2.5e-7, 3e-9
"""Time for each entry of the shapes, and time for each nodal diameter and unit of (size of a
sector)^3 [s]; measured on a processor of 2023, accurate to a factor of three."""

MODAL_BYTES, MODAL_SECONDS, DIAMETER_SECONDS = 50, 4e-9, 4e-3
"""Cost of the modes of bladed disks with a free and a clamped centre, for each nodal diameter:
bytes for each entry of a sector matrix, seconds for each unit of (size of a sector)^3, and
a constant number of seconds."""

DENSE_BYTES, DENSE_SECONDS = 70, 1e-9
"""Bytes per matrix entry and seconds per unit of size^3 of a structure without symmetry."""

LARGE_BYTES, LARGE_SECONDS = 2e9, 30.0
"""Memory [bytes] and time [s] above which a stage is reported as large."""


@dataclass(frozen=True, kw_only=True)
class Cost:
    """Lower bound of the cost of a stage; rotation effects and mistuned blades increase it."""

    dofs: int  #: degrees of freedom of the full bladed disk
    modes: int  #: number of modes of the bladed disk to compute
    memory: float  #: memory [bytes]
    time: float  #: processor time [s]

    def __str__(self) -> str:
        """Return the cost as text."""
        time = f"{self.time / 60:.2g} min" if self.time < 3600 else f"{self.time / 3600:.2g} h"
        return (
            f"{self.dofs} degrees of freedom and {self.modes} modes take at least"
            f" {self.memory / 1e9:.2g} GB of memory and some {time}"
        )


def stage_cost(case: Case) -> Cost:
    """Return the cost of the reduced stage of a case, assuming identical blades.

    Raises:
        CaseError: parts of the bladed disk do not fit together.
    """
    blades, dofs = case.blades, DOFS_PER_NODE * len(case_beam_model(case).mesh.points)
    modes = case.reduction.fixed_interface_modes + 2 * blades + 2
    sector, diameters = dofs / blades, blades // 2 + 1
    return Cost(
        dofs=dofs,
        modes=modes,
        memory=8.0 * FIELDS * dofs * modes + BYTES_PER_ENTRY * diameters * sector**2,
        time=SECONDS_PER_ENTRY * dofs * modes + SECONDS_PER_CUBE * diameters * sector**3,
    )


def modal_cost(structure: Structure) -> Cost:
    """Return the cost of all modes of a full bladed disk, with a free and with a clamped centre."""
    size, blocks, memory, time = structure.size, 1, DENSE_BYTES, DENSE_SECONDS
    if structure.layout is not None and structure.is_cyclic:
        blocks, memory, time = structure.layout.sectors // 2 + 1, MODAL_BYTES, MODAL_SECONDS
        size = structure.layout.sector_dofs.shape[1]
    return Cost(
        dofs=structure.size,
        modes=structure.size,
        memory=float(memory) * blocks * size**2,
        time=blocks * (time * size**3 + DIAMETER_SECONDS),
    )


def tell_cost(cost: Cost) -> None:
    """Log the cost of a large stage before it is built.

    Raises:
        CaseError: the stage needs more memory than this computer has.
    """
    if cost.memory > (most := memory()):
        expected = f"a smaller stage: {cost}; this computer has only {most / 1e9:.3g} GB"
        raise CaseError([Fault(key="bladed_disk", expected=expected)])
    if cost.memory > LARGE_BYTES or cost.time > LARGE_SECONDS:
        logger.warning("Large stage: %s.", cost)

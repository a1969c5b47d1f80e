"""Critical time step of a superelement, from one factorisation and without its reduction."""

import numpy as np

from bladewhirl.models.superelements.further_modes import stiffest
from bladewhirl.models.superelements.reduction import STIFF, modes_and_static
from bladewhirl.models.superelements.sector import Sector, sector_errors
from bladewhirl.models.superelements.superelement import Superelement


def critical_time_step(part: Superelement, modes: int) -> float:
    """Return 2 / omega_max [s] at rest, with the highest frequency omega_max of the reduced part
    whose contact nodes are held.

    That of a sector is nearly highest for the largest nodal diameter, in which neighbouring sectors
    move against each other, and only this one is computed.

    Args:
        part: blade, sector with its number of sectors, or wheel.
        modes: number of free-interface modes of the part.

    Raises:
        SuperelementError: the part cannot be reduced.
    """
    rows = part.contact_rows
    if part.left_dofs is None:
        squares, shapes, moved = modes_and_static(part, modes, rows.T.toarray())
        return 2.0 / stiffest(squares, rows @ shapes, rows @ moved)
    assert part.sectors is not None
    with sector_errors(STIFF):
        solved = {"modes": modes, "loads": rows.shape[0], "waves": 1}
        sector = Sector(part, part.sectors, **solved, rigid=True)
        wave = sector.wave(part.sectors // 2)
        squares, shapes = wave.lowest(modes)
        contact = rows @ wave.tie
        moved = wave.static(contact.conj().T.toarray(), shapes, exact=False)
    compliance = contact @ moved
    hermitian = np.asarray(0.5 * (compliance + compliance.conj().T))
    return 2.0 / stiffest(squares, contact @ shapes, hermitian)

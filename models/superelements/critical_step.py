"""Critical time step of a superelement and the friction that locks its contact nodes, from one
factorisation and without its reduction."""

from typing import NamedTuple

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.superelements.further_modes import stiffest
from bladewhirl.models.superelements.reduction import STIFF, modes_and_static
from bladewhirl.models.superelements.sector import Sector, sector_errors
from bladewhirl.models.superelements.superelement import Superelement

ROUNDING = 1e-9
"""A displacement of a contact node along the radius by a force along the circumference is a
rounding error up to this fraction of that by a force along the radius."""


class Limits(NamedTuple):
    """Limits of a march at rest."""

    time_step: float
    """2 / omega_max [s], with the highest frequency omega_max of the reduced part whose contact
    nodes are held."""
    friction: float
    """Smallest friction coefficient with which static friction presses a contact node outward more
    than the normal force presses it inward; infinite if there is none."""


def limits_of(part: Superelement, modes: int) -> Limits:
    """Return the limits of a march with a reduced part.

    The highest frequency of a sector is nearly that of the largest nodal diameter, in which
    neighbouring sectors move against each other, and only this one is computed; there the disk
    gives way least, so that a single blade locks at about the same friction.

    Args:
        part: blade, sector with its number of sectors, or wheel.
        modes: number of free-interface modes of the part.

    Raises:
        SuperelementError: the part cannot be reduced.
    """
    rows = part.contact_rows
    if part.left_dofs is None:
        squares, shapes, moved = modes_and_static(part, modes, rows.T.toarray())
        return _limits(squares, rows @ shapes, rows @ moved)
    assert part.sectors is not None
    with sector_errors(STIFF):
        solved = {"modes": modes, "loads": rows.shape[0], "waves": 1}
        sector = Sector(part, part.sectors, **solved, rigid=True)
        wave = sector.wave(part.sectors // 2)
        squares, shapes = wave.lowest(modes)
        contact = rows @ wave.tie
        moved = wave.static(contact.conj().T.toarray(), shapes, exact=False)
    compliance = contact @ moved
    return _limits(squares, contact @ shapes, 0.5 * (compliance + compliance.conj().T))


def _limits(squares: FloatArray, contact: ComplexArray, compliance: ComplexArray) -> Limits:
    """Return the limits from modes, squared frequencies (modes,), displacements of the contact
    nodes in them, (3c, modes), and residual flexibility, (3c, 3c)."""
    time_step = 2.0 / stiffest(squares, contact, compliance)
    if squares.min() <= 0.0:  # a part with rigid modes
        return Limits(time_step, np.inf)
    static = compliance + (contact / squares) @ contact.conj().T
    radial, tangential = (np.diag(static, n)[::3].real for n in (0, 1))
    locked = tangential < -ROUNDING * radial  # friction drags backward
    return Limits(time_step, float((radial / -tangential)[locked].min(initial=np.inf)))

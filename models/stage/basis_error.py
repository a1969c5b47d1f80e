"""Error of a superelement that was condensed for a range of speeds."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.stage.superelement_structure import LARGE, on_springs, structure_of
from bladewhirl.models.superelements.reduction import lowest_modes
from bladewhirl.models.superelements.sector import Sector
from bladewhirl.models.superelements.superelement import Superelement

COMPARED = 10  #: number of the lowest frequencies that are compared


def basis_error(case: Case, speed: float, frequency: FloatArray) -> float | None:
    """Return the largest relative error of the lowest frequencies of a superelement, which come
    from modes at other speeds, against those of its file at their speed.

    None if the superelement is not condensed, because the rotation has no effect or because it is
    small, or if blades differ.

    Args:
        case: the case.
        speed: speed of rotation [rad/s].
        frequency: frequencies at this speed, in any order [rad/s], (modes,).
    """
    table = case.bladed_disk.matrices
    effects, massless = case.rotation.effects, case.reduction.boundary == "massless"
    if effects == "none" or not massless or case.bladed_disk.mistuning.is_given(table.copies):
        return None
    part = structure_of(case)
    if table.kind != "sector" and part.size < LARGE:
        return None
    part = part.at(speed, "centrifugal")
    if table.kind == "sector":
        exact = _of_sector(part, table.copies)
    else:
        held = part if part.centre_dofs is None else on_springs(case, part)
        exact = lowest_modes(held, COMPARED)[0]
    count = min(len(exact), len(frequency), COMPARED)
    return float(np.abs(np.sort(frequency)[:count] / np.sqrt(exact[:count]) - 1.0).max())


def _of_sector(part: Superelement, sectors: int) -> FloatArray:
    """Return the lowest squared frequencies of a wheel of sectors, ascending."""

    def lowest(k: int) -> FloatArray:
        wave, pair = sector.wave(k), 0 < 2 * k < sectors
        return np.repeat(wave.lowest(min(COMPARED, wave.size))[0], 1 + pair)

    sector = Sector(part, sectors, modes=COMPARED, loads=0, rigid=False)
    return np.sort(np.concatenate([*sector.each_wave(lowest)]))[:COMPARED]

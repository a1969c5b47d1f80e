"""Error of a superelement that was condensed for a range of speeds."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.stage.superelement_structure import LARGE, on_springs, structure_of
from bladewhirl.models.superelements.reduction import ReducedSuperelement, lowest_modes
from bladewhirl.models.superelements.sector import Sector
from bladewhirl.models.superelements.superelement import Superelement

COMPARED = 10  #: number of the lowest frequencies that are compared


def basis_error(case: Case, speed: float, reduced: ReducedSuperelement) -> float | None:
    """Return the largest relative error of the lowest frequencies of a superelement, which come
    from modes at other speeds, against those of its file at their speed.

    None if the superelement is not condensed, because the rotation has no effect or because it is
    small, or if blades differ.

    Args:
        case: the case.
        speed: speed of rotation [rad/s].
        reduced: reduction at this speed.
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
        squares, exact = _of_sector(part, table.copies, reduced)
    else:
        held = part if part.centre_dofs is None else on_springs(case, part)
        exact = lowest_modes(held, COMPARED)[0]
        squares = np.sort(reduced.squares)
    count = min(len(exact), len(squares), COMPARED)
    return float(np.abs(np.sqrt(squares[:count] / exact[:count]) - 1.0).max())


def _of_sector(
    part: Superelement, sectors: int, reduced: ReducedSuperelement
) -> tuple[FloatArray, FloatArray]:
    """Return the lowest squared frequencies of the reduction of a wheel of sectors, by nodal
    diameter, and the exact ones of these nodal diameters, (modes,) each."""
    assert reduced.waves is not None  # the sectors are equal
    first = np.argsort(reduced.squares)[:COMPARED]
    squares, diameter = reduced.squares[first], abs(reduced.waves.number[first])
    diameters, counts = np.unique(diameter, return_counts=True)
    most = dict(zip(diameters.tolist(), counts.tolist(), strict=True))

    def lowest(k: int) -> FloatArray:
        wave, pair = sector.wave(k), 0 < 2 * k < sectors
        return np.repeat(wave.lowest(min(most[k], wave.size))[0], 1 + pair)[: most[k]]

    chosen = {"modes": max(most.values()), "loads": 0, "waves": len(most)}
    sector = Sector(part, sectors, **chosen, rigid=False)
    exact = np.concatenate([*sector.each_wave(lowest, most)])
    return squares[np.argsort(diameter, kind="stable")], exact

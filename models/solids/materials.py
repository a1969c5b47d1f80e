"""Materials of the cells of a solid: those of the mesh file, by set, and those that are given."""

import warnings
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from bladewhirl.meshes.files.volumes import VolumeMesh
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.inputs.errors import Hint
from bladewhirl.models.inputs.fields import positive
from bladewhirl.models.inputs.plausible import MATERIAL, fault_of
from bladewhirl.models.inputs.units import finite, to_si
from bladewhirl.models.solids.groups import cells_of, invalid

Given = float | str | Mapping[str, float | str] | None
"""A value for all cells without a material in the file, or values by the name of a group."""

SYMBOLS = {"young_modulus": "Pa", "poisson_ratio": "", "density": "kg/m3"}


class Materials(NamedTuple):
    """Constants of the isotropic elastic materials of all cells."""

    young_modulus: FloatArray  #: Young's modulus [Pa], (cells,)
    poisson_ratio: FloatArray  #: Poisson's ratio, (cells,)
    density: FloatArray  #: density [kg/m3], (cells,)

    def __str__(self) -> str:
        rows = np.unique(np.array(self), axis=1).T.tolist()
        return "; ".join(f"{e:g} Pa, {ratio:g}, {rho:g} kg/m3" for e, ratio, rho in rows)

    @property
    def tensor(self) -> FloatArray:
        """Elasticity tensor [Pa], (3, 3, 3, 3, cells)."""
        shear = self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))
        lame = 2.0 * shear * self.poisson_ratio / (1.0 - 2.0 * self.poisson_ratio)
        one = np.eye(3)
        symmetric = np.einsum("ik,jl->ijkl", one, one) + np.einsum("il,jk->ijkl", one, one)
        volumetric = np.einsum("ij,kl->ijkl", one, one)
        return np.asarray(lame * volumetric[..., None] + shear * symmetric[..., None])


def materials_of(
    mesh: VolumeMesh, given: Mapping[str, Given], unit: str, mass_unit: str | None
) -> Materials:
    """Return the materials of the cells of a mesh.

    Args:
        mesh: mesh, with the materials of its file.
        given: value of each key of `Materials`.
        unit: unit of length of the file.
        mass_unit: unit of mass of the materials of the file; the unit of time is the second.

    Raises:
        CaseError: a value is invalid, or cells have no material.
    """
    return Materials(**{key: _values(mesh, key, given[key], unit, mass_unit) for key in SYMBOLS})


def _values(
    mesh: VolumeMesh, key: str, given: Given, unit: str, mass_unit: str | None
) -> FloatArray:
    read: Callable[[str, float | str], float] = (
        _ratio if key == "poisson_ratio" else lambda key, v: positive(key, v, SYMBOLS[key])
    )
    values, reasons = of_file(mesh, key)
    if key != "poisson_ratio" and np.isfinite(values).any():
        values *= unit_scale(key, unit, mass_unit)
    if isinstance(given, Mapping):
        for group, value in given.items():
            values[cells_of(mesh, key, group)] = read(key, value)
    elif given is not None:
        value, without = read(key, given), np.isnan(values)
        others = np.unique(values[~without & (abs(values - value) > 1e-9 * value)])
        if len(others):
            shown = ", ".join(f"{other:g}" for other in others)
            text = f"{key} = {given!r} is only for cells without a material in {mesh.name}, which"
            text += f" gives {shown}; {key} = {{'SET': ...}} replaces it"
            warnings.warn(text, Hint, stacklevel=5)
        values[without] = value
    if len(bare := np.flatnonzero(np.isnan(values))):
        reason = reasons.get(int(bare[0]), "the file gives no material to them")
        raise invalid(key, None, f"a value for {len(bare)} of {len(values)} cells; {reason}")
    for value in np.unique(values).tolist():
        if key == "poisson_ratio":
            _ratio(key, value)
        elif expected := fault_of(value, *MATERIAL[key]):
            shown = repr(given) if isinstance(given, str | float | int) else f"{value:g}"
            warnings.warn(f"unusual {key} = {shown}: expected {expected}", Hint, stacklevel=5)
    return values


def of_file(mesh: VolumeMesh, key: str) -> tuple[FloatArray, dict[int, str]]:
    """Return a constant of each cell in the units of the file, not a number where it gives none,
    and the reason by cell of the materials without it."""
    values = np.full(sum(len(cells) for _, cells in mesh.blocks), np.nan)
    reasons = dict[int, str]()
    for section in mesh.sections:
        chosen = cells_of(mesh, "ELSET", section.group)
        values[chosen] = section.properties.get(key, np.nan)
        reasons |= dict.fromkeys(chosen.tolist(), section.missing(key))
    return values, reasons


def unit_scale(key: str, unit: str, mass_unit: str | None) -> float:
    """Return the factor from the units of a file to SI units, of "young_modulus" or "density"."""
    if mass_unit is None and to_si(f"1 {unit}", "m") != 1.0:
        expected = 'the unit of mass of the materials of the file, such as "t" for N, mm and s'
        raise invalid("mass_unit", None, expected)
    try:
        mass = to_si(f"1 {mass_unit or 'kg'}", "kg")
    except ValueError as error:
        raise invalid("mass_unit", mass_unit, f'a unit of mass such as "t" ({error})') from None
    return mass / to_si(f"1 {unit}", "m") ** (1 if key == "young_modulus" else 3)


def _ratio(key: str, value: float | str) -> float:
    try:
        ratio = finite(value) if not isinstance(value, str) else -1.0
    except (TypeError, ValueError):
        ratio = -1.0
    if not 0.0 <= ratio < 0.5:
        raise invalid(key, value, "a number from 0 to less than 0.5")
    return ratio

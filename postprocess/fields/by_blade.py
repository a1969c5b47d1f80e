"""Values of blades from those of their contact nodes, which are listed blade by blade."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import Array, IntArray, tip_rows
from bladewhirl.postprocess.fields.lost_blades import masked
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.result import portions
from bladewhirl.postprocess.fields.wheels import of_first_wheel

LARGE_DISPLACEMENT = 0.1
"""Displacement of a tip, divided by the length of the blade, above which a linear model is no
longer accurate."""

WRONG_BY_A_TENTH = 1.0 / 3.0
"""Displacement of a tip, divided by the length of the blade, at which a linear model has an error
of a tenth."""

EQUAL = (
    1e-6  #: two natural frequencies of a nodal diameter are a pair up to this relative difference
)

ANY = -1  #: nodal diameter of modes that every engine order excites


def blade_length(dataset: xr.Dataset) -> float:
    """Return the length of a blade [m]; the tip radius for modes, and for results before format
    11."""
    return float(dataset.attrs.get("blade_length", dataset.attrs["tip_radius"]))


def blade_starts(dataset: xr.Dataset) -> IntArray:
    """Return the number of the first contact node of each blade, (blade,)."""
    return np.flatnonzero(np.diff(dataset.variables["blade"].values, prepend=-1))


def blade_count(dataset: xr.Dataset) -> int:
    """Return the number of blades."""
    return len(blade_starts(dataset))


def of_blades(dataset: xr.Dataset, values: Array, choice: np.ufunc = np.add) -> Array:
    """Return the sum of values (..., contact_node) over the contact nodes of each blade, (...,
    blade); the smallest or largest value with `numpy.minimum` or `numpy.maximum`. A shaft line
    without a wheel has no blades."""
    if not values.shape[-1]:
        return values
    return np.asarray(choice.reduceat(values, blade_starts(dataset), axis=-1))


def blade_means(dataset: xr.Dataset, values: Array) -> Array:
    """Return the means of values (..., contact_node) over the contact nodes of each blade, (...,
    blade)."""
    nodes = np.diff(blade_starts(dataset), append=values.shape[-1])
    return np.asarray(of_blades(dataset, values) / nodes)


def blade_angles(dataset: xr.Dataset) -> Array:
    """Return the mean angle of the contact nodes of each blade from +x, rotating axes [rad],
    (blade,)."""
    angle, first = dataset["tip_angle"].values, blade_starts(dataset)
    nodes = np.diff(first, append=len(angle))
    apart = angle - np.repeat(angle[first], nodes)
    return np.asarray(angle[first] + blade_means(dataset, np.arctan2(np.sin(apart), np.cos(apart))))


def blade_radii(dataset: xr.Dataset) -> Array:
    """Return the mean radius of the contact nodes of each blade, turning steadily, (blade,) [m]."""
    return blade_means(dataset, dataset["contact_radius"].values + dataset["tip_growth"].values)


def diameter_shares(dataset: xr.Dataset) -> Array:
    """Return the share of each nodal diameter in the motion of the tips in each rotor mode,
    (rotor_mode, nodal_diameter); an engine order r excites the diameter of `aliased`. Of several
    wheels on a shaft line they are those of the first one."""
    dataset = of_first_wheel(dataset)
    blades = blade_count(dataset)
    rows = np.moveaxis(tip_rows(dataset), 1, 0).reshape(blades, -1, dataset.sizes["rotor_mode"])
    power = np.sum(np.abs(np.fft.fft(rows, axis=0)) ** 2, axis=1).T
    waves, total = np.zeros((len(power), blades // 2 + 1)), power.sum(axis=1, keepdims=True)
    np.add.at(waves.T, aliased(np.arange(blades), blades), power.T)
    return np.asarray(np.divide(waves, total, out=np.zeros_like(waves), where=total > 0.0))


def natural_modes(dataset: xr.Dataset) -> tuple[Array, IntArray]:
    """Return natural frequencies without contact in rotating axes [Hz] and their nodal diameters,
    (modes,) each, ascending, two of equal frequency and nodal diameter once.

    Those of beams have the Coriolis forces of backward waves, which engine orders up to half the
    number of blades excite; those of superelements have none. The diameter is the one with the
    largest share in the motion of the tips; `ANY` for copies that do not influence each other, of
    which the modes of the first are returned. The records of a shaft line are on modes without its
    bearings, so that it has no natural frequencies here.
    """
    if has(dataset, "line"):
        return np.zeros(0), np.zeros(0, dtype=np.int64)
    waves = "rotor_backward_frequency"
    frequency = np.abs(dataset[waves if waves in dataset else "rotor_frequency"].values)
    copies = dataset.sizes["copy"]
    diameter = np.full(len(frequency), ANY)
    if copies == 1:
        diameter = diameter_shares(dataset).argmax(axis=1)
    frequency, diameter = frequency[: len(frequency) // copies], diameter[: len(diameter) // copies]
    order = np.lexsort((frequency, diameter))
    frequency, diameter = frequency[order] / (2.0 * np.pi), diameter[order]
    apart = np.diff(frequency, prepend=-np.inf) > EQUAL * frequency
    apart |= np.diff(diameter, prepend=ANY - 1) != 0
    kept = np.flatnonzero(apart)[np.argsort(frequency[apart], kind="stable")]
    return frequency[kept], diameter[kept]


def aliased(order: IntArray, blades: int) -> IntArray:
    """Return the nodal diameter that each engine order excites on a number of equal blades."""
    return np.asarray(np.minimum(order % blades, -order % blades))


def contact_motion(dataset: xr.Dataset, direction: int) -> Array:
    """Return the radial (0) or tangential (1) displacement of each contact node in rotating axes
    at every record [m], (time, contact_node), with the part of their own flexibility; nan for a
    blade that is lost."""
    return np.concatenate([moved[..., direction] for moved in _motions(dataset)])


def largest_contact_motion(dataset: xr.Dataset) -> Array:
    """Return the largest displacement of each contact node at any record in each direction [m],
    (contact_node, 3)."""
    if not dataset.sizes["contact_node"]:
        return np.zeros((0, 3))
    largest = [np.fmax.reduce(np.abs(moved)) for moved in _motions(dataset)]
    return np.asarray(np.fmax.reduce(largest))


def largest_displacement(dataset: xr.Dataset) -> float:
    """Return the largest displacement of a contact node at any record [m]."""
    if not dataset.sizes["contact_node"]:
        return 0.0
    return max(float(np.nanmax(np.linalg.norm(moved, axis=2))) for moved in _motions(dataset))


def _motions(dataset: xr.Dataset) -> Iterator[Array]:
    """Yield the displacements of contact nodes for portions of the records, nan for lost blades."""
    for portion in portions(dataset):
        part = dataset.isel(time=portion)
        yield masked(part, part["contact_displacement"].values)

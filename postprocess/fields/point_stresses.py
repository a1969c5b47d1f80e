"""Stresses at the points of a superelement, from a result.

The stress is the sum of that of the modes, that of the contact forces without their part in the
modes, and that of steady rotation, see `models.superelements.stresses`. The von Mises stress is the
root of a sum of five squares, which are linear in the stress:

    s^2 = 3/4 (xx - yy)^2 + (zz - (xx + yy) / 2)^2 + 3 (xy^2 + yz^2 + zx^2)
"""

from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.models.inputs.errors import Fault
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError, history
from bladewhirl.postprocess.fields.lost_blades import lost_blades
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.wheels import EVERY_FORCE

ROOT = np.sqrt(3.0)
VON_MISES = np.array(
    [
        [0.5 * ROOT, -0.5 * ROOT, 0.0, 0.0, 0.0, 0.0],
        [-0.5, -0.5, 1.0, 0.0, 0.0, 0.0],
        *ROOT * np.eye(6)[3:],
    ]
)
"""Matrix from the components xx, yy, zz, xy, yz and zx to the five terms, (5, 6)."""

MOST_BYTES = 3e7  #: size of the stresses of solids computed in one matrix product [bytes]

PRODUCTS = np.array([[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]])
"""Axes of the components xx, yy, zz, xy, yz and zx."""


def has_stresses(dataset: xr.Dataset) -> bool:
    """Return true for beams, and for a superelement whose file gives the recovery of stress."""
    return has(dataset, "lines") or has(dataset, "stress")


class PointStresses:
    """Von Mises stress at the points of all copies, for any records."""

    def __init__(self, dataset: xr.Dataset) -> None:
        """Prepare the products.

        Args:
            dataset: result of a superelement with stresses.
        """
        self._dataset = dataset
        self._factor = dataset["copy_stiffness"].values[:, None]
        self.points = dataset.sizes["point"]  #: number of points of a copy

    @property
    def steady(self) -> bool:
        """Whether the stress of steady rotation is part of the result."""
        return "steady_stress" in self._dataset

    @cached_property
    def _modes(self) -> Array:
        """Terms of the points for unit modal coordinates, (5 points, modes)."""
        shape = self._dataset["stress_shape"].values
        terms = np.einsum("kc,pcm->pkm", VON_MISES, shape)
        return np.asarray(terms.reshape(-1, shape.shape[-1]))

    @cached_property
    def _forces(self) -> Array:
        """Terms by unit contact forces, (distances, 5 points of a sector, 3 nodes of a sector)."""
        given = self._dataset["stress_by_force"].values
        terms = np.einsum("kc,dpcni->dpkni", VON_MISES, given)
        return np.asarray(terms.reshape(len(terms), terms.shape[1] * len(VON_MISES), -1))

    @cached_property
    def _forces_of_waves(self) -> NDArray[np.complex128]:
        """Terms by unit waves of contact forces over the sectors, (nodal diameters, 3 nodes of a
        sector, 5 points of a sector)."""
        waves = np.fft.rfft(self._forces, axis=0)
        return np.ascontiguousarray(np.swapaxes(waves, 1, 2))

    @cached_property
    def _steady(self) -> Array | float:
        """Terms by steady rotation, (5 points,); 0 if they are not part of the result."""
        if not self.steady:
            return 0.0
        return np.asarray((self._dataset["steady_stress"].values @ VON_MISES.T).ravel())

    def terms(self, motion: Array, force: Array) -> Array:
        """Return the five terms [Pa], (record, point, 5), of one copy after another, for modal
        coordinates (record, mode) and contact forces (record, node, direction)."""
        count = len(motion)
        motion = self._factor * motion.reshape(count, self._dataset.sizes["copy"], -1)
        terms = motion.reshape(-1, motion.shape[2]) @ self._modes.T  # one product of matrices
        force = force.reshape(count, -1, self._forces.shape[2])
        of_sectors = terms.reshape(count, force.shape[1], -1)
        pushed = np.flatnonzero(force.any(axis=(1, 2)))
        of_sectors[pushed] += self._by_forces(force[pushed])
        terms += self._steady
        return np.asarray(terms.reshape(count, -1, len(VON_MISES)))

    def _by_forces(self, force: Array) -> Array:
        """Return terms by contact forces, (record, sector, 5 points of a sector), for forces
        (record, sector, 3 nodes of a sector). What a sector does to the one that is a number of
        sectors ahead depends on this number only, so that waves over the sectors do not mix."""
        distances = len(self._forces)
        if distances == 1:
            return np.asarray(force @ self._forces[0].T)
        waves = np.moveaxis(np.fft.rfft(force, axis=1), 1, 0) @ self._forces_of_waves
        return np.asarray(np.moveaxis(np.fft.irfft(waves, distances, axis=0), 0, 1))

    def terms_at(self, records: IntArray) -> Array:
        """Return the five terms [Pa] at records, see `terms`."""
        motion = history(self._dataset, "rotor_displacement", records)
        name = EVERY_FORCE if EVERY_FORCE in self._dataset else "contact_force"
        return self.terms(motion, history(self._dataset, name, records))

    def at(self, records: IntArray, terms: Array | None = None) -> Array:
        """Return the von Mises stress [Pa], (record, point), of one copy after another; zero for
        lost blades. `terms` are those of these records, if they are known."""
        stress = size_of(self.terms_at(records) if terms is None else terms)
        lost = lost_blades(self._dataset)
        if lost is not None:
            gone = np.flatnonzero(lost.gone(self._dataset["time"].values[records]))
            of_copies = stress.reshape(len(records), -1, self.points)
            of_copies[np.ix_(gone, lost.blades)] = 0.0
        return stress

    def on_sides(self, records: IntArray) -> Array:
        """Return the von Mises stress [Pa], (record, point, 1), computed in portions."""
        portions = np.array_split(records, -(-len(records) // self.together))
        return np.concatenate([self.at(portion) for portion in portions])[..., None]

    @property
    def together(self) -> int:
        """Number of records whose terms are computed together; at least 1."""
        each = 8 * len(VON_MISES) * self.points * self._dataset.sizes["copy"]
        return max(1, int(MOST_BYTES / each))


def size_of(terms: Array) -> Array:
    """Return the von Mises stress (...,) of five terms (..., 5) [Pa]."""
    return np.asarray(np.sqrt(np.einsum("...k,...k->...", terms, terms)))


def on_sectors(by_force: Array, places: IntArray) -> Array:
    """Return values at places of a copy by contact forces on each sector of it, (places, sectors,
    ...), from values by the number of sectors from the force to the place, (sectors, places of a
    sector, ...)."""
    sector, place = np.divmod(places, by_force.shape[1])
    distance = (sector[:, None] - np.arange(len(by_force))) % len(by_force)
    return np.asarray(by_force[distance, place[:, None]])


def gauge_row(dataset: xr.Dataset, point: int, direction: Array) -> tuple[IntArray, Array, Array]:
    """Return the points of a result that have a number in the file, and the strain in a direction
    at each of them for unit modal coordinates [kg^-1/2/m], (points, modes), and by unit contact
    forces on the copy without their part in the modes [1/N], (points, 3 * nodes of a copy).

    The strain follows from the stress s by the law of Hooke, ((1 + nu) n s n - nu tr s) / E for the
    unit vector n.

    Args:
        dataset: result of a superelement.
        point: number of the point in the file.
        direction: direction of the gauge in the axes of the file, (3,).

    Raises:
        ViewError: the file gives no stresses or no material, or has no such point.
    """
    if not has_stresses(dataset) or "point_young_modulus" not in dataset:
        expected = "another sensor, or a file with stress_recovery, young_modulus and poisson_ratio"
        raise ViewError(Fault(expected=expected))
    number = dataset["point_number"].values
    places = np.flatnonzero(number == point)
    if not len(places):
        raise ViewError(Fault(expected=f"a point of the file, from 0 to {number.max()}"))
    shape = dataset["stress_shape"].values[places]
    pushed = np.moveaxis(on_sectors(dataset["stress_by_force"].values, places), 1, 2)
    stress = np.concatenate([shape, pushed.reshape(*shape.shape[:2], -1)], axis=2)
    unit = direction / np.linalg.norm(direction)
    twice = np.where(np.arange(6) < 3, 1.0, 2.0)  # shear stresses count twice
    along = twice * unit[PRODUCTS[0]] * unit[PRODUCTS[1]]
    ratio = dataset["point_poisson_ratio"].values[places, None]
    modulus = dataset["point_young_modulus"].values[places, None]
    trace = stress[:, :3].sum(axis=1)
    strain = (1.0 + ratio) * np.einsum("c,pcm->pm", along, stress) - ratio * trace
    modal, by_force = np.split(strain / modulus, [shape.shape[2]], axis=1)
    return places, modal, by_force

"""The modes of a stage that springs between rotor and casing couple, with their amplitudes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray, IntArray
from bladewhirl.meshes.ring_mesh import U, W
from bladewhirl.models.case.shaft import Effects
from bladewhirl.models.coupling.springs import CouplingModes, CouplingSprings
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.casing import CasingModel
from bladewhirl.models.elements.cyclic import is_pair, wave_parts
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.models.modal.modes import ModeTable
from bladewhirl.models.rotation.matrices import RotationMatrices

FAMILIES = tuple(f"{rank}F" for rank in range(1, 6))
"""Families of the bladed disk that are coupled, besides the suspension pair."""

RADIAL_SHARE = 1.0 / 3.0
"""Least share of radial motion in a radial mode. Bending modes of a ring with k nodal diameters
have k^2 / (1 + k^2), so a half for k = 1; modes that stretch it have 1 / (1 + k^2)."""

SMALLEST_AMPLITUDE = 1e-9
"""Modes with a smaller share of the largest radial amplitude of their body are not coupled."""

ROUNDING = 1e-9
"""Share of a matrix below which the part that a mirror symmetry forbids is rounding."""

Fields = Callable[[IntArray], FloatArray]


@dataclass(frozen=True, kw_only=True)
class CoupledEntries:
    """Coupled modes of two bodies, in ascending nodal diameter, the casing's first."""

    modes: CouplingModes  #: with physical amplitudes: of w, and at the tips, per unit coordinate
    family: tuple[str, ...]  #: "casing", "suspension", "1F" to "5F", (entries,)
    number: IntArray  #: of each entry's mode among those of its body; a sine follows, (entries,)

    @property
    def radial(self) -> dict[int, IntArray]:
        """Numbers of the casing's coupled modes by nodal diameter."""
        return {
            int(self.modes.nodal_diameter[i]): self.number[i] + np.arange(1 + self.modes.paired[i])
            for i in np.flatnonzero(self.modes.on_casing)
        }

    def among(self, on_rotor: IntArray, on_casing: IntArray) -> IntArray:
        """Positions of the entries whose modes have these numbers on their bodies."""
        there = np.isin(self.number, on_rotor), np.isin(self.number, on_casing)
        return np.flatnonzero(np.where(self.modes.on_casing, there[1], there[0]))

    def take(self, chosen: IntArray) -> Self:
        """Keep some entries, by positions."""
        return replace(
            self,
            modes=self.modes.take(chosen),
            family=tuple(self.family[i] for i in chosen),
            number=self.number[chosen],
        )

    def with_unit_amplitudes(self) -> Self:
        """Give every mode amplitude one, as the paper does."""
        return replace(self, modes=self.modes.with_unit_amplitudes())

    def springs(self, kappa: float, *, with_pi: bool = True) -> CouplingSprings:
        """Springs of stiffness kappa [N/m] that couple these modes."""
        return CouplingSprings(modes=self.modes, number=self.number, kappa=kappa, with_pi=with_pi)

    def mode_numbers(self, *, on_casing: bool) -> tuple[IntArray, IntArray]:
        """Coordinates that belong to one body, and the numbers of their modes on it."""
        coordinates = np.flatnonzero(self.modes.on_casing[self.modes.entry] == on_casing)
        return coordinates, (self.number[self.modes.entry] + self.modes.is_sine)[coordinates]

    def find(self, family: str, k: int | None = None) -> IntArray:
        """Positions of the entries of a family, of one nodal diameter or of all."""
        here = np.array([name == family for name in self.family], dtype=np.bool_)
        if k is not None:
            here &= self.modes.nodal_diameter == k
        return np.flatnonzero(here)

    def six_modes(self) -> Self:
        """Keep the paper's system: k = 1 of casing, 1F and suspension, in this order (Eqs 4-9).

        Raises:
            ValueError: one of them is missing, as the suspension pair is with a clamped centre.
        """
        chosen = [self.find(family, 1) for family in ("casing", "1F", "suspension")]
        for family, numbers in zip(("casing", "1F", "suspension"), chosen, strict=True):
            if len(numbers) != 1:
                raise ValueError(f"the stage has no {family} pair with one nodal diameter")
        return self.take(np.concatenate(chosen))


@dataclass(frozen=True, kw_only=True)
class StageModes(CoupledEntries):
    """Coupled modes of a full stage."""

    modal: ModalStage  #: finite elements and all modes of both bodies


def stage_modes(modal: ModalStage, *, damping_ratio: float) -> StageModes:
    """Collect the modes of a full stage that the springs couple; see `coupled_entries`.

    Args:
        modal: finite element models with all their modes.
        damping_ratio: of every mode.

    Raises:
        ValueError: modes without nodal diameter: the stage has no cyclic symmetry.
    """
    disk, wall = modal.disk_modes, modal.casing_modes
    coupled = coupled_entries(
        tip_motion(modal.disk, disk, disk.family, disk.fields),
        wall_motion(modal.casing, wall, wall.family, wall.fields),
        damping_ratio=damping_ratio,
    )
    return StageModes(
        modes=coupled.modes, family=coupled.family, number=coupled.number, modal=modal
    )


def at_speed(stage: StageModes, matrices: RotationMatrices, effects: Effects) -> StageModes:
    """Return the modes at rest with the rotation matrices of the rotor.

    Args:
        stage: coupled modes at rest.
        matrices: of its bladed disk.
        effects: that count, not none.
    """
    modes = stage.modes
    coordinates, numbers = stage.mode_numbers(on_casing=False)
    fields = stage.modal.disk_modes.fields(numbers)
    among = np.ix_(coordinates, coordinates)
    coriolis, softening = np.zeros((2, modes.size, modes.size))
    if effects == "full":
        coriolis[among] = fields.T @ (matrices.coriolis @ fields)
    softening[among] = fields.T @ ((matrices.geometric - matrices.mass) @ fields)
    mirrored = modes.is_sine[:, None] == modes.is_sine
    for matrix, forbidden in ((coriolis, mirrored), (softening, ~mirrored)):
        if np.abs(matrix[forbidden]).max() <= ROUNDING * np.abs(matrix).max():
            matrix[forbidden] = 0.0  # the disk is its own mirror image
    return replace(stage, modes=replace(modes, coriolis=coriolis, softening=softening))


@dataclass(frozen=True, kw_only=True)
class RadialModes:
    """Radial motion of the modes of one body at the springs."""

    frequency: FloatArray  #: [rad/s], (modes,)
    nodal_diameter: IntArray  #: (modes,)
    column: IntArray  #: DFT column of each mode, (modes,); -1 without symmetry
    family: tuple[str, ...]  #: of each mode
    angles: FloatArray  #: of tips or nodes, equally spaced [rad], (points,)
    motion: Callable[[IntArray], tuple[FloatArray, FloatArray]]
    """Radial and tangential displacement at these points of modes by number [kg^-1/2],
    (points, chosen) each."""

    @property
    def is_cyclic(self) -> bool:
        """Whether each mode has one nodal diameter."""
        return bool(np.all(self.column >= 0))

    def amplitudes(
        self, selected: Sequence[bool] | BoolArray, *, radial_only: bool = False
    ) -> dict[int, float]:
        """Return the non-zero radial amplitudes of selected modes by number, without sines of
        pairs.

        Args:
            selected: which modes, (modes,).
            radial_only: leave out modes that are not radial, see `is_radial`.
        """
        one_a_pair = (self.column % 2 != 0) | (self.column == 0)
        numbers = np.flatnonzero(one_a_pair & np.asarray(selected, dtype=np.bool_))
        outward, along = self.motion(numbers)
        values = wave_amplitudes(outward, self.angles, self.nodal_diameter[numbers])
        moving = np.abs(values) > SMALLEST_AMPLITUDE * np.abs(values).max(initial=0.0)
        if radial_only:
            moving &= is_radial(outward, along)
        return dict(zip(numbers[moving].tolist(), values[moving].tolist(), strict=True))


def coupled_entries(
    rotor: RadialModes, casing: RadialModes, *, damping_ratio: float
) -> CoupledEntries:
    """Find the modes that the springs couple: those with radial motion at the springs.

    Of the bladed disk these are the suspension pair and `FAMILIES`; of the casing the lowest
    radial one of each nodal diameter that the bladed disk has too, see `lowest_radial`. On both
    the springs see the part of the radial displacement that follows cos k theta, sampled at the
    tips or nodes.

    Args:
        rotor: modes of the bladed disk, ascending.
        casing: modes of the casing, ascending.
        damping_ratio: of every mode.

    Raises:
        ValueError: modes without nodal diameter: the stage has no cyclic symmetry.
    """
    if not (rotor.is_cyclic and casing.is_cyclic):
        raise ValueError("coupling by nodal diameter needs a stage with cyclic symmetry")
    blades, elements = len(rotor.angles), len(casing.angles)
    coupled = {"suspension", *FAMILIES}
    tips = rotor.amplitudes([name in coupled for name in rotor.family])
    lowest = lowest_radial(casing)
    entries: list[tuple[int, bool, int, float]] = []  # nodal diameter, on rotor, number, amplitude
    for k in sorted({int(rotor.nodal_diameter[number]) for number in tips}):
        if k in lowest:
            entries.append((k, False, *lowest[k]))
        entries += [
            (k, True, number, tips[number]) for number in tips if rotor.nodal_diameter[number] == k
        ]
    family = tuple(rotor.family[n] if on_rotor else "casing" for _, on_rotor, n, _ in entries)
    modes = CouplingModes(
        name=tuple(
            name if name == "suspension" else f"{name} k={k}"
            for name, (k, _, _, _) in zip(family, entries, strict=True)
        ),
        on_casing=np.array([not on_rotor for _, on_rotor, _, _ in entries], dtype=np.bool_),
        nodal_diameter=np.array([k for k, _, _, _ in entries], dtype=np.int64),
        frequency=np.array(
            [
                (rotor if on_rotor else casing).frequency[number]
                for _, on_rotor, number, _ in entries
            ]
        ),
        amplitude=np.array([amplitude for _, _, _, amplitude in entries]),
        damping_ratio=np.full(len(entries), damping_ratio),
        paired=np.array(
            [is_pair(k, blades if on_rotor else elements) for k, on_rotor, _, _ in entries],
            dtype=np.bool_,
        ),
    )
    numbers = np.array([number for _, _, number, _ in entries], dtype=np.int64)
    return CoupledEntries(modes=modes, family=family, number=numbers)


def tip_motion(
    disk: BladedDiskModel, modes: ModeTable, family: tuple[str, ...], fields: Fields
) -> RadialModes:
    """Return the radial motion of the tips in modes of a bladed disk, full or reduced.

    Args:
        disk: the finite element model.
        modes: their numbers.
        family: of each, (modes,).
        fields: of modes by number, on the free degrees of freedom, (size, chosen).
    """

    def motion(chosen: IntArray) -> tuple[FloatArray, FloatArray]:
        field = fields(chosen)
        return field[disk.tip_radial], field[disk.tip_tangential]

    return RadialModes(
        frequency=modes.frequency,
        nodal_diameter=modes.nodal_diameter,
        column=disk.blade_columns(modes.column),
        family=family,
        angles=disk.tip_angles - disk.tip_angles[0],
        motion=motion,
    )


def wall_motion(
    casing: CasingModel, modes: ModeTable, family: tuple[str, ...], fields: Fields
) -> RadialModes:
    """Return the radial motion of the wall in modes of a casing; see `tip_motion`."""

    def motion(chosen: IntArray) -> tuple[FloatArray, FloatArray]:
        nodal = casing.nodal(fields(chosen))
        return nodal[:, W], nodal[:, U]

    return RadialModes(
        frequency=modes.frequency,
        nodal_diameter=modes.nodal_diameter,
        column=modes.column,
        family=family,
        angles=casing.mesh.angles,
        motion=motion,
    )


def lowest_radial(casing: RadialModes) -> dict[int, tuple[int, float]]:
    """Number and amplitude of the lowest radial mode of each nodal diameter of a cyclic casing.

    Nodal diameters are below half the number of elements; of a pair it is the cosine.
    """
    below = 2 * casing.nodal_diameter < len(casing.angles)
    lowest: dict[int, tuple[int, float]] = {}
    for number, amplitude in casing.amplitudes(below, radial_only=True).items():  # ascending
        lowest.setdefault(int(casing.nodal_diameter[number]), (number, amplitude))
    return lowest


def is_radial(outward: FloatArray, along: FloatArray) -> BoolArray:
    """Return which casing modes are radial: springs couple them, and a distortion excites them.

    Args:
        outward: w at the nodes, (nodes, modes).
        along: u at the nodes, (nodes, modes).
    """
    radial, tangential = np.sum(outward**2, axis=0), np.sum(along**2, axis=0)
    return np.asarray(radial >= RADIAL_SHARE * (radial + tangential))


def wave_amplitudes(field: FloatArray, angle: FloatArray, k: IntArray) -> FloatArray:
    """Amplitude of cos k theta in each column of a field at equally spaced angles, (fields,).

    Args:
        field: (angles, fields).
        angle: [rad], (angles,).
        k: nodal diameter of each column, (fields,).
    """
    amplitude = np.zeros(len(k))
    for harmonic in np.unique(k):
        here = k == harmonic
        amplitude[here] = wave_parts(field[:, here], angle, np.array([harmonic]))[0, 0]
    return amplitude

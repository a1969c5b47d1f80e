"""The modes of a stage that springs between rotor and casing couple, with their amplitudes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bladewhirl.models.bladed_disk import BladedDisk
from bladewhirl.models.casing import Casing
from bladewhirl.models.coupling import BoolArray, CouplingModes, FloatArray, IntArray
from bladewhirl.models.cyclic import is_pair
from bladewhirl.models.modes import Modes, families

FAMILIES = tuple(f"{rank}F" for rank in range(1, 6))
"""Families of the bladed disk that are coupled, besides the suspension pair."""

SMALLEST_AMPLITUDE = 1e-9
"""Modes with a smaller share of the largest radial amplitude of their body are not coupled."""


@dataclass(frozen=True, kw_only=True)
class StageModes:
    """Coupled modes of a stage, in ascending nodal diameter, the casing's first."""

    modes: CouplingModes  #: with physical amplitudes: of w, and at the tips, per unit coordinate
    family: tuple[str, ...]  #: "casing", "suspension", "1F" to "5F", (entries,)
    number: IntArray  #: of each entry's mode among those of its body; a sine follows, (entries,)

    def take(self, chosen: IntArray) -> StageModes:
        """Keep some entries, by positions."""
        return StageModes(
            modes=self.modes.take(chosen),
            family=tuple(self.family[i] for i in chosen),
            number=self.number[chosen],
        )

    def with_unit_amplitudes(self) -> StageModes:
        """Give every mode amplitude one, as the paper does."""
        ones = np.ones(self.modes.entries)
        return replace(self, modes=replace(self.modes, amplitude=ones))

    def find(self, family: str, k: int | None = None) -> IntArray:
        """Positions of the entries of a family, of one nodal diameter or of all."""
        here = np.array([name == family for name in self.family], dtype=np.bool_)
        if k is not None:
            here &= self.modes.nodal_diameter == k
        return np.flatnonzero(here)

    def six_modes(self) -> StageModes:
        """Keep the paper's system: k = 1 of casing, 1F and suspension, in this order (Eqs 4-9).

        Raises:
            ValueError: one of them is missing, as the suspension pair is with a clamped centre.
        """
        chosen = [self.find(family, 1) for family in ("casing", "1F", "suspension")]
        for family, found in zip(("casing", "1F", "suspension"), chosen, strict=True):
            if len(found) != 1:
                raise ValueError(f"the stage has no {family} pair with one nodal diameter")
        return self.take(np.concatenate(chosen))


def stage_modes(
    disk: BladedDisk,
    disk_modes: Modes,
    casing: Casing,
    casing_modes: Modes,
    *,
    damping_ratio: float,
) -> StageModes:
    """Collect the modes that the springs couple: those with radial motion at the springs.

    Of the bladed disk these are the suspension pair and `FAMILIES`; of the casing the lowest of
    each nodal diameter that the bladed disk has too, below half the number of elements. On both
    the springs see the part of the radial displacement that follows cos k theta, sampled at the
    tips or nodes.

    Args:
        disk: the bladed disk.
        disk_modes: its modes.
        casing: the casing.
        casing_modes: its modes.
        damping_ratio: of every mode.

    Raises:
        ValueError: modes without nodal diameter: the stage has no cyclic symmetry.
    """
    if not (disk_modes.is_cyclic and casing_modes.is_cyclic):
        raise ValueError("coupling by nodal diameter needs a stage with cyclic symmetry")
    radial = disk_modes.shapes[disk.tip_radial]
    disk_amplitude = wave_amplitudes(radial, disk.tip_angles, disk_modes.nodal_diameter)
    wall = casing.nodal(casing_modes.shapes)[:, 0]
    casing_amplitude = wave_amplitudes(wall, casing.mesh.angles, casing_modes.nodal_diameter)

    labels = families(disk_modes, "bladed-disk")
    found: list[tuple[int, bool, int, str]] = []  # nodal diameter, on the rotor, number, family
    for k in range(min(disk_modes.sectors // 2, (casing_modes.sectors - 1) // 2) + 1):
        wall_waves = _first_waves(casing_modes, casing_amplitude, k)[:1]
        disk_waves = [
            (k, True, int(number), labels[number])
            for number in _first_waves(disk_modes, disk_amplitude, k)
            if labels[number] in ("suspension", *FAMILIES)
        ]
        if disk_waves:
            found += [(k, False, int(number), "casing") for number in wall_waves]
            found += disk_waves

    on_rotor = np.array([rotor for _, rotor, _, _ in found], dtype=np.bool_)
    number = np.array([n for _, _, n, _ in found], dtype=np.int64)
    return StageModes(
        modes=CouplingModes(
            name=tuple(_name(family, k) for k, _, _, family in found),
            on_casing=~on_rotor,
            nodal_diameter=np.array([k for k, _, _, _ in found], dtype=np.int64),
            frequency=_either(on_rotor, number, disk_modes.frequency, casing_modes.frequency),
            amplitude=_either(on_rotor, number, disk_amplitude, casing_amplitude),
            damping_ratio=np.full(len(found), damping_ratio),
            paired=np.array(
                [
                    is_pair(k, disk_modes.sectors if rotor else casing_modes.sectors)
                    for k, rotor, _, _ in found
                ],
                dtype=np.bool_,
            ),
        ),
        family=tuple(family for _, _, _, family in found),
        number=number,
    )


def wave_amplitudes(field: FloatArray, angle: FloatArray, k: IntArray) -> FloatArray:
    """Amplitude of cos k theta in each column of a field at equally spaced angles, (fields,).

    Args:
        field: (angles, fields).
        angle: [rad], (angles,).
        k: nodal diameter of each column, (fields,).
    """
    count = len(angle)
    waves = np.cos(np.multiply.outer(angle, k))
    share = np.where((k == 0) | (2 * k == count), 1.0, 2.0) / count
    return np.asarray(share * np.sum(field * waves, axis=0))


def _first_waves(modes: Modes, amplitude: FloatArray, k: int) -> IntArray:
    """Cosine (or only) modes of nodal diameter k with a radial amplitude, ascending."""
    column = 0 if k == 0 else 2 * k - 1
    moving = np.abs(amplitude) > SMALLEST_AMPLITUDE * np.abs(amplitude).max()
    return np.flatnonzero((modes.column == column) & moving)


def _either(
    on_rotor: BoolArray, number: IntArray, rotor: FloatArray, casing: FloatArray
) -> FloatArray:
    return np.array([(rotor if on else casing)[n] for on, n in zip(on_rotor, number, strict=True)])


def _name(family: str, k: int) -> str:
    return family if family == "suspension" else f"{family} k={k}"

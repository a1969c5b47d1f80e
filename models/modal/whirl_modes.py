"""Modes of a bladed disk with Coriolis forces: complex fields that travel forward or backward.

A field p exp(i (k n alpha + w t)) over the sectors n solves

    (-w^2 M + i w 2 Omega G + K_Omega) p = 0

for each nodal diameter k. If K_Omega is positive definite, w is real. A field with w > 0 travels
backward, a field with w < 0 forward. If K_Omega is indefinite, only Coriolis forces keep the motion
bounded.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from bladewhirl.meshes.line_mesh import BoolArray, ComplexArray, FloatArray, IntArray
from bladewhirl.models.elements.cyclic import NO_COLUMN, SectorLayout, is_pair
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.modal.modes import Direction, ListedModes, Modes
from bladewhirl.models.structure.eigenproblems import gyroscopic_eigen, lowest_gyroscopic_eigen
from bladewhirl.models.structure.waves import Waves, spring_shares

DENSE_SIZE = 800
"""Largest size of a structure without symmetry whose modes are computed with a dense solver."""

TRAVELS = 0.5
"""A mode travels if its shares of backward and forward waves differ by more than this."""

SLOW = 1e-6
"""A wave counts as standing if its frequency is at most this fraction of the speed of rotation."""


@dataclass(frozen=True, kw_only=True)
class WhirlModes(ListedModes):
    """Motions Re(p exp(i frequency t)) in the rotating frame, in ascending order of frequency.

    The frequency is zero if a mode grows without oscillation. Amplitudes are p, with p^H M p = 1.
    """

    REAL_FIELDS: ClassVar[int] = 2

    growth: FloatArray  #: growth rate [1/s]; zero if K_Omega is positive definite, (modes,)
    direction: tuple[Direction, ...]
    """Direction of travel in the rotating frame, "forward" towards +theta, (modes,)."""
    rank: IntArray
    """Rank of each mode, from 0, by frequency among the branches that have the same nodal diameter
    and direction of travel at rest, (modes,). These branches do not cross. -1 without symmetry."""
    backward_at_rest: BoolArray
    """True if the branch of a mode travels backward at rest, (modes,)."""

    def fields(self, chosen: IntArray) -> ComplexArray:
        """Return the fields p of the chosen modes on the free DoF, (size, chosen)."""
        return np.stack([self._field(int(mode)) for mode in chosen], axis=-1)

    def _field(self, mode: int) -> ComplexArray:
        amplitude = self.amplitudes[mode]
        if not self.has_one_wave[mode]:
            return np.asarray(amplitude, dtype=np.complex128)
        assert self.layout is not None  # its modes have a rank
        wave = self.layout.basis(int(self.nodal_diameter[mode])) @ amplitude
        return np.asarray(wave.conj() if self.goes_ahead[mode] else wave)

    @property
    def has_one_wave(self) -> BoolArray:
        return np.asarray(self.rank >= 0)

    @property
    def goes_ahead(self) -> BoolArray:
        return np.asarray(np.array(self.direction) == "forward")

    @property
    def pattern(self) -> tuple[str, ...]:
        return tuple("single" if way == "standing" else "wave" for way in self.direction)

    def drawn(self, numbers: IntArray) -> IntArray:
        return numbers

    def waves_of(self, numbers: IntArray, omega: float) -> dict[Direction, IntArray]:
        named, _ = self.named_directions(omega)
        return {named[number]: np.array([number]) for number in numbers[::-1]}  # the lowest

    def real_fields(self, fields: ComplexArray) -> FloatArray:
        """Return two real fields of each mode, Re p and -Im p: its motion is Re p cos(w t) - Im p
        sin(w t)."""
        return np.stack([fields.real, -fields.imag], axis=1).reshape(-1, *fields.shape[1:])

    def expand(self, chosen: IntArray) -> Modes:
        shapes = self.real_fields(self.fields(chosen).T).T
        return Modes(shapes=shapes, sectors=0, **self.numbers(np.repeat(chosen, 2)))

    def static_frequency(self, omega: float) -> FloatArray:
        """Return the frequency of each mode in the static frame [rad/s], (modes,), positive for
        backward waves. Standing modes keep their frequency in the rotating frame.

        Args:
            omega: speed of rotation [rad/s].
        """
        signs = {"backward": 1.0, "forward": -1.0, "standing": 0.0}
        sign = np.array([signs[way] for way in self.direction])
        moved = sign * self.frequency - self.nodal_diameter * omega
        return np.where(sign == 0.0, self.frequency, moved)

    def named_directions(
        self, omega: float, *, fixed: bool = False
    ) -> tuple[tuple[Direction, ...], tuple[Direction, ...]]:
        names = np.array(self.direction)
        signed = self.static_frequency(omega)
        static = directions(np.where(names == "standing", 0.0, signed), omega)
        return in_sense_of_rotation(self.direction, omega), in_sense_of_rotation(static, omega)


def directions(signed: FloatArray, omega: float) -> tuple[Direction, ...]:
    """Return the direction of each wave, given by the sign of its frequency.

    Args:
        signed: frequencies, positive for backward, negative for forward waves [rad/s], (modes,).
        omega: speed of rotation [rad/s]; waves with a frequency of at most `SLOW` times this speed
            are standing.
    """
    return tuple(
        "standing" if abs(w) <= SLOW * abs(omega) else ("backward" if w > 0.0 else "forward")
        for w in signed
    )


def in_sense_of_rotation(ways: Sequence[Direction], omega: float) -> tuple[Direction, ...]:
    """Return directions towards +theta or -theta as directions with or against the rotation."""
    opposite: dict[Direction, Direction] = {"forward": "backward", "backward": "forward"}
    return tuple(opposite.get(way, way) if omega < 0.0 else way for way in ways)


def whirl_modes(structure: Structure, count: int | None = None) -> WhirlModes:
    """Return the modes of a rotating structure, including any Coriolis forces.

    Args:
        structure: structure linearised about the state of steady rotation.
        count: number of the lowest modes; all if None, which takes a minute for a thousand degrees
            of freedom without symmetry.
    """
    layout, omega = structure.layout, structure.speed or 0.0
    if layout is None or not structure.is_cyclic:
        modes = _plain_modes(structure, count)
    else:
        each = (wave_modes(wave, omega, layout.sectors, layout) for wave in structure.waves())
        modes = joined_modes(list(each))
    return modes.take(np.argsort(modes.frequency, kind="stable")[:count])


def wave_modes(
    wave: Waves, omega: float, sectors: int, layout: SectorLayout | None = None
) -> WhirlModes:
    """Return the modes of one nodal diameter at a speed [rad/s].

    Args:
        wave: matrices of the nodal diameter.
        omega: speed of rotation [rad/s].
        sectors: number of sectors.
        layout: degrees of freedom of the sectors; None if fields of all sectors are not needed.
    """
    w, vectors = gyroscopic_eigen(
        wave.mass, wave.stiffness_at(omega), omega * wave.known("gyroscopic")
    )
    size, k = wave.size, wave.nodal_diameter
    rank = np.concatenate([np.arange(size)[::-1], np.arange(size)])  # w descends
    backward = np.repeat([True, False], size)
    ways: list[Direction] = ["backward" if each > 0.0 else "forward" for each in w.real]
    if not is_pair(k, sectors):  # w and -w describe the same motion
        w, vectors, rank, ways = w[:size], vectors[:, :size], rank[:size], ["standing"] * size
        backward = backward[:size]
    return WhirlModes(
        frequency=np.abs(w.real),
        column=np.full(len(w), NO_COLUMN),
        growth=-w.imag,
        nodal_diameter=np.full(len(w), k),
        purity=np.ones(len(w)),
        spring_share=wave.shares(vectors),
        direction=tuple(ways),
        rank=rank,
        backward_at_rest=backward,
        amplitudes=tuple(vectors.T),
        layout=layout,
    )


def _plain_modes(structure: Structure, count: int | None) -> WhirlModes:
    """Return the modes of a structure without symmetry; w and -w describe the same motion."""
    matrices = structure.mass, structure.stiffness, structure.drag(structure.speed or 0.0)
    if count is None or structure.size <= DENSE_SIZE:
        w, vectors = gyroscopic_eigen(*(matrix.toarray() for matrix in matrices))
    else:
        w, vectors = lowest_gyroscopic_eigen(*matrices, 2 * min(count + 1, structure.size - 2))
    kept = slice(0, len(w) // 2)
    w, vectors = w[kept], vectors[:, kept]
    diameter, purity = np.full(len(w), NO_COLUMN), np.zeros(len(w))
    ways: list[Direction] = ["standing"] * len(w)
    if structure.layout is not None:
        diameter, purity, ways = travelling(vectors, structure.mass.diagonal(), structure.layout)
    return WhirlModes(
        frequency=np.abs(w.real),
        column=np.full(len(w), NO_COLUMN),
        growth=-w.imag,
        nodal_diameter=diameter,
        purity=purity,
        spring_share=spring_shares(vectors, structure.springs, structure.elastic),
        direction=tuple(ways),
        rank=np.full(len(w), NO_COLUMN),
        backward_at_rest=np.full(len(w), True),
        amplitudes=tuple(vectors.T),
        layout=structure.layout,
    )


def travelling(
    fields: ComplexArray, weights: FloatArray, layout: SectorLayout
) -> tuple[IntArray, FloatArray, list[Direction]]:
    """Return the dominant nodal diameter of each field, its share, and the direction of travel.

    If sectors differ, a mode contains waves in both directions. The mode counts as standing if
    neither direction prevails.

    Args:
        fields: p of Re(p exp(i w t)), w positive, (size, modes).
        weights: weight of each degree of freedom, the diagonal of the mass matrix, (size,).
        layout: sectors of the structure.
    """
    count = layout.sectors
    spectrum = np.fft.fft(fields[layout.sector_dofs], axis=0, norm="ortho")
    power = np.einsum("nim,i->nm", np.abs(spectrum) ** 2, weights[layout.sector_dofs[0]])
    x, y, _ = layout.centre_dofs
    if x >= 0:  # a motion of the centre along (1, i) or (1, -i) has nodal diameter 1
        for wave, sign in ((1, -1j), (count - 1, 1j)):
            power[wave] += weights[x] * np.abs(fields[x] + sign * fields[y]) ** 2 / 2.0
    half = np.arange(count // 2 + 1)
    backward, forward = power[half], power[-half]
    single = ~np.array([is_pair(int(k), count) for k in half])
    forward[single] = backward[single]
    energy = np.where(single[:, None], backward, backward + forward)
    diameter = energy.argmax(axis=0)
    modes = np.arange(fields.shape[1])
    excess = (backward - forward)[diameter, modes] / energy[diameter, modes]
    return (
        diameter,
        energy[diameter, modes] / energy.sum(axis=0),
        [
            "standing" if abs(share) <= TRAVELS else ("backward" if share > 0.0 else "forward")
            for share in excess
        ],
    )


def joined_modes(parts: Sequence[WhirlModes]) -> WhirlModes:
    """Return the modes of all parts in one object, one part after the other."""
    joined: dict[str, Any] = {}
    for name, first in vars(parts[0]).items():
        values = [vars(part)[name] for part in parts]
        if name != "layout":
            joined[name] = sum(values, ()) if isinstance(first, tuple) else np.concatenate(values)
    return replace(parts[0], **joined)

"""Frequencies and labels of all modes of a structure; shapes are computed when needed.

On a cyclic structure every mode is stored as complex amplitudes in one sector. All modes of
hundreds of blades then fit in memory, and the suspension pair is chosen from all modes, not only
from the modes that are shown.

The labels of a structure with unequal sectors follow from its *tuned twin*, a cyclic structure
whose sectors are the mean of all sectors. Each mode is expanded in the modes of the twin. The mode
gets the family with the largest share in this expansion. The mode gets the nodal diameter with the
largest mass-weighted share in its motion; this share is called the purity of the mode.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import BoolArray, ComplexArray, FloatArray, IntArray
from bladewhirl.models.elements.cyclic import NO_COLUMN, is_pair
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.inputs.mode_names import NamedModes
from bladewhirl.models.modal.modes import (
    Direction,
    ListedModes,
    Modes,
    ModeTable,
    align_phase,
    constrained_eigh,
    families,
    is_first_of_pair,
    plain_modes,
)
from bladewhirl.models.modal.whirl_modes import WhirlModes, directions

Body = Literal["bladed-disk", "casing"]

MOST = 0.5
"""A branch at speed is the suspension if the shaft springs have more than this share of its strain
energy."""


@dataclass(frozen=True, kw_only=True)
class LabelledModes(ListedModes):
    """Modes without Coriolis forces; of a degenerate pair the cosine mode is first."""

    REAL_FIELDS: ClassVar[int] = 1

    size: int  #: number of free degrees of freedom of the structure

    def fields(self, chosen: IntArray) -> FloatArray:
        """Return the mass-normalised fields of the chosen modes on the free DoF, (size, chosen)."""
        found, columns = np.zeros((self.size, len(chosen))), self.column[chosen]
        for k in np.unique(self.nodal_diameter[chosen]).tolist():
            here = np.flatnonzero(self.nodal_diameter[chosen] == k)
            vectors = np.stack([self.amplitudes[i] for i in chosen[here]], axis=-1)
            if self.layout is None or not self.is_cyclic:
                found[:, here] = vectors.real
                continue
            waves, both = self.layout.real_shapes(k, vectors.astype(np.complex128))
            each = len(both) // len(here)  # 2 for a cosine and a sine
            sine = (each == 2) & (columns[here] % 2 == 0)
            found[:, here] = waves[:, each * np.arange(len(here)) + sine]
        return found

    @property
    def has_one_wave(self) -> BoolArray:
        return np.asarray(self.column >= 0)

    @property
    def goes_ahead(self) -> BoolArray:
        return np.full(self.count, False)

    @property
    def pattern(self) -> tuple[str, ...]:
        first = [is_first_of_pair(self.column, number) for number in range(self.count)]
        sine = [False, *first[:-1]]
        return tuple(
            "cosine" if one else "sine" if other else "single"
            for one, other in zip(first, sine, strict=False)
        )

    def named_directions(
        self, omega: float, *, fixed: bool = False
    ) -> tuple[tuple[Direction, ...], tuple[Direction, ...]]:
        """Return the directions of the two waves to which the modes of a degenerate pair combine in
        the frame of the body: the backward wave is listed with the cosine mode, the forward wave
        with the sine mode."""
        sign = np.array([{"cosine": 1.0, "sine": -1.0}.get(name, 0.0) for name in self.pattern])
        rotation = np.where(sign == 0.0, 0.0, self.nodal_diameter * abs(omega))
        own, rate = sign * self.frequency, abs(omega)
        rotating, static = (own + rotation, own) if fixed else (own, own - rotation)
        return directions(rotating, rate), directions(static, rate)

    def drawn(self, numbers: IntArray) -> IntArray:
        return numbers[:1]

    def waves_of(self, numbers: IntArray, omega: float) -> dict[Direction, IntArray]:
        waves: tuple[Direction, ...] = ("standing", "forward", "backward")
        return dict.fromkeys(waves if len(numbers) == 2 else waves[:1], numbers)

    def real_fields(self, fields: ComplexArray) -> FloatArray:
        return fields.real

    def expand(self, chosen: IntArray) -> Modes:
        sectors = self.layout.sectors if self.layout else 0
        return Modes(shapes=self.fields(chosen), sectors=sectors, **self.numbers(chosen))

    @property
    def named(self) -> NamedModes:
        """Families and nodal diameters of the modes, for selection by name."""
        return NamedModes(family=self.family, nodal_diameter=self.nodal_diameter)

    def one_a_pair(self) -> IntArray:
        """Return the numbers of all modes except the sine modes of pairs, ascending."""
        return np.flatnonzero((self.column % 2 != 0) | (self.column == 0))


def no_modes() -> LabelledModes:
    """Return the modes of a body that does not move."""
    none, whole = np.zeros(0), np.zeros(0, dtype=np.int64)
    return LabelledModes(
        frequency=none,
        column=whole,
        nodal_diameter=whole,
        purity=none,
        spring_share=none,
        family=(),
        amplitudes=(),
        layout=None,
        size=0,
    )


def labelled_modes(
    structure: Structure, reference: tuple[int, int], body: Body, count: int | None = None
) -> LabelledModes:
    """Return the modes of a structure with their labels.

    Args:
        structure: matrices and sectors.
        reference: positions, among the DoF of a sector, of the radial and the tangential
            displacement that fix the phase of degenerate pairs.
        body: "bladed-disk" or "casing"; the names of special families differ, see `families`.
        count: exact number of the lowest modes; all if None.
    """
    if structure.is_cyclic:
        labels = _tuned(structure, reference, body)
        return labels if count is None else labels.take(slice(count))
    modes = plain_modes(structure, count)
    family = mode_families(structure, modes, reference, body)
    return LabelledModes(
        family=family,
        at_rest=family if structure.at_rest is not None else (),
        amplitudes=tuple(modes.shapes.T),
        layout=structure.layout,
        size=structure.size,
        **modes.numbers(),
    )


def structure_modes(
    structure: Structure, reference: tuple[int, int], count: int | None = None
) -> Modes:
    """Return the lowest modes of a structure, by nodal diameter if the structure is cyclic.

    Args:
        structure: matrices and sectors.
        reference: see `labelled_modes`.
        count: number of modes, all if None. On a cyclic structure, `count` is increased by one if
            the last mode is the first of a pair.
    """
    if not structure.is_cyclic:
        return plain_modes(structure, count)
    found = _by_diameter(structure, reference)
    count = found.count if count is None else min(count, found.count)
    return found.expand(np.arange(count + is_first_of_pair(found.column, count - 1)))


def mode_families(
    structure: Structure, modes: Modes, reference: tuple[int, int], body: Body
) -> tuple[str, ...]:
    """Return the family of each mode.

    The family follows from the tuned twin if sectors differ, otherwise from the rank of the mode.

    Args:
        structure: structure of the modes.
        modes: modes of the full or a reduced model, with fields on the free DoF of the structure.
        reference: see `labelled_modes`.
        body: see `labelled_modes`.
    """
    if modes.is_cyclic or structure.layout is None:
        return _names(structure, modes, reference, body)[0]
    return _families_of_twin(structure, modes, _tuned(structure, reference, body))


def families_at_speed(names: list[str], shares: FloatArray) -> list[str]:
    """Return the families of the branches of one nodal diameter and one direction at a speed.

    The branch with more than half of its strain energy in the shaft springs is the suspension, and
    the remaining families keep their order. Without such a branch the names at rest are kept.

    Args:
        names: families of the branches at rest, by rank.
        shares: share of the shaft springs in the strain energy at the speed, by rank, (branches,).
    """
    most = int(np.argmax(shares))
    if "suspension" not in names or shares[most] <= MOST:
        return names
    others = [name for name in names if name != "suspension"]
    return [*others[:most], "suspension", *others[most:]]


def _names(
    structure: Structure, modes: ModeTable, reference: tuple[int, int], body: Body
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the families of modes, and the families of the same branches at rest.

    The structure of the modes has equal sectors, or none. Modes of a rotating structure have the
    rank of modes at rest, because the frequencies of one nodal diameter do not cross as the speed
    changes.
    """
    if structure.at_rest is None:
        sectors = structure.layout.sectors if structure.layout else 0
        names = tuple(families(modes, body, sectors))
        return names, names
    at_rest = labelled_modes(structure.at_rest, reference, body)
    if structure.layout is not None and not structure.at_rest.is_cyclic:
        at_rest = _tuned(structure.at_rest, reference, body)
    return named_at_speed(modes, at_rest)


def named_at_speed(
    modes: ModeTable, at_rest: LabelledModes
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the families of modes at a speed, and the families of the same branches at rest, by
    the ranks of the modes of each DFT column; see `families_at_speed`."""
    family, before = [""] * modes.count, [""] * modes.count
    for column in np.unique(modes.column).tolist():
        ranked = [at_rest.family[i] for i in np.flatnonzero(at_rest.column == column)]
        here = np.flatnonzero(modes.column == column)
        named = families_at_speed(ranked[: len(here)], modes.spring_share[here])
        for mode, now, then in zip(here.tolist(), named, ranked, strict=False):
            family[mode], before[mode] = now, then
    return tuple(family), tuple(before)


def modes_of_blocks(
    blocks: Iterable[tuple[int, FloatArray, ComplexArray, FloatArray]],
    sectors: int,
) -> LabelledModes:
    """Return the modes of all nodal diameters, ascending, without families and layout. Negative
    squared frequencies give negative frequencies.

    Args:
        blocks: nodal diameter (-1 for modes without one), squared frequencies [rad2/s2], (m,),
            amplitudes in one sector, (DoF, m), and share of the shaft springs in the strain energy,
            (m,), for each block.
        sectors: number of sectors.
    """
    squares, shares, columns, diameters, amplitudes = [], [], [], [], []
    for k, square, vectors, share in blocks:
        of_block = [NO_COLUMN]
        if k != NO_COLUMN:
            of_block = [2 * k - 1, 2 * k] if is_pair(k, sectors) else [0 if k == 0 else sectors - 1]
        squares.append(np.repeat(square, len(of_block)))
        shares.append(np.repeat(share, len(of_block)))
        columns.append(np.tile(of_block, len(square)))
        diameters.append(np.full(len(square) * len(of_block), k))
        amplitudes += [vector for vector in vectors.T for _ in of_block]
    order = np.argsort(np.concatenate(squares), kind="stable")
    square, diameter = np.concatenate(squares)[order], np.concatenate(diameters)[order]
    return LabelledModes(
        frequency=np.sign(square) * np.sqrt(np.abs(square)),
        column=np.concatenate(columns)[order],
        nodal_diameter=diameter,
        purity=np.where(diameter == NO_COLUMN, 0.0, 1.0),
        spring_share=np.concatenate(shares)[order],
        family=("",) * len(order),
        amplitudes=tuple(amplitudes[i] for i in order),
        layout=None,
        size=len(order),
    )


def _by_diameter(structure: Structure, reference: tuple[int, int]) -> LabelledModes:
    """Return all modes of a cyclic structure, or of the tuned twin of another structure, without
    families."""
    layout, omega, blocks = structure.layout, structure.speed or 0.0, []
    assert layout is not None  # both callers check this
    for wave in structure.waves():
        k = wave.nodal_diameter
        constraints = layout.basis(k).conj().T @ structure.constraints
        square, vectors = constrained_eigh(wave.stiffness_at(omega), wave.mass, constraints)
        vectors = align_phase(vectors, reference, pair=is_pair(k, layout.sectors))
        blocks.append((k, square, vectors, wave.shares(vectors)))
    found = replace(modes_of_blocks(blocks, layout.sectors), layout=layout, size=structure.size)
    if structure.at_rest is None:  # negative squares are rounding errors
        found = replace(found, frequency=np.maximum(found.frequency, 0.0))
    return found


def _tuned(structure: Structure, reference: tuple[int, int], body: Body) -> LabelledModes:
    """Return the modes of `_by_diameter` with their families."""
    found = _by_diameter(structure, reference)
    family, at_rest = _names(structure, found, reference, body)
    return replace(found, family=family, at_rest=() if structure.at_rest is None else at_rest)


def _families_of_twin(structure: Structure, modes: Modes, twin: LabelledModes) -> tuple[str, ...]:
    """Expand each mode in the modes of the tuned twin, and return for each mode the family whose
    coefficients have the largest sum of squares."""
    layout = structure.layout
    assert layout is not None  # structures with a twin have sectors
    impulse = structure.mass @ modes.shapes
    one, parts, order = twin.one_a_pair(), [], []
    for k in np.unique(twin.nodal_diameter):
        here = one[twin.nodal_diameter[one] == k]
        vectors = np.column_stack([twin.amplitudes[i] for i in here])
        part = np.abs(vectors.conj().T @ (layout.basis(int(k)).conj().T @ impulse)) ** 2
        parts.append((2.0 if is_pair(int(k), layout.sectors) else 1.0) * part)
        order += here.tolist()
    return _largest_share(twin.family, [twin.family[i] for i in order], np.vstack(parts))


def _largest_share(
    names: tuple[str, ...], family: Sequence[str], parts: FloatArray
) -> tuple[str, ...]:
    """Return for each mode the family with the largest sum of parts, (modes,).

    Args:
        names: families in the order of preference among equal sums.
        family: family of each part, (parts,).
        parts: share of each part in each mode, (parts, modes).
    """
    names = tuple(dict.fromkeys(names))
    shares = np.zeros((len(names), parts.shape[1]))
    np.add.at(shares, [names.index(name) for name in family], parts)
    return tuple(names[i] for i in shares.argmax(axis=0))


def with_families(modes: WhirlModes, at_rest: LabelledModes, mass: sp.csr_array) -> WhirlModes:
    """Return whirling modes with their families, and the families of the same branches at rest.

    If sectors are equal, the frequencies of waves of one nodal diameter do not cross as the speed
    changes. A wave then has the rank of a mode at rest, and `families_at_speed` gives its family.
    Otherwise a mode has the family with the largest share in its expansion in the modes at rest.

    Args:
        modes: whirling modes of a rotating structure.
        at_rest: its modes at rest.
        mass: mass matrix on its free degrees of freedom, (size, size).
    """
    if modes.has_one_wave[:1].any():
        return with_wave_families(modes, at_rest)
    impulse = mass @ modes.fields(np.arange(modes.count))
    parts = np.abs(at_rest.fields(np.arange(at_rest.count)).T @ impulse) ** 2
    names = _largest_share(at_rest.family, at_rest.family, parts)
    return replace(modes, family=names, at_rest=names)


def with_wave_families(modes: WhirlModes, at_rest: LabelledModes) -> WhirlModes:
    """Return the waves of a structure with equal sectors with their families, see
    `with_families`."""
    family, before = [""] * modes.count, [""] * modes.count
    for k, names_at_rest in names_of(at_rest).items():
        for backward in (True, False):
            here = (modes.nodal_diameter == k) & (modes.backward_at_rest == backward)
            ranked = np.flatnonzero(here)[np.argsort(modes.rank[here])]
            if ranked.size:
                names_now = families_at_speed(names_at_rest, modes.spring_share[ranked])
                for mode in ranked.tolist():
                    rank = int(modes.rank[mode])
                    family[mode], before[mode] = names_now[rank], names_at_rest[rank]
    return replace(modes, family=tuple(family), at_rest=tuple(before))


def names_of(modes: LabelledModes) -> dict[int, list[str]]:
    """Return for each nodal diameter the families of the modes at rest, the lowest mode first, with
    one entry for both modes of a pair."""
    one, names = modes.one_a_pair(), modes.at_rest or modes.family
    return {
        int(k): [names[i] for i in one[modes.nodal_diameter[one] == k]]
        for k in np.unique(modes.nodal_diameter[one])
    }

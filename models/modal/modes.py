"""Natural modes of a structure, with nodal diameter, family and share of spring energy."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np
import scipy.linalg as la
import scipy.sparse.linalg as spla
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import BoolArray, ComplexArray, FloatArray, IntArray
from bladewhirl.models.elements.cyclic import NO_COLUMN, SectorLayout, is_pair, wave_shares
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.structure.dft import nodal_diameter_of

Direction = Literal["forward", "backward", "standing"]  #: direction in which a wave travels

DENSE_LIMIT = 3000  #: largest structure whose modes are computed by a dense solver

RIGID_SHARE = 0.99
"""A casing mode is rigid if at least this share of its strain energy is in the support."""

RIGID_FREQUENCY = 0.01
"""A casing mode is also rigid if its frequency is at most this share of the lowest frequency with
two or more nodal diameters."""


@dataclass(frozen=True, kw_only=True)
class ModeTable:
    """Properties of a set of modes without their fields, in ascending order of frequency."""

    frequency: FloatArray  #: natural frequency [rad/s], (modes,)
    column: IntArray  #: column of the real DFT over sectors, (modes,); -1 without symmetry
    nodal_diameter: IntArray  #: dominant nodal diameter of the mode, (modes,); -1 without sectors
    purity: FloatArray  #: mass-weighted share of `nodal_diameter` in the mode, (modes,)
    spring_share: FloatArray  #: share of the strain energy in the springs, (modes,)

    @property
    def count(self) -> int:
        """Number of modes."""
        return len(self.frequency)

    @property
    def is_cyclic(self) -> bool:
        """True if the modes were computed by nodal diameter."""
        return bool(np.all(self.column != NO_COLUMN))

    def numbers(self, chosen: IntArray | slice = slice(None)) -> dict[str, Any]:
        """Return the properties of the chosen modes, by name."""
        return {each.name: getattr(self, each.name)[chosen] for each in fields(ModeTable)}


@dataclass(frozen=True, kw_only=True)
class Modes(ModeTable):
    """Mass-normalised modes with their fields.

    On a cyclic structure a degenerate pair consists of a cosine and a sine mode. The radial
    reference displacement of the cosine mode is positive and largest in sector 0.
    """

    shapes: FloatArray  #: fields on the free DoF of the structure [kg^-1/2], (size, modes)
    sectors: int  #: number of sectors of the structure; 0 without sectors

    def take(self, chosen: IntArray | slice) -> "Modes":
        """Return the chosen modes."""
        return replace(self, shapes=self.shapes[:, chosen], **self.numbers(chosen))


@dataclass(frozen=True, kw_only=True)
class ListedModes(ModeTable, ABC):
    """Modes of a body with their families, as they are listed, chosen and drawn: with one real
    field each (`labels.LabelledModes`), or with Coriolis forces (`whirl_modes.WhirlModes`)."""

    REAL_FIELDS: ClassVar[int]  #: number of real fields of a mode

    family: tuple[str, ...] = ()  #: "1F", "2F", ..., "suspension", "rigid", (modes,)
    at_rest: tuple[str, ...] = ()
    """Families of the same branches at rest, (modes,); empty for a structure at rest."""
    amplitudes: tuple[ComplexArray | FloatArray, ...]
    """Complex amplitudes of each mode in one sector (see `cyclic`) [kg^-1/2]; the full field of a
    mode without symmetry."""
    layout: SectorLayout | None  #: sectors of the structure

    def find(self, family: str, nodal_diameter: int) -> IntArray:
        """Return the numbers of the modes of one family and nodal diameter, ascending."""
        named = np.array([name == family for name in self.family], dtype=np.bool_)
        return np.flatnonzero(named & (self.nodal_diameter == nodal_diameter))

    def take(self, chosen: IntArray | slice) -> Self:
        """Return the chosen modes."""
        kept, taken = np.arange(self.count)[chosen], dict[str, Any]()
        for name, values in vars(self).items():
            if isinstance(values, tuple):
                taken[name] = tuple(values[i] for i in kept if values)
            elif isinstance(values, np.ndarray):
                taken[name] = values[kept]
        return replace(self, **taken)

    @property
    @abstractmethod
    def has_one_wave(self) -> BoolArray:
        """True for each mode of a single nodal diameter, which the symmetry gives, (modes,)."""

    @property
    @abstractmethod
    def goes_ahead(self) -> BoolArray:
        """True for each mode whose field is that of exp(-i k angle), so the complex conjugate of
        the wave of its amplitudes, (modes,)."""

    @property
    @abstractmethod
    def pattern(self) -> tuple[str, ...]:
        """Pattern of each mode: "cosine" and "sine" of a pair, "wave", or "single", (modes,)."""

    @abstractmethod
    def named_directions(
        self, omega: float, *, fixed: bool = False
    ) -> tuple[tuple[Direction, ...], tuple[Direction, ...]]:
        """Return the direction of each mode in the rotating and in the static frame at a speed of
        rotation [rad/s]; forward is the sense of rotation, also for a negative speed.

        Args:
            omega: speed of rotation of the bladed disk [rad/s].
            fixed: true for modes of a body that does not rotate.
        """

    @abstractmethod
    def drawn(self, numbers: IntArray) -> IntArray:
        """Return those of the modes of one name that have shapes of their own."""

    @abstractmethod
    def waves_of(self, numbers: IntArray, omega: float) -> dict[Direction, IntArray]:
        """Return the waves that modes of one name can show at a speed [rad/s], by direction, with
        the numbers of the modes of each wave."""

    @abstractmethod
    def real_fields(self, fields: ComplexArray) -> FloatArray:
        """Return the real fields of modes with fields p of the motions Re(p exp(i w t)), mode by
        mode: (modes, ...) becomes (modes * REAL_FIELDS, ...)."""

    @abstractmethod
    def expand(self, chosen: IntArray) -> Modes:
        """Return the chosen modes with their real fields on the free degrees of freedom."""


def plain_modes(structure: Structure, count: int | None) -> Modes:
    """Return the lowest modes of a structure without cyclic symmetry; all if `count` is None."""
    if structure.size > DENSE_LIMIT and count is not None and not structure.constraints.size:
        shift = -1e-6 * abs(structure.stiffness).max() / abs(structure.mass).max()
        square, shapes = spla.eigsh(
            structure.stiffness.tocsc(), k=count, M=structure.mass.tocsc(), sigma=shift
        )
    else:
        square, vectors = constrained_eigh(
            structure.stiffness.toarray(), structure.mass.toarray(), structure.constraints, count
        )
        shapes = vectors.real
    return collect_modes(structure, square, shapes, np.full(len(square), NO_COLUMN), count)


def collect_modes(
    structure: Structure,
    square: FloatArray,
    shapes: FloatArray,
    column: IntArray,
    count: int | None = None,
) -> Modes:
    """Sort modes by frequency, keep the lowest without separating a pair, and compute their
    properties.

    Args:
        structure: structure of the modes.
        square: squared frequencies [rad2/s2], (modes,).
        shapes: fields, (size, modes).
        column: DFT columns, (modes,).
        count: number of modes to keep; all if None.
    """
    order = np.argsort(square, kind="stable")
    if count is not None and count < len(order):
        while is_first_of_pair(column[order], count - 1):
            count += 1
        order = order[:count]
    square, shapes, column = square[order], shapes[:, order], column[order]
    frequency = natural_frequencies(structure, square)
    strain = square
    if structure.at_rest is not None:
        strain = np.einsum("im,im->m", shapes, structure.elastic @ shapes)
    sprung = np.unique(structure.springs.indices)  # the few DoF on which springs act
    in_springs = np.einsum(
        "im,im->m", shapes[sprung], structure.springs[sprung][:, sprung] @ shapes[sprung]
    )
    floor = np.finfo(float).tiny
    if structure.layout is None:
        diameter, purity = np.full(len(order), NO_COLUMN), np.zeros(len(order))
    elif np.all(column != NO_COLUMN):
        diameter = np.array([nodal_diameter_of(int(c)) for c in column], dtype=np.int64)
        purity = np.ones(len(order))
    else:
        shares = wave_shares(shapes, structure.mass.diagonal(), structure.layout)
        diameter, purity = shares.argmax(axis=0), shares.max(axis=0)
    return Modes(
        frequency=frequency,
        shapes=shapes,
        column=column,
        nodal_diameter=diameter,
        purity=purity,
        spring_share=in_springs / np.maximum(np.maximum(in_springs, np.abs(strain)), floor),
        sectors=structure.layout.sectors if structure.layout else 0,
    )


def natural_frequencies(structure: Structure, squares: FloatArray) -> FloatArray:
    """Return the frequencies [rad/s] that belong to squared frequencies.

    At rest, negative squares are rounding errors and give zero. With rotation effects, negative
    squares occur past a critical speed, where only Coriolis forces stabilise some modes. The
    frequency then has the sign of the square.
    """
    if structure.at_rest is None:
        return np.sqrt(np.maximum(squares, 0.0))
    return np.asarray(np.sign(squares) * np.sqrt(np.abs(squares)))


def is_first_of_pair(columns: IntArray, position: int) -> bool:
    """Return true if the mode at a position is a cosine mode and the next is its sine mode."""
    following = columns[position + 1 : position + 2]
    cosine = columns[position] > 0 and columns[position] % 2 == 1
    return bool(cosine and following.size and following[0] == columns[position] + 1)


def constrained_eigh(
    stiffness: NDArray[np.inexact],
    mass: NDArray[np.inexact],
    constraints: NDArray[np.inexact],
    count: int | None = None,
) -> tuple[FloatArray, ComplexArray]:
    """Solve a generalised Hermitian eigenproblem for fields x with v^H M x = 0 for each constraint
    v.

    Args:
        stiffness: K, (n, n).
        mass: M, (n, n).
        constraints: constraints v, (n, constraints), with entries of order one; columns of zeros
            are ignored.
        count: number of the lowest eigenvalues; all if None.

    Returns:
        eigenvalues in ascending order (m,), and mass-normalised vectors (n, m).
    """
    constraints = constraints[:, np.linalg.norm(constraints, axis=0) > 1e-9]
    if constraints.size:
        allowed = la.null_space((mass @ constraints).conj().T)
        square, vectors = constrained_eigh(
            allowed.conj().T @ stiffness @ allowed,
            allowed.conj().T @ mass @ allowed,
            np.zeros((allowed.shape[1], 0)),
            count,
        )
        return square, allowed @ vectors
    return lowest_pairs(stiffness, mass, count)


def lowest_pairs(
    stiffness: NDArray[np.inexact], mass: NDArray[np.inexact], count: int | None = None
) -> tuple[FloatArray, ComplexArray]:
    """Solve a generalised Hermitian eigenproblem K x = lambda M x.

    All eigenvectors are computed even if few are returned, because bisection for a few eigenvalues
    is slower and loses digits of frequencies that are far below the highest frequencies. The
    eigenvalues are Rayleigh quotients, which restore these digits.

    Args:
        stiffness: K, (n, n).
        mass: M, positive definite, (n, n).
        count: number of the lowest eigenvalues; all if None.

    Returns:
        eigenvalues in ascending order (m,), and mass-normalised vectors (n, m).
    """
    vectors = la.eigh(stiffness, mass)[1][:, :count]
    square = rayleigh_quotients(stiffness, mass, vectors)
    order = np.argsort(square, kind="stable")
    return square[order], vectors[:, order]


def rayleigh_quotients(
    stiffness: NDArray[np.inexact], mass: NDArray[np.inexact], vectors: NDArray[np.inexact]
) -> FloatArray:
    """Return the Rayleigh quotients of vectors (n, m), which are squared frequencies, (m,).

    Their error is of the order of the squared error of the vectors.
    """
    strain, inertia = (
        np.einsum("im,im->m", vectors.conj(), matrix @ vectors).real for matrix in (stiffness, mass)
    )
    return np.asarray(strain / inertia)


def align_phase(vectors: ComplexArray, reference: tuple[int, int], *, pair: bool) -> ComplexArray:
    """Change the phase of complex vectors so that the radial reference amplitude is positive.

    If a mode of a pair has no radial amplitude, its tangential amplitude becomes -i times a
    positive number, which is its phase in modes with both amplitudes on a structure with mirror
    symmetry. Vectors of single modes (``pair`` False) are real, and only their sign changes.
    """
    radial, tangential = reference
    size = np.abs(vectors).max(axis=0)
    by_radial = np.abs(vectors[radial]) > 1e-6 * size
    quarter = 1j if pair else 1.0
    pivot = np.where(by_radial, vectors[radial], quarter * vectors[tangential])
    pivot = np.where(np.abs(pivot) > 1e-6 * size, pivot, 1.0)
    return np.asarray(vectors * (np.abs(pivot) / pivot))


def families(modes: ModeTable, body: Literal["bladed-disk", "casing"], sectors: int) -> list[str]:
    """Return the family of each mode of a body of equal sectors, or of none (0): "1F", "2F", ... by
    rank within its nodal diameter.

    On a bladed disk the pair with the largest share of strain energy in the shaft springs is called
    "suspension"; on a casing a mode that does not deform the wall is called "rigid". These modes
    have no rank.
    """
    labels = [""] * modes.count
    if body == "casing":
        lowest = modes.frequency[modes.nodal_diameter >= 2].min(initial=np.inf)
        at_rest = modes.frequency <= RIGID_FREQUENCY * lowest
        few = modes.nodal_diameter <= 1
        held_by_support = modes.spring_share >= RIGID_SHARE
        special = np.flatnonzero(few & (held_by_support | (at_rest & np.isfinite(lowest))))
        name = "rigid"
    else:
        special = suspension_pair(modes)
        name = "suspension"
    for apart in special.tolist():
        labels[apart] = name
    ranked: dict[int, int] = {}
    for mode in range(modes.count):
        if labels[mode]:
            continue
        k = int(modes.nodal_diameter[mode])
        multiplicity = 2 if is_pair(k, sectors) else 1
        labels[mode] = f"{ranked.get(k, 0) // multiplicity + 1}F"
        ranked[k] = ranked.get(k, 0) + 1
    return labels


def suspension_pair(modes: ModeTable) -> IntArray:
    """Return the two modes of k = 1 with the largest share of strain energy in the shaft springs.

    Returns:
        the numbers of both modes, (2,); an empty array if no mode strains the springs (clamped
        centre).
    """
    candidates = np.flatnonzero(modes.nodal_diameter == 1)
    shares = modes.spring_share[candidates]
    if not shares.size or shares.max() <= 1e-9:
        return np.zeros(0, dtype=np.int64)
    return np.sort(candidates[np.argsort(-shares, kind="stable")[:2]])

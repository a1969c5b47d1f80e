"""Reduction of a superelement to modes and the displacements of its contact nodes.

Two kinds of boundary are possible:

``massless``: the lowest free-interface modes, which carry all mass, and the residual flexibility of
all other modes at the contact nodes (MacNeal 1971),

    C = B K^-1 B^T - P W^-2 P^T,      u = P q + C f

with the displacements u = B x of the contact nodes for the coordinates x of the superelement, the
forces f on the contact nodes, the modal coordinates q, the diagonal matrix W of the frequencies,
the displacements P of the contact nodes in the modes, and the residual flexibility C. C follows
from one static solution for each contact displacement, so that it includes all other modes.

``consistent``: all modes of the Craig-Bampton model with the contact nodes as boundary. The contact
nodes have mass, and C is zero.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.models.superelements.dense_pencil import SMALL as SMALL_DENSE
from bladewhirl.models.superelements.dense_pencil import DensePencil
from bladewhirl.models.superelements.diameters import turned_to_diameters
from bladewhirl.models.superelements.free_motions import FreeMotions
from bladewhirl.models.superelements.further_modes import further, independent, scaled, stiffest
from bladewhirl.models.superelements.solver import MatrixPencil, Pencil, announce
from bladewhirl.models.superelements.stresses import (
    InModes,
    ReducedStress,
    load_columns,
    recovered_rows,
    reduced_stress,
    rows_in_modes,
)
from bladewhirl.models.superelements.superelement import (
    IndefiniteError,
    Matrix,
    Superelement,
    SuperelementError,
    dense,
    diagonal,
)

RIGID = 1e-10
"""A mode is rigid if its squared frequency is at most this fraction of the smallest ratio of
stiffness to mass of a coordinate."""

ENOUGH = 1e-12
"""The smallest eigenvalue of the radial residual flexibility must exceed this fraction of the
largest radial static flexibility."""

STIFF = Fault(
    key="stiffness",
    expected="a matrix that is not indefinite, and no motion without stiffness except rigid ones",
)

ABOVE = 1.25
"""Shift as a multiple of the softening of a wheel. The translations of a rotor without bearings
have minus the softening as squared frequency; a shift that only just exceeds it makes them so much
larger than other modes in the inverse that these are lost in rounding errors."""

FEW = 8
"""Number of modes that are computed with static displacements alone; among them are all that the
rotation of a wheel makes unstable."""

ALL_MODES = 2500  #: largest number of coordinates of which all modes are computed for the damping

LOWEST, SMALL = 60, 1e-12
"""Number of lowest modes from which the damping of a large structure follows; and the smallest
mass of what they leave of the shapes, as a fraction of the largest."""

RIGID_SECTOR = Fault(
    expected="a sector without rigid modes and with a stiffness that is not indefinite"
)


class SectorWaves(NamedTuple):
    """Modes of a wheel of equal sectors as waves, which follow from those of the first sector.

    In the axes of a sector at the angle a from the first one, a mode with the number k is cos(k a)
    times itself in the first sector, minus sin(k a) times its partner there.
    """

    number: IntArray
    """Nodal diameter of each mode, negative for the sine wave of a pair, (modes,)."""
    partner: IntArray  #: other mode of the pair, or the single mode itself, (modes,)
    of_first: Callable[[str], FloatArray]
    """Function from the name of rows, such as "points", to these of the first sector for unit modal
    coordinates, (rows, modes)."""


@dataclass(frozen=True, kw_only=True)
class ReducedSuperelement(Rotating[Matrix]):
    """A superelement in modal coordinates: mass-normalised modes of its stiffness, which is
    diagonal, with matrices (modes, modes) and loads (modes,)."""

    FORMS: ClassVar[tuple[str, ...]] = (*Rotating.FORMS, "root")
    ROWS: ClassVar[tuple[str, ...]] = ("contact", "centre", "strains", "shapes")

    contact: FloatArray
    """Radial, tangential and axial displacements of the contact nodes for unit modal coordinates
    [kg^-1/2], (3c, modes)."""
    compliance: FloatArray
    """Residual flexibility C of the contact displacements [m/N], (3c, 3c); zero with a consistent
    boundary."""
    centre: FloatArray
    """x and y of the centre for unit modal coordinates [kg^-1/2], (2, modes); zero if there is no
    centre."""
    of_points: InModes  #: computes `points`
    points_by_force: Callable[[sp.csr_array], FloatArray]
    """Function from rows on the displacements of the points, (rows, 3p), to these sums of
    displacements by unit contact forces without their part in the modes [m/N], (rows, 3c); it is
    also what unit forces along the rows do to the contact nodes. Zero with a consistent boundary.
    """
    strains: FloatArray
    """Strains of gauges for unit modal coordinates [kg^-1/2/m], (gauges, modes), if the file gives
    their recovery."""
    strains_by_force: FloatArray
    """Strains by unit contact forces without their part in the modes [1/N], as
    `ReducedStress.forces`."""
    stress: ReducedStress | None = None  #: stress at the points, if the file gives its recovery
    root: FloatArray | None = None
    """Square root of the stiffness at rest, on the modes [1/s], (modes, modes), of a structure at
    speed: twice the damping ratio times this matrix is the modal damping of the structure at rest.
    With a massless boundary it is the root of the whole stiffness; the root of the stiffness on
    some modes at speed is too large, because the highest modes, which are left out, are stiff."""
    kept: int
    """Number of the lowest modes, which have the damping ratio of the structure; higher modes have
    that of the boundary."""
    shapes: FloatArray | None = None
    """Modes of a structure that is not a wheel of sectors [kg^-1/2], (n, modes)."""
    waves: SectorWaves | None = None  #: waves of a wheel of equal sectors

    @property
    def squares(self) -> FloatArray:
        """Squared frequencies with their signs [rad2/s2], (modes,)."""
        return diagonal(self.stiffness)

    @cached_property
    def frequency(self) -> FloatArray:
        """Natural frequency of each mode [rad/s], (modes,); negative if its square is negative."""
        return np.asarray(np.sign(self.squares) * np.sqrt(np.abs(self.squares)))

    @cached_property
    def points(self) -> FloatArray:
        """x, y and z of the points for pictures, for unit modal coordinates [kg^-1/2], (3p,
        modes)."""
        return self.of_points(None)


def massless(
    part: Superelement,
    modes: int,
    root: "Root | None" = None,
    others: Sequence[Superelement] = (),
    forces: FloatArray | None = None,
    free: FreeMotions | None = None,
) -> ReducedSuperelement:
    """Return the lowest free-interface modes with the residual flexibility of the contact nodes.

    Args:
        part: superelement; every motion except rigid ones must have stiffness (no mechanisms).
        modes: number of modes.
        root: function from shapes to `ReducedSuperelement.root`, if it is needed.
        others: the structure at other speeds; the lowest modes of the first one, and the static
            displacements by the loads of the rotation at all speeds are added, see
            `further_modes.further`.
        forces: further forces, those of bearings, whose static displacements are added, (n, m).
            With them, modes of the frequency of the last one are kept too: wheels on a shaft have
            common groups of them.

    Raises:
        SuperelementError: `modes` is not below the number of coordinates, or is so large that a
            contact node has no radial residual flexibility; or a matrix is indefinite.
    """
    rows = part.contact_rows
    loads = load_columns(part, dense(rows).T)
    own, loads, groups = loads.shape[1], _with(loads, forces), forces is not None
    squares, shapes, moved = modes_and_static(part, modes, loads, groups=groups)
    check_count(len(squares), modes)
    if free is not None:
        shapes, moved = free.within(part.mass, squares, shapes, moved, loads)
    shapes = turned_to_diameters(squares, shapes, rows @ shapes, part.contact_angle)
    elastic = np.abs(squares) > rigid_limit(part)
    kept = rows @ shapes[:, elastic]
    compliance = np.asarray(rows @ moved[:, : 3 * part.contacts])
    compliance = 0.5 * (compliance + compliance.T)
    if others or loads.shape[1] > own:
        limit = stiffest(squares, rows @ shapes, compliance)
        first = 3 * part.contacts if others else own
        fields = [moved[:, first:], *_at_speeds(others, modes, groups=groups)]
        stiff, added = further(part.stiffness, part.mass, shapes, np.hstack(fields), limit)
        moved = moved - added @ (added.T @ loads / stiff[:, None])
        compliance = compliance - (rows @ added / stiff) @ (rows @ added).T
        squares, shapes = np.concatenate([squares, stiff]), np.hstack([shapes, added])
        elastic = np.abs(squares) > rigid_limit(part)
        kept = rows @ shapes[:, elastic]
    changes = dict[str, FloatArray]()
    if free is not None:
        squares, shapes, moved, changes = free.settled(part, shapes, moved)
        compliance = np.asarray(rows @ moved[:, : 3 * part.contacts])
        compliance = 0.5 * (compliance + compliance.T)
        elastic = np.abs(squares) > rigid_limit(part)
        kept = rows @ shapes[:, elastic]
    static = np.diag(compliance)[::3] + ((kept**2) @ (1.0 / squares[elastic]))[::3]
    if not la.eigvalsh(compliance[::3, ::3])[0] > ENOUGH * static.max():
        expected = (
            f"fewer free-interface modes than {modes}: the modes that are left out have to give all"
            " contact nodes a radial flexibility"
        )
        raise SuperelementError(Fault(expected=expected))
    reduced = _reduced(part, squares, shapes, moved[:, :own], compliance, len(squares), root)
    return _changed(reduced, changes)


def _with(loads: FloatArray, forces: FloatArray | None) -> FloatArray:
    return loads if forces is None else np.hstack([loads, forces])


def _at_speeds(others: Sequence[Superelement], modes: int, *, groups: bool) -> Iterator[FloatArray]:
    """Yield the lowest modes of the first structure, a few modes of the others, and the static
    displacements by the loads of the rotation of all, (n, fields)."""
    for each in others:
        count = max(modes, _few(each))
        yield from modes_and_static(each, count, each.loads, groups=groups)[1:]
        modes = 0


def _few(part: Superelement) -> int:
    return min(FEW, part.size - 1)


def check_count(found: int, modes: int) -> None:
    """Check that as many modes were found as were demanded.

    Raises:
        SuperelementError: there are fewer.
    """
    if found < modes:
        expected = f"at most {found} free-interface modes, got {modes}: other motions have no mass"
        raise SuperelementError(Fault(expected=expected))


def boundary_size(part: Superelement) -> int:
    """Return the number of coordinates of contact nodes and centre."""
    centre = 0 if part.centre_dofs is None else len(part.centre_dofs)
    return int(np.count_nonzero(part.contact_dofs >= 0)) + centre


def consistent(
    part: Superelement,
    fixed_interface_modes: int,
    kept: int,
    root: "Root | None" = None,
    others: Sequence[Superelement] = (),
    forces: FloatArray | None = None,
    free: FreeMotions | None = None,
) -> ReducedSuperelement:
    """Return all modes of the Craig-Bampton model whose boundary are contact nodes and centre.

    Args:
        part: superelement without rigid modes.
        fixed_interface_modes: number of fixed-interface modes.
        kept: number of the lowest modes, which have the damping ratio of the structure.
        root: function from shapes to `ReducedSuperelement.root`, if it is needed.
        others: the structure at other speeds, see `massless`; the basis then also has what
            `massless` adds.
        forces: see `massless`.
        free: see `massless`.

    Raises:
        SuperelementError: `fixed_interface_modes` is larger than the number of coordinates that are
            not on the boundary.
    """
    mass, stiffness = sp.csr_array(part.mass), sp.csr_array(part.stiffness)
    boundary = part.contact_dofs[part.contact_dofs >= 0]
    if part.centre_dofs is not None:
        boundary = np.concatenate([boundary, part.centre_dofs])
    inside = np.setdiff1d(np.arange(part.size), boundary)
    if fixed_interface_modes > len(inside):
        expected = (
            f"at most {len(inside)} fixed-interface modes, the number of coordinates inside, got"
            f" {fixed_interface_modes}"
        )
        raise SuperelementError(Fault(expected=expected))
    groups, basis = forces is not None, np.zeros((part.size, len(boundary)))
    basis[boundary, np.arange(len(boundary))] = 1.0
    if len(inside):
        announce(part.size, fixed_interface_modes, len(boundary))
        rows = stiffness[inside]
        # A shaft line is free without bearings.
        shift = 0.0 if forces is None else ABOVE * part.softening
        pencil = _factorised(rows[:, inside], mass[inside][:, inside], shift)
        basis[inside] = -pencil.solve(rows[:, boundary].toarray())
        if fixed_interface_modes:
            lowest = pencil.lowest_groups if groups else pencil.lowest
            modes = lowest(fixed_interface_modes)[1]
            basis = np.hstack([basis, np.zeros((part.size, modes.shape[1]))])
            basis[inside, len(boundary) :] = modes
    if (others or groups) and basis.shape[1] < part.size:
        statics = modes_and_static(part, _few(part), _with(part.loads, forces), groups=groups)[1:]
        fields = [basis, *statics, *_at_speeds(others, fixed_interface_modes, groups=groups)]
        basis = independent(mass, scaled(mass, np.hstack(fields)))
    squares, vectors = la.eigh(basis.T @ (stiffness @ basis), basis.T @ (mass @ basis))
    _check_definite(part, squares)
    compliance = np.zeros((3 * part.contacts, 3 * part.contacts))
    shapes, changes = basis @ vectors, dict[str, FloatArray]()
    shapes = turned_to_diameters(squares, shapes, part.contact_rows @ shapes, part.contact_angle)
    if free is not None:
        nothing = np.zeros((part.size, 0))
        shapes, _ = free.within(mass, squares, shapes, nothing, nothing)
        squares, shapes, _, changes = free.settled(part, shapes, nothing)
    elastic = squares > rigid_limit(part)
    # Contact forces act on modes only; the boundary moves as in these under any static load.
    still, loads = np.zeros((part.size, 3 * part.contacts)), part.loads
    rest = np.zeros(loads.shape)
    if part.stress_recovery is not None and loads.shape[1]:
        rest = _static_rest(part, loads, shapes[:, elastic], squares[elastic])
    moved = np.hstack([still, rest])
    return _changed(_reduced(part, squares, shapes, moved, compliance, kept, root), changes)


def _changed(
    reduced: ReducedSuperelement, changes: Mapping[str, FloatArray]
) -> ReducedSuperelement:
    known: dict[str, Any] = {name: reduced.known(name) + change for name, change in changes.items()}
    return replace(reduced, **known)


def _static_rest(
    part: Superelement, loads: FloatArray, shapes: FloatArray, squares: FloatArray
) -> FloatArray:
    """Return the static displacements under loads [N], without their part in modes, (n, loads)."""
    own, lowest, moved = modes_and_static(part, _few(part), loads)
    whole = moved + lowest @ (lowest.T @ loads / own[:, None])
    return np.asarray(whole - shapes @ (shapes.T @ loads / squares[:, None]))


def _reduced(
    part: Superelement,
    squares: FloatArray,
    shapes: FloatArray,
    moved: FloatArray,
    compliance: FloatArray,
    kept: int,
    root: "Root | None",
) -> ReducedSuperelement:
    centre = np.zeros((2, shapes.shape[1]))
    if part.centre_dofs is not None:
        centre = shapes[part.centre_dofs]

    rows = recovered_rows(part)
    by_force = np.asarray(rows["points"] @ moved[:, : 3 * part.contacts])
    return ReducedSuperelement(
        **part.on_modes(squares, shapes),
        contact=part.contact_rows @ shapes,
        compliance=compliance,
        centre=centre,
        of_points=rows_in_modes(rows["points"], shapes),
        points_by_force=lambda sums: np.asarray(sums @ by_force),
        strains=np.asarray(rows["strains"] @ shapes),
        strains_by_force=np.asarray(rows["strains"] @ moved[:, : 3 * part.contacts])[None],
        stress=reduced_stress(part, squares, shapes, moved, np.abs(squares) > rigid_limit(part)),
        root=None if root is None else root(shapes),
        kept=kept,
        shapes=shapes,
    )


def root_of(stiffness: Any) -> Any:
    """Return the square root of a matrix without its negative eigenvalues, (m, m)."""
    squares, vectors = la.eigh(stiffness)
    return (vectors * np.sqrt(np.maximum(squares, 0.0))) @ vectors.conj().T


Root = Callable[[FloatArray], FloatArray]
"""Function from mass-normalised shapes, (n, m), to the square root of a stiffness on them, (m, m).
"""


def _root_of_lowest(part: Superelement) -> Root:
    """Return the root of the stiffness from the lowest modes, and for what they leave of the shapes
    an upper bound, the geometric mean of stiffness and mass. The root of the stiffness on the
    shapes would be too large for low modes at speed."""
    squares, modes = lowest_modes(part, min(LOWEST, part.size - 1))
    rows = part.mass @ modes

    def root(shapes: FloatArray) -> FloatArray:
        inside = rows.T @ shapes
        rest = shapes - modes @ inside
        masses, turn = la.eigh(rest.T @ (part.mass @ rest))
        turn = turn[:, masses > SMALL * masses[-1]] if masses[-1] > 0.0 else turn[:, :0]
        scale = np.sqrt(masses[len(masses) - turn.shape[1] :])
        rest = rest @ (turn / scale)
        back = turn * scale
        of_rest = back @ root_of(rest.T @ (part.stiffness @ rest)) @ back.T
        return np.asarray(
            inside.T @ (np.sqrt(np.maximum(squares, 0.0))[:, None] * inside) + of_rest
        )

    return root


def root_at_rest(part: Superelement, most: int = ALL_MODES) -> Root:
    """Return the root of the whole stiffness, from all modes; of more than `most` coordinates from
    the lowest ones."""
    if part.size > most:
        return _root_of_lowest(part)
    squares, modes = la.eigh(dense(part.stiffness), dense(part.mass))
    rows = np.maximum(squares, 0.0)[:, None] ** 0.25 * (part.mass @ modes).T

    def root(shapes: FloatArray) -> FloatArray:
        inside = rows @ shapes
        return np.asarray(inside.T @ inside)

    return root


def lowest_modes(part: Superelement, count: int) -> tuple[FloatArray, FloatArray]:
    """Return the lowest modes: squared frequencies [rad2/s2], (count,), ascending, and
    mass-normalised shapes [kg^-1/2], (n, count); fewer if the other motions have no mass.

    Raises:
        SuperelementError: `count` is not below the number of coordinates, or a matrix is
            indefinite.
    """
    return modes_and_static(part, count, np.zeros((part.size, 0)))[:2]


def modes_and_static(
    part: Superelement, count: int, loads: FloatArray, *, groups: bool = False
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the lowest modes, see `lowest_modes`, and the static displacements under columns of
    loads, (n, m), without their part in these modes; with `groups` all modes of the frequency of
    the last one.

    Raises:
        SuperelementError: as for `lowest_modes`, or other motions than those of the modes have no
            stiffness.
    """
    if not count <= part.size - 1:
        expected = f"at most {part.size - 1} modes of {part.size} coordinates, got {count}"
        raise SuperelementError(Fault(expected=expected))
    announce(part.size, count, loads.shape[1])
    pencil = _factorised(part.stiffness, part.mass, small_shift(part))
    squares, shapes = (pencil.lowest_groups if groups else pencil.lowest)(count)
    _check_definite(part, squares)
    try:
        return squares, shapes, pencil.static(loads, shapes)
    except la.LinAlgError:
        raise IndefiniteError(STIFF) from None


def _factorised(stiffness: Matrix, mass: Matrix, shift: float) -> Pencil:
    try:
        if not sp.issparse(stiffness) and len(stiffness) <= SMALL_DENSE:
            return DensePencil(stiffness, dense(mass), shift)
        return MatrixPencil(stiffness, mass, shift)
    except la.LinAlgError:
        raise IndefiniteError(STIFF) from None


def _check_definite(part: Superelement, squares: FloatArray) -> None:
    if squares[0] < -rigid_limit(part) - part.softening:
        expected = (
            "a matrix that is not indefinite; the lowest squared frequency is"
            f" {squares[0]:.4g} rad2/s2"
        )
        raise IndefiniteError(Fault(key="stiffness", expected=expected))


def small_shift(part: Superelement) -> float:
    """Return the shift of `solver` that allows rigid modes, and the softening of a wheel
    [rad2/s2]."""
    return 1e3 * rigid_limit(part) + ABOVE * part.softening


def rigid_limit(part: Superelement) -> float:
    """Return the squared frequency below which a mode counts as rigid [rad2/s2]."""
    mass, stiffness = diagonal(part.mass), diagonal(part.stiffness)
    return float(RIGID * (stiffness[mass > 0.0] / mass[mass > 0.0]).min())

"""Matrices of a blade, a sector or a wheel on its lowest modes, by nodal diameter.

In a motion with nodal diameter k the displacements of the next blade, in its own polar axes, are
those of the blade before it times exp(i k alpha), with alpha = 2 pi / blades. For a sector this
follows from its two faces, see `cyclic`. The blades of a wheel are recognised by their contact
nodes: modes of equal frequency span a space that a turn by one blade maps onto itself if all blades
are equal; the eigenvalues exp(i k alpha) of this map give the nodal diameters. Separate blades have
equal matrices for every nodal diameter.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.models.structure.waves import Waves
from bladewhirl.models.superelements.joined import joined, over_speeds
from bladewhirl.models.superelements.reduction import (
    RIGID_SECTOR,
    STIFF,
    ReducedSuperelement,
    lowest_modes,
    modes_and_static,
)
from bladewhirl.models.superelements.sector import Sector, Wave, sector_errors
from bladewhirl.models.superelements.solver import lanczos_vectors
from bladewhirl.models.superelements.stresses import RECOVERED, recovered_rows
from bladewhirl.models.superelements.superelement import FIXED, Superelement, dense

UNKNOWN = -1  #: nodal diameter of the only block of a structure whose blades differ

BY_VELOCITY = "gyroscopic", "damping"  #: matrices of forces due to velocities

ALL = 400
"""Largest number of coordinates of a blade or a wheel of which all modes are used."""

EQUAL = 1e-6
"""Frequencies of a wheel count as equal if their squares differ by at most this fraction."""

CLOSE = 1e-3
"""Rounded coordinates of a mesh mix modes of a wheel whose squared frequencies differ by at most
this fraction; differences between blades mix others, too."""

CYCLIC = 1e-3
"""A wheel is cyclic if a turn by one blade maps the modes of equal frequency onto each other with a
relative error of at most this."""


SPANNED = 1e-3
"""Forces of blades below this fraction of the largest ones have no static displacements of their
own in the blocks of a sector."""


@dataclass(frozen=True, kw_only=True)
class NodalBlock(Waves):
    """Matrices of one nodal diameter on m mass-normalised modes of the structure at rest; of a
    whole structure whose blades differ, the nodal diameter is `UNKNOWN`.

    A field p exp(i w t) with w > 0 and k > 0 travels backward. The displacements of the contact
    nodes and of the points are those of the first sector, or of the whole structure. Loads of the
    rotation are zero for nodal diameters other than 0.
    """

    LOADS: ClassVar[tuple[str, ...]] = (*Waves.LOADS, "blade_loads")
    ROWS: ClassVar[tuple[str, ...]] = ("contact", "centre", *RECOVERED, "blade")

    contact: ComplexArray
    """Radial, tangential and axial displacements of the contact nodes [kg^-1/2], (3c, m)."""
    centre: ComplexArray  #: x and y of the centre [kg^-1/2], (2, m); zero without a centre
    points: ComplexArray  #: displacements of the points along x, y and z [kg^-1/2], (3p, m)
    strains: ComplexArray  #: strains of gauges [kg^-1/2/m], (gauges, m)
    stresses: ComplexArray  #: stresses at the points [Pa kg^-1/2/m], (6p, m)
    blade: ComplexArray | None = None
    """Displacements of all coordinates of the structure [kg^-1/2], (n, m), of a sector with
    blade_stiffness whose nodes are touched."""
    blade_loads: ComplexArray | None = None
    """Forces of the stiffness of the blade in the modes of all nodal diameters, (m, loads)."""


Blocks = Mapping[int, NodalBlock]
"""Blocks by nodal diameter; the key `UNKNOWN` for the only block if the blades are not equal."""


def blade_blocks(
    part: Superelement, blades: int, count: int, highest: float = 0.0, *, between: bool = True
) -> Blocks:
    """Return the blocks of equal blades that do not influence each other, one for each nodal
    diameter.

    Args:
        part: the blade.
        blades: number of blades.
        count: number of modes of a blade at a speed, see `over_speeds`.
        highest: highest speed at which the blocks are used [rad/s].
        between: whether the blocks are used at speeds between rest and the highest.
    """
    if part.size <= min(count, ALL):
        shapes = la.eigh(dense(part.stiffness), dense(part.mass))[1]
    else:
        most, states = min(count, part.size - 1), over_speeds(part, highest, between=between)
        shapes = joined(part, [lowest_modes(each, most)[1] for each in states])
    block = _block(part, np.asarray(shapes, dtype=np.complex128), 0)
    return {k: replace(block, nodal_diameter=k) for k in range(blades // 2 + 1)}


def sector_blocks(
    part: Superelement,
    sectors: int,
    count: int,
    highest: float = 0.0,
    *,
    touched: bool = False,
    clamped: bool = False,
    mistuned: bool = True,
    between: bool = True,
    static: bool = True,
    diameters: Sequence[int] | None = None,
) -> Blocks:
    """Return the blocks of a wheel of equal sectors.

    Besides the modes, a block has the static displacements under forces on the contact nodes, and
    under the Coriolis forces and the damping forces of these modes if the nodes are not touched:
    ten modes of a wheel that rotates are then as accurate as with a hundred modes.

    Args:
        part: the sector.
        sectors: number of sectors.
        count: number of modes of each nodal diameter at a speed, see `over_speeds`.
        highest: highest speed at which the blocks are used [rad/s].
        touched: whether the static displacements at each speed are exact, so that the residual
            flexibility of the contact nodes is known; the sector must then be clamped.
        clamped: whether the sector has no rigid modes.
        mistuned: whether the touched blades differ, if the sector has blade_stiffness.
        between: whether the blocks are used at speeds between rest and the highest.
        static: whether a block has the static displacements besides the modes.
        diameters: the nodal diameters; all by default.

    Raises:
        SuperelementError: the sector takes too much memory, its faces do not match, or it has
            rigid modes though it is clamped.
    """
    loads = sp.csc_array(part.contact_rows.T)
    if not static:
        loads = loads[:, :0]
    differ = touched and mistuned and part.blade_stiffness is not None
    velocity = (
        [] if touched or not static else [*map(sp.csr_array, part.given(BY_VELOCITY).values())]
    )
    solutions = loads.shape[1] + len(velocity) * count
    solutions += differ * lanczos_vectors(count)  # modes are computed twice
    chosen = range(sectors // 2 + 1) if diameters is None else diameters
    solved = {"modes": count, "loads": solutions, "waves": len(chosen)}
    rigid = not (touched or clamped)
    with sector_errors(STIFF if rigid else RIGID_SECTOR):
        states = [
            Sector(state, sectors, **solved, rigid=rigid)
            for state in over_speeds(part, highest, between=between)
        ]
        of_blade = np.zeros((part.size, 0))
        if differ:
            of_blade = _blade_loads(part, states, count)
            loads = sp.csc_array(sp.hstack([loads, of_blade]))

        def block(k: int) -> NodalBlock:
            found = [*fields(states[0].wave(k), loads)]
            for sector in states[1:]:
                found += fields(sector.wave(k), loads if touched else loads[:, :0])
            together = joined(part, found)
            made = _block(part, together, k)
            if k != 0:
                still: dict[str, Any] = dict.fromkeys(part.given(part.LOADS), np.zeros(made.size))
                made = replace(made, **still)
            if not touched or part.blade_stiffness is None:
                return made
            return replace(made, blade=together, blade_loads=together.conj().T @ of_blade)

        def fields(wave: Wave, loads: sp.csc_array) -> Iterator[ComplexArray]:
            _, shapes = wave.lowest(min(count, wave.size))
            yield np.asarray(wave.tie @ shapes, dtype=np.complex128)
            if not static:
                return
            forces = [(loads.T @ wave.tie).conj().T.toarray()]
            forces += [wave.on_wave(matrix, shapes) for matrix in velocity]
            if touched and wave.diameter == 0:
                forces.append(wave.tie.T @ part.loads)
            moved = wave.tie @ wave.static(np.hstack(forces), shapes, exact=touched)
            yield np.asarray(moved[:, np.any(moved, axis=0)], dtype=np.complex128)

        return dict(zip(chosen, states[0].each_wave(block, chosen), strict=True))


def _blade_loads(part: Superelement, states: list[Sector], count: int) -> FloatArray:
    """Return forces that span, but for `SPANNED`, those of the stiffness of the blade in the modes
    of all nodal diameters at all speeds, (n, loads).

    Their static displacements are the first change of the modes when blades differ.
    """

    def in_modes(sector: Sector, k: int) -> FloatArray:
        wave = sector.wave(k)
        squares, shapes = wave.lowest(min(count, wave.size))
        moved = wave.tie @ (shapes / squares)
        return np.hstack([moved.real, moved.imag])

    moved = [field for sector in states for field in sector.each_wave(partial(in_modes, sector))]
    forces = sp.csr_array(part.blade_stiffness) @ np.hstack(moved)
    squares, vectors = la.eigh(forces.T @ forces)
    kept = squares > SPANNED**2 * squares[-1]
    return np.asarray(forces @ (vectors[:, kept] / np.sqrt(squares[kept])))


def wheel_blocks(
    part: Superelement,
    springs: tuple[float, float],
    blades: int,
    count: int,
    highest: float = 0.0,
    *,
    between: bool = True,
) -> Blocks:
    """Return the blocks of a whole bladed disk; the only block `UNKNOWN` if its blades differ or
    are not to be distinguished.

    Args:
        part: the wheel, whose stiffness includes the springs of the shaft.
        springs: stiffness of these springs along x and y [N/m].
        blades: number of blades, whose contact nodes are listed one blade after the other.
        count: number of modes at a speed, see `over_speeds`; all of a small wheel.
        highest: highest speed at which the blocks are used [rad/s].
        between: whether the blocks are used at speeds between rest and the highest.
    """
    states = over_speeds(part, highest, between=between) if part.size > ALL else (part,)
    modes = [_wheel_modes(each, count) for each in states]
    found = [_by_nodal_diameter(part, *each, blades) if blades > 1 else None for each in modes]
    groups = [each for each in found if each is not None]
    if len(groups) < len(found):
        groups = [{UNKNOWN: np.asarray(shapes, dtype=np.complex128)} for _, shapes in modes]
    return {
        k: _block(part, joined(part, [each[k] for each in groups if k in each]), k, springs)
        for k in sorted(set().union(*groups))
    }


def with_clamped_centre(part: Superelement) -> Superelement:
    """Return a wheel whose centre does not move."""
    assert part.centre_dofs is not None
    kept = np.setdiff1d(np.arange(part.size), part.centre_dofs)
    place = np.full(part.size + 1, FIXED)  # the last entry is that of a fixed component
    place[kept] = np.arange(len(kept))

    select = sp.csr_array(sp.eye_array(part.size))[:, kept]
    dofs: dict[str, Any] = {"contact_dofs": place[part.contact_dofs], "centre_dofs": None}
    return replace(part, **part.projected(select), **dofs)


def block_of(reduced: ReducedSuperelement) -> NodalBlock:
    """Return the only block of a structure whose blades differ, from its reduction at a speed."""
    none = np.zeros((0, reduced.size), dtype=np.complex128)
    matrices = replace(reduced, stiffness=reduced.stiffness_at(0.0)).given(Waves.FORMS[:-1])
    rows = {"contact": reduced.contact, "centre": reduced.centre, "points": reduced.points}
    given = matrices | rows | {"springs": np.zeros(reduced.mass.shape)}
    waves: dict[str, Any] = {name: dense(one).astype(np.complex128) for name, one in given.items()}
    return NodalBlock(
        **waves,
        nodal_diameter=UNKNOWN,
        strains=none,
        stresses=none,
    )


def _wheel_modes(part: Superelement, count: int) -> tuple[FloatArray, FloatArray]:
    """Return squared frequencies and shapes: all modes of a small wheel, else the lowest ones with
    the static displacement by forces at the centre, so that they also suit other springs."""
    if part.size <= ALL:
        squares, shapes = la.eigh(dense(part.stiffness), dense(part.mass))
        return squares, shapes
    count = min(count, part.size - 1)
    if part.centre_dofs is None:
        return lowest_modes(part, count)
    forces = np.zeros((part.size, 2))
    forces[part.centre_dofs, [0, 1]] = 1.0
    squares, shapes, moved = modes_and_static(part, count, forces)
    moved /= np.sqrt(np.einsum("im,im->m", moved, part.mass @ moved))
    basis = np.hstack([shapes, moved])
    squares, vectors = la.eigh(basis.T @ (part.stiffness @ basis), basis.T @ (part.mass @ basis))
    return squares, basis @ vectors


def _by_nodal_diameter(
    part: Superelement, squares: FloatArray, shapes: FloatArray, blades: int
) -> dict[int, ComplexArray] | None:
    """Return for each nodal diameter the fields of its backward waves, (n, m); None if the blades
    are not equal."""
    angles = part.contact_position[:, :2].reshape(blades, -1, 2).mean(axis=1)
    order = np.argsort(np.arctan2(angles[:, 1], angles[:, 0]))
    at_nodes = (part.contact_rows @ shapes).reshape(blades, -1, len(squares))[order]
    following = np.roll(at_nodes, -1, axis=0).reshape(-1, len(squares))
    here = at_nodes.reshape(-1, len(squares))
    starts = np.flatnonzero(np.diff(squares) > EQUAL * np.abs(squares[1:])) + 1
    turns = _turned(here, following, squares, np.split(np.arange(len(squares)), starts))
    if turns is None:
        return None
    found: dict[int, list[ComplexArray]] = {k: [] for k in range(blades // 2 + 1)}
    for modes, turn in turns:
        values, vectors = np.linalg.eig(turn)
        waves = np.round(np.angle(values) * blades / (2.0 * np.pi)).astype(int)
        for wave in np.unique(waves):
            k = int(wave) % blades
            if k > blades // 2:
                continue  # forward waves are the conjugates of backward waves
            among, _ = np.linalg.qr(vectors[:, waves == wave])
            found[k].append(np.asarray(shapes[:, modes] @ among, dtype=np.complex128))
    return {k: np.hstack(fields) for k, fields in found.items() if fields}


def _turned(
    here: FloatArray, following: FloatArray, squares: FloatArray, groups: list[IntArray]
) -> list[tuple[IntArray, FloatArray]] | None:
    """Return groups of modes with the matrix of a turn by one blade on each of them; None if there
    is no such matrix. A group that a turn does not map onto itself is joined with the nearer of its
    neighbours: a mesh that repeats only but for its digits mixes modes of close frequencies.

    Args:
        here: displacements of the contact nodes in the modes, (3c, m).
        following: those of the next blades, (3c, m).
        squares: squared frequencies, (m,).
        groups: modes of equal frequency.
    """
    found, groups = list[tuple[IntArray, FloatArray]](), [*groups]
    while groups:
        modes = groups.pop(0)
        turn, _, rank, _ = np.linalg.lstsq(here[:, modes], following[:, modes], rcond=CYCLIC)
        error = np.linalg.norm(here[:, modes] @ turn - following[:, modes])
        if rank == len(modes) and error <= CYCLIC * np.linalg.norm(following[:, modes]):
            found.append((modes, np.asarray(turn, dtype=np.float64)))
            continue
        if not groups:  # the last modes lack their partners
            return found
        first, last = modes[0], modes[-1]
        below = squares[last] - squares[first - 1] if found else np.inf
        above = squares[last + 1] - squares[first]
        if min(below, above) > CLOSE * abs(squares[last]):
            return None
        if below < above:
            groups.insert(0, np.concatenate([found.pop()[0], modes]))
        else:
            groups[0] = np.concatenate([modes, groups[0]])
    return found


def _block(
    part: Superelement,
    fields: ComplexArray,
    nodal_diameter: int,
    springs: tuple[float, float] = (0.0, 0.0),
) -> NodalBlock:
    modes = fields.shape[1]
    centre = np.zeros((2, modes), dtype=np.complex128)
    if part.centre_dofs is not None:
        centre = fields[part.centre_dofs]
    matrices = part.projected(fields, (*Rotating.FORMS, *Rotating.LOADS))
    rows = {name: np.asarray(rows @ fields) for name, rows in recovered_rows(part).items()}
    return NodalBlock(
        **{**matrices, **rows, "mass": np.eye(modes, dtype=np.complex128)},
        nodal_diameter=nodal_diameter,
        speed=part.speed,
        springs=centre.conj().T @ (np.array(springs)[:, None] * centre),
        contact=np.asarray(part.contact_rows @ fields),
        centre=centre,
    )

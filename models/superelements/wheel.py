"""A wheel from one sector: real modes and residual flexibility, by nodal diameter."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from bladewhirl.meshes.coincident import COINCIDENT, near_pairs
from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.structure.rotating import Rotating, of_modes
from bladewhirl.models.superelements.condensed import FURTHER_MODES
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.further_modes import further, stiffest
from bladewhirl.models.superelements.kept_reduction import (
    Arrays,
    arrays_of,
    kept_reduction,
    restored,
)
from bladewhirl.models.superelements.mistuned import (
    blade_products,
    change_of_waves,
    coupled_waves,
    stiffened,
)
from bladewhirl.models.superelements.nodal_blocks import NodalBlock, sector_blocks
from bladewhirl.models.superelements.reduction import (
    RIGID_SECTOR,
    ReducedSuperelement,
    SectorWaves,
    check_count,
    root_of,
)
from bladewhirl.models.superelements.sector import sector_errors
from bladewhirl.models.superelements.stresses import RECOVERED, ReducedStress
from bladewhirl.models.superelements.superelement import (
    FIXED,
    IndefiniteError,
    Superelement,
    SuperelementError,
)


class ReducedWave(NamedTuple):
    """Lowest modes of one nodal diameter at a speed."""

    squares: FloatArray  #: squared frequencies [rad2/s2], (modes,)
    shapes: ComplexArray  #: the modes in the block that they come from, (m, modes)
    block: NodalBlock  #: this block on the modes
    by_force: Mapping[str, ComplexArray]
    """What each of `RECOVERED` is by contact forces without their part in the modes, (rows, 3c)."""
    residual: ComplexArray  #: residual flexibility of the contact nodes [m/N], (3c, 3c)
    steady: FloatArray
    """Stress by the centrifugal forces at 1 rad/s [Pa s2], (6p,), see `ReducedStress`; empty if
    they are not known, and for nodal diameters other than 0."""
    root: ComplexArray | None
    """See `ReducedSuperelement.root`; None if the stiffness does not depend on the speed."""


class WheelOverSpeeds:
    """A wheel of sectors with a massless boundary, whose reduction at a speed takes milliseconds.

    Its motions are the lowest modes of each nodal diameter, and the static displacements under
    forces on the contact nodes, at rest, at half and at all of the highest speed. Contact nodes are
    numbered sector by sector, counter-clockwise. Points for pictures and gauges are those of all
    sectors. `blocks` are the matrices of each nodal diameter.
    """

    def __init__(
        self,
        part: Superelement,
        sectors: int,
        modes: int,
        highest: float = 0.0,
        file: str | None = None,
        *,
        mistuned: bool = True,
        static: bool = True,
        coupled: int = 0,
    ) -> None:
        """Reduce the sector, or read what was kept of an earlier reduction.

        Args:
            part: sector with left_dofs and right_dofs; with blade_stiffness if blades differ, or
                their stiffness is needed.
            sectors: number of sectors.
            modes: number of free-interface modes of each nodal diameter at a speed; if it has two
                waves, of each of them.
            highest: highest speed [rad/s].
            file: file of the sector, beside which its reduction is kept; None to keep nothing.
            mistuned: whether blades with blade_stiffness differ.
            static: false if modes are only needed at rest and at the highest speed, without static
                displacements and residual flexibility.
            coupled: number of further modes that describe how Coriolis forces couple these modes,
                with the static displacements under these forces; 0 without Coriolis forces.

        Raises:
            SuperelementError: the sector has too few coordinates, takes too much memory, or has
                rigid modes.
        """
        self._part, self._sectors, self._modes = part, sectors, modes
        own, size = part.blade_stiffness, transformation(part, sectors, 0).shape[1]
        if modes >= size:
            expected = f"fewer than {size} free-interface modes, the coordinates of a sector"
            raise SuperelementError(Fault(expected=expected))
        differ = mistuned and own is not None
        count = modes + (FURTHER_MODES if static and (highest or differ) else 0)

        def compute() -> list[Arrays]:
            found = sector_blocks(
                *(part, sectors, count + coupled, highest),
                touched=not coupled,
                clamped=True,
                mistuned=differ,
                between=static,
                static=static or coupled > 0,
            )
            parts = [arrays_of(replace(each, blade=None)) for each in found.values()]
            fields = [each.blade for each in found.values() if each.blade is not None]
            return parts if own is None else [*parts, {"products": blade_products(own, fields)}]

        settings = (sectors, modes, coupled, highest, differ, static)
        parts = compute() if file is None else kept_reduction(file, part, settings, compute)
        self._products = None if own is None else parts[-1]["products"]
        self.blocks = [restored(NodalBlock, each) for each in parts[: sectors // 2 + 1]]

    def at(
        self,
        omega: float,
        factor: FloatArray | None = None,
        others: Sequence[float] = (),
        diameters: Collection[int] | None = None,
    ) -> tuple[Superelement, ReducedSuperelement]:
        """Return the contact nodes of the wheel and its reduction at a speed.

        Args:
            omega: speed of rotation [rad/s].
            factor: factor on the stiffness of each blade, (sectors,); None if blades are equal.
            others: other speeds, see `_of_block`; none if blades differ.
            diameters: nodal diameters whose modes are needed; all by default, and if blades differ.

        Returns:
            a superelement with the contact nodes and the points of the wheel, whose coordinates are
            modal coordinates with diagonal matrices; and the reduction.

        Raises:
            SuperelementError: the stiffness is not positive definite at this speed.
        """
        sectors, modes = self._sectors, self._modes
        if factor is None:
            waves = [
                _of_block(block, omega, modes, others=others)
                if diameters is None or k in diameters
                else _without_modes(block, omega)
                for k, block in enumerate(self.blocks)
            ]
            return _expanded(self._part, sectors, waves)
        waves = [_of_block(block, omega, modes, static=True) for block in self.blocks]
        wheel, reduced = _expanded(self._part, sectors, waves)
        change = change_of_waves(self._coupled(waves), factor)
        order = _order(waves, sectors)
        return wheel, stiffened(reduced, change[order][:, order], sectors * modes, factor)

    def blades_at(self, omega: float) -> FloatArray:
        """Return the stiffness of each blade on the modes of `at` at a speed [rad/s] [1/s2],
        (sectors, modes, modes)."""
        waves = [_of_block(block, omega, self._modes) for block in self.blocks]
        coupled, order = self._coupled(waves), _order(waves, self._sectors)
        each = (change_of_waves(coupled, 1.0 + unit) for unit in np.eye(self._sectors))
        return np.array([change[order][:, order] for change in each])

    def _coupled(self, waves: Sequence[ReducedWave]) -> ComplexArray:
        assert self._products is not None
        return coupled_waves(self._products, [wave.shapes for wave in waves], self._sectors)


def _expanded(
    part: Superelement, sectors: int, waves: Sequence[ReducedWave]
) -> tuple[Superelement, ReducedSuperelement]:
    """Return the wheel and its reduction from the modes of each nodal diameter."""
    rows, first = 3 * part.contacts, waves[0].block
    spread = np.asarray(2.0 * np.pi / sectors * np.arange(sectors), dtype=np.float64)
    coupled = set(Rotating.FORMS) - {"mass", "stiffness"}
    matrices: dict[str, list[FloatArray]] = {name: [] for name in first.given(coupled)}
    loads: dict[str, list[FloatArray]] = {name: [] for name in first.given(Rotating.LOADS)}
    roots = list[FloatArray]()
    squares = []
    for k, wave in enumerate(waves):
        pair = 0 < 2 * k < sectors
        for _ in _real_waves(k, spread):
            squares.append(wave.squares)
            for name, parts in loads.items():  # those of nodal diameter 0, on all sectors
                parts.append(np.sqrt(sectors) * getattr(wave.block, name).real)
        for name, blocks in matrices.items():
            blocks.append(_on_waves(getattr(wave.block, name), pair=pair))
        if wave.root is not None:
            roots.append(_on_waves(wave.root, pair=pair))
    order, steady = _order(waves, sectors), waves[0].steady
    place = np.argsort(order)
    flexibility = _by_distance([wave.residual for wave in waves], sectors)
    compliance = np.block(
        [[flexibility[(i - j) % sectors] for j in range(sectors)] for i in range(sectors)]
    )

    def in_modes(name: str, turn: FloatArray | None = None, sectors: int = sectors) -> FloatArray:
        """Return a quantity of the first sectors, such as "contact", in combinations of modes."""
        count = sectors * len(getattr(first, name))
        found, start = np.zeros((count, len(order) if turn is None else turn.shape[1])), 0
        for k, wave in enumerate(waves):
            for phases in _real_waves(k, spread):
                rows = getattr(wave.block, name)
                each = np.stack([(one * rows).real for one in phases[:sectors]])
                modes = each.shape[-1]
                if name == "points":
                    each = each.reshape(sectors, each.shape[1] // 3, 3, modes)
                    each = rotate(each, spread[:sectors, None, None], axis=2)
                among, start = place[start : start + modes], start + modes
                if turn is None:
                    found[:, among] = each.reshape(count, modes)
                else:
                    found += each.reshape(count, modes) @ turn[among]
        return found

    def points_by_force(sums: sp.csr_array) -> FloatArray:
        given = sums.toarray().reshape(sums.shape[0], sectors, -1, 3)
        used = given.any(axis=(0, 1, 3))
        own = rotate(given[:, :, used], -spread[:, None], axis=3).reshape(len(given), sectors, -1)
        blocks = [wave.by_force["points"].reshape(-1, 3, rows)[used] for wave in waves]
        moved = np.zeros((len(given), sectors, rows))
        for n, block in enumerate(_by_distance(blocks, sectors)):
            moved += np.roll(own @ block.reshape(-1, rows), -n, axis=1)
        return moved.reshape(len(given), -1)

    values = np.concatenate(squares)[order]
    reduced = ReducedSuperelement(
        **of_modes(values),
        **{name: la.block_diag(*blocks)[order][:, order] for name, blocks in matrices.items()},
        **{name: np.concatenate(parts)[order] for name, parts in loads.items()},
        root=la.block_diag(*roots)[order][:, order] if roots else None,
        speed=first.speed,
        contact=in_modes("contact"),
        compliance=0.5 * (compliance + compliance.T),
        centre=np.zeros((2, len(values))),
        of_points=partial(in_modes, "points"),
        points_by_force=points_by_force,
        strains=in_modes("strains"),
        strains_by_force=_by_distance([wave.by_force["strains"] for wave in waves], sectors),
        stress=(
            ReducedStress(
                of_modes=partial(in_modes, "stresses"),
                forces=_by_distance([wave.by_force["stresses"] for wave in waves], sectors),
                steady=np.tile(steady, sectors) if len(steady) else None,
            )
            if part.stress_recovery is not None
            else None
        ),
        kept=len(values),
        waves=SectorWaves(*_numbers(waves, sectors, order), partial(in_modes, sectors=1)),
    )
    return _wheel(part, spread, values), reduced


def _by_distance(blocks: Sequence[ComplexArray], sectors: int) -> FloatArray:
    """Return what unit forces on a sector do to the sector that is n sectors ahead, (sectors,
    ...), from what forces with each nodal diameter do to the first sector, (...)."""
    return np.asarray(np.fft.irfft(blocks, sectors, axis=0))


def _order(waves: Sequence[ReducedWave], sectors: int) -> IntArray:
    """Return the positions of all real modes, which are nodal diameter by nodal diameter, by
    frequency; as they are with Coriolis forces, which couple the modes of a nodal diameter."""
    twice = (1 + (0 < 2 * k < sectors) for k in range(len(waves)))
    tiled = [np.tile(wave.squares, times) for wave, times in zip(waves, twice, strict=True)]
    squares = np.concatenate(tiled)
    if waves[0].block.gyroscopic is not None:
        return np.arange(len(squares))
    return np.argsort(np.sqrt(squares), kind="stable")


def _numbers(
    waves: Sequence[ReducedWave], sectors: int, order: IntArray
) -> tuple[IntArray, IntArray]:
    """Return `SectorWaves.number` and `SectorWaves.partner` of the real modes in an order."""
    numbers, partners, start = [], [], 0
    for k, wave in enumerate(waves):
        own = start + np.arange(modes := len(wave.squares))
        pair = 0 < 2 * k < sectors
        numbers += [np.full(modes, k), np.full(modes, -k)] if pair else [np.full(modes, k)]
        partners += [own + modes, own] if pair else [own]
        start += modes * (1 + pair)
    place = np.argsort(order)
    return np.concatenate(numbers)[order], place[np.concatenate(partners)[order]]


def _real_waves(k: int, spread: FloatArray) -> Iterator[list[complex]]:
    """Yield the complex amplitudes of all sectors, at the angles `spread`, in the cosine and in
    the sine wave of a nodal diameter, or in its single wave."""
    pair = 0 < 2 * k < len(spread)
    scale = np.sqrt((1 + pair) / len(spread))
    for phase in (1.0, -1j) if pair else (1.0,):
        yield [scale * phase * np.exp(1j * k * angle) for angle in spread]


def _of_block(
    block: NodalBlock,
    omega: float,
    modes: int,
    *,
    static: bool = False,
    others: Sequence[float] = (),
) -> ReducedWave:
    """Return the lowest modes at a speed [rad/s] from a block, with their shapes.

    Args:
        block: matrices of a nodal diameter.
        omega: speed [rad/s].
        modes: number of modes.
        static: whether the static displacements under the forces of blades follow the modes, as
            further orthogonal motions with their stiffness.
        others: other speeds [rad/s]; the lowest modes at the first one, and the static
            displacements by the loads of the rotation at all speeds are added, see
            `further_modes.further`.
    """
    stiffness = block.stiffness_at(omega)
    squares, shapes = la.eigh(stiffness)
    check_count(len(squares), modes)
    if not squares[0] > 0.0:
        raise IndefiniteError(RIGID_SECTOR)
    rest, stiff = shapes[:, modes:], squares[modes:]
    shapes, squares = shapes[:, :modes], squares[:modes]
    touched = block.contact @ rest
    by_force = (rest / stiff) @ touched.conj().T
    loads, moved = shapes.conj().T @ block.loads, rest.conj().T @ block.loads / stiff[:, None]
    steady = block.stresses @ (rest @ moved + shapes @ (loads / squares[:, None]))
    if others:
        limit = stiffest(squares, block.contact @ shapes, block.contact @ by_force)
        states = [la.eigh(block.stiffness_at(speed)) for speed in others]
        fields = [rest @ moved, states[0][1][:, :modes]]
        fields += [each @ (each.conj().T @ block.loads / own[:, None]) for own, each in states]
        own, added = further(stiffness, np.eye(block.size), shapes, np.hstack(fields), limit)
        by_force = by_force - (added / own) @ (block.contact @ added).conj().T
        shapes, squares = np.hstack([shapes, added]), np.concatenate([squares, own])
    forced = block.projected(by_force, RECOVERED)
    if static:
        among = la.qr((rest.conj().T @ block.blade_loads) / stiff[:, None], mode="economic")[0]
        own, turn = la.eigh((among.conj().T * stiff) @ among)
        among = among @ turn
        moved = touched @ among
        by_force = by_force - (rest @ among / own) @ moved.conj().T
        forced["points"] = block.points @ by_force
        shapes, squares = np.hstack([shapes, rest @ among]), np.concatenate([squares, own])
    residual = block.contact @ by_force
    return ReducedWave(
        squares=squares,
        shapes=shapes,
        block=block.at(omega).on(shapes),
        by_force=forced,
        residual=0.5 * (residual + residual.conj().T),
        steady=steady[:, 0].real if block.loads.any() else np.zeros(0),
        root=(
            None
            if block.stiffness_speed is None
            else shapes.conj().T @ root_of(block.stiffness) @ shapes
        ),
    )


def _without_modes(block: NodalBlock, omega: float) -> ReducedWave:
    """Return no modes of a block at a speed [rad/s], and no flexibility of its contact nodes.

    Raises:
        IndefiniteError: the stiffness is not positive definite at this speed.
    """
    with sector_errors(RIGID_SECTOR):
        la.cholesky(block.stiffness_at(omega))  # it must be as stable as the other ones
    forces, none = len(block.contact), np.zeros((block.size, 0), dtype=np.complex128)
    rows = {name: np.zeros((len(getattr(block, name)), forces), complex) for name in RECOVERED}
    return ReducedWave(
        squares=np.zeros(0),
        shapes=none,
        block=block.at(omega).on(none),
        by_force=rows,
        residual=np.zeros((forces, forces), dtype=np.complex128),
        steady=np.zeros(0),
        root=None if block.stiffness_speed is None else np.zeros((0, 0), dtype=np.complex128),
    )


def _on_waves(matrix: ComplexArray, *, pair: bool) -> FloatArray:
    """Return a matrix of the complex amplitudes of one nodal diameter as a matrix of its real
    modes: those of the cosine, then those of the sine if it has two waves."""
    if not pair:
        return matrix.real
    return np.block([[matrix.real, matrix.imag], [-matrix.imag, matrix.real]])


def whole_wheel(part: Superelement, sectors: int) -> Superelement:
    """Return the assembled wheel of a sector, with sparse matrices.

    Coordinates are those of a sector without its right face, sector by sector. Displacements of
    contact nodes are in the axes of the first sector, other displacements in those of their sector.

    Args:
        part: sector with left_dofs and right_dofs.
        sectors: number of sectors.

    Raises:
        SuperelementError: the superelement is not a sector.
    """
    tie = sp.csr_array(transformation(part, sectors, 0).real)
    assert part.right_dofs is not None
    ahead = np.zeros(part.size)
    ahead[part.right_dofs[part.right_dofs != FIXED]] = 1.0
    on = sp.csr_array(sp.diags_array(ahead) @ tie)  # the right face follows the next sector
    rest = sp.csr_array(tie - on)
    place = np.full(part.size + 1, FIXED)
    place[:-1][ahead == 0.0] = np.arange(tie.shape[1])
    contact = place[part.contact_dofs]
    step = sp.csr_array(np.roll(np.eye(sectors), 1, axis=1))
    spread = np.asarray(2.0 * np.pi / sectors * np.arange(sectors), dtype=np.float64)
    turn = sp.block_diag([_turned_contact(contact, tie.shape[1], angle) for angle in spread])

    def assembled(matrix: Any) -> sp.csr_array:
        inner = sp.csr_array(rest.T @ matrix @ rest + on.T @ matrix @ on)
        across = sp.kron(step, rest.T @ matrix @ on) + sp.kron(step.T, on.T @ matrix @ rest)
        both = sp.kron(sp.eye_array(sectors), inner) + across
        return sp.csr_array(turn @ both @ turn.T)

    recovered: dict[str, Any] = {}
    for key, rows in part.given(part.ROWS).items():
        own = sp.kron(sp.eye_array(sectors), rows @ rest)
        recovered[key] = sp.csr_array((own + sp.kron(step, rows @ on)) @ turn.T)
    if (moved := recovered.get("recovery")) is not None:
        each = moved.toarray().reshape(sectors, -1, 3, moved.shape[1])
        recovered["recovery"] = rotate(each, spread[:, None, None], axis=2).reshape(moved.shape)
    loads = part.given(part.LOADS).items()
    picture = _wheel(part, spread, np.ones(1))
    offset = tie.shape[1] * np.arange(sectors)[:, None, None]
    dofs = np.where(contact == FIXED, FIXED, contact + offset).reshape(-1, 3)
    return replace(
        picture,
        **{key: assembled(matrix) for key, matrix in part.given(part.FORMS).items()},
        **{key: turn @ np.tile((rest + on).T @ load, sectors) for key, load in loads},
        **recovered,
        contact_dofs=dofs,
    )


def _turned_contact(contact: IntArray, size: int, angle: float) -> sp.csr_array:
    """Return the matrix that turns x and y of the contact nodes by an angle, (size, size)."""
    turn = sp.lil_array(sp.eye_array(size))
    c, s = np.cos(angle), np.sin(angle)
    for x, y, _ in contact:
        turn[x, x] = turn[y, y] = c
        turn[x, y], turn[y, x] = -s, s
    return sp.csr_array(turn)


def _wheel(part: Superelement, spread: FloatArray, squares: FloatArray) -> Superelement:
    """Return the nodes and points of a wheel, with diagonal matrices of its modes."""
    positions = rotate(part.contact_position, spread[:, None]).reshape(-1, 3)
    changes: dict[str, Any] = dict.fromkeys((*part.FORMS, *part.ROWS, *part.LOADS))
    changes |= dict.fromkeys(("young_modulus", "poisson_ratio", "left_dofs", "right_dofs"))
    if part.points is not None:
        changes["points"] = rotate(part.points, spread[:, None]).reshape(-1, 3)
        changes["recovery"] = np.zeros((3 * len(changes["points"]), len(squares)))
        if part.triangles is not None:
            of_sector = _outside(part.triangles, changes["points"].reshape(len(spread), -1, 3))
            starts = len(part.points) * np.arange(len(spread))
            changes["triangles"] = (of_sector + starts[:, None, None]).reshape(-1, 3)
    return replace(
        part,
        **{**changes, **of_modes(squares)},
        contact_position=positions,
        contact_dofs=np.full((len(positions), 3), -1),
    )


def _outside(triangles: IntArray, points: FloatArray) -> IntArray:
    """Return the triangles (triangle, 3) of a sector that do not lie on a face of which the next or
    the previous sector has all points, for the points of all sectors (sector, point, 3) [m]."""
    distance, inside = COINCIDENT * float(np.ptp(points)), np.full(len(triangles), False)
    for neighbour in points[1], points[-1]:
        face = np.isin(np.arange(len(neighbour)), near_pairs(points[0], neighbour, distance)[:, 0])
        inside |= face[triangles].all(axis=1)
    return np.asarray(triangles[~inside])

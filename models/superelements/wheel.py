"""A wheel from one sector: real modes and residual flexibility, by nodal diameter."""

from collections.abc import Iterator, Sequence
from dataclasses import fields as fields_of
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.superelements.condensed import FURTHER_MODES
from bladewhirl.models.superelements.cyclic import cyclic_reduction
from bladewhirl.models.superelements.further_modes import further, stiffest
from bladewhirl.models.superelements.kept_reduction import Arrays, kept_reduction
from bladewhirl.models.superelements.mistuned import (
    blade_products,
    change_of_waves,
    coupled_waves,
    stiffened,
)
from bladewhirl.models.superelements.nodal_blocks import NodalBlock, sector_blocks
from bladewhirl.models.superelements.reduction import (
    FURTHER,
    RIGID_SECTOR,
    ReducedSuperelement,
    check_count,
    rigid_limit,
    root_of,
)
from bladewhirl.models.superelements.sector import Sector, Wave, sector_errors
from bladewhirl.models.superelements.stresses import RECOVERED, ReducedStress, recovered_rows
from bladewhirl.models.superelements.superelement import (
    FIXED,
    LOADS,
    RECOVERIES,
    IndefiniteError,
    Superelement,
    SuperelementError,
)

BY_FORCE = "_by_force"  #: what the name of a quantity has added for the part by contact forces

WAVE = (
    *("squares", "contact", "steady", "residual"),
    *(name + part for name in RECOVERED for part in ("", BY_FORCE)),
)
"""Arrays of one nodal diameter, see `_reduced`."""


def massless_wheel(
    part: Superelement, sectors: int, modes: int, file: str | None = None
) -> tuple[Superelement, ReducedSuperelement]:
    """Return the contact nodes of a wheel, and its reduction with a massless boundary.

    Contact nodes are numbered sector by sector, counter-clockwise. Points for pictures and gauges
    are those of all sectors.

    Args:
        part: sector with left_dofs and right_dofs.
        sectors: number of sectors.
        modes: number of free-interface modes for each nodal diameter; if it has two waves, for each
            of them.
        file: file of the sector, beside which its reduction is kept; None to keep nothing.

    Returns:
        a superelement with the contact nodes and the points of the wheel, whose coordinates are
        modal coordinates with diagonal matrices; and the reduction.

    Raises:
        SuperelementError: the sector has too few coordinates, takes too much memory, or has rigid
            modes.
    """

    def compute() -> Arrays:
        with sector_errors(RIGID_SECTOR):
            sector = Sector(part, sectors, modes=modes, loads=3 * part.contacts, rigid=False)
            found = sector.each_wave(lambda wave: _reduced(part, wave, modes))
            return {
                f"{name}_{k}": array for k, one in enumerate(found) for name, array in one.items()
            }

    kept = compute() if file is None else kept_reduction(file, part, (sectors, modes), compute)
    names = (*WAVE, *(key for key in FURTHER if getattr(part, key) is not None))
    waves = [{name: kept[f"{name}_{k}"] for name in names} for k in range(sectors // 2 + 1)]
    return _expanded(part, sectors, waves)


class WheelOverSpeeds:
    """A wheel of sectors whose reduction at a speed takes milliseconds.

    Its motions are the lowest modes of each nodal diameter, and the static displacements under
    forces on the contact nodes, at rest, at half and at all of the highest speed.
    """

    def __init__(
        self, part: Superelement, sectors: int, modes: int, highest: float, file: str
    ) -> None:
        """Reduce the sector, or read what was kept of an earlier reduction.

        Args:
            part: sector with left_dofs and right_dofs; with blade_stiffness if blades differ.
            sectors: number of sectors.
            modes: number of modes of each nodal diameter at a speed.
            highest: highest speed [rad/s].
            file: file of the sector, beside which its reduction is kept.

        Raises:
            SuperelementError: as for `massless_wheel`.
        """
        self._part, self._sectors, self._modes = part, sectors, modes
        self._given = [key for key in FURTHER if getattr(part, key) is not None]
        own = part.blade_stiffness

        def compute() -> Arrays:
            found = sector_blocks(part, sectors, modes + FURTHER_MODES, highest, touched=True)
            arrays: dict[str, FloatArray] = {}
            if own is not None:
                matrix = sp.csr_array(own)
                arrays["products"] = blade_products(matrix, [each.blade for each in found.values()])
            for k, block in found.items():
                values = vars(block) | {"blade": np.zeros((0, block.size))}
                arrays |= {f"{name}_{k}": one for name, one in values.items() if one is not None}
            return arrays

        kept = kept_reduction(file, part, (sectors, modes, highest), compute)
        self._products = kept.get("products")
        names = [field.name for field in fields_of(NodalBlock)]
        self._blocks = [
            NodalBlock(**{name: kept.get(f"{name}_{k}") for name in names})  # type: ignore[arg-type]
            for k in range(sectors // 2 + 1)
        ]

    def at(
        self, omega: float, factor: FloatArray | None = None, others: Sequence[float] = ()
    ) -> tuple[Superelement, ReducedSuperelement]:
        """Return the contact nodes of the wheel and its reduction at a speed, see `massless_wheel`.

        Args:
            omega: speed of rotation [rad/s].
            factor: factor on the stiffness of each blade, (sectors,); None if blades are equal.
            others: other speeds, see `_of_block`; none if blades differ.

        Raises:
            SuperelementError: the stiffness is not positive definite at this speed.
        """
        sectors, modes = self._sectors, self._modes
        if factor is None:
            waves = [
                _of_block(block, omega, modes, self._given, others=others) for block in self._blocks
            ]
            return _expanded(self._part, sectors, waves)
        waves = [_of_block(block, omega, modes, self._given, static=True) for block in self._blocks]
        wheel, reduced = _expanded(self._part, sectors, waves)
        change = change_of_waves(self._coupled(waves), factor)
        order = _order(waves, sectors)
        return wheel, stiffened(reduced, change[order][:, order], sectors * modes, factor)

    def blades_at(self, omega: float) -> FloatArray:
        """Return the stiffness of each blade on the modes of `at` at a speed [rad/s] [1/s2],
        (sectors, modes, modes)."""
        waves = [_of_block(block, omega, self._modes, self._given) for block in self._blocks]
        coupled, order = self._coupled(waves), _order(waves, self._sectors)
        each = (change_of_waves(coupled, 1.0 + unit) for unit in np.eye(self._sectors))
        return np.array([change[order][:, order] for change in each])

    def _coupled(self, waves: Sequence[Arrays]) -> ComplexArray:
        assert self._products is not None
        return coupled_waves(self._products, [wave["shapes"] for wave in waves], self._sectors)


def _expanded(
    part: Superelement, sectors: int, waves: Sequence[Arrays]
) -> tuple[Superelement, ReducedSuperelement]:
    """Return the wheel and its reduction from the arrays of each nodal diameter, see `_reduced`."""
    rows = 3 * part.contacts
    spread = np.asarray(2.0 * np.pi / sectors * np.arange(sectors), dtype=np.float64)
    frequency, contact, strains, stresses, loads = [], [], [], [], []
    matrices = (*FURTHER, "root")
    further: dict[str, list[FloatArray]] = {key: [] for key in matrices if key in waves[0]}
    for k, wave in enumerate(waves):
        pair = 0 < 2 * k < sectors
        for phases in _real_waves(k, spread):
            contact.append(np.vstack([(one * wave["contact"]).real for one in phases]))
            strains.append(np.vstack([(one * wave["strains"]).real for one in phases]))
            stresses.append(np.vstack([(one * wave["stresses"]).real for one in phases]))
            frequency.append(np.sqrt(wave["squares"]))
            if "loads" in wave:  # those of nodal diameter 0, on all sectors
                loads.append(np.sqrt(sectors) * wave["loads"].real)
        for key, blocks in further.items():
            blocks.append(_on_waves(wave[key], pair=pair))
    order = _order(waves, sectors)
    flexibility = _by_distance([wave["residual"] for wave in waves], sectors)
    compliance = np.block(
        [[flexibility[(i - j) % sectors] for j in range(sectors)] for i in range(sectors)]
    )

    def points() -> FloatArray:
        moved = []
        for k, wave in enumerate(waves):
            for phases in _real_waves(k, spread):
                each = np.stack([(one * wave["points"]).real for one in phases])
                each = each.reshape(sectors, -1, 3, each.shape[-1])
                turned = rotate(each, spread[:, None, None], axis=2)
                moved.append(turned.reshape(-1, each.shape[-1]))
        return np.hstack(moved)[:, order]

    def points_by_force(sums: sp.csr_array) -> FloatArray:
        given = sums.toarray().reshape(sums.shape[0], sectors, -1, 3)
        used = given.any(axis=(0, 1, 3))
        own = rotate(given[:, :, used], -spread[:, None], axis=3).reshape(len(given), sectors, -1)
        blocks = [wave["points" + BY_FORCE].reshape(-1, 3, rows)[used] for wave in waves]
        moved = np.zeros((len(given), sectors, rows))
        for n, block in enumerate(_by_distance(blocks, sectors)):
            moved += np.roll(own @ block.reshape(-1, rows), -n, axis=1)
        return moved.reshape(len(given), -1)

    values = np.asarray(np.concatenate(frequency)[order], dtype=np.float64)
    reduced = ReducedSuperelement(
        frequency=values,
        contact=np.hstack(contact)[:, order],
        compliance=0.5 * (compliance + compliance.T),
        centre=np.zeros((2, len(values))),
        of_points=points,
        points_by_force=points_by_force,
        strains=np.hstack(strains)[:, order],
        strains_by_force=_by_distance([wave["strains" + BY_FORCE] for wave in waves], sectors),
        stress=(
            ReducedStress(
                modes=np.hstack(stresses)[:, order],
                forces=_by_distance([wave["stresses" + BY_FORCE] for wave in waves], sectors),
                steady=np.tile(waves[0]["steady"], sectors) if len(waves[0]["steady"]) else None,
            )
            if part.stress_recovery is not None
            else None
        ),
        kept=len(values),
        loads=np.vstack(loads)[order].T if loads else np.zeros(0),
        **{key: la.block_diag(*blocks)[order][:, order] for key, blocks in further.items()},
    )
    return _wheel(part, spread, values), reduced


def _by_distance(blocks: Sequence[ComplexArray], sectors: int) -> FloatArray:
    """Return what unit forces on a sector do to the sector that is n sectors ahead, (sectors,
    ...), from what forces with each nodal diameter do to the first sector, (...)."""
    return np.asarray(np.fft.irfft(blocks, sectors, axis=0))


def _order(waves: Sequence[Arrays], sectors: int) -> IntArray:
    """Return the positions of all real modes, which are nodal diameter by nodal diameter, by
    frequency; as they are with Coriolis forces, which couple the modes of a nodal diameter."""
    twice = (1 + (0 < 2 * k < sectors) for k in range(len(waves)))
    tiled = [np.tile(wave["squares"], times) for wave, times in zip(waves, twice, strict=True)]
    squares = np.concatenate(tiled)
    if "gyroscopic" in waves[0]:
        return np.arange(len(squares))
    return np.argsort(np.sqrt(squares), kind="stable")


def _real_waves(k: int, spread: FloatArray) -> Iterator[list[complex]]:
    """Yield the complex amplitudes of all sectors, at the angles `spread`, in the cosine and in
    the sine wave of a nodal diameter, or in its single wave."""
    pair = 0 < 2 * k < len(spread)
    scale = np.sqrt((1 + pair) / len(spread))
    for phase in (1.0, -1j) if pair else (1.0,):
        yield [scale * phase * np.exp(1j * k * angle) for angle in spread]


def _reduced(part: Superelement, wave: Wave, modes: int) -> Arrays:
    """Return the modes of one nodal diameter, all for the first sector: squared frequencies
    [rad2/s2], (modes,); displacements of contact nodes and points, strains of gauges and stresses
    of points, (rows, modes) each, and the same by contact forces without their part in the modes,
    (rows, 3c); the stress by steady rotation, (6p,), see `ReducedStress`; the residual flexibility
    [m/N], (3c, 3c); and the optional matrices on the modes. What the file does not give is empty.

    Raises:
        SuperelementError: there are too few coordinates, or rigid modes.
    """
    if modes >= wave.size:
        raise SuperelementError(
            f"expected fewer than {wave.size} free-interface modes, the coordinates of a sector"
        )
    squares, shapes = wave.lowest(modes)
    check_count(len(squares), modes)
    if not squares[0] > rigid_limit(part):
        raise IndefiniteError(RIGID_SECTOR)
    forces = (part.contact_rows @ wave.tie).conj().T.toarray()
    moved = wave.static(forces, shapes)
    residual = forces.conj().T @ moved
    fields, rest, steady = wave.tie @ shapes, wave.tie @ moved, np.zeros(0)
    rows = recovered_rows(part)
    if part.centrifugal_load is not None and wave.diameter == 0:
        load = (wave.tie.T @ part.centrifugal_load)[:, None]
        still = wave.static(load, shapes) + shapes @ (shapes.T @ load / squares[:, None])
        steady = (rows["stresses"] @ (wave.tie @ still))[:, 0]
    return {
        **{name: matrix @ fields for name, matrix in rows.items()},
        **{name + BY_FORCE: matrix @ rest for name, matrix in rows.items()},
        "steady": steady,
        "squares": squares,
        "contact": part.contact_rows @ fields,
        "residual": 0.5 * (residual + residual.conj().T),
        **{
            key: fields.conj().T @ (matrix @ fields)
            for key in FURTHER
            if (matrix := getattr(part, key)) is not None
        },
    }


def _of_block(
    block: NodalBlock,
    omega: float,
    modes: int,
    given: Sequence[str],
    *,
    static: bool = False,
    others: Sequence[float] = (),
) -> Arrays:
    """Return the arrays of `_reduced` at a speed [rad/s] from a block, and the shapes of the modes.

    Args:
        block: matrices of a nodal diameter.
        omega: speed [rad/s].
        modes: number of modes.
        given: names of the optional matrices that the superelement has.
        static: whether the static displacements under the forces of blades follow the modes, as
            further orthogonal motions with their stiffness.
        others: other speeds [rad/s]; the lowest modes at the first one, and the static
            displacements by the loads of the rotation at all speeds are added, see
            `further_modes.further`.
    """
    stiffness = block.stiffness + block.change(omega)
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
        states = [la.eigh(block.stiffness + block.change(speed)) for speed in others]
        fields = [rest @ moved, states[0][1][:, :modes]]
        fields += [each @ (each.conj().T @ block.loads / own[:, None]) for own, each in states]
        own, added = further(stiffness, np.eye(block.size), shapes, np.hstack(fields), limit)
        by_force = by_force - (added / own) @ (block.contact @ added).conj().T
        shapes, squares = np.hstack([shapes, added]), np.concatenate([squares, own])
        loads = shapes.conj().T @ block.loads
    recovered = {name: getattr(block, name) for name in RECOVERED}
    forced = {name + BY_FORCE: rows @ by_force for name, rows in recovered.items()}
    if static:
        among = la.qr((rest.conj().T @ block.blade_loads) / stiff[:, None], mode="economic")[0]
        own, turn = la.eigh((among.conj().T * stiff) @ among)
        among = among @ turn
        moved = touched @ among
        by_force = by_force - (rest @ among / own) @ moved.conj().T
        forced["points" + BY_FORCE] = block.points @ by_force
        shapes, squares = np.hstack([shapes, rest @ among]), np.concatenate([squares, own])
        loads = shapes.conj().T @ block.loads
    matrices, residual = {key: getattr(block, key) for key in given}, block.contact @ by_force
    return {
        **{name: rows @ shapes for name, rows in recovered.items()},
        **forced,
        "squares": squares,
        "shapes": shapes,
        "contact": block.contact @ shapes,
        "steady": steady[:, 0].real if block.loads.any() else np.zeros(0),
        "loads": loads,
        "residual": 0.5 * (residual + residual.conj().T),
        "root": shapes.conj().T @ root_of(block.stiffness) @ shapes,
        **{key: shapes.conj().T @ matrix @ shapes for key, matrix in matrices.items()},
    }


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
    tie = sp.csr_array(cyclic_reduction(part, sectors, 0).transformation.real)
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
    for key in RECOVERIES:
        if (rows := getattr(part, key)) is not None:
            own = sp.kron(sp.eye_array(sectors), rows @ rest)
            recovered[key] = sp.csr_array((own + sp.kron(step, rows @ on)) @ turn.T)
    if (moved := recovered.get("recovery")) is not None:
        each = moved.toarray().reshape(sectors, -1, 3, moved.shape[1])
        recovered["recovery"] = rotate(each, spread[:, None, None], axis=2).reshape(moved.shape)
    loads = {
        key: turn @ np.tile((rest + on).T @ load, sectors)
        for key in LOADS
        if (load := getattr(part, key)) is not None
    }
    picture = _wheel(part, spread, np.ones(1))
    offset = tie.shape[1] * np.arange(sectors)[:, None, None]
    dofs = np.where(contact == FIXED, FIXED, contact + offset).reshape(-1, 3)
    return replace(
        picture,
        mass=assembled(part.mass),
        stiffness=assembled(part.stiffness),
        **{
            key: assembled(matrix)
            for key in (*FURTHER, "blade_stiffness")
            if (matrix := getattr(part, key)) is not None
        },
        contact_dofs=dofs,
        **recovered,
        **loads,
    )


def _turned_contact(contact: IntArray, size: int, angle: float) -> sp.csr_array:
    """Return the matrix that turns x and y of the contact nodes by an angle, (size, size)."""
    turn = sp.lil_array(sp.eye_array(size))
    c, s = np.cos(angle), np.sin(angle)
    for x, y, _ in contact:
        turn[x, x] = turn[y, y] = c
        turn[x, y], turn[y, x] = -s, s
    return sp.csr_array(turn)


def _wheel(part: Superelement, spread: FloatArray, frequency: FloatArray) -> Superelement:
    """Return the nodes and points of a wheel, with diagonal matrices of its modes."""
    positions = rotate(part.contact_position, spread[:, None]).reshape(-1, 3)
    changes: dict[str, Any] = dict.fromkeys(("strain_recovery", "stress_recovery"))
    changes |= dict.fromkeys(("young_modulus", "poisson_ratio", *LOADS))
    if part.points is not None:
        changes["points"] = rotate(part.points, spread[:, None]).reshape(-1, 3)
        changes["recovery"] = np.zeros((3 * len(changes["points"]), len(frequency)))
        if part.triangles is not None:
            count = len(part.points)
            changes["triangles"] = np.vstack(
                [part.triangles + n * count for n in range(len(spread))]
            )
    return replace(
        part,
        mass=np.eye(len(frequency)),
        stiffness=np.diag(frequency**2),
        damping=None,
        gyroscopic=None,
        stiffness_speed=None,
        stiffness_speed4=None,
        blade_stiffness=None,
        contact_position=positions,
        contact_dofs=np.full((len(positions), 3), -1),
        left_dofs=None,
        right_dofs=None,
        **changes,
    )

"""Bladed disks of superelements for modal analysis: blocks by nodal diameter, at any speed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.meshes.plane import directions, rotate
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import faults_at
from bladewhirl.models.case.superelement import SOURCE, SuperelementTable
from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.models.modal.labels import (
    LabelledModes,
    modes_of_blocks,
    named_at_speed,
    with_wave_families,
)
from bladewhirl.models.modal.modal_disk import UNEQUAL_SECTORS, ModalDisk
from bladewhirl.models.modal.modes import ListedModes, families, is_first_of_pair
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.modal.tip_motion import tip_motion
from bladewhirl.models.modal.touching import Tips
from bladewhirl.models.modal.whirl_modes import joined_modes, wave_modes
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.cone import compliance_in_wall_axes, in_wall_axes
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.superelement_structure import (
    FEWEST,
    Listed,
    blocks_of_sectors,
    is_of_equal_sectors,
    on_springs,
    structure_of,
    wheel_over_speeds,
    with_modes,
    without_rotation,
)
from bladewhirl.models.structure.rotating import Effects
from bladewhirl.models.structure.waves import Waves
from bladewhirl.models.superelements.nodal_blocks import (
    UNKNOWN,
    Blocks,
    NodalBlock,
    blade_blocks,
    block_of,
    wheel_blocks,
    with_clamped_centre,
)
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError

COUPLED, COUPLED_AT_ONE_SPEED, COUPLED_IN_SECTORS = 20, 100, 8
"""Number of further modes, which rotation, damping or a wall may couple to the chosen ones: of each
nodal diameter of a wheel or blade for modes at many speeds; of the whole for those at the speed of
the case; and of each nodal diameter of sectors, see `sector_blocks`."""


@dataclass(frozen=True, kw_only=True)
class MatrixDisk(ModalDisk):
    """A superelement, or its copies, on its modes by nodal diameter."""

    stage: Matrices  #: the structure at rest
    speed: float  #: speed of rotation of the case [rad/s], counter-clockwise
    blocks: Blocks  #: matrices with the effects of the rotation on this structure only
    count: int | None  #: number of modes to list; all if None

    @property
    def _table(self) -> SuperelementTable:
        return self.stage.case.bladed_disk.matrices

    @cached_property
    def labelled(self) -> LabelledModes:
        return self._labelled(self.blocks)

    @cached_property
    def listed(self) -> ListedModes:
        """The lowest modes; those of separate blades, which are the same for every nodal diameter,
        once."""
        blocks, listed = self.blocks, self.labelled
        if self._table.kind == "blade":
            blocks = {UNKNOWN: replace(self.blocks[0], nodal_diameter=UNKNOWN)}
            listed = self._labelled(blocks)
        lowest: ListedModes
        if self.effects == "full":
            copies = self._table.copies
            modes = joined_modes([wave_modes(each, self.speed, copies) for each in blocks.values()])
            modes = modes.take(np.argsort(modes.frequency, kind="stable")[: self.count])
            lowest = with_wave_families(modes, listed)
        else:
            count = min(self.count or listed.count, listed.count)
            lowest = listed.take(slice(count + is_first_of_pair(listed.column, count - 1)))
        if (found := self._dominant(lowest.amplitudes)) is not None:
            lowest = replace(lowest, nodal_diameter=found[0], purity=found[1])
        return lowest

    def _labelled(self, blocks: Blocks) -> LabelledModes:
        """Return the modes without Coriolis forces, with their families; the modes of a wheel whose
        blades differ or are not known have none."""
        copies = self._table.copies
        at_rest = _collected(blocks, copies, 0.0)
        if UNKNOWN not in blocks or self._table.kind == "blade":
            at_rest = replace(at_rest, family=tuple(families(at_rest, "bladed-disk", copies)))
        if self.effects != "centrifugal" or self.speed == 0.0:
            return at_rest
        turning = _collected(blocks, copies, self.speed)
        family, before = named_at_speed(turning, at_rest)
        return replace(turning, family=family, at_rest=before)

    def _dominant(
        self, amplitudes: Sequence[ComplexArray | FloatArray]
    ) -> tuple[IntArray, FloatArray] | None:
        """Return the dominant nodal diameter of each mode of a wheel whose blades differ, and its
        share in the motion of the contact nodes; None for other structures."""
        blades = self._table.copies
        if UNKNOWN not in self.blocks or blades == 1:
            return None
        part, block = self.stage.part, self.blocks[UNKNOWN]
        x, y = part.contact_position[:, :2].reshape(blades, -1, 2).mean(axis=1).T
        turns = np.exp(-1j * np.outer(np.arange(blades), np.arctan2(y, x)))
        moved = (block.contact @ np.stack(amplitudes, axis=-1)).reshape(blades, -1, len(amplitudes))
        power = (np.abs(np.einsum("kb,bim->kim", turns, moved)) ** 2).sum(axis=1)
        shares = power[: blades // 2 + 1].copy()
        shares[1 : (blades + 1) // 2] += power[: blades // 2 : -1]
        shares /= shares.sum(axis=0)
        return shares.argmax(axis=0), shares.max(axis=0)

    @property
    def waves(self) -> Mapping[int, Waves]:
        if UNKNOWN in self.blocks or np.ptp(self.stage.factor) > 0.0:
            raise UserError(UNEQUAL_SECTORS)
        return self.blocks

    @property
    def centre(self) -> ComplexArray:
        rows = self.blocks[1].centre
        return rows if rows.any() else rows[:0]

    @property
    def tips(self) -> Mapping[int, Tips]:
        stage, slope = self.stage, self.stage.slope
        if UNKNOWN in self.blocks:
            raise UserError(UNEQUAL_SECTORS)
        reduced = stage.reduced
        static = (reduced.contact / reduced.squares) @ reduced.contact.T + reduced.compliance
        static = compliance_in_wall_axes(static, slope)[::3, ::3]
        found, one = {}, self._table.kind == "blade"
        copies = 1 if one else self._table.copies
        own = len(static) // copies
        slope_of_own = slope[:own] if isinstance(slope, np.ndarray) else slope
        # Displacements of each blade, counter-clockwise from the first, by forces on the first.
        angle = np.mod(stage.angle.reshape(copies, -1)[:, 0] - stage.angle.flat[0], 2.0 * np.pi)
        distance = static.reshape(copies, own, copies, own)[np.argsort(angle), :, 0]
        for k, block in self.blocks.items():
            phases = np.exp(-2j * np.pi * k * np.arange(copies) / copies)
            flexibility = np.tensordot(phases, distance, 1)
            contact = in_wall_axes(block.contact[: 3 * own], slope_of_own)
            if self._table.kind == "wheel":  # the fields are those of the whole wheel
                contact = np.sqrt(copies) * contact
            radius = stage.part.contact_radius[:own]
            found[k] = Tips(contact=contact, radius=radius, flexibility=flexibility)
        return found

    @property
    def has_surface(self) -> bool:
        return self.stage.part.triangles is not None

    def points(self, modes: ListedModes, numbers: IntArray) -> ComplexArray:
        """Return some modes at the points of a copy, or of the whole structure [kg^-1/2], (modes,
        points, 3); a mode moves as Re(displacement exp(i w t)).

        Raises:
            UserError: no points are known.
        """
        part = self.stage.part
        if part.points is None:
            raise UserError(
                f"{part.name}: expected a superelement with points, where mode shapes are drawn"
            )
        columns, ahead, displacement = modes.column, modes.goes_ahead, []
        for mode in numbers.tolist():
            k, column = int(modes.nodal_diameter[mode]), int(columns[mode])
            if UNKNOWN in self.blocks or self._table.kind == "blade":
                field = next(iter(self.blocks.values())).points @ modes.amplitudes[mode]
                displacement.append(field.reshape(-1, 3))
                continue
            sine = -1j if column > 0 and column % 2 == 0 else 1.0
            field = sine * (self.blocks[k].points @ modes.amplitudes[mode])
            wave = self._around(k, field)
            displacement.append(wave.conj() if ahead[mode] else wave)
        moved = np.array(displacement, dtype=np.complex128).reshape(-1, *part.points.shape)
        turn = self._table.angle
        return np.asarray(rotate(moved.real, turn) + 1j * rotate(moved.imag, turn))

    def _around(self, k: int, field: ComplexArray) -> ComplexArray:
        """Return the displacements of the points of the whole structure, (points, 3), from those of
        its first sector, or of the whole wheel, with nodal diameter k."""
        if self._table.kind == "wheel":
            return np.asarray(field.reshape(-1, 3))
        turns = 2.0 * np.pi / self._table.copies * np.arange(self._table.copies)
        waves = (field * np.exp(1j * k * turns)[:, None]).reshape(len(turns), -1, 3)
        angle = turns[:, None]
        return (rotate(waves.real, angle) + 1j * rotate(waves.imag, angle)).reshape(-1, 3)

    def arrays(self, modes: ListedModes, numbers: IntArray, wall: Mapping[str, Any]) -> StageArrays:
        from scipy.spatial import KDTree  # long to load

        fields, stage = modes.real_fields(self.points(modes, numbers)), self.stage.shown_arrays
        first = np.full(len(stage.blade), True)
        if len(stage.copy_angle) > 1:
            first = stage.blade == 0
        radius, angle = stage.contact_radius[first], stage.tip_angle[first]
        nodes = np.column_stack([radius[:, None] * directions(angle), stage.axial_position[first]])
        moved = fields[:, KDTree(stage.point).query(nodes)[1]]
        names = ("blade", "node", "tip_angle", "contact_radius", "axial_position", "tip_recess")
        each, none = np.repeat(numbers, modes.REAL_FIELDS), np.zeros(0)
        return replace(
            stage,
            **{name: getattr(stage, name)[first] for name in names},
            point_number=none.astype(np.int64),
            point_young_modulus=none,
            point_poisson_ratio=none,
            stress_shape=none,
            sector_stress_shape=none,
            sector_point_shape=none,
            mode_wave=none.astype(np.int64),
            mode_partner=none.astype(np.int64),
            stress_by_force=none,
            steady_stress=none,
            copy_stiffness=none,
            **wall,
            rotor_frequency=modes.frequency[each],
            rotor_nodal_diameter=modes.nodal_diameter[each],
            contact_shape=np.moveaxis(rotate(moved, -angle), 0, -1),
            copy_angle=np.zeros(1),
            point_shape=np.moveaxis(fields, 0, -1),
            centre_shape=none,
            gauge_shape=none,
            gauge_by_force=none,
        )

    @property
    def tip_motions(self) -> tuple[str, ...]:
        part, modes, found = self.stage.part, self.listed, []
        copies = self._table.copies if self._table.kind == "wheel" else 1
        of_blade = self.stage.given.contacts // copies
        for k, amplitude in zip(modes.nodal_diameter.tolist(), modes.amplitudes, strict=True):
            block = self.blocks[UNKNOWN if UNKNOWN in self.blocks else max(k, 0)]
            moved = (block.contact @ amplitude).reshape(-1, of_blade, 3)
            most = int(np.linalg.norm(moved, axis=(1, 2)).argmax())
            place = part.contact_position[most * of_blade : (most + 1) * of_blade]
            found.append(tip_motion(place, moved[most]))
        return tuple(found)

    @property
    def hints(self) -> tuple[str, ...]:
        hints = super().hints
        if self._table.part.stiffness_speed is None:
            hints += (
                "the stiffness of the superelement is the same at every speed: its file has no"
                " stiffness_speed",
            )
        return hints


def still_stage(case: Case, count: int | None) -> Matrices:
    """Return the stage of a case with a superelement at rest, for modal analysis.

    Args:
        case: the case.
        count: number of modes to list; all if None.
    """
    table = case.bladed_disk.matrices
    still, listed = without_rotation(case), None
    if count is not None and case.reduction.boundary == "massless":
        if is_of_equal_sectors(case):
            listed = Listed(0.0, COUPLED_IN_SECTORS if _couples(case) else 0)
            if case.rotation.effects != "none":
                at = abs(case.march.speed.rad_per_s(0.0))  # 0 if the reference is needed
                listed = listed._replace(speed=at)
            still = with_modes(still, max(FEWEST, 2 * -(-count // (table.copies // 2 + 1))))
        elif table.kind != "sector":
            still = with_modes(still, FEWEST)  # the blocks have the modes that are listed
    return build_matrices(still, listed=listed)


def matrix_disks(
    case: Case, stage: Matrices, each: int, count: int | None, highest: float
) -> dict[str, ModalDisk]:
    """Return the bladed disk of a case with a superelement by the state of its centre: "free" if it
    moves, and "clamped".

    Args:
        case: the case.
        stage: what `still_stage` returns.
        each: number of modes of each nodal diameter.
        count: number of the lowest modes to list, in place of `each`.
        highest: highest speed at which the blocks are used [rad/s].

    Raises:
        CaseError: the superelement cannot be reduced as the case demands.
    """
    try:
        found = _blocks(case, stage, each, count, highest)
    except SuperelementError as error:
        raise CaseError(faults_at(case, f"{SOURCE}.file", error)) from None
    effects = case.rotation.effects
    return {
        centre: MatrixDisk(
            case=case,
            speed=case.march.speed.rad_per_s(stage.reference_frequency),
            # Coriolis forces act whenever the file has their matrix, unless the case excludes them.
            effects="full" if effects == "none" and _whirls(stage) else effects,
            stage=stage,
            blocks=_acted_on(blocks, effects),
            count=count,
        )
        for centre, blocks in found.items()
    }


def _whirls(stage: Matrices) -> bool:
    return stage.table.part.gyroscopic is not None


def _couples(case: Case) -> bool:
    """Return whether Coriolis forces couple the modes at a speed."""
    part = case.bladed_disk.matrices.part
    return part.gyroscopic is not None and case.rotation.effects != "centrifugal"


def _blocks(
    case: Case, stage: Matrices, each: int, count: int | None, highest: float
) -> dict[str, Blocks]:
    """Return the blocks of a structure by the state of its centre, see `matrix_disks`.

    Raises:
        SuperelementError: the superelement cannot be reduced as the case demands.
    """
    table, part, equal = stage.table, structure_of(case), is_of_equal_sectors(case)
    each = each if count is None else count
    between = count is None
    # At speeds between those of the blocks, and where the wall holds tips.
    couples = between or _couples(case)
    coupled = COUPLED if count is None else COUPLED_AT_ONE_SPEED
    if table.kind == "sector":
        coupled = COUPLED_IN_SECTORS
    further = coupled if couples else 0
    if table.kind == "blade":
        each += further
        return {"clamped": blade_blocks(part, table.copies, each, highest, between=between)}
    if case.bladed_disk.mistuning.is_given(table.copies) and table.kind == "sector":
        return {"clamped": {UNKNOWN: block_of(build_matrices(case).reduced)}}
    if equal and count is not None:
        return {"clamped": _lowest_blocks(stage.case, stage.given, count, further, highest)}
    if table.kind == "sector":
        blocks = blocks_of_sectors(stage.case, stage.given, each + further, highest)
        return {"clamped": blocks}
    total = (each + further) * (table.copies if count is None else 1)
    springs = case.shaft.stiffnesses
    states = {"clamped": part}
    if part.centre_dofs is not None:
        part = on_springs(case, part)
        states = {"free": part, "clamped": with_clamped_centre(part)}
    return {
        centre: wheel_blocks(state, springs, table.copies, total, highest, between=between)
        for centre, state in states.items()
    }


def _lowest_blocks(
    still: Case, part: Superelement, count: int, further: int, highest: float
) -> Blocks:
    """Return the blocks of equal sectors, which have the `count` lowest modes at a speed.

    Args:
        still: case without rotation, whose reduction has the modes to begin with.
        part: the sector.
        count: number of modes of the wheel.
        further: number of further modes of each nodal diameter.
        highest: the speed [rad/s]; 0 for modes at rest.
    """
    table, equal = still.bladed_disk.matrices, replace(part, blade_stiffness=None)
    known, blocks = dict[int, int](), dict[int, NodalBlock]()  # number of modes; blocks
    short, each = [*range(table.copies // 2 + 1)], still.reduction.free_interface_modes
    while short:
        if blocks:
            chosen: dict[str, Any] = {"static": further > 0, "diameters": short}
            own = (still, equal, each + further, highest)
            blocks |= blocks_of_sectors(*own, between=False, **chosen)
        else:
            wheel = wheel_over_speeds(still, equal, 0.0, Listed(highest, further))
            blocks = dict(enumerate(wheel.blocks))
        known |= dict.fromkeys(short, each)
        squares = {k: la.eigvalsh(blocks[k].stiffness_at(highest))[: known[k]] for k in blocks}
        every = np.sort(np.concatenate([*squares.values()]))
        limit = every[count - 1] if count <= len(every) else np.inf
        each = with_modes(still, 2 * each).reduction.free_interface_modes
        short = [k for k, found in squares.items() if found[-1] < limit and known[k] < each]
    return blocks


def _acted_on(blocks: Blocks, effects: Effects) -> Blocks:
    """Return blocks with effects of the rotation only; for "none" with any Coriolis forces."""
    if effects != "none":
        return {k: block.under(effects) for k, block in blocks.items()}
    still: dict[str, Any] = {"stiffness_speed": None, "stiffness_speed4": None}
    return {k: replace(block, **still) for k, block in blocks.items()}


def _collected(blocks: Blocks, sectors: int, omega: float) -> LabelledModes:
    """Return the modes of all blocks without Coriolis forces, ascending, without families."""
    found = []
    for k, block in blocks.items():
        square, vectors = la.eigh(block.stiffness_at(omega))
        found.append((k, square, vectors, block.shares(vectors)))
    return modes_of_blocks(found, sectors)

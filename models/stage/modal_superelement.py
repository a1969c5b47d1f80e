"""Modes and waves of a superelement in its case, at any speed of rotation."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg as la
from scipy.spatial import KDTree

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.meshes.plane import directions, rotate
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import faults_at
from bladewhirl.models.case.plausibility import stiffness_hints
from bladewhirl.models.case.superelement import SOURCE, SuperelementTable
from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.models.modal.describe import casing_arrays
from bladewhirl.models.modal.labels import (
    LabelledModes,
    modes_of_blocks,
    named_at_speed,
    wave_families,
)
from bladewhirl.models.modal.modal_model import (
    FAMILIES,
    UNEQUAL_SECTORS,
    ModalModel,
)
from bladewhirl.models.modal.modes import ListedModes, families, is_first_of_pair
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.modal.tip_motion import tip_motion
from bladewhirl.models.modal.touching import Tips
from bladewhirl.models.modal.whirl_modes import WhirlModes, joined_modes, wave_modes
from bladewhirl.models.rotation.unequal_bearings import on_unequal_bearings
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.cone import compliance_in_wall_axes, in_wall_axes
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.superelement_structure import (
    on_springs,
    structure_of,
    wheel_over_speeds,
    without_rotation,
)
from bladewhirl.models.structure.rotating import Effects
from bladewhirl.models.structure.waves import Waves
from bladewhirl.models.superelements.nodal_blocks import (
    UNKNOWN,
    Blocks,
    blade_blocks,
    block_of,
    sector_blocks,
    wheel_blocks,
    with_clamped_centre,
)
from bladewhirl.models.superelements.superelement import FIXED, Superelement, SuperelementError

COUPLED, COUPLED_AT_ONE_SPEED, COUPLED_IN_SECTORS = 20, 100, 8
"""Number of further modes, which rotation, damping or a wall may couple to the chosen ones: of each
nodal diameter of a wheel or blade for modes at many speeds; of the whole for those at the speed of
the case; and of each nodal diameter of sectors, see `sector_blocks`."""

FEWEST = 4  #: number of modes of each nodal diameter that are computed first where nothing couples


@dataclass(frozen=True, kw_only=True)
class ModalSuperelement(ModalModel):
    """A superelement, or its copies, and the casing in their modes."""

    stage: Matrices  #: the structure at rest
    families: int  #: number of families
    count: int | None  #: number of modes to list; all if None
    highest: float  #: highest speed for which the blocks are made [rad/s]

    def covering(self, highest: float) -> "ModalSuperelement":
        model = self
        if self.case.rotation.effects != "none" and highest > self.highest:
            model = replace(self, highest=highest)
        assert model.blocks
        return model

    @property
    def blocks(self) -> Blocks:
        """Matrices of each nodal diameter, with the effects of the rotation on this structure only;
        computed at first use.

        Raises:
            CaseError: the superelement cannot be reduced as the case demands.
        """
        return self._all_blocks[0]

    @property
    def clamped_blocks(self) -> Blocks | None:
        """The same with a clamped centre; None if no centre moves."""
        return self._all_blocks[1]

    @cached_property
    def _all_blocks(self) -> tuple[Blocks, Blocks | None]:
        try:
            found = _blocks(self)
        except SuperelementError as error:
            raise CaseError(faults_at(self.case, f"{SOURCE}.file", error)) from None
        effects = self.case.rotation.effects
        blocks, clamped = (each and _acted_on(each, effects) for each in found)
        assert blocks is not None
        return blocks, clamped

    @property
    def effects(self) -> Effects:
        """Effects of the rotation; Coriolis forces act whenever the file has their matrix, unless
        the case excludes them."""
        effects = self.case.rotation.effects
        if effects == "none" and self._table.part.gyroscopic is not None:
            return "full"
        return effects

    @property
    def centre(self) -> str:
        return "clamped" if self.clamped_blocks is None else "free"

    @cached_property
    def by_centre(self) -> dict[str, ListedModes]:
        listed = self.blocks
        if self._table.kind == "blade":  # the same for every nodal diameter
            listed = {UNKNOWN: replace(self.blocks[0], nodal_diameter=UNKNOWN)}
        found: dict[str, ListedModes] = {self.centre: self._modes(listed)}
        if self.clamped_blocks is not None:
            found["clamped"] = self._modes(self.clamped_blocks)
        return found

    @property
    def listed_modes(self) -> ListedModes:
        return self.by_centre[self.centre]

    @property
    def has_surface(self) -> bool:
        return self.stage.part.triangles is not None

    def points(self, numbers: IntArray) -> ComplexArray:
        """Return some of the listed modes at the points of a copy, or of the whole structure
        [kg^-1/2], (modes, points, 3); a mode moves as Re(displacement exp(i w t)).

        Raises:
            UserError: no points are known.
        """
        part, listed = self.stage.part, self.listed_modes
        if part.points is None:
            raise UserError(
                f"{part.name}: expected a superelement with points, where mode shapes are drawn"
            )
        amplitudes, columns = listed.amplitudes, listed.column
        ahead = np.full(listed.count, False)
        if isinstance(listed, WhirlModes):
            ahead = np.array(listed.direction) == "forward"  # p of exp(-i k angle)
        displacement = []
        for mode in numbers.tolist():
            k, column = int(listed.nodal_diameter[mode]), int(columns[mode])
            if UNKNOWN in self.blocks or self._table.kind == "blade":
                field = next(iter(self.blocks.values())).points @ amplitudes[mode]
                displacement.append(field.reshape(-1, 3))
                continue
            sine = -1j if column > 0 and column % 2 == 0 else 1.0
            field = sine * (self.blocks[k].points @ amplitudes[mode])
            wave = self._around(k, field)
            displacement.append(wave.conj() if ahead[mode] else wave)
        moved = np.array(displacement, dtype=np.complex128).reshape(-1, *part.points.shape)
        turn = self._table.angle
        return np.asarray(rotate(moved.real, turn) + 1j * rotate(moved.imag, turn))

    def shown_arrays(self, disk_modes: IntArray, casing_modes: IntArray) -> StageArrays:
        moving, listed, stage = self.points(disk_modes), self.listed_modes, self.stage.shown_arrays
        fields = moving.real
        if isinstance(listed, WhirlModes):
            fields = np.stack([fields, -moving.imag], axis=1).reshape(-1, *fields.shape[1:])
        first = np.full(len(stage.blade), True)
        if len(stage.copy_angle) > 1:
            first = stage.blade == 0
        radius, angle = stage.contact_radius[first], stage.tip_angle[first]
        nodes = np.column_stack([radius[:, None] * directions(angle), stage.axial_position[first]])
        moved = fields[:, KDTree(stage.point).query(nodes)[1]]
        names = ("blade", "node", "tip_angle", "contact_radius", "axial_position", "tip_recess")
        walls: dict[str, Any] = {}
        if self.casing is not None:
            walls = casing_arrays(self.casing, self.casing_modes.take(casing_modes))
        none = np.zeros(0)
        return replace(
            stage,
            **{name: getattr(stage, name)[first] for name in names},
            stress_shape=none,
            stress_by_force=none,
            steady_stress=none,
            copy_stiffness=none,
            **walls,
            rotor_frequency=np.repeat(listed.frequency[disk_modes], len(fields) // len(moving)),
            rotor_nodal_diameter=np.repeat(
                listed.nodal_diameter[disk_modes], len(fields) // len(moving)
            ),
            contact_shape=np.moveaxis(rotate(moved, -angle), 0, -1),
            copy_angle=np.zeros(1),
            point_shape=np.moveaxis(fields, 0, -1),
            centre_shape=none,
            gauge_shape=none,
            gauge_by_force=none,
        )

    def tip_motions(self, modes: ListedModes) -> tuple[str, ...]:
        part, copies = self.stage.part, self._table.copies
        of_blade = self.stage.given.contacts // (copies if self._table.kind == "wheel" else 1)
        clamped = self.clamped_blocks is not None and modes is self.by_centre["clamped"]
        blocks, found = self.clamped_blocks if clamped else self.blocks, []
        assert blocks is not None
        for k, amplitude in zip(modes.nodal_diameter.tolist(), modes.amplitudes, strict=True):
            block = blocks[UNKNOWN] if UNKNOWN in blocks else blocks[max(k, 0)]
            moved = (block.contact @ amplitude).reshape(-1, of_blade, 3)
            most = int(np.linalg.norm(moved, axis=(1, 2)).argmax())
            place = part.contact_position[most * of_blade : (most + 1) * of_blade]
            found.append(tip_motion(place, moved[most]))
        return tuple(found)

    def _around(self, k: int, field: ComplexArray) -> ComplexArray:
        """Return the displacements of the points of the whole structure, (points, 3), from those of
        its first sector, or of the whole wheel, with nodal diameter k."""
        if self._table.kind == "wheel":
            return np.asarray(field.reshape(-1, 3))
        turns = 2.0 * np.pi / self._table.copies * np.arange(self._table.copies)
        waves = (field * np.exp(1j * k * turns)[:, None]).reshape(len(turns), -1, 3)
        angle = turns[:, None]
        return (rotate(waves.real, angle) + 1j * rotate(waves.imag, angle)).reshape(-1, 3)

    @cached_property
    def disk_modes(self) -> LabelledModes:
        return self._labelled(self.blocks, self.speed if self.effects == "centrifugal" else 0.0)

    @property
    def waves(self) -> dict[int, Waves]:
        if UNKNOWN in self.blocks or np.ptp(self.stage.factor) > 0.0:
            raise UserError(UNEQUAL_SECTORS)
        found: dict[int, Waves] = {**self.blocks}
        difference = self.case.shaft.anisotropy
        if difference and self.clamped_blocks is not None and 1 in found:
            along_x = self.blocks[1].centre[0].conj()
            found[1] = on_unequal_bearings(found[1], along_x, difference)
        return found

    @property
    def tips(self) -> dict[int, Tips]:
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
    def shaft_waves(self) -> Waves:
        if self.clamped_blocks is None:
            raise UserError(
                f'critical speeds: expected {SOURCE}.kind = "wheel" with centre_dofs: this'
                f" {self._table.kind} has no centre that whirls on the springs of the shaft"
            )
        if self.case.rotation.effects != "full":
            raise UserError(
                'critical speeds: expected rotation.effects = "full" (--set rotation.effects=full),'
                f" got {self.case.rotation.effects}: without spin softening no whirl is stationary"
                " in rotating axes"
            )
        return self.waves[1]

    @property
    def shaft_block(self) -> Waves:
        if self.clamped_blocks is None:
            raise UserError(
                f'veering: expected {SOURCE}.kind = "wheel" with centre_dofs: this'
                f" {self._table.kind} has no centre that can be free or clamped"
            )
        wave, block = self.waves[1], self.blocks[1]
        whirl = (block.centre[0] - 1j * block.centre[1]) / np.sqrt(2.0)
        # New coordinates, of which the last one is the whirl of the centre and the others leave it
        # at rest.
        turn = np.linalg.qr(whirl.conj()[:, None], mode="complete")[0][:, ::-1].copy()
        turn[:, -1] /= whirl @ turn[:, -1]
        return Waves.on_springs(wave.on(turn), 0.0)

    def growth(self, omegas: FloatArray) -> FloatArray | None:
        return None

    @property
    def clearance_gone(self) -> float:
        return float("nan")

    @property
    def hints(self) -> tuple[str, ...]:
        hints = tuple(stiffness_hints(self.case))
        if self._table.part.stiffness_speed is None:
            hints += (
                "the stiffness of the superelement is the same at every speed: its file has no"
                " stiffness_speed",
            )
        return hints

    @property
    def _table(self) -> SuperelementTable:
        return self.stage.table

    def _modes(self, blocks: Blocks) -> ListedModes:
        """Return the lowest modes at the speed of the case."""
        copies, omega = self._table.copies, self.speed
        listed: ListedModes
        if self.effects == "full":
            waves = [wave_modes(block, omega, copies) for block in blocks.values()]
            modes = joined_modes(waves)
            modes = modes.take(np.argsort(modes.frequency, kind="stable")[: self.count])
            family, before = wave_families(self._labelled(blocks, 0.0), modes)
            listed = replace(modes, family=family, at_rest=before)
        else:
            labelled = self._labelled(blocks, omega)
            count = min(self.count or labelled.count, labelled.count)
            listed = labelled.take(slice(count + is_first_of_pair(labelled.column, count - 1)))
        if (found := self._dominant(blocks, listed.amplitudes)) is not None:
            listed = replace(listed, nodal_diameter=found[0], purity=found[1])
        return listed

    def _labelled(self, blocks: Blocks, omega: float) -> LabelledModes:
        """Return the modes without Coriolis forces at a speed [rad/s], with their families; the
        modes of a wheel whose blades differ or are not known have none."""
        copies = self._table.copies
        at_rest = _collected(blocks, copies, 0.0)
        if UNKNOWN not in blocks or self._table.kind == "blade":
            at_rest = replace(at_rest, family=tuple(families(at_rest, "bladed-disk", copies)))
        if omega == 0.0 or self.case.rotation.effects == "none":
            return at_rest
        turning = _collected(blocks, copies, omega)
        family, before = named_at_speed(turning, at_rest)
        return replace(turning, family=family, at_rest=before)

    def _dominant(
        self, blocks: Blocks, amplitudes: Sequence[ComplexArray | FloatArray]
    ) -> tuple[IntArray, FloatArray] | None:
        """Return the dominant nodal diameter of each mode of a wheel whose blades differ, and its
        share in the motion of the contact nodes; None for other structures."""
        blades = self._table.copies
        if UNKNOWN not in blocks or self._table.kind == "blade" or blades == 1:
            return None
        part, block = self.stage.part, blocks[UNKNOWN]
        x, y = part.contact_position[:, :2].reshape(blades, -1, 2).mean(axis=1).T
        turns = np.exp(-1j * np.outer(np.arange(blades), np.arctan2(y, x)))
        moved = (block.contact @ np.stack(amplitudes, axis=-1)).reshape(blades, -1, len(amplitudes))
        power = (np.abs(np.einsum("kb,bim->kim", turns, moved)) ** 2).sum(axis=1)
        shares = power[: blades // 2 + 1].copy()
        shares[1 : (blades + 1) // 2] += power[: blades // 2 : -1]
        shares /= shares.sum(axis=0)
        return shares.argmax(axis=0), shares.max(axis=0)


def modal_superelement(
    case: Case, *, families: int = FAMILIES, count: int | None = None, highest: float = 0.0
) -> ModalSuperelement:
    """Return a superelement and the casing in their modes, of which those of the superelement are
    computed at first use.

    Args:
        case: case with a superelement.
        families: number of modes of each nodal diameter.
        count: number of the lowest modes to list, in place of `families`.
        highest: highest speed at which modes are needed besides that of the case [rad/s].

    Raises:
        CaseError: the superelement cannot be reduced as the case demands.
    """
    table = case.bladed_disk.superelement
    assert table is not None
    still = without_rotation(case)
    if _is_of_equal_sectors(case) and count is not None:
        still = _with_modes(still, max(FEWEST, 2 * -(-count // (table.copies // 2 + 1))))
    stage = build_matrices(still)
    if case.rotation.effects != "none":
        highest = max(highest, abs(case.march.speed.rad_per_s(stage.reference_frequency)))
    return ModalSuperelement(
        case=case,
        reference_frequency=stage.reference_frequency,
        casing=stage.casing if stage.reduced_casing.is_flexible else None,
        casing_modes=stage.casing_modes,
        stage=stage,
        families=families,
        count=count,
        highest=highest,
    )


def _is_of_equal_sectors(case: Case) -> bool:
    """Return whether the modes of sectors with a massless boundary are listed."""
    table = case.bladed_disk.superelement
    assert table is not None
    mistuned = case.bladed_disk.mistuning.is_given(table.copies)
    return table.kind == "sector" and not mistuned and case.reduction.boundary == "massless"


def _blocks(model: ModalSuperelement) -> tuple[Blocks, Blocks | None]:
    """Return the blocks of a structure, and those with a clamped centre if its centre moves.

    Raises:
        SuperelementError: the superelement cannot be reduced as the case demands.
    """
    case, stage, count, highest = model.case, model.stage, model.count, model.highest
    table, part, equal = stage.table, structure_of(case), _is_of_equal_sectors(case)
    each = model.families if count is None else count
    couples = part.gyroscopic is not None or part.damping is not None
    if count is None or (case.rotation.effects != "none" and not equal):
        couples = True  # at speeds between those of the blocks, and where the wall holds tips
    coupled = COUPLED if count is None else COUPLED_AT_ONE_SPEED
    if table.kind == "sector":
        coupled = COUPLED_IN_SECTORS
    further = coupled if couples else 0
    if table.kind == "blade":
        return blade_blocks(part, table.copies, each + further, highest), None
    if case.bladed_disk.mistuning.is_given(table.copies) and table.kind == "sector":
        return {UNKNOWN: block_of(build_matrices(case).reduced)}, None
    if equal and count is not None:
        return _lowest_blocks(stage.case, stage.given, count, further, highest), None
    if table.kind == "sector":
        return sector_blocks(stage.given, table.copies, each + further, highest), None
    total = (each + further) * (table.copies if count is None else 1)
    springs = case.shaft.stiffnesses
    part = part if part.centre_dofs is None else on_springs(case, part)
    blocks = wheel_blocks(part, springs, table.copies, total, highest)
    if part.centre_dofs is None:
        return blocks, None
    fixed = with_clamped_centre(part)
    return blocks, wheel_blocks(fixed, springs, table.copies, total, highest)


def _with_modes(case: Case, each: int) -> Case:
    """Return a case whose sector is reduced to some modes of each nodal diameter, or all but one
    of them."""
    table = case.bladed_disk.superelement
    assert table is not None
    part = table.part
    assert part.right_dofs is not None
    most = part.size - int(np.count_nonzero(part.right_dofs != FIXED)) - 1
    reduction = case.reduction.model_copy(update={"free_interface_modes": min(each, most)})
    return case.model_copy(update={"reduction": reduction})


def _lowest_blocks(
    still: Case, part: Superelement, count: int, further: int, highest: float
) -> Blocks:
    """Return the blocks of equal sectors, which have the `count` lowest modes at a speed.

    Args:
        still: case without rotation, whose reduction has the modes to begin with.
        part: the sector.
        count: number of modes of the wheel.
        further: number of further modes of each nodal diameter.
        highest: the speed [rad/s]; 0 for modes at rest, where the reduction of the case is used.
    """
    table, equal = still.bladed_disk.superelement, replace(part, blade_stiffness=None)
    assert table is not None
    while True:
        each = still.reduction.free_interface_modes
        if highest or further:
            blocks = sector_blocks(equal, table.copies, each + further, highest, between=False)
        else:
            blocks = dict(enumerate(wheel_over_speeds(still, equal, 0.0).blocks))
        squares = [la.eigvalsh(block.stiffness_at(highest))[:each] for block in blocks.values()]
        reached = min(found.max() for found in squares)
        if each >= count or np.count_nonzero(np.concatenate(squares) <= reached) >= count:
            return blocks
        still = _with_modes(still, 2 * each)
        if still.reduction.free_interface_modes == each:
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

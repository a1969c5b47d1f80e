"""The stage of a shaft line with a wheel that rubs: rotor and wheels in the modes of their whole.

The rotor without its bearings is a superelement in rotating axes, see `models.shaft_line.rotor`, on
which the rotation acts in full. Its modes contain the static displacements by forces of the
bearings. Contact nodes are those of the wheel of [bladed_disk].
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.case.analysis import MODES, Contact, Initial, March
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.casing import Casing
from bladewhirl.models.case.excitation import EngineOrder, NoExcitation
from bladewhirl.models.case.file import case_fault, faults_at, with_values
from bladewhirl.models.case.shaft_line import WheelWall
from bladewhirl.models.case.superelement import SOURCE, SuperelementTable
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.shaft_line.line import LineModel, line_model
from bladewhirl.models.shaft_line.rotor import (
    LineRotor,
    OnLine,
    line_rotor,
    linearised,
    wheel_with_hub,
)
from bladewhirl.models.stage.blade_loss import recess_without
from bladewhirl.models.stage.build_matrices import other_speeds
from bladewhirl.models.stage.cone import slopes
from bladewhirl.models.stage.contact_problem import ContactProblem, LostBlades
from bladewhirl.models.stage.damaged_rotor import (
    DamagedRotor,
    changes_of_coordinates,
    damaged_rotor,
)
from bladewhirl.models.stage.excitations import excitation_loads
from bladewhirl.models.stage.further_wheels import further_arrays
from bladewhirl.models.stage.kept_modes import KeptModes
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.stage.modal_loads import Load, Start
from bladewhirl.models.stage.on_line import StageOnLine, with_supports
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.ring import Ring, stage_casing
from bladewhirl.models.stage.speed_change import with_drive, with_rotation
from bladewhirl.models.stage.varying_speed import SpeedChange
from bladewhirl.models.superelements.free_motions import SLOWEST, FreeMotions
from bladewhirl.models.superelements.reduction import (
    ReducedSuperelement,
    boundary_size,
    consistent,
    massless,
)
from bladewhirl.models.superelements.superelement import HUB, Superelement, SuperelementError

KEPT_ROTORS = 2  #: number of rotors at rest that are kept for further speeds

WITHOUT_MOTION = {
    "title": "",
    "casing": Casing(),
    "march": March(),
    "contact": Contact(),
    "excitation": NoExcitation(),
    "initial": Initial(),
}
"""Tables of a case on which its rotor at rest does not depend, by name."""

LEAST_INERTIA = 0.02
"""Smallest share of the moment of inertia that turns with the drive, with which a free speed is
that of the rotor rather than of its torsion."""


@dataclass(frozen=True, kw_only=True, repr=False)
class RotorOnLine(StageOnLine, Matrices):
    """A shaft line with wheels, reduced; the masses of its supports are modes of the casing."""

    part: LineRotor
    ring: Ring  #: the casing without supports, with the rings of all wheels
    on_line: OnLine  #: the rotor at rest
    wheels: tuple[Superelement, ...]  #: its wheels with their hubs

    def with_case(self, case: Case) -> "RotorOnLine":
        case = case.in_seconds(self.reference_frequency)
        # The modes are those of all speeds, and keep the momentum in steps of a length.
        if case.march.varies or case.march.time_step != self.case.march.time_step:
            return build_rotor_on_line(case, self.ring)
        return replace(self, case=case)

    def at(self, omega: float) -> "RotorOnLine":
        at_speed = {"march.speed": omega / self.reference_frequency}
        return replace(
            build_rotor_on_line(with_values(self.case, at_speed), self.ring), omega=omega
        )

    @property
    def over_many_speeds(self) -> "RotorOnLine":
        """The stage itself, whose rotor at rest is kept for other speeds."""
        return self

    @cached_property
    def rotor(self) -> ReducedRotor:
        return self.without_dampers

    @property
    def damping_ratio(self) -> FloatArray:
        return np.zeros(self.reduced.size)

    def by_velocity(self, speed: float) -> FloatArray:
        damping = self.reduced.drag(speed)
        return np.asarray(damping if self.reduced.root is None else damping + self.reduced.root)

    @property
    def _rows(self) -> FloatArray:
        """The six displacements of each node, (nodes, 6, modes)."""
        return np.asarray(self.part.line_rows @ self._shapes).reshape(-1, HUB, self.reduced.size)

    @property
    def _shapes(self) -> FloatArray:
        assert self.reduced.shapes is not None
        return self.reduced.shapes

    @cached_property
    def line_nodes(self) -> ComplexArray:
        x, y, _, about_x, about_y, _ = self._rows.swapaxes(0, 1)
        return np.stack([x + 1j * y, about_y - 1j * about_x], axis=1)

    @property
    def line_along(self) -> FloatArray:
        return self._rows[:, [2, 5]]

    @property
    def weight_rows(self) -> FloatArray:
        return self.part.weight_rows @ self._shapes

    @property
    def slope(self) -> float | FloatArray:
        first = slopes(self.case.casing, self._each(self.axial_position)[0])
        return self._by_wheel(first, [wall.slope for wall in self._walls])

    @property
    def recess(self) -> FloatArray:
        """See `Matrices.recess`; that of further wheels also has the difference of the clearances
        of their rigid walls from that of the first."""
        if self.case.casing.type == "ring":
            return super().recess
        first, radius = self.case.casing.clearance, self.part.contact_radius
        further = [
            wall.clearance - first + (0.0 if wall.radius is None else wall.radius - own)
            for wall, own in zip(self._walls, self._each(radius)[1:], strict=True)
        ]
        return np.asarray(self._by_wheel(self._each(super().recess)[0], further))

    @property
    def _walls(self) -> list[WheelWall]:
        """Walls of further wheels."""
        further = self.line.table.walls.values()
        return [one.casing for one in further if one.casing is not None]

    def _each(self, values: FloatArray) -> list[FloatArray]:
        """Return the values of the contact nodes of each wheel that has a wall."""
        return np.split(values, np.cumsum(self.part.wheel_nodes)[:-1])

    def _by_wheel(
        self, first: float | FloatArray, further: Sequence[float | FloatArray]
    ) -> float | FloatArray:
        """Return values of all contact nodes, (nodes,), from those of each wheel; the first ones if
        they are one number for all."""
        if np.ndim(first) == 0 and all(np.ndim(one) == 0 and one == first for one in further):
            return first
        each = zip((first, *further), self.part.wheel_nodes, strict=True)
        return np.concatenate([np.broadcast_to(one, count) for one, count in each])

    def clearance_key(self, node: int) -> str:
        wheel = int(np.searchsorted(np.cumsum(self.part.wheel_nodes), node, side="right"))
        keys = [f"shaft_line.{key}.clearance" for key in self.line.table.walls]
        return ["casing.clearance", *keys][wheel]

    @cached_property
    def without_dampers(self) -> ReducedRotor:
        rotor, nodes = super().without_dampers, self.part.wheel_nodes
        if self.reduced_casing.walls == 1:
            return rotor
        return replace(rotor, wall=np.repeat(np.arange(len(nodes)), nodes))

    def wall_arrays(self, modes: IntArray) -> dict[str, Any]:
        return self.ring.wall_arrays(modes[: self.reduced_casing.wall_modes])

    def unit_forces(self, load: EngineOrder) -> FloatArray:
        return self._on_first(super().unit_forces(load))

    def static_answer(self, load: EngineOrder) -> FloatArray:
        return self._on_first(super().static_answer(load))

    def _on_first(self, forces: FloatArray) -> FloatArray:
        """Return the forces of an engine order, which acts on the blades of the first wheel."""
        first = np.arange(len(forces)) < self.table.copies
        return np.asarray(np.where(first[:, None], forces, 0.0))

    @property
    def inertia(self) -> float:
        reduced, load = self.reduced, self.reduced.centrifugal_load
        assert load is not None
        steady = self.speed**2 * load / reduced.squares
        grown = (2.0 * load - reduced.slope(self.speed) @ steady) @ steady
        return float(self.undeformed_inertia + grown)

    @property
    def undeformed_inertia(self) -> float:
        """Moment of inertia about the axis of all that turns, at rest [kg m2]."""
        of_wheels = sum(wheel.polar_inertia for wheel in self.line.wheels)
        return super().inertia + self.line.polar_inertia + of_wheels

    def without_blades(self, given: ContactProblem, turning: ContactProblem) -> LostBlades:
        case, loss, speed = self.case, self.case.blade_loss, self.speed
        assert loss is not None
        assert loss.damaged is not None
        sectors = self.table.copies if self.table.kind == "sector" else 1
        try:
            rest = damaged_rotor(
                *(self.line, self.on_line, self.wheels, loss.damaged.with_hub, sectors, speed),
                partial(_prepared, case, self.line),
            )
            release = rest.release(speed)
            reduced_at = partial(_damaged_at, case, rest, release["constant"], self.reduced)
            reduced = reduced_at(speed, other_speeds(case, self.reference_frequency))
        except SuperelementError as error:
            raise CaseError(faults_at(case, "blade_loss.damaged.file", error)) from None
        if (gone := np.unique(self.blade[rest.lost]).tolist()) != sorted(loss.blade):
            named = ", ".join(map(str, gone)) or "none"
            expected = f"the blades whose contact nodes the damaged wheel lacks: {named}"
            raise CaseError([case_fault(case, "blade_loss.blade", expected)])
        after = replace(
            self,
            part=rest.on_line.rotor,
            on_line=rest.on_line,
            reduced=reduced,
            reduced_at=reduced_at,
            kept=replace(self.kept, rotor=np.arange(reduced.size)),
        )
        problem = after.released(given, release, rest)
        limit = problem.critical_time_step
        if not case.march.time_step < limit:
            expected = f"less than the critical step {limit:.6g} s of what remains after the loss"
            raise CaseError([case_fault(case, "march.time_step", expected)])
        mass, own = rest.on_line.rotor.mass, self._shapes[rest.kept]
        restriction, extension = changes_of_coordinates(mass, own, after._shapes)
        tips = np.flatnonzero(rest.lost)
        clearance = float(case.casing.clearance_profile.smallest)
        reach = given.rotor.tip_recess[tips] + self.blade_length + clearance
        rotor = replace(problem.rotor, tip_recess=recess_without(given, tips, reach))
        return LostBlades(
            time=loss.time,
            after=replace(problem, rotor=rotor),
            restriction=restriction,
            extension=extension,
            tips=tips,
            reach=reach,
        )

    def released(
        self, given: ContactProblem, release: dict[str, FloatArray], rest: DamagedRotor
    ) -> ContactProblem:
        """Return the contact problem of this stage after a loss.

        Args:
            given: contact problem of the whole rotor at a constant speed.
            release: see `DamagedRotor.release`.
            rest: the rotor of this stage.
        """
        case, modes, still = self.case, self._shapes, self.casing_rest
        patterns = {name: modes.T @ force for name, force in release.items()}
        freed = Load(rotor=patterns.pop("constant"), casing=still)
        problem = replace(
            given,
            rotor=self.bodies[0],
            bearings=self.bearings,
            loads=(*excitation_loads(self), *self.own_loads, freed),
            start=Start.of_rotor(self.rotor_rest, self.rotor_rest, len(still)),
        )
        course = case.march.course(self.reference_frequency)
        if course is None:
            return problem
        change = SpeedChange(
            course=course, rotor=self.turning.rotor, compliance=self.compliance_over(course)
        )
        problem = with_rotation(problem, change, **patterns)
        whole = self.line.wheels[0].polar_inertia
        return with_drive(case, problem, self.undeformed_inertia - whole + rest.inertia)

    @property
    def own_properties(self) -> dict[str, Any]:
        return {"modes": self.reduced.size, "copies": self.table.copies}

    def own_hints(self) -> Iterator[str]:
        """Yield a warning if what the drive turns rigidly has almost no inertia."""
        drive = self.case.march.drive
        if drive is None:
            return
        across = self.turning.patterns["by_acceleration"]
        stiff = self.inertia - float(across @ across)
        if stiff < LEAST_INERTIA * self.inertia:
            yield (
                f"march.drive.inertia = {drive.inertia:g} kg m2: the rotor twists against a drive"
                " of almost no inertia, whose speed then follows each vibration; give at least"
                f" {LEAST_INERTIA * self.inertia:.2g} kg m2"
            )

    @property
    def fewer_modes(self) -> str:
        return f"fewer shaft_line.segments.elements, {super().fewer_modes}"

    @cached_property
    def shown_arrays(self) -> StageArrays:
        table, hub = self.line.table, self.wheels[0].hub_position
        assert hub is not None
        wheel = np.repeat(table.walled, self.part.wheel_nodes)
        return replace(
            super().shown_arrays,
            wheel=wheel if self._walls else wheel[:0],
            shaft_position=self.line.position,
            shaft_radius=self.line.outer_radius,
            wheel_origin=float(self.line.position[self.line.wheels[0].node] - hub[2]),
            bearing_name=table.named(),
            bearing_node=np.array([self.line.node(each.position) for each in table.bearings]),
            **further_arrays(*(self.line, self.wheels, self.part, self._shapes, self.table.angle)),
        )


def build_rotor_on_line(case: Case, ring: Ring | None = None) -> RotorOnLine:
    """Return the stage of a case with a wheel on its shaft line.

    Args:
        case: the case.
        ring: its casing without supports, if it is known.

    Raises:
        CaseError: the bearings do not hold the line, or the rotor cannot be reduced as the case
            demands.
    """
    try:
        line = line_model(case)
        wheels, at_rest = _at_rest(case.model_copy(update=WITHOUT_MOTION))
        case = case.in_seconds(line.reference_frequency)
        on_line = _prepared(case, line, at_rest)
        reduced_at = partial(_reduced_at, case, on_line)
        others = other_speeds(case, line.reference_frequency)
        reduced = reduced_at(line.speed, others)
    except SuperelementError as error:
        raise CaseError(faults_at(case, f"{SOURCE}.file", error)) from None
    ring, rotor = stage_casing(case) if ring is None else ring, on_line.rotor
    wall = with_supports(ring.reduced_casing, line.table.supports)
    return RotorOnLine(
        case=case,
        casing=ring.casing,
        casing_modes=ring.casing_modes,
        reduced_casing=wall,
        reference_frequency=line.reference_frequency,
        ring=ring,
        on_line=on_line,
        wheels=wheels,
        line=line,
        part=rotor,
        given=rotor,
        shown=np.arange(rotor.point_count),
        reduced=reduced,
        reduced_at=reduced_at,
        build=build_rotor_on_line,
        blade=_blades(rotor.wheel_nodes, _rubbing(case)),
        kept=KeptModes(
            rotor=np.arange(reduced.size),
            casing=np.arange(len(wall.frequency)),
            coupled=None,
            springs=None,
        ),
    )


@lru_cache(maxsize=KEPT_ROTORS)
def _at_rest(case: Case) -> tuple[tuple[Superelement, ...], OnLine]:
    """Return the wheels with their hubs and the rotor at rest of a case, which are those of cases
    that differ in speed, load, contact and casing."""
    line = line_model(case)
    tables = (case.bladed_disk.matrices, *(one.superelement for one in line.table.wheels))
    wheels = tuple(wheel_with_hub(one.with_hub, one.copies) for one in tables)
    return wheels, line_rotor(line, wheels)


def _rubbing(case: Case) -> list[SuperelementTable]:
    """Return the tables of the wheels that have a wall, first that of [bladed_disk]."""
    assert case.shaft_line is not None
    further = case.shaft_line.walls.values()
    return [case.bladed_disk.matrices, *(one.superelement for one in further)]


def _blades(nodes: Sequence[int], tables: Sequence[SuperelementTable]) -> IntArray:
    """Return the number of the blade of each contact node, counted on from wheel to wheel."""
    counts = [table.copies for table in tables]
    each = [first // count for first, count in zip(nodes, counts, strict=True)]
    return np.repeat(np.arange(sum(counts)), np.repeat(each, counts))


def _prepared(case: Case, line: LineModel, on_line: OnLine) -> OnLine:
    """Return a rotor as the case needs it: linearised for a free speed."""
    if case.march.drive is None:
        return on_line
    return on_line._replace(rotor=linearised(on_line.rotor, line.speed))


def _damaged_at(
    case: Case,
    rest: DamagedRotor,
    force: FloatArray,
    whole: ReducedSuperelement,
    omega: float,
    others: tuple[float, ...] = (),
) -> ReducedSuperelement:
    """Return what remains of a rotor in its modes at a speed [rad/s], with all contact nodes.

    Args:
        case: the case.
        rest: what remains.
        force: force by the loss, whose static displacement is added to the modes, (n,).
        whole: the whole rotor in its modes.
        omega: speed [rad/s].
        others: see `_reduced_at`.
    """
    on_line, stays = rest.on_line, ~rest.lost
    rotor = on_line.rotor
    rotor = replace(
        rotor,
        contact_position=rotor.contact_position[stays],
        contact_dofs=rotor.contact_dofs[stays],
    )
    pushed = np.column_stack([on_line.forces, force])
    reduced = _reduced_at(case, on_line._replace(rotor=rotor, forces=pushed), omega, others)
    return rest.with_lost_nodes(reduced, whole)


def _reduced_at(
    case: Case, on_line: OnLine, omega: float, others: tuple[float, ...] = ()
) -> ReducedSuperelement:
    """Return the rotor in its modes at a speed [rad/s], with the modes and static displacements of
    other speeds that `massless` adds."""
    root, forces, reduction = on_line.damping, on_line.forces, case.reduction
    part, *slower = (on_line.rotor.at(speed) for speed in (omega, *others))
    angle, free = abs(omega) * case.march.time_step, None
    if on_line.rigid is not None and angle > SLOWEST:
        free = FreeMotions(on_line.rigid, angle)
    if reduction.boundary == "massless":
        modes = min(reduction.free_interface_modes, part.size - 1)
        return massless(part, modes, root, slower, forces, free)
    kept = reduction.fixed_interface_modes
    if kept == MODES:  # the default: all modes of a small superelement
        kept = min(kept, part.size - boundary_size(part))
    return consistent(part, kept, kept, root, slower, forces, free)

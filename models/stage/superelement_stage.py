"""The stage of a superelement: its reduction, and its contact problem."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.analysis import MODES
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder, Imbalance
from bladewhirl.models.case.file import case_fault, faults_at
from bladewhirl.models.case.superelement import SOURCE, SuperelementTable
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.imports.inspection import NEGATIVE
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.modal.describe import casing_arrays
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.stage.coating import node_coating, tip_thickness
from bladewhirl.models.stage.cone import in_cone, slopes
from bladewhirl.models.stage.contact_problem import (
    ContactProblem,
    ReducedCasing,
    ReducedRotor,
    Start,
    WallClosure,
    WallCoating,
)
from bladewhirl.models.stage.excitations import LoadedStage, closing_unbalance, direction, loads_on
from bladewhirl.models.stage.ring import Ring, flexible_ring, rigid_wall
from bladewhirl.models.stage.superelement_loads import (
    blade_angles,
    blade_means,
    centre_rows,
    engine_order_forces,
    mean_along,
    static_shapes,
)
from bladewhirl.models.stage.superelement_springs import coupling_springs
from bladewhirl.models.stage.superelement_structure import (
    assembled,
    damping_root,
    over_speeds,
    remembered,
    structure_key,
    structure_of,
    wheel_of_sectors,
    without_rotation,
)
from bladewhirl.models.superelements.condensed import FURTHER_MODES
from bladewhirl.models.superelements.points import with_fewer_points
from bladewhirl.models.superelements.reduction import (
    ReducedSuperelement,
    boundary_size,
    consistent,
    massless,
    rigid_limit,
)
from bladewhirl.models.superelements.superelement import (
    COMPONENTS,
    IndefiniteError,
    Superelement,
    SuperelementError,
)

LENGTH = 0.2
"""Length of a blade, divided by the largest radius of a contact node, if the file does not show
it."""

POINT_NUMBERS, FEWEST_POINTS = 50_000_000, 200
"""Largest number of displacements and stresses of points in all modes of a wheel from a sector; and
number of points of a sector that are always kept."""

HIGHEST = 1e5  #: highest plausible first natural frequency [Hz]


@dataclass(frozen=True, kw_only=True)
class SuperelementStage:
    """A superelement in its case, reduced."""

    case: Case
    part: Superelement  #: the superelement; the wheel if the file has a sector
    given: Superelement  #: the superelement of the file, with the points that pictures show
    shown: IntArray  #: numbers of these points in the file, (points,)
    reduced: ReducedSuperelement  #: modes of one copy and its contact nodes
    factor: FloatArray  #: factor on the stiffness of each copy, (copies,)
    blade: IntArray  #: number of the blade of each contact node of a copy, (nodes,)
    ring: Ring | None  #: flexible casing; None: a rigid wall
    reduced_at: Callable[[float], ReducedSuperelement]
    """Function that returns the reduction at another speed [rad/s]."""
    frequency_at_rest: float | None = None
    """Reference frequency of the structure at rest [rad/s], if `part` has effects of rotation."""
    blades: bool = False  #: whether the stiffness of each of the equal blades of sectors is needed

    @property
    def table(self) -> SuperelementTable:
        """The table of the case."""
        table = self.case.bladed_disk.superelement
        assert table is not None
        return table

    @property
    def reference_frequency(self) -> float:
        """Lowest natural frequency of the modes that are not rigid [rad/s]. Speeds are in multiples
        of it."""
        if self.frequency_at_rest is not None:
            return self.frequency_at_rest
        frequency = self.reduced.frequency
        elastic = frequency > np.sqrt(rigid_limit(self.part))
        return float(frequency[elastic].min() if elastic.any() else frequency.max())

    @property
    def speed(self) -> float:
        """Speed of rotation [rad/s]."""
        return self.case.march.speed.rad_per_s(self.reference_frequency)

    @property
    def copies(self) -> int:
        """Number of structures that do not influence each other."""
        return len(self.factor)

    @cached_property
    def angle(self) -> FloatArray:
        """Angle of each contact node from +x at t = 0 [rad], (copies, nodes)."""
        turned = 2.0 * np.pi / self.copies * np.arange(self.copies) + self.table.angle
        return np.asarray(turned[:, None] + self.part.contact_angle)

    @property
    def casing_radius(self) -> float:
        """Radius of the wall [m]: that from which the clearance is measured, plus the clearance."""
        return self.case.tip_radius + self.case.casing.clearance

    @property
    def blade_length(self) -> float:
        """Length of a blade [m]: the extent in radius of the surface of a clamped blade; `LENGTH`
        times the largest radius of a contact node for sectors, wheels and files without a
        surface."""
        outermost = float(self.part.contact_radius.max())
        if self.table.kind != "blade" or self.part.points is None or self.part.triangles is None:
            return LENGTH * outermost
        x, y, _ = self.part.points[self.part.triangles.ravel()].T
        return outermost - float(np.hypot(x, y).min())

    @cached_property
    def slope(self) -> float | FloatArray:
        """Slope of the wall [rad]; under a contour that at each contact node, (nodes,)."""
        return slopes(self.case.casing, self.part.contact_position[:, 2])

    @property
    def recess(self) -> FloatArray:
        """Radius from which the clearance is measured, minus the radius of each contact node [m],
        (nodes,)."""
        radius = self.case.casing.radius
        if radius is None:
            return np.zeros(self.part.contacts)
        return np.asarray(radius - self.part.contact_radius)

    @property
    def problem(self) -> ContactProblem:
        """The contact problem at the constant speed `speed`."""
        return self.problem_at(self.speed)

    def problem_at(self, speed: float) -> ContactProblem:
        """Return the contact problem at a constant speed of rotation [rad/s]."""
        case, blade = self.case, self.blade
        rotor = self.rotor_at(speed)
        cylinder = ContactProblem(
            rotor=rotor,
            casing=self.wall,
            speed=speed,
            friction=case.wall_friction,
            sliding="full" if case.contact.sliding == "full" else "permanent",
            tip_rotation=case.contact.tip_rotation,
            displacement_limit=case.march.displacement_limit or self.blade_length,
            start=Start.of_rotor(
                static_shapes(case, "displacement", self.reduced, blade, self.copies),
                static_shapes(case, "velocity", self.reduced, blade, self.copies),
                len(self.wall.frequency),
            ),
            closure=WallClosure.around(case.casing.closure, self._wall_angle, self.wall.radius),
            coating=self.coating,
            springs=self._springs(rotor),
            loads=loads_on(
                LoadedStage(
                    case=case,
                    speed=speed,
                    varies=case.march.varies,
                    centre=rotor.centre,
                    rest=np.zeros(len(rotor.frequency)),
                    ring=self.ring,
                    blade_angle=self.blade_angle,
                    unbalance=partial(self._unbalance, rotor),
                    forces_of_order=self.forces_of_order,
                )
            ),
        )
        return in_cone(cylinder, self.slope)

    def rotor_at(self, speed: float) -> ReducedRotor:
        """Return the copies in modal coordinates at a speed of rotation [rad/s]."""
        case, reduced = self.case, self.reduced
        massless = case.reduction.boundary == "massless"
        centre = centre_rows(reduced, self.table.angle)
        rotor = ReducedRotor.of_copies(
            frequency=np.sqrt(self.factor)[:, None] * reduced.frequency,
            damping_ratio=np.tile(self.damping_ratio, (self.copies, 1)),
            contact=reduced.contact,
            compliance=self._compliance if massless else None,
            angle=self.angle,
            radius=self.part.contact_radius,
            recess=self.recess,
            tip_radius=self.case.tip_radius,
            centre=centre,
            by_velocity=self.by_velocity(speed),
        )
        if not centre.any():
            return rotor
        return replace(
            rotor,
            dampers=np.sqrt(case.shaft.dampings)[:, None] * centre,
            anisotropy=case.shaft.anisotropy,
            circulation=(
                case.shaft.damping * speed if case.shaft.damping_frame == "static" else 0.0
            ),
        )

    def _springs(self, rotor: ReducedRotor) -> CouplingSprings | None:
        """Return the springs between blades and casing; None without them."""
        if not self.case.coupling.stiffness:
            return None
        assert self.ring is not None  # the case refuses springs on a rigid wall
        radial = self.reduced.contact.reshape(len(self.blade), 3, -1)[:, 0]
        moved = sp.block_diag([blade_means(self.blade) @ radial] * self.copies)
        outward = np.asarray(moved.toarray(), dtype=np.float64)
        return coupling_springs(self.case, outward, self.blade_angle, rotor.frequency, self.ring)

    @cached_property
    def blade_angle(self) -> FloatArray:
        """Angle of the middle of the contact nodes of each blade [rad], (blades,)."""
        return blade_angles(self.angle, self.blade).ravel()

    def _unbalance(self, rotor: ReducedRotor, load: Imbalance) -> float:
        """Return the unbalance m e of an imbalance [kg m]."""
        size = load.size(self.reference_frequency)
        if size is not None:
            return size
        assert load.clearance_speed is not None  # a case has one key for the unbalance
        force = direction(load, self.blade_angle) @ rotor.centre
        outward = rotor.at_tips(rotor.tip_radial, force / rotor.stiffness)
        gap = self.wall.clearance[:, 0].min() + rotor.tip_recess
        speed = load.clearance_speed.rad_per_s(self.reference_frequency)
        return closing_unbalance(outward, gap, speed)

    def forces_of_order(self, load: EngineOrder) -> list[tuple[int, ComplexArray]]:
        """Return the complex modal forces of each engine order, see `engine_order_forces`. The
        residual flexibility of the contact nodes does not respond to them."""
        at = self.reduced.points if load.points else self.reduced.contact
        middle = blade_angles(self.angle, self.blade)
        return engine_order_forces(self._mean_along(load) @ at, middle, load)

    def static_of_order(self, load: EngineOrder) -> list[tuple[int, ComplexArray]]:
        """Return the complex displacements of the contact nodes that the forces of each engine
        order cause by the residual flexibility [m], (copies, 3 * nodes)."""
        means, reduced = self._mean_along(load), self.reduced
        moved = reduced.points_by_force(means) if load.points else means @ reduced.compliance
        return [
            (order, flat.reshape(self.copies, -1) / self.factor[:, None])
            for order, flat in engine_order_forces(
                moved, blade_angles(self.angle, self.blade), load
            )
        ]

    def _mean_along(self, load: EngineOrder) -> sp.csr_array:
        """Return the mean displacement on each blade of a copy along the direction of a load, as
        rows on contact nodes or on the points of the load, see `mean_along`."""
        nodes = self.part.contacts
        if not load.points:
            return mean_along(load, self.blade, np.zeros(nodes), np.arange(nodes), nodes)
        middle = blade_angles(self.angle, self.blade)
        number = np.asarray(load.points)
        if self.table.kind == "sector":  # the points of the wheel are those of all sectors
            number = np.searchsorted(self.shown, number)
            count = len(self.shown)
            number = (number + count * np.arange(self.table.copies)[:, None]).ravel()
        assert self.part.points is not None  # the case has points of the file only
        x, y, _ = self.part.points[number].T
        angle = np.arctan2(y, x)
        apart = np.angle(np.exp(1j * (angle[:, None] + self.table.angle - middle[0])))
        blade = np.abs(apart).argmin(axis=1)
        if len(np.unique(blade)) < middle.shape[1]:
            key = f"{self.case.key_of(load)}.points"
            expected = "points on every blade of the file"
            raise CaseError([case_fault(self.case, key, expected)])
        return mean_along(load, blade, angle, number, self.part.point_count)

    @property
    def _compliance(self) -> FloatArray:
        """Residual flexibility of the contact nodes of each copy [m/N], (copies, 3c, 3c)."""
        return self.reduced.compliance / self.factor[:, None, None]

    @property
    def damped_as_at_rest(self) -> bool:
        """True if `by_velocity` contains the modal damping."""
        return self.case.rotation.effects == "full"

    @property
    def damping_ratio(self) -> FloatArray:
        """Damping ratio of each mode of a copy, (modes,); zero if `by_velocity` contains it."""
        return self._ratio * float(not self.damped_as_at_rest)

    @property
    def _ratio(self) -> FloatArray:
        ratio = np.full(len(self.reduced.frequency), self.case.damping.ratio)
        if self.case.reduction.boundary == "consistent":
            ratio[self.reduced.kept :] = self.case.damping.boundary_ratio
        return ratio

    def by_velocity(self, speed: float) -> FloatArray | None:
        """Return the matrix of the forces due to velocities that `damping_ratio` does not give, at
        a speed [rad/s]: [1/s], (modes, modes); None without such forces.

        They are the damping and the Coriolis forces of the file. With rotation.effects = "full",
        all modes have the modal damping of the structure at rest, as those of beams.
        """
        reduced, modes = self.reduced, self.reduced.size
        given = reduced.given(("damping", "gyroscopic"))
        matrices = [reduced.drag(speed)] if given else []
        if self.damped_as_at_rest:
            ratio = np.sqrt(self._ratio)
            assert reduced.root is not None  # the rotation acts on the structure
            matrices.append(2.0 * ratio[:, None] * reduced.root * ratio)
        return np.asarray(sum(matrices, np.zeros((modes, modes)))) if matrices else None

    @cached_property
    def coating(self) -> WallCoating | None:
        """The coating of the wall; None if there is none."""
        table = self.table
        thickness = tip_thickness(table.part, table.copies if table.kind == "wheel" else 1)
        return node_coating(self.case, self.part, self.blade, self.casing_radius, thickness)

    @cached_property
    def arrays(self) -> StageArrays:
        """Arrays of the stage in a result."""
        part, copies = self.part, self.copies
        turn = self.table.angle
        points = np.zeros((0, 3)) if part.points is None else rotate(part.points, turn)
        modes = len(self.reduced.frequency)
        shapes = rotate(self.reduced.points.reshape(len(points), 3, modes), turn, axis=1)
        within = np.bincount(self.blade)[0]
        by_force = self.reduced.strains_by_force
        strained = by_force.reshape(*by_force.shape[:2], by_force.shape[2] // 3, 3)
        centre = dict[str, Any]()
        if part.centre_dofs is not None:
            centre = {"centre_shape": centre_rows(self.reduced, turn)}
        ring, walls = self.ring, dict[str, Any]()
        if ring is not None:
            walls = casing_arrays(ring.casing, ring.casing_modes)
        return StageArrays(
            rotor_frequency=(np.sqrt(self.factor)[:, None] * self.reduced.frequency).ravel(),
            blade=np.concatenate([self.blade + copy for copy in range(copies)]),
            node=np.tile(np.arange(part.contacts) % within, copies),
            tip_angle=self.angle.ravel(),
            contact_radius=np.tile(part.contact_radius, copies),
            axial_position=np.tile(part.contact_position[:, 2], copies),
            tip_recess=np.tile(self.recess, copies),
            contact_shape=np.tile(self.reduced.contact.reshape(-1, 3, modes), (copies, 1, 1)),
            **centre,
            copy_angle=np.asarray(2.0 * np.pi / copies * np.arange(copies), dtype=np.float64),
            gauge_shape=self.reduced.strains,
            gauge_by_force=np.multiply.outer(1.0 / self.factor, strained),
            **self._stresses(),
            point=points,
            point_shape=shapes,
            triangle=np.zeros((0, 3), np.int64) if part.triangles is None else part.triangles,
            wall_angle=self._wall_angle,
            clearance=self.case.casing.clearance_profile.value(self._wall_angle),
            **walls,
        )

    def _stresses(self) -> dict[str, Any]:
        """Return the arrays of stresses in a result, if the file gives their recovery."""
        stress, modes = self.reduced.stress, len(self.reduced.frequency)
        if stress is None:
            return {}
        distances, values, columns = stress.forces.shape
        points = self.part.point_count
        arrays: dict[str, Any] = {
            "point_number": np.tile(self.shown, points // len(self.shown)),
            "stress_shape": stress.modes.reshape(points, COMPONENTS, modes),
            "stress_by_force": stress.forces.reshape(
                distances, values // COMPONENTS, COMPONENTS, columns // 3, 3
            ),
            "copy_stiffness": self.factor,
        }
        if stress.steady is not None and self.case.rotation.effects != "none":
            steady = self.speed**2 * stress.steady
            arrays["steady_stress"] = steady.reshape(points, COMPONENTS)
        for key in ("young_modulus", "poisson_ratio"):
            if (numbers := getattr(self.given, key)) is not None:
                arrays[f"point_{key}"] = np.tile(numbers, points // len(numbers))
        return arrays

    @cached_property
    def wall(self) -> ReducedCasing:
        """The wall: at equally spaced angles from 0, or a flexible casing."""
        if self.ring is not None:
            return self.ring.reduced_casing
        return rigid_wall(self.case, self.casing_radius)

    @property
    def _wall_angle(self) -> FloatArray:
        return self.wall.angle

    def check_start(self, problem: ContactProblem) -> None:
        """Check the gaps at the start of a contact problem of this stage.

        Raises:
            CaseError: a contact node is beyond the wall.
        """
        gap = problem.initial_gap()
        if problem.coating is not None:
            gap = gap - problem.coating.removable
        if gap.min() < 0.0:
            copy, node = divmod(int(gap.argmin()), self.part.contacts)
            expected = (
                f"all contact nodes inside the wall at t = 0: node {node} of blade {copy} would be"
                f" {-gap.min():.4g} m beyond the wall; use a larger clearance, another phase of its"
                " lobes, or casing.closure, which moves the wall inward later"
            )
            raise CaseError([case_fault(self.case, "casing.clearance", expected)])


def superelement_stage(
    case: Case, ring: Ring | None = None, *, blades: bool = False
) -> SuperelementStage:
    """Return the stage of a case with a superelement.

    Args:
        case: the case.
        ring: its flexible casing, if it is known.
        blades: whether the stiffness of each of the equal blades of sectors is needed.

    Raises:
        CaseError: the superelement cannot be reduced as the case demands.
    """
    table = case.bladed_disk.superelement
    assert table is not None
    part, at_rest, omega = structure_of(case), None, 0.0
    factor = case.bladed_disk.mistuning.factors("stiffness", table.copies)
    shown = np.arange(part.point_count)
    if table.kind == "sector":
        fields = case.reduction.free_interface_modes
        if case.rotation.effects != "none":  # those of three speeds
            fields = 3 * (fields + FURTHER_MODES + 3 * part.contacts)
        values = 3 if part.stress_recovery is None else 3 + COMPONENTS
        most = max(POINT_NUMBERS // (values * table.copies**2 * fields), FEWEST_POINTS)
        loads = case.excitations.values()
        needed = {point for load in loads for point in getattr(load, "points", ())}
        gauges = (getattr(sensor, "point", None) for sensor in case.sensor)
        needed |= {point for point in gauges if point is not None and point < part.point_count}
        part, shown = with_fewer_points(part, most, needed)
    key = "bladed_disk.superelement.file"
    if case.rotation.effects != "none":
        at_rest = _reference_at_rest(case)
        omega = case.march.speed.rad_per_s(at_rest)
    of_waves = table.kind == "sector" and case.reduction.boundary == "massless"
    if not of_waves:
        name = "free" if case.reduction.boundary == "massless" else "fixed"
        key = f"reduction.{name}_interface_modes"
    reduced_at = partial(_reduced_at, case, part, factor, omega, blades)
    try:
        given, part, reduced = reduced_at(omega, others=_other_speeds(case, at_rest))
    except SuperelementError as error:
        if at_rest is not None and isinstance(error, IndefiniteError):
            expected = "a speed at which the structure keeps its stiffness in spite of the rotation"
            raise CaseError([case_fault(case, "march.speed", expected)]) from None
        raise CaseError(faults_at(case, key, error)) from None
    if table.kind == "blade":
        rigid = int((reduced.frequency <= np.sqrt(rigid_limit(part))).sum())
        if rigid:
            expected = f"a blade that is clamped at its root; the matrices have {rigid} rigid modes"
            raise CaseError([Fault(key=f"{SOURCE}.file", expected=expected)])
    if reduced.damping is not None:
        rates = np.linalg.eigvalsh(0.5 * (reduced.damping + reduced.damping.T))
        if rates[0] < -NEGATIVE * abs(rates).max():
            expected = "a damping matrix without negative eigenvalues, which feed energy"
            raise CaseError([Fault(key=f"{SOURCE}.file", expected=expected)])
    per_blade = part.contacts if table.kind == "blade" else part.contacts // table.copies
    stage = SuperelementStage(
        case=case,
        part=part,
        given=given,
        shown=shown,
        reduced=reduced,
        factor=factor if table.kind == "blade" else np.ones(1),
        blade=np.arange(part.contacts) // per_blade,
        reduced_at=lambda speed: reduced_at(speed)[2],
        ring=flexible_ring(case) if ring is None and case.casing.type == "ring" else ring,
        frequency_at_rest=at_rest,
        blades=blades,
    )
    hertz = stage.reference_frequency / (2.0 * np.pi)
    if hertz > HIGHEST:
        expected = (
            f"matrices in SI units, or length_unit and mass_unit in the file: the first natural"
            f" frequency would be {hertz:.3g} Hz"
        )
        raise CaseError([Fault(key=f"{SOURCE}.file", expected=expected)])
    return replace(stage, case=case.in_seconds(stage.reference_frequency))


def _reduced_at(
    case: Case,
    part: Superelement,
    factor: FloatArray,
    highest: float,
    blades: bool,
    omega: float,
    others: Sequence[float] = (),
) -> tuple[Superelement, Superelement, ReducedSuperelement]:
    """Return a superelement at a speed, its structure with its supports, and its reduction.

    Args:
        case: case of the superelement.
        part: superelement at rest.
        factor: factor on the stiffness of each blade, (blades,).
        highest: highest speed [rad/s], on whose `range_of` the reduction depends.
        blades: whether the stiffness of equal blades is needed.
        omega: speed [rad/s].
        others: other speeds [rad/s], whose modes and static displacements are added, see
            `massless` and `consistent`.

    Raises:
        SuperelementError: as for `massless` and `consistent`.
    """
    table, reduction = case.bladed_disk.superelement, case.reduction
    assert table is not None
    if table.kind == "sector" and reduction.boundary == "massless":
        speeds = omega, highest
        found = wheel_of_sectors(case, part, speeds, factor, others, blades=blades)
        return part, *found
    root, slower, effects = None, list[Superelement](), case.rotation.effects
    if effects != "none":
        still = over_speeds(case, part, highest)
        part = still.at(omega, effects)
        root = damping_root(case, still, highest)
        slower = [assembled(case, still.at(each, effects)) for each in others]
    held = assembled(case, part)
    if reduction.boundary == "massless":
        return part, held, massless(held, reduction.free_interface_modes, root, slower)
    kept = reduction.fixed_interface_modes
    if kept == MODES:  # the default: all modes of a small superelement
        kept = min(kept, held.size - boundary_size(held))
    return part, held, consistent(held, kept, kept, root, slower)


def _other_speeds(case: Case, at_rest: float | None) -> tuple[float, ...]:
    """Return the lowest speed of a case whose speed varies, and one between it and the highest
    [rad/s]; none if the speed is constant, or if the rotation does not act on the structure.

    Args:
        case: the case.
        at_rest: reference frequency at rest, if the rotation acts on the structure [rad/s].
    """
    course = None if at_rest is None else case.march.course(at_rest)
    if course is None or np.ptp(course.range) == 0.0:
        return ()
    low, high = sorted(map(abs, course.range))
    low = 0.0 if np.prod(course.range) < 0.0 else low
    return low, float(np.sqrt(0.5 * (low**2 + high**2)))


_at_rest: dict[str, float] = {}
"""Reference frequencies of the last cases, by all they depend on."""


def _reference_at_rest(case: Case) -> float:
    """Return the reference frequency of the structure at rest [rad/s], computed once for all points
    of a sweep."""
    key = structure_key(case)
    still = without_rotation(case)
    return remembered(_at_rest, key, lambda: superelement_stage(still).reference_frequency)

"""The stage of a superelement: the matrices of a file, reduced."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.case.file import case_fault, with_values
from bladewhirl.models.case.gauge_positions import gauge_hints
from bladewhirl.models.case.speed_course import SpeedCourse
from bladewhirl.models.case.superelement import SuperelementTable
from bladewhirl.models.elements.cut_rings import WheelOfBeams
from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.stage.basis_error import basis_error
from bladewhirl.models.stage.blade_loss import copies_after_loss
from bladewhirl.models.stage.coating import node_footprint, tip_thickness
from bladewhirl.models.stage.cone import compliance_in_wall_axes, in_wall_axes, slopes
from bladewhirl.models.stage.contact_problem import ContactProblem, LostBlades
from bladewhirl.models.stage.engine_order import mean_along
from bladewhirl.models.stage.loads import blade_means
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.ring import Ring
from bladewhirl.models.stage.speed_change import compliance_over_speeds
from bladewhirl.models.stage.stage import Basis, BladeStiffness, Stage, Turning
from bladewhirl.models.stage.superelement_structure import wheel_over_speeds
from bladewhirl.models.stage.varying_speed import ComplianceOverSpeeds
from bladewhirl.models.structure.rotating import Rotating
from bladewhirl.models.superelements.reduction import ReducedSuperelement, rigid_limit
from bladewhirl.models.superelements.superelement import COMPONENTS, Superelement

LENGTH = 0.2
"""Length of a blade, divided by the largest radius of a contact node, if the file does not show
it."""

ROUNDING = 1e-9  #: a flexibility up to this fraction of the radial one is a rounding error


@dataclass(frozen=True, kw_only=True, repr=False)
class Matrices(Stage):
    """A superelement in its case, reduced."""

    part: Superelement  #: the superelement; the wheel if the file has a sector
    given: Superelement  #: the superelement of the file, with the points that pictures show
    shown: IntArray  #: numbers of these points in the file, (points,)
    reduced: ReducedSuperelement  #: modes of one copy and its contact nodes
    reduced_at: Callable[[float], ReducedSuperelement]
    """Function that returns the reduction at another speed [rad/s]."""
    build: Callable[[Case, Ring], "Matrices"]
    """Function that builds the stage of a case with the same superelement and casing."""

    @property
    def table(self) -> SuperelementTable | WheelOfBeams:
        """The table of the case, or what it would contain for a wheel of beams."""
        return self.case.bladed_disk.matrices

    def at(self, omega: float) -> "Matrices":
        stage = self
        if self.case.rotation.effects != "none":
            at_speed = {"march.speed": omega / self.reference_frequency}
            stage = self.build(with_values(self.case, at_speed), self)
        return replace(stage, omega=omega)

    def of_diameters(self, diameters: Collection[int]) -> "Matrices":
        if self.table.kind != "sector" or self._differ:
            return self
        build: Any = self.build
        return replace(self, build=partial(build, diameters=diameters))

    @property
    def over_many_speeds(self) -> "Matrices":
        """The stage for many other speeds, see `at`: a superelement is then condensed for their
        range, so that it is reduced at each of them in milliseconds."""
        build: Any = self.build
        return replace(self, build=partial(build, condensed_from=0))

    @property
    def copies(self) -> int:
        """Number of structures that do not influence each other."""
        return len(self.factor)

    @cached_property
    def angle(self) -> FloatArray:
        """Angle of each contact node from +x at t = 0 [rad], (copies, nodes)."""
        turned = 2.0 * np.pi / self.copies * np.arange(self.copies) + self.table.angle
        return np.asarray(turned[:, None] + self.part.contact_angle)

    @cached_property
    def blade_angle(self) -> FloatArray:
        """Mean angle of the contact nodes of each blade [rad], (copies, blades of a copy)."""
        return np.asarray(np.angle(np.exp(1j * self.angle) @ blade_means(self.blade).T))

    @property
    def axial_position(self) -> FloatArray:
        return self.part.contact_position[:, 2]

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
        return slopes(self.case.casing, self.axial_position)

    @property
    def recess(self) -> FloatArray:
        """Radius from which the clearance is measured, minus the radius of each contact node [m],
        (nodes,)."""
        radius = self.case.casing.radius
        if radius is None:
            return np.zeros(self.part.contacts)
        return np.asarray(radius - self.part.contact_radius)

    @property
    def centre_rows(self) -> FloatArray:
        """x and y of the centre for unit modal coordinates [kg^-1/2], (2, modes)."""
        return rotate(np.eye(2), -self.table.angle) @ self.reduced.centre

    @cached_property
    def without_dampers(self) -> ReducedRotor:
        """The bladed disk without dampers at its centre."""
        case, reduced = self.case, self.reduced
        compliance = reduced.compliance / self.factor[:, None, None]
        rotor = ReducedRotor.of_copies(
            frequency=np.sqrt(self.factor)[:, None] * reduced.frequency,
            damping_ratio=np.tile(self.damping_ratio, (self.copies, 1)),
            contact=reduced.contact,
            compliance=compliance if case.reduction.boundary == "massless" else None,
            angle=self.angle,
            radius=self.part.contact_radius,
            recess=self.recess,
            tip_radius=self.case.tip_radius,
            centre=self.centre_rows,
            by_velocity=self.by_velocity(self.speed),
        )
        if not case.joint:
            return rotor
        nodes = np.arange(self.part.contacts)
        tips = self.tips if len(self.tips) < len(nodes) else nodes[:0]
        return replace(rotor, joined=np.setdiff1d(nodes, tips))

    @cached_property
    def rotor(self) -> ReducedRotor:
        case, rotor, centre = self.case, self.without_dampers, self.centre_rows
        if not centre.any():
            return rotor
        static = case.shaft.damping_frame == "static"
        return replace(
            rotor,
            dampers=np.sqrt(case.shaft.dampings)[:, None] * centre,
            anisotropy=case.shaft.anisotropy,
            circulation=case.shaft.damping * self.speed if static else 0.0,
        )

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

    def footprint(self) -> FloatArray:
        table = self.table
        thickness = tip_thickness(table.part, table.copies if table.kind == "wheel" else 1)
        return node_footprint(self.case, self.part, self.blade, thickness)

    def unit_forces(self, load: EngineOrder) -> FloatArray:
        """Return the modal forces of unit forces on each blade. The residual flexibility of the
        contact nodes does not respond to them."""
        at = self.reduced.points if load.points else self.reduced.contact
        return np.asarray(self._mean_along(load) @ at)

    def static_answer(self, load: EngineOrder) -> FloatArray:
        means, reduced = self._mean_along(load), self.reduced
        return reduced.points_by_force(means) if load.points else means @ reduced.compliance

    @property
    def tips(self) -> IntArray:
        """Contact nodes of a copy that are in no joint, all if there are no others, (tips,)."""
        pairs = [self.table.joint_nodes(joint) for joint in self.case.joint]
        joined = np.array([node for pair in pairs for side in pair for node in side], dtype=int)
        within = np.arange(self.part.contacts) % np.bincount(self.blade)[0]
        free = np.flatnonzero(~np.isin(within, joined))
        return free if len(free) else np.arange(self.part.contacts)

    def _mean_along(self, load: EngineOrder) -> sp.csr_array:
        """Return the mean displacement on each blade of a copy along the direction of a load, as
        rows on contact nodes or on the points of the load, see `mean_along`."""
        nodes = self.part.contacts
        if not load.points:
            tips = self.tips
            return mean_along(load, self.blade[tips], np.zeros(len(tips)), tips, nodes)
        number = np.asarray(load.points)
        if self.table.kind == "sector":  # the points of the wheel are those of all sectors
            number = np.searchsorted(self.shown, number)
            count = len(self.shown)
            number = (number + count * np.arange(self.table.copies)[:, None]).ravel()
        assert self.part.points is not None  # the case has points of the file only
        x, y, _ = self.part.points[number].T
        angle = np.arctan2(y, x)
        apart = np.angle(np.exp(1j * (angle[:, None] + self.table.angle - self.blade_angle[0])))
        blade = np.abs(apart).argmin(axis=1)
        if len(np.unique(blade)) < self.blade_angle.shape[1]:
            key = f"{self.case.key_of(load)}.points"
            expected = "points on every blade of the file"
            raise CaseError([case_fault(self.case, key, expected)])
        return mean_along(load, blade, angle, number, self.part.point_count)

    @property
    def has_centre(self) -> bool:
        return self.part.centre_dofs is not None

    @property
    def inertia(self) -> float:
        """Moment of inertia of what the drive turns besides the bladed disk [kg m2]."""
        drive = self.case.march.drive
        return 0.0 if drive is None else drive.inertia

    @property
    def turning(self) -> Turning:
        reduced, factor = self.reduced, self.factor
        load, euler = reduced.loads.T
        steady = self.speed**2 * load / reduced.squares
        patterns = {
            "by_square": np.tile(load - reduced.stiffness_speed @ steady, len(factor)),
            "by_acceleration": (euler - reduced.coriolis @ steady / factor[:, None]).ravel(),
        }
        if reduced.stiffness_speed4 is not None:
            patterns["by_fourth"] = np.tile(-reduced.stiffness_speed4 @ steady, len(factor))
        rotor = Rotating(**{each.name: getattr(reduced, each.name) for each in fields(Rotating)})
        return Turning(rotor=rotor, patterns=patterns, factor=factor)

    def compliance_over(self, course: SpeedCourse) -> ComplianceOverSpeeds | None:
        if self.case.reduction.boundary != "massless":
            return None
        return compliance_over_speeds(
            self.reduced, self.reduced_at, self.factor, self.slope, course
        )

    def without_blades(self, given: ContactProblem, turning: ContactProblem) -> LostBlades:
        return copies_after_loss(self, turning)

    def blade_stiffness(self, omega: float) -> tuple[Stage, BladeStiffness]:
        """Return the wheel of equal sectors at a speed [rad/s], and the stiffness of its blades;
        the stage is one that `build_stage` made for it.

        Raises:
            UserError: the superelement is not a sector, or does not give the stiffness of its
                blade.
        """
        table, effects = self.table, self.case.rotation.effects
        if table.kind != "sector" or table.part.blade_stiffness is None:
            raise UserError(
                'response: draws: expected beams, or bladed_disk.superelement.kind = "sector" and'
                " a file with blade_stiffness (bw.mesh3d with blade = GROUP)"
            )
        wheel = wheel_over_speeds(self.case, self.given, omega)
        at = omega if effects != "none" else 0.0
        part, reduced = wheel.at(at)
        own = replace(self, part=part, reduced=reduced, omega=omega)
        slope, at_rest = np.zeros((reduced.size, reduced.size)), None
        if effects != "none" and reduced.stiffness_speed is not None:
            slope = reduced.slope(omega)
        if own.damped_as_at_rest:
            assert reduced.root is not None  # the rotation acts on the structure
            at_rest = reduced.root @ reduced.root
        return own, BladeStiffness(blades=wheel.blades_at(at), slope=slope, at_rest=at_rest)

    @property
    def basis(self) -> Basis:
        reduction = self.case.reduction
        if reduction.boundary == "massless":
            return Basis("reduction.free_interface_modes", reduction.free_interface_modes)
        return Basis("reduction.fixed_interface_modes", reduction.fixed_interface_modes)

    @property
    def fewer_modes(self) -> str:
        return 'fewer reduction.free_interface_modes, or reduction.boundary = "massless"'

    def own_hints(self) -> Iterator[str]:
        """Yield warnings about contact nodes and matrices of the file that are not used, about a
        damping matrix that adds to the modal damping, and about a contact node that the given
        friction locks against the wall."""
        if left_out := self.table.left_out:
            yield (
                f"{left_out} contact nodes of the file are left out: they are at the place of"
                " others"
            )
        if len(self.shown) < (points := self.table.part.point_count):
            yield (
                f"pictures show {len(self.shown)} of the {points} points of the sector: the shapes"
                " of all points take too much memory; fewer reduction.free_interface_modes allow"
                " more"
            )
        yield from gauge_hints(self.case.sensor, self.table.part)
        ratio = self.case.damping.ratio
        if self.reduced.damping is not None and ratio > 0.0:
            yield (
                f"the matrix damping of the superelement adds to damping.ratio = {ratio:g};"
                " with damping.ratio = 0 only the matrix damps"
            )
        limits = self.locking_friction()
        node = min(limits, key=limits.__getitem__, default=-1)
        if limits and self.case.wall_friction > limits[node]:
            yield (
                f"contact node {node} locks itself against the wall with a friction above"
                f" {limits[node]:.3g}: static friction presses it outward more than the normal"
                " force pushes it inward, so that contact can grow without bound"
            )

    def locking_friction(self) -> dict[int, float]:
        """Return for each contact node the friction coefficient above which it locks itself.

        Friction on a single node drags it backward. If the node then moves outward by more than
        the normal force moves it inward, no static equilibrium in contact exists. Nodes that no
        friction locks are left out.
        """
        radial, tangential = self.static_response()
        outward = -np.sign(self.speed) * tangential
        locked = np.flatnonzero(outward > ROUNDING * radial)
        return {int(n): float(radial[n] / outward[n]) for n in locked}

    def static_response(self) -> tuple[FloatArray, FloatArray]:
        """Return the displacement of each contact node normal to the wall, per normal and per
        tangential force on it [m/N], (nodes,) each; empty for a structure with rigid modes."""
        reduced, slope = self.reduced, self.slope
        squares = reduced.squares
        if squares.min() <= rigid_limit(self.part):
            return np.zeros(0), np.zeros(0)
        # The modes and the residual flexibility together are statically exact.
        rows = in_wall_axes(reduced.contact, slope)
        compliance = compliance_in_wall_axes(reduced.compliance, slope)
        radial, tangential = rows[::3], rows[1::3]
        residual = np.diag(compliance)[::3], np.diag(compliance, 1)[::3]
        return (
            residual[0] + (radial**2) @ (1.0 / squares),
            residual[1] + (radial * tangential) @ (1.0 / squares),
        )

    @property
    def own_properties(self) -> dict[str, Any]:
        frequency = self.reduced.frequency
        return {
            "superelement": self.part.name,
            "source": self.part.source,
            "coordinates": self.table.part.size,
            "copies": self.table.copies,
            "copies_differ": self._differ,
            "modes": len(frequency) * self.copies,
            "frequency_error": self.basis_error,
            "stress_points": None if self.reduced.stress is None else self.given.point_count,
            "contact_nodes": list(self._contact_nodes()),
        }

    @property
    def basis_error(self) -> float | None:
        """Largest relative error of the lowest frequencies, see `basis_error.basis_error`."""
        return basis_error(self.case, self.speed, self.reduced)

    @property
    def _differ(self) -> bool:
        return self.case.bladed_disk.mistuning.is_given(self.table.copies)

    def _contact_nodes(self) -> Iterator[dict[str, Any]]:
        """Yield place and flexibility of each contact node of a copy, and the joint of which it is
        an end; of all copies if they differ."""
        part, residual = self.part, np.diag(self.reduced.compliance)
        own = {
            int(node): joint.name
            for joint in self.case.joint
            for node in np.concatenate(self.table.joint_nodes(joint))
        }
        of_blade = part.contacts // len(np.unique(self.blade))
        radial, _ = self.static_response()
        locking = self.locking_friction()
        equal = 1 if self._differ else self.table.copies // self.copies
        for node in range(part.contacts // equal):
            yield {
                "node": node,
                "radius": float(part.contact_radius[node]),
                "angle": float(self.angle[0, node]),
                "axial": float(part.contact_position[node, 2]),
                "flexibility": float(radial[node]) if radial.size else None,
                "residual": float(residual[3 * node]),
                "locking_friction": locking.get(node),
                "joint": own.get(node % of_blade),
            }

    @property
    def node_sets(self) -> Mapping[str, IntArray]:
        return {"contact nodes": np.arange(self.part.contacts * self.copies)}

    @property
    def attributes(self) -> Mapping[str, str | float | int]:
        layer = self.coating
        worn = {"coating_thickness": "thickness", "coating_removable": "removable"}
        return {
            **super().attributes,
            **({} if layer is None else {key: getattr(layer, name) for key, name in worn.items()}),
            "superelement": self.part.name,
            "boundary": self.case.reduction.boundary,
        }

    @cached_property
    def shown_arrays(self) -> StageArrays:
        part, copies = self.part, self.copies
        turn = self.table.angle
        points = np.zeros((0, 3)) if part.points is None else rotate(part.points, turn)
        modes = len(self.reduced.frequency)
        within = np.bincount(self.blade)[0]
        by_force = self.reduced.strains_by_force
        strained = by_force.reshape(*by_force.shape[:2], by_force.shape[2] // 3, 3)
        centre = dict[str, Any]()
        if part.centre_dofs is not None:
            centre = {"centre_shape": self.centre_rows}
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
            **self._point_shapes(turn),
            triangle=np.zeros((0, 3), np.int64) if part.triangles is None else part.triangles,
            **self.wall_arrays(self.kept.casing),
        )

    def _point_shapes(self, turn: float) -> dict[str, Any]:
        """Return the shapes of the points, turned by an angle; with equal sectors those of the
        first one, from which all others follow."""
        waves, modes = self.reduced.waves, len(self.reduced.frequency)
        rows = self.reduced.points if waves is None else waves.of_first("points")
        shapes = rotate(rows.reshape(-1, 3, modes), turn, axis=1)
        if waves is None:
            return {"point_shape": shapes}
        numbers = {"mode_wave": waves.number, "mode_partner": waves.partner}
        return {"sector_point_shape": shapes} | numbers

    def _stresses(self) -> dict[str, Any]:
        """Return the arrays of stresses in a result, if the file gives their recovery."""
        stress, modes = self.reduced.stress, len(self.reduced.frequency)
        if stress is None:
            return {}
        distances, values, columns = stress.forces.shape
        points = self.part.point_count
        arrays: dict[str, Any] = {
            "point_number": np.tile(self.shown, points // len(self.shown)),
            "stress_by_force": stress.forces.reshape(
                distances, values // COMPONENTS, COMPONENTS, columns // 3, 3
            ),
            "copy_stiffness": self.factor,
        }
        if (waves := self.reduced.waves) is None:
            arrays["stress_shape"] = stress.modes.reshape(points, COMPONENTS, modes)
        else:
            own = waves.of_first("stresses").reshape(-1, COMPONENTS, modes)
            arrays["sector_stress_shape"] = own
        if stress.steady is not None and self.case.effects != "none":
            steady = self.speed**2 * stress.steady
            arrays["steady_stress"] = steady.reshape(points, COMPONENTS)
        for key in ("young_modulus", "poisson_ratio"):
            if (numbers := getattr(self.given, key)) is not None:
                arrays[f"point_{key}"] = np.tile(numbers, points // len(numbers))
        return arrays

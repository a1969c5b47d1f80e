"""What the stages of a shaft line have in common: bearings, loads and the start of a march."""

from abc import abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.excitation import Harmonic
from bladewhirl.models.case.shaft_line import NONE
from bladewhirl.models.shaft_line.line import LineModel, parts
from bladewhirl.models.stage.bearings import Bearings, ShaftLineMotion
from bladewhirl.models.stage.modal_loads import Load, Start
from bladewhirl.models.stage.stage import Stage
from bladewhirl.models.stage.wall import ReducedCasing


def with_supports(wall: ReducedCasing, supports: int) -> ReducedCasing:
    """Return a casing that also has the displacements of supports, along x and y each, as modes
    without stiffness that do not move the wall."""
    count, none = 2 * supports, np.zeros(2 * supports)
    return replace(
        wall,
        frequency=np.concatenate([wall.frequency, none]),
        damping_ratio=np.concatenate([wall.damping_ratio, none]),
        nodal=np.concatenate([wall.nodal, np.zeros((*wall.nodal.shape[:2], count))], axis=2),
        column=np.concatenate([wall.column, np.full(count, -1)]),
        dampers=np.hstack([wall.dampers, np.zeros((len(wall.dampers), count))]),
        supports=supports,
    )


@dataclass(frozen=True, kw_only=True, repr=False)
class StageOnLine(Stage):
    """A rotor on the bearings of a shaft line; the masses of its supports are the last modes of the
    casing."""

    line: LineModel  #: equations in static axes

    @property
    @abstractmethod
    def line_nodes(self) -> ComplexArray:
        """Deflection and slope of each node for unit modal coordinates, rotating axes [kg^-1/2],
        (nodes, 2, modes)."""

    @property
    @abstractmethod
    def line_along(self) -> FloatArray:
        """Displacement along the axis and rotation about it of each node [kg^-1/2], (nodes, 2,
        modes)."""

    @property
    @abstractmethod
    def weight_rows(self) -> FloatArray:
        """Modal forces of a unit acceleration along x and along y [kg^1/2], (2, modes)."""

    @cached_property
    def bearings(self) -> Bearings:
        """Bearings of the line in the order of the case, then those against tilt, then the springs
        of the supports."""
        line, rows = self.line, list[tuple[ComplexArray, ComplexArray]]()
        nodes, fixed, matrices = self.line_nodes, self._support, []
        still, ground = np.zeros_like(nodes[0, 0]), np.zeros_like(fixed[0])
        for number, bearing in enumerate(line.table.bearings):
            rows.append((nodes[line.node(bearing.position), 0], fixed[number]))
            matrices.append((bearing.stiffness, bearing.damping))
        for number, bearing in enumerate(line.table.bearings):
            if np.any(bearing.tilt_stiffness):
                rows.append((nodes[line.node(bearing.position), 1], ground))
                matrices.append((bearing.tilt_stiffness, NONE))
            if bearing.support is not None:
                rows.append((still, fixed[number]))
                matrices.append((bearing.support.stiffness, bearing.support.damping))
        rotor, support = (np.array(each) for each in zip(*rows, strict=True))
        stiffness, damping = (
            np.array([parts(each) for each in kind]) for kind in zip(*matrices, strict=True)
        )
        shaft = ShaftLineMotion(
            nodes=nodes,
            along=self.line_along,
            stiffness=self.turning.rotor.stiffness_at(0.0),
            bearings=len(line.table.bearings),
        )
        return Bearings(
            rotor=rotor, support=support, stiffness=stiffness, damping=damping, shaft=shaft
        )

    @cached_property
    def _support(self) -> ComplexArray:
        """Displacement x + i y of the support of each bearing for unit modal coordinates, zero
        without a support, (bearings, casing modes)."""
        table, place = self.line.table, self.reduced_casing.wall_modes
        rows = np.zeros((len(table.bearings), len(self.casing_rest)), dtype=np.complex128)
        for row, bearing in zip(rows, table.bearings, strict=True):
            if bearing.support is not None:
                row[place : place + 2] = np.array([1.0, 1.0j]) / np.sqrt(bearing.support.mass)
                place += 2
        return rows

    def forces_on_line(self, force: ComplexArray) -> FloatArray:
        """Return the modal forces of forces x + i y and moments on the nodes, (nodes, 2)."""
        return np.asarray(np.einsum("np,npm->m", force, self.line_nodes.conj()).real)

    def pushed(self, load: Harmonic) -> FloatArray:
        wheel, place = self.line.table.wheel, load.position
        if place is None:
            assert wheel is not None  # else the case gives the position
            place = wheel.position
        moved = self.line_nodes[self.line.node(place), 0]
        return np.stack([moved.real, moved.imag])

    @cached_property
    def own_loads(self) -> tuple[Load, ...]:
        """Loads of the unbalances, whose moment about the axis is that of their masses, and of
        gravity."""
        loads, square = list[Load](), self.speed**2
        still, varies = self.casing_rest, self.case.march.varies
        nodes = len(self.line.position)
        unbalance = self.line.unbalance_force(self.line.table.unbalance)[: 2 * nodes]
        unbalance = unbalance.reshape(nodes, 2)
        if unbalance.any() and square > 0.0:
            pattern = square * self.forces_on_line(unbalance)
            by_square = 1.0 / square if varies else 0.0
            loads.append(Load(rotor=pattern, casing=still, by_square=by_square))
        if unbalance.any() and varies:
            aside = self.forces_on_line(1j * unbalance)
            loads.append(Load(rotor=aside, casing=still, constant=0.0, by_acceleration=-1.0))
        if self.case.gravity is None:
            return tuple(loads)
        on_supports, turning = self._support_weight, {"frequency": self.speed}
        if varies:
            turning = {"order": 1.0}
        for pull, phase in ((self._weight.real, 0.0), (self._weight.imag, -0.5 * np.pi)):
            loads.append(Load(rotor=pull, casing=still, phase=phase, **turning))
        if on_supports.any():
            loads.append(Load(rotor=self.rotor_rest, casing=on_supports))
        return tuple(loads)

    @property
    def _weight(self) -> ComplexArray:
        """Modal forces W of gravity on the rotor: those at the angle psi are the real part of W
        exp(-i psi), (modes,)."""
        assert self.case.gravity is not None
        along_x, along_y = self.weight_rows
        return np.asarray(complex(*self.case.gravity.acceleration) * (along_x - 1j * along_y))

    @property
    def _support_weight(self) -> FloatArray:
        """Modal forces of gravity on the supports, (casing modes,)."""
        assert self.case.gravity is not None
        table, pulled = self.line.table, self.casing_rest
        given = [each.support for each in table.bearings if each.support is not None]
        pulls = [np.sqrt(one.mass) * np.array(self.case.gravity.acceleration) for one in given]
        pulled[self.reduced_casing.wall_modes :] = np.ravel(pulls)
        return pulled

    @cached_property
    def start(self) -> Start:
        """Static state under gravity at the speed at the start, in static axes; or no displacement
        at all.

        In rotating axes the coordinates of a round rotor are then the real part of Q exp(-i Omega
        t), and its bearings move by B Q / 2 with their rows B. Accelerations and damping are
        those of central differences, so that the march stays in this state.
        """
        casing, gravity, rotor = self.casing_rest, self.case.gravity, self.rotor
        if gravity is None or gravity.start == "unbent":
            return Start.of_rotor(self.rotor_rest, self.rotor_rest, len(casing))
        course = self.case.march.course(self.reference_frequency)
        omega = self.speed if course is None else float(course.speed(0.0))
        modes, turning = len(rotor.frequency), self.turning.rotor
        slower, step = (omega - self.speed) * turning.known("gyroscopic"), self.case.march.time_step
        rate, square = np.sin(omega * step) / step, (2.0 * np.sin(0.5 * omega * step) / step) ** 2
        dynamic = turning.stiffness_at(omega) - square * np.eye(modes)
        dynamic = dynamic - 1j * rate * (rotor.damping + slower)
        supports = np.arange(self.reduced_casing.wall_modes, len(casing))
        places, moved = self.bearings.rotor, self.bearings.support[:, supports]
        waves = [1.0, 1.0j] if omega else [1.0]  # real and imaginary part of Q
        stretch = np.hstack([*(wave / len(waves) * places for wave in waves), -moved])
        k0, k2 = self.bearings.stiffness.T[:, :, None]
        force = -(k0 * stretch + k2 * stretch.conj())
        own = np.hstack([*(wave * dynamic for wave in waves), np.zeros((modes, len(supports)))])
        rows, loads = own - places.conj().T @ force, self._weight
        equations = [rows.real, rows.imag][: len(waves)]
        known = [loads.real, loads.imag][: len(waves)]
        matrix = np.vstack([*equations, (moved.conj().T @ force).real])
        found = np.linalg.solve(matrix, np.concatenate([*known, self._support_weight[supports]]))
        casing[supports] = found[len(waves) * modes :]
        across = found[modes : 2 * modes] if omega else self.rotor_rest
        return Start(
            rotor=found[:modes],
            rotor_velocity=omega * across,
            casing=casing,
            casing_velocity=np.zeros_like(casing),
        )

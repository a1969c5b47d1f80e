"""Equations of a shaft line in static axes.

The deflections and slopes of the axis in the planes of x and y are the real and the imaginary parts
of complex unknowns z, those of the nodes of the shaft in turn, then the displacements of the
supports. At the constant speed Omega

    M z'' + (C_0 + t K_s - i Omega P) z' + C_2 conj(z') + (K_s + K_0 - i Omega t K_s) z + K_2
    conj(z) = f

with the stiffness K_s of the shaft, its loss time t, the polar inertias P, and the parts K_0 and
K_2 of the bearings and supports: K u = k_0 z + k_2 conj(z) for u = (Re z, Im z) with

    k_0 = (k_xx + k_yy)/2 + i (k_yx - k_xy)/2,   k_2 = (k_xx - k_yy)/2 + i (k_xy + k_yx)/2.

A spinning section resists a change of its slope: -i Omega I_p z' with its polar inertia, which for
the shaft itself is twice the diametral one. A wheel of solids adds its wave of nodal diameter 1,
whose first displacements are the deflection and the slope of its node, see `hub_waves`; its
amplitudes turn with it, and are further unknowns z.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.shaft_line import Matrix2, Segment, ShaftLine, Unbalance
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.shaft_line.elements import RoundElements, cowper, shaft_matrices
from bladewhirl.models.shaft_line.wheel import WheelOnLine, wheels_on_line
from bladewhirl.models.superelements.joined import range_of

SAME_PLACE = 1e-9  #: positions that differ by less, as a fraction of the length, are one node

SINGULAR = 1e-14
"""Smallest singular value of the stiffness at rest, scaled to a diagonal of one, of a line that is
held, as a fraction of the largest one."""


@dataclass(frozen=True, kw_only=True)
class LineModel:
    """A shaft line with n complex unknowns: deflection and slope of each node, then supports, then
    amplitudes of wheels."""

    case: Case
    shaft: RoundElements
    mass: Any  #: mass M, (n, n), complex with a wheel
    polar: FloatArray  #: polar inertias P, (n, n)
    shaft_stiffness: FloatArray  #: stiffness K_s of the shaft, (n, n)
    stiffness: tuple[ComplexArray, ComplexArray]  #: parts K_0 and K_2 of bearings and supports
    damping: tuple[ComplexArray, ComplexArray]  #: parts C_0 and C_2 of bearings and supports

    bearing_rows: FloatArray
    """Displacement of the shaft relative to ground or support at each bearing, as rows on the
    unknowns, (bearings, n)."""

    bare_mass: FloatArray  #: mass of the shaft with its disks in a plane, (2 nodes, 2 nodes)
    wheels: tuple[WheelOnLine, ...] = ()

    @property
    def table(self) -> ShaftLine:
        """The table of the case."""
        table = self.case.shaft_line
        assert table is not None
        return table

    @property
    def size(self) -> int:
        """Number of complex unknowns, n."""
        return len(self.mass)

    @property
    def position(self) -> FloatArray:
        """Position of each node along z [m], (nodes,)."""
        return self.shaft.node

    @property
    def outer_radius(self) -> FloatArray:
        """Outer radius at each node [m], the larger one at a step, (nodes,)."""
        ends = 0.5 * self.shaft.outer
        left, right = np.append(ends[:, 0], 0.0), np.append(0.0, ends[:, 1])
        return np.asarray(np.maximum(left, right))

    @property
    def polar_inertia(self) -> float:
        """Polar moment of inertia of shaft and disks [kg m2]."""
        tilted = np.zeros(self.size)
        tilted[1 : 2 * len(self.position) : 2] = 1.0
        tilted[: 2 * len(self.position) : 2] = self.position
        return float(tilted @ self.polar @ tilted)

    def node(self, position: float) -> int:
        """Return the node at a position of the case [m]."""
        return int(np.abs(self.position - position).argmin())

    @cached_property
    def reference_frequency(self) -> float:
        """Lowest natural frequency at rest without dampers [rad/s], of which speeds are
        multiples."""
        mass, _, stiffness = self.matrices(0.0)
        flexibility = np.linalg.solve(stiffness, mass)
        return float(1.0 / np.sqrt(np.abs(np.linalg.eigvals(flexibility)).max()))

    @property
    def speed(self) -> float:
        """Speed of rotation of the case [rad/s]."""
        return self.case.march.speed.rad_per_s(self.reference_frequency)

    @property
    def is_round(self) -> bool:
        """Whether no bearing or support distinguishes two axes, so that the parts C_2 and K_2 are
        zero."""
        return not (self.stiffness[1].any() or self.damping[1].any())

    def forms(self, omega: float) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return mass, damping and stiffness for the unknowns at a speed [rad/s], without the parts
        C_2 and K_2, (n, n) each."""
        loss = self.table.loss_time * self.shaft_stiffness
        drag = self.damping[0] + loss - 1j * omega * self.polar
        stiffness = self.shaft_stiffness + self.stiffness[0] - 1j * omega * loss
        for wheel in self.wheels:
            rows = np.ix_(wheel.unknowns, wheel.unknowns)
            _, by_velocity, by_place = wheel.whirling.turning(omega)
            drag[rows] += by_velocity
            stiffness[rows] += by_place
        return self.mass, drag, stiffness

    def matrices(self, omega: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return mass, damping and stiffness for real and imaginary parts of the unknowns at a
        speed [rad/s], (2n, 2n) each; those of damping and stiffness are not symmetric."""
        mass, drag, stiffness = self.forms(omega)
        return (
            real_form(mass),
            real_form(drag, self.damping[1]),
            real_form(stiffness, self.stiffness[1]),
        )

    def unbalance_force(self, rows: tuple[Unbalance, ...]) -> ComplexArray:
        """Return the forces of unbalances at a speed of 1 rad/s, at the instant at which the axes
        of the shaft are those at rest [kg m, kg m2], (n,)."""
        force = np.zeros(self.size, dtype=np.complex128)
        for row in rows:
            place = 2 * self.node(row.position)
            force[place] += row.unbalance * np.exp(1j * row.phase)
            force[place + 1] += row.couple * np.exp(1j * row.couple_phase)
        return force

    def weight(self, acceleration: complex) -> ComplexArray:
        """Return the forces of a uniform acceleration x + i y on all masses [N, N m], (n,)."""
        uniform = np.zeros(self.size)
        nodes, supports = 2 * len(self.position), self.table.supports
        uniform[:nodes:2] = 1.0
        uniform[nodes : nodes + supports] = 1.0
        return np.asarray(self.mass @ uniform * acceleration)

    def bearing_force(self, unknowns: ComplexArray, velocity: ComplexArray) -> ComplexArray:
        """Return the forces x + i y of the bearings on the shaft [N], (bearings, ...), for unknowns
        and their velocities, (n, ...)."""
        forces = []
        for row, bearing in zip(self.bearing_rows, self.table.bearings, strict=True):
            moved, rate = row @ unknowns, row @ velocity
            (k0, k2), (c0, c2) = parts(bearing.stiffness), parts(bearing.damping)
            forces.append(-(k0 * moved + k2 * moved.conj() + c0 * rate + c2 * rate.conj()))
        return np.array(forces)


def parts(matrix: Matrix2) -> tuple[complex, complex]:
    """Return the factors of z and of conj(z) that are equivalent to a real matrix."""
    (xx, xy), (yx, yy) = matrix
    return complex(xx + yy, yx - xy) / 2.0, complex(xx - yy, xy + yx) / 2.0


def real_form(
    direct: ComplexArray | FloatArray, mirrored: ComplexArray | None = None
) -> FloatArray:
    """Return the real matrix of z -> A z + B conj(z) for real and imaginary parts, (2n, 2n).

    Args:
        direct: A, (n, n).
        mirrored: B, (n, n); zero if None.
    """
    a = np.asarray(direct)
    b = np.zeros(a.shape) if mirrored is None else mirrored
    return np.block([[a.real + b.real, b.imag - a.imag], [a.imag + b.imag, a.real - b.real]])


def refuse_line(case: Case) -> None:
    """Check that a case has a bladed disk.

    Raises:
        CaseError: it has a shaft line in its place.
    """
    if case.shaft_line is not None:
        expected = (
            "not allowed here: a shaft line has run, modes, campbell,"
            " critical-speeds, response, stability, periodic and show"
        )
        raise CaseError([Fault(key="shaft_line", expected=expected)])


def line_model(case: Case, highest: float = 0.0) -> LineModel:
    """Return the equations of the shaft line of a case.

    Args:
        case: case with [shaft_line].
        highest: highest speed besides that of the case at which a wheel is needed [rad/s].

    Raises:
        CaseError: the bearings do not hold the line, or the wheel has no hub.
    """
    line = _model(case, 0.0)
    if line.wheels and (top := range_of(max(abs(line.speed), highest))):
        return _model(case, top)
    return line


def _model(case: Case, highest: float) -> LineModel:
    table = case.shaft_line
    assert table is not None
    shaft = _elements(case, table)
    plane = shaft_matrices(shaft)
    held = len(plane.stiffness) + table.supports
    wheels = wheels_on_line(case, highest, shaft.node, held)
    size = max([held, *(int(wheel.unknowns.max()) + 1 for wheel in wheels)])
    square = 2 * [slice(len(plane.stiffness))]
    mass: Any
    mass, polar, stiffness = np.zeros((3, size, size))
    mass[*square] = plane.translation + plane.rotation
    polar[*square] = 2.0 * plane.rotation
    stiffness[*square] = plane.stiffness
    for disk in table.disks:
        place = 2 * int(np.abs(shaft.node - disk.position).argmin())
        arm = np.array([1.0, disk.offset])
        mass[place : place + 2, place : place + 2] += disk.mass * np.outer(arm, arm)
        mass[place + 1, place + 1] += disk.diametral_inertia
        polar[place + 1, place + 1] += disk.polar_inertia
    springs, dampers = np.zeros((2, 2, size, size), dtype=np.complex128)
    support = len(plane.stiffness)
    rows = np.zeros((len(table.bearings), size))
    for bearing, row in zip(table.bearings, rows, strict=True):
        place, tilt = 2 * int(np.abs(shaft.node - bearing.position).argmin()), np.zeros(size)
        row[place], tilt[place + 1] = 1.0, 1.0
        if (below := bearing.support) is not None:
            row[support], ground = -1.0, np.zeros(size)
            ground[support] = 1.0
            mass[support, support] += below.mass
            _add(springs, below.stiffness, ground)
            _add(dampers, below.damping, ground)
            support += 1
        _add(springs, bearing.stiffness, row)
        _add(springs, bearing.tilt_stiffness, tilt)
        _add(dampers, bearing.damping, row)
    bare_mass = mass[*square].copy()
    for wheel in wheels:
        own = np.zeros((size, size), np.complex128)
        own[np.ix_(wheel.unknowns, wheel.unknowns)] = wheel.whirling.mass
        mass = mass + own
    model = LineModel(
        case=case,
        shaft=shaft,
        mass=mass,
        bare_mass=bare_mass,
        wheels=wheels,
        polar=polar,
        shaft_stiffness=stiffness,
        stiffness=(springs[0], springs[1]),
        damping=(dampers[0], dampers[1]),
        bearing_rows=rows,
    )
    _check_held(model)
    return model


def _add(parts_of: ComplexArray, matrix: Matrix2, row: FloatArray) -> None:
    for part, factor in zip(parts_of, parts(matrix), strict=True):
        part += factor * np.outer(row, row)


def _check_held(model: LineModel) -> None:
    """Check that bearings and supports hold the line.

    Raises:
        CaseError: a motion has no stiffness.
    """
    stiffness = model.matrices(0.0)[2]
    scale = 1.0 / np.sqrt(np.abs(np.diag(stiffness)))
    values = np.linalg.svd(scale[:, None] * stiffness * scale, compute_uv=False)
    if not values[-1] > SINGULAR * values[0]:
        expected = (
            "bearings that hold the line against displacement and tilt in both planes: at least"
            " two positions, or tilt_stiffness"
        )
        raise CaseError([Fault(key="shaft_line.bearings", expected=expected)])


def _elements(case: Case, table: ShaftLine) -> RoundElements:
    """Return the elements between nodes at the ends of elements, disks, bearings and unbalances."""
    ends = table.start + np.cumsum([0.0, *(each.length for each in table.segments)])
    slack = SAME_PLACE * (ends[-1] - ends[0])
    planned = [
        np.linspace(ends[n], ends[n + 1], segment.elements + 1)
        for n, segment in enumerate(table.segments)
    ]
    places = list(table.positions)
    nodes = np.sort(np.concatenate([*planned, np.clip(places, ends[0], ends[-1])]))
    nodes = nodes[np.append(True, np.diff(nodes) > slack)]
    segment = np.searchsorted(ends, (nodes[1:] + nodes[:-1]) / 2.0) - 1
    rows = [table.segments[n] for n in segment]
    share = [(nodes[e : e + 2] - ends[n]) / table.segments[n].length for e, n in enumerate(segment)]
    materials = [case.material.find(each.material) for each in rows]
    outer = [
        each.outer_diameter
        + ((each.end_outer_diameter or each.outer_diameter) - each.outer_diameter) * along
        for each, along in zip(rows, share, strict=True)
    ]
    torsion = np.array(
        [
            m.young_modulus / (2.0 + 2.0 * row.poisson_ratio)
            for row, m in zip(rows, materials, strict=True)
        ]
    )
    return RoundElements(
        node=nodes,
        outer=np.array(outer),
        inner=np.array([each.inner_diameter for each in rows]),
        young_modulus=np.array([each.young_modulus for each in materials]),
        shear_modulus=torsion * [_shear(row) for row in rows],
        torsion_modulus=torsion,
        density=np.array([each.density for each in materials]),
    )


def _shear(segment: Segment) -> float:
    """Return the shear coefficient."""
    if segment.shear_coefficient is not None:
        return segment.shear_coefficient
    middle = (segment.outer_diameter + (segment.end_outer_diameter or segment.outer_diameter)) / 2.0
    return cowper(segment.inner_diameter / middle, segment.poisson_ratio)

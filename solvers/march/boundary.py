"""Scheme for many contact nodes, with massless or consistent boundary.

The equations are in the comment of `solvers/kernel/boundary.c`.
"""

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.stage.boundary_problem import BoundaryProblem
from bladewhirl.solvers.kernel.structs import (
    Struct,
    aligned_copy,
    boundary_march,
    lib,
    padded,
    zeros,
)
from bladewhirl.solvers.march.march import CoatingRecords, EndReason, Statistics
from bladewhirl.solvers.packing.arrangement import Arrangement
from bladewhirl.solvers.packing.body import lengthened
from bladewhirl.solvers.packing.casing import nodal_response, pack_casing, pack_closure
from bladewhirl.solvers.packing.supports import damper_ends

DIRECTIONS = 3
"""Components of the displacement of a contact node: radial, tangential, axial."""


@dataclass(frozen=True, kw_only=True)
class BoundaryChunk:
    """Consecutive records of a march with many contact nodes. Nodes of all copies are numbered
    copy by copy."""

    step: IntArray  #: step number of each record, (records,)
    time: FloatArray  #: time of each record [s], (records,)
    modal_displacement: FloatArray  #: [kg^1/2 m], (records, copies, modes)
    modal_velocity: FloatArray  #: [kg^1/2 m/s], (records, copies, modes)
    contact_displacement: FloatArray
    """Radial, tangential and axial displacement of each node [m], (records, nodes, 3)."""
    contact_force: FloatArray
    """Radial, tangential and axial contact force on each node [N], (records, nodes, 3)."""
    gap: FloatArray  #: smallest gap of each node since the last record [m], (records, nodes)
    contact_impulse: FloatArray
    """Normal impulse on each node since the last record [N s], (records, nodes)."""
    friction_impulse: FloatArray
    """Friction impulse on each node since the last record, positive towards -theta [N s],
    (records, nodes)."""
    axial_impulse: FloatArray
    """Axial friction impulse on each node since the last record [N s], (records, nodes)."""
    contact_steps: IntArray  #: steps with contact since the last record, (records, nodes)
    contacts: IntArray  #: number of nodes in contact at the record, (records,)
    energy: FloatArray  #: energy of all copies [J], (records,)
    external_work: FloatArray  #: work of the loads since the start [J], (records,)
    normal_work: FloatArray  #: work of the normal contact forces [J], (records,)
    friction_work: FloatArray  #: work of the friction forces [J], (records,)
    damping_work: FloatArray  #: energy lost by damping [J], (records,)
    casing_displacement: FloatArray
    """Modal displacements of a flexible casing [kg^1/2 m], (records, casing modes)."""
    casing_velocity: FloatArray
    """Modal velocities of a flexible casing [kg^1/2 m/s], (records, casing modes)."""
    coating: CoatingRecords | None = None  #: records of an abradable coating

    @property
    def records(self) -> int:
        """Number of records."""
        return len(self.step)


@dataclass(frozen=True, kw_only=True)
class BoundaryState:
    """State between two steps."""

    step: int  #: number of steps n
    arrays: dict[str, FloatArray]  #: arrays of the struct `BoundaryState`

    @property
    def statistics(self) -> Statistics:
        """Quality measures since the start."""
        counts = self.arrays["counts"]
        return Statistics(
            steps=self.step,
            contact_steps=int(counts[lib.BOUNDARY_CONTACT_STEPS]),
            complementarity_residual=float(counts[lib.BOUNDARY_RESIDUAL]),
            lcp_failures=int(counts[lib.BOUNDARY_UNSOLVED]),
        )


class BoundaryMarch:
    """Central differences with contact of many nodes, of second order without contact.

    Args:
        problem: contact problem.
        time_step: time step [s].
        record_every: number of steps between records.

    Raises:
        ValueError: the time step is not below the critical time step.
    """

    cyclic = (False, False)

    def __init__(self, problem: BoundaryProblem, time_step: float, record_every: int) -> None:
        limit = problem.critical_time_step
        if not time_step < limit:
            raise ValueError(
                f"time step {time_step:.3g} s is at or above the critical step {limit:.3g} s; use a"
                " smaller step or fewer modes"
            )
        self._problem, self._dt, self._every = problem, time_step, record_every
        copies, modes = problem.frequency.shape
        nodes = len(problem.radius)
        self._boundary = _constants(problem, time_step)
        self._ring: Struct | None = None
        self._arrangement: Arrangement | None = None
        length = 2.0 * np.pi / len(problem.wall)
        if problem.casing is not None:
            self._arrangement, self._ring = _pack_ring(problem, time_step)
            length = 1.0 / problem.casing.radius
        self._closure = pack_closure(problem.closure, length)
        self._coating = _pack_coating(problem)
        group = nodes if self._ring is None else copies * nodes
        self._sizes = {
            "copies": copies,
            "modes": modes,
            "nodes": nodes,
            "twice_nodes": 2 * nodes,
            "components": DIRECTIONS * nodes,
            "group": group,
            "twice_group": 2 * group,
            "bordered": group + 1,
            "patterns": len(problem.loads),
            **_ring_sizes(self._ring, self._arrangement, copies * nodes),
            **_coating_sizes(self._coating, problem, group),
        }

    def init(self) -> BoundaryState:
        """Return the state at t = 0."""
        problem, dt = self._problem, self._dt
        x, v = problem.displacement, problem.velocity
        squares = problem.frequency**2
        force = np.zeros_like(x)
        for load in problem.loads:
            if load.ramp <= 0.0 < load.end:
                force = force + load.amplitude * np.cos(load.phase)
        drag = 2.0 * problem.damping_ratio * problem.frequency * v
        if problem.by_velocity is not None:
            drag = drag + v @ problem.by_velocity.T
        arrays = zeros("BoundaryState", self._sizes)
        if self._arrangement is not None:  # a casing at rest
            pushed = sum(
                load.casing * np.cos(load.phase)
                for load in problem.loads
                if load.casing is not None and load.ramp <= 0.0 < load.end
            )
            start = 0.5 * dt**2 * pushed + np.zeros(len(self._arrangement.entry))
            arrays["casing"][0] = self._arrangement.pack(start)
        arrays["q"][0] = x - dt * v + 0.5 * dt**2 * (force - squares * x - drag)
        arrays["q"][1] = x
        arrays["direction"][:, 0::2] = np.sign(problem.speed)
        arrays["gap"][:] = problem.initial_gap
        if problem.coating is not None:
            arrays["strain"][:] = problem.coating.strain
        return BoundaryState(step=0, arrays=arrays)

    def advance(
        self, state: BoundaryState, steps: int, record_every: int | None = None
    ) -> tuple[BoundaryState, BoundaryChunk, EndReason | None]:
        """Advance by a number of steps; see `Scheme.advance`."""
        every = self._every if record_every is None else record_every
        arrays = {name: aligned_copy(array) for name, array in state.arrays.items()}
        records = zeros("BoundaryRecords", self._sizes | {"records": steps // every + 2})
        scratch = Struct("BoundaryScratch", **zeros("BoundaryScratch", self._sizes))
        status, reached, written = boundary_march(
            (
                *(self._boundary, self._ring, self._coating, self._closure),
                Struct("BoundaryState", **arrays),
            ),
            (Struct("BoundaryRecords", **records), scratch),
            state.step,
            steps,
            every,
        )
        kept = {name: array[:written] for name, array in records.items()}
        end = EndReason.DIVERGENT if status == lib.DIVERGED else None
        after = BoundaryState(step=reached, arrays=arrays)
        return after, self._chunk(kept, after), end

    def _chunk(self, kept: dict[str, FloatArray], after: BoundaryState) -> BoundaryChunk:
        rows, work = len(kept["step"]), kept["work"]
        nodes = self._problem.angle.size
        force = kept["force"].reshape(rows, nodes, DIRECTIONS)
        impulse = kept["impulse"].reshape(rows, nodes, DIRECTIONS)
        moved = kept["q"] @ self._boundary.columns
        if self._problem.massless:
            moved = moved + np.einsum("rcj,cij->rci", kept["force"], self._boundary.compliance)
        casing, casing_velocity = kept["casing"], kept["casing_velocity"]
        if self._arrangement is not None:
            casing = self._arrangement.unpack(casing)
            casing_velocity = self._arrangement.unpack(casing_velocity)
        coating = None
        if self._coating is not None:
            coating = CoatingRecords(
                coating_impulse=kept["coating_impulse"].reshape(rows, nodes),
                coating_work=np.zeros((rows, 0)),
                wear_volume=kept["coating"][:, lib.REMOVED],
                wear_dissipated=kept["coating"][:, lib.DISSIPATED],
                coating_energy=kept["coating"][:, lib.STORED],
                wear_time=np.array([after.step * self._dt]),
                coating_strain=after.arrays["strain"][None].copy(),
            )
        return BoundaryChunk(
            coating=coating,
            step=np.asarray(kept["step"], dtype=np.int64),
            time=kept["step"] * self._dt,
            modal_displacement=kept["q"],
            modal_velocity=kept["velocity"],
            contact_displacement=moved.reshape(rows, nodes, DIRECTIONS),
            contact_force=force,
            gap=kept["gap"].reshape(rows, nodes),
            contact_impulse=impulse[:, :, 0],
            friction_impulse=-impulse[:, :, 1],
            axial_impulse=impulse[:, :, 2],
            contact_steps=kept["touched"].reshape(rows, nodes).astype(np.int64),
            contacts=np.asarray((force[:, :, 0] < 0.0).sum(axis=1)),
            energy=kept["energy"],
            external_work=work[:, lib.EXTERNAL],
            normal_work=work[:, lib.NORMAL],
            friction_work=work[:, lib.FRICTION],
            damping_work=work[:, lib.DAMPING],
            casing_displacement=casing,
            casing_velocity=casing_velocity,
        )


def _constants(problem: BoundaryProblem, dt: float) -> Struct:
    frequency, contact = problem.frequency, np.ascontiguousarray(problem.contact)
    squares, damping = frequency**2, 2.0 * problem.damping_ratio * frequency
    inverse = 1.0 / (1.0 / dt**2 + 0.5 * damping / dt)
    compliance, modes = problem.compliance, contact.shape[1]
    response, coupled = np.zeros((0, modes, modes)), np.zeros((0, modes))
    if problem.by_velocity is not None:
        coupled = np.ascontiguousarray(0.5 * (problem.by_velocity + problem.by_velocity.T))
        velocity = 0.5 / dt * problem.by_velocity
        response = np.array([np.linalg.inv(np.diag(1.0 / row) + velocity) for row in inverse])
    if not problem.massless:
        compliance = np.array([(contact * row) @ contact.T for row in inverse])
        if len(response):
            compliance = contact @ response @ contact.T
    weight, before = inverse, 0.5 * damping / dt - 1.0 / dt**2
    if len(response):
        weight, before = np.ones_like(inverse), np.full_like(inverse, -2.0 / dt**2)
    loads = [[load.end, load.ramp, load.frequency, load.phase] for load in problem.loads]
    patterns = [load.amplitude for load in problem.loads]
    return Struct(
        "Boundary",
        a=weight * (2.0 / dt**2 - squares),
        b=weight * before,
        c=weight,
        response=response,
        coupled=coupled,
        stiffness=squares,
        damping=damping,
        contact=contact,
        columns=np.ascontiguousarray(contact.T),
        normal=np.ascontiguousarray(contact[::DIRECTIONS].T),
        compliance=np.ascontiguousarray(compliance),
        angle=np.ascontiguousarray(problem.angle),
        recess=np.asarray(problem.recess, dtype=np.float64),
        radius=np.asarray(problem.radius, dtype=np.float64),
        wall=_closed(problem.wall),
        load=np.reshape(patterns, (len(patterns), *frequency.shape)).astype(np.float64),
        load_times=np.reshape(loads, (len(loads), 4)).astype(np.float64),
        massless=float(problem.massless),
        full=float(problem.full_sliding),
        friction=float(problem.friction),
        speed=float(problem.speed),
        time_step=dt,
        limit=float(problem.displacement_limit),
        gap_scale=float(np.abs(problem.wall[:, 0]).mean()),
    )


def _pack_ring(problem: BoundaryProblem, dt: float) -> tuple[Arrangement, Struct]:
    """Return the arrangement of the modes of a flexible casing, and its arrays."""
    casing = problem.casing
    assert casing is not None
    still = np.zeros(len(casing.frequency))
    loads = [still if load.casing is None else load.casing for load in problem.loads]
    arrangement, arrays = pack_casing(casing, loads, dt, cyclic=casing.by_harmonics)
    nodes, kinds = casing.nodal.shape[:2]
    ends = np.append(np.arange(nodes), 0)
    response = nodal_response(casing, dt)[ends][:, :, ends]
    elements = nodes / (2.0 * np.pi)
    return arrangement, Struct(
        "Ring",
        casing=arrays,
        response=np.ascontiguousarray(response.reshape(2 * (kinds * (nodes + 1),))),
        dampers=damper_ends(casing.dampers, arrays.body, arrangement, dt),
        place=lengthened(problem.angle.ravel() * elements),
        elements_per_step=problem.speed * dt * elements,
    )


def _pack_coating(problem: BoundaryProblem) -> Struct | None:
    """Return the coating; None if the wall has none."""
    coating, closure = problem.coating, problem.closure
    if coating is None:
        return None
    steepest = float(np.abs(problem.wall[:, 1]).max())
    if closure is not None:
        most = np.abs(closure.course.value(np.linspace(0.0, 1e3, 10001))).max()
        steepest += float(most * np.abs(closure.share[:, 1]).max())
    return Struct(
        "NodeCoating",
        half=coating.footprint / coating.arc / 2.0,
        track=coating.track,
        area=coating.arc * coating.width,
        rods=coating.strain.shape[1],
        steepest=steepest,
        thickness=coating.thickness,
        young_modulus=coating.young_modulus,
        yield_stress=coating.yield_stress,
        hardening=coating.hardening,
        limit=coating.limit,
    )


def _coating_sizes(coating: Struct | None, problem: BoundaryProblem, group: int) -> dict[str, int]:
    """Return the lengths of the arrays of a coating, zero without one."""
    names = "coated_copies coated_tips under coated_group augmented tracks rods coating_sums"
    if coating is None or problem.coating is None:
        return dict.fromkeys(names.split(), 0)
    copies, nodes = problem.angle.shape
    tracks, rods = problem.coating.strain.shape
    return {
        "coated_copies": copies,
        "coated_tips": copies * nodes,
        "under": int(2.0 * coating.half.max()) + 2,
        "coated_group": group,
        "augmented": 2 * group + 1,
        "tracks": tracks,
        "rods": rods,
        "coating_sums": lib.COATING_SUMS,
    }


def _ring_sizes(ring: Struct | None, arrangement: Arrangement | None, tips: int) -> dict[str, int]:
    """Return the lengths of the arrays of a ring, zero without one."""
    names = (
        "tips wide twice_wide ends tableau sums closed entries casing_entries dampers"
        " all_components twice_tips"
    )
    if ring is None or arrangement is None:
        return dict.fromkeys(names.split(), 0)
    wide = padded(tips)
    return {
        "tips": tips,
        "wide": wide,
        "twice_wide": 2 * wide,
        "ends": lib.HALF * wide,
        "tableau": 2 * tips + 2,
        "sums": padded(arrangement.columns + arrangement.half + lib.LANES),
        "closed": ring.casing.radial.start.shape[1],
        "entries": arrangement.entries,
        "casing_entries": arrangement.entries,
        "dampers": len(ring.dampers.rows),
        "all_components": DIRECTIONS * tips,
        "twice_tips": 2 * tips,
    }


def _closed(values: FloatArray) -> FloatArray:
    """Return values and derivatives on a circle as rows, with the first angle again at the end; the
    derivatives are multiplied by the distance of two angles."""
    angles = len(values)
    rows = np.concatenate([values, values[:1]]).T * [[1.0], [2.0 * np.pi / angles]]
    return np.ascontiguousarray(rows)

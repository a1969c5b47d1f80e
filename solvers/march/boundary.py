"""Scheme for many contact nodes, with massless or consistent boundary.

The equations are in the comment of `solvers/kernel/boundary.c`.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.boundary_problem import BoundaryProblem
from bladewhirl.solvers.kernel.structs import Struct, aligned_copy, boundary_march, lib, zeros
from bladewhirl.solvers.march.march import (
    CoatingRecords,
    EndReason,
    KernelState,
    MarchRecords,
)
from bladewhirl.solvers.packing.arrangement import Arrangement
from bladewhirl.solvers.packing.boundary import (
    DIRECTIONS,
    coating_sizes,
    pack_boundary,
    pack_node_coating,
    pack_ring,
    ring_sizes,
)
from bladewhirl.solvers.packing.casing import pack_closure


@dataclass(frozen=True, kw_only=True)
class BoundaryChunk(MarchRecords):
    """Consecutive records of a march with many contact nodes. Nodes of all copies are numbered
    copy by copy."""

    modal_displacement: FloatArray  #: [kg^1/2 m], (records, copies, modes)
    modal_velocity: FloatArray  #: [kg^1/2 m/s], (records, copies, modes)
    contact_displacement: FloatArray
    """Radial, tangential and axial displacement of each node [m], (records, nodes, 3)."""
    contact_force: FloatArray
    """Radial, tangential and axial contact force on each node [N], (records, nodes, 3)."""
    axial_impulse: FloatArray
    """Axial friction impulse on each node since the last record [N s], (records, nodes)."""

    def beyond(self, problem: Any, arrays: Any, time_step: float) -> tuple[str, str]:
        """Return the contact node that passed the displacement limit as text, see `Chunk`."""
        node = int(np.abs(self.contact_displacement[-1, :, 0]).argmax())
        return f"contact node {arrays.node[node]} of blade {arrays.blade[node]}", ""


class BoundaryMarch:
    """Central differences with contact of many nodes; second-order accurate without contact.

    Args:
        problem: contact problem.
        time_step: time step [s].
        record_every: number of steps between records.

    Raises:
        ValueError: the time step is not below the critical time step.
    """

    cyclic = (False, False)
    chunk: ClassVar[type[BoundaryChunk]] = BoundaryChunk
    records_casing = True

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
        self._boundary = pack_boundary(problem, time_step)
        self._ring: Struct | None = None
        self._arrangement: Arrangement | None = None
        length = 2.0 * np.pi / len(problem.wall)
        if problem.casing is not None:
            self._arrangement, self._ring = pack_ring(problem, time_step)
            length = 1.0 / problem.casing.radius
        self._closure = pack_closure(problem.closure, length)
        self._coating = pack_node_coating(problem)
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
            **ring_sizes(self._ring, self._arrangement, copies * nodes),
            **coating_sizes(self._coating, problem, group),
        }

    def init(self) -> KernelState:
        """Return the state at t = 0."""
        problem, dt = self._problem, self._dt
        x, v = problem.start.rotor, problem.start.rotor_velocity
        squares = problem.frequency**2
        force = np.zeros_like(x)
        for load in problem.loads:
            if load.ramp <= 0.0 < load.end:
                force = force + load.rotor * np.cos(load.phase)
        drag = 2.0 * problem.damping_ratio * problem.frequency * v
        if problem.by_velocity is not None:
            drag = drag + v @ problem.by_velocity.T
        arrays = zeros("BoundaryState", self._sizes)
        if self._arrangement is not None:
            for number, moved in enumerate(self._casing_start()):
                arrays["casing"][number] = self._arrangement.pack(moved)
        arrays["q"][0] = x - dt * v + 0.5 * dt**2 * (force - squares * x - drag)
        arrays["q"][1] = x
        arrays["direction"][:, 0::2] = np.sign(problem.speed)
        arrays["gap"][:] = problem.initial_gap
        if problem.coating is not None:
            arrays["strain"][:] = problem.coating.strain
        return KernelState(step=0, arrays=arrays)

    def _casing_start(self) -> tuple[FloatArray, FloatArray]:
        """Return the modal displacements of the casing one step before the start and at the
        start."""
        problem, casing, dt = self._problem, self._problem.casing, self._dt
        assert casing is not None
        x, v = problem.start.casing, problem.start.casing_velocity
        pushed = sum(
            load.casing * np.cos(load.phase)
            for load in problem.loads
            if load.ramp <= 0.0 < load.end
        )
        restored = casing.frequency**2 * x + 2.0 * casing.damping_ratio * casing.frequency * v
        restored += casing.dampers.T @ (casing.dampers @ v)
        return x - dt * v + 0.5 * dt**2 * (pushed - restored), x

    def advance(
        self, state: KernelState, steps: int, record_every: int | None = None
    ) -> tuple[KernelState, BoundaryChunk, EndReason | None]:
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
        after = KernelState(step=reached, arrays=arrays)
        return after, self._chunk(kept, after), end

    def _chunk(self, kept: dict[str, FloatArray], after: KernelState) -> BoundaryChunk:
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

"""Time integration by central differences with forward-increment Lagrange multipliers."""

from dataclasses import replace

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.cone import in_wall_axes
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.models.stage.varying_speed import Rotation, displacement_by
from bladewhirl.solvers.kernel.structs import (
    Arrays,
    Struct,
    lib,
    march,
    padded,
    working_array,
    zeros,
)
from bladewhirl.solvers.march.march import (
    Chunk,
    CoatingRecords,
    EndReason,
    KernelState,
    check_time_step,
)
from bladewhirl.solvers.packing.arrangement import load_times
from bladewhirl.solvers.packing.casing import pack_casing, pack_closure, pack_coating
from bladewhirl.solvers.packing.foreshortening import pack_foreshortening
from bladewhirl.solvers.packing.joints import pack_joints
from bladewhirl.solvers.packing.rotor import (
    DIRECTIONS,
    blade_columns,
    pack_gyroscopic,
    pack_rotor,
)
from bladewhirl.solvers.packing.speed import pack_drive, pack_speed
from bladewhirl.solvers.packing.supports import (
    pack_bearings,
    pack_dampers,
    pack_fuse,
    pack_springs,
)

ENDS = {lib.DIVERGED: EndReason.DIVERGENT, lib.FUSED: EndReason.FUSED}
"""Reasons for an end by the status of the kernel."""


class CentralDifference:
    """The scheme of Carpenter, Taylor and Katona (1991) with damping and sliding friction.

    The scheme is of second order without contact. The contact conditions are satisfied at the end
    of each step. An instance must not march in two threads at the same time, because its calls
    share working arrays. With the symbols of `solvers/kernel/march.c`, the complementarity residual
    of a step is max_j |min(g_j, W_jj lambda_j)| / max(clearance, max_j |g_p,j|), where g are the
    gaps of the corrected displacements. The part of g due to foreshortening follows from the
    compliance.

    Args:
        problem: contact problem.
        time_step: time step [s].
        record_every: number of steps between records.
        cyclic: whether to treat the harmonics of a cyclic rotor or casing separately; if not, all
            products are dense.

    Raises:
        ValueError: the time step is not below the critical time step.
    """

    def __init__(
        self, problem: ContactProblem, time_step: float, record_every: int, *, cyclic: bool = True
    ) -> None:
        check_time_step(problem, time_step)
        self._problem, self._time_step, self._record_every = problem, time_step, record_every
        turns = problem.joints is not None and problem.rotor.by_velocity is not None
        self._columns = blade_columns(problem.rotor) if cyclic and not turns else None
        self.cyclic = self._columns is not None, cyclic and problem.casing.by_harmonics
        rotor, self._rotor = pack_rotor(problem, time_step, self._columns)
        casing, self._casing = pack_casing(
            problem.casing,
            [load.casing for load in problem.loads],
            time_step,
            cyclic=self.cyclic[1],
            friction=None if problem.sliding == "full" else problem.friction,
        )
        self._arrangements = rotor, casing
        bodies = self._rotor.body, self._casing.body
        self._stage = {
            "rotor": self._rotor,
            "casing": self._casing,
            "springs": pack_springs(problem, self._arrangements),
            "dampers": pack_dampers(problem, bodies, self._arrangements, time_step),
            "gyroscopic": pack_gyroscopic(problem, rotor, time_step),
            "bearings": pack_bearings(problem, self._arrangements, time_step),
            "closure": pack_closure(problem.closure),
            "coating": pack_coating(problem),
            "foreshortening": pack_foreshortening(problem, rotor, time_step, cyclic=self.cyclic[0]),
            "joints": pack_joints(problem, time_step),
            "numbers": _numbers(problem, time_step),
        }
        self._stage["speed"] = pack_speed(problem, rotor, self._stage, self._pack_coupled)
        self._stage["drive"] = pack_drive(problem, rotor)
        self._stage["fuse"] = pack_fuse(problem, rotor)
        # State and records are copied to and from arrays that are used again, as making and
        # checking new ones takes longer.
        self._state = Struct("State", **zeros("State", self._sizes()))
        self._records = Struct(
            "Records", **zeros("Records", self._sizes() | {"records": 0, "driven_records": 0})
        )
        self._scratch = working_array(self._stage, self._state)
        #: whether records contain the motion of the casing; if not, its arrays have no columns
        self.records_casing = True

    def _pack_coupled(self, problem: ContactProblem) -> dict[str, Struct | None]:
        """Return the structs that depend on Coriolis forces, for the same problem at another
        speed."""
        dt, cyclic = self._time_step, self.cyclic[0]
        arrangement, packed = pack_rotor(problem, dt, self._columns)
        like = self._stage["gyroscopic"]
        return {
            "rotor": packed,
            "gyroscopic": pack_gyroscopic(problem, arrangement, dt, like),
            "bearings": pack_bearings(problem, (arrangement, self._arrangements[1]), dt),
            "foreshortening": pack_foreshortening(problem, arrangement, dt, cyclic=cyclic),
        }

    def init(self) -> KernelState:
        """Return the state at t = 0; x_{-1} follows from the initial velocity and acceleration."""
        problem, dt = self._problem, self._time_step
        turned = problem.rotation_at(0.0)
        state = self.begin(0, problem.start, turned)
        arrays = state.arrays
        arrays["gap"] = problem.initial_gap()
        arrays["until"] -= 1.0
        arrays["direction"][:, 0::2] = np.sign(turned.speed)
        if problem.start.contact_force.size:
            arrays["force"] = problem.start.contact_force.reshape(arrays["force"].shape).copy()
        if problem.coating is not None:
            arrays["strain"][:] = problem.coating.strain
        rotor, casing = (
            arrangement.unpack(arrays[name][0])
            for arrangement, name in zip(self._arrangements, ("rotor", "casing"), strict=True)
        )
        if (joints := problem.joints) is not None:
            acting = [load.amplitude(0.0, turned, problem.speed) for load in problem.loads]
            rows = joints.rows(len(problem.rotor.tip_angle)) @ problem.rotor.all_contact
            for row, displacement in ((1, problem.start.rotor), (2, rotor)):
                arrays["joint_place"][row] = rows @ displacement.ravel()
                arrays["joint_place"][row] += joints.damper_rows @ joints.damper_start.ravel()
            arrays["bodies"][:] = joints.damper_start.ravel()
            arrays["joint_place"][0] = joints.start + acting @ joints.by_load
            arrays["joint_force"][:] = joints.start_force
        earlier = replace(problem, start=replace(problem.start, rotor=rotor, casing=casing))
        arrays["gaps"][:] = arrays["gap"], earlier.initial_gap(-dt)
        return state

    def begin(self, step: int, start: Start, turned: Rotation) -> KernelState:
        """Return the state at a step with given displacements and velocities, without gaps,
        contact and works before this step."""
        problem, dt = self._problem, self._time_step
        rotor, casing, torque, rate = self.accelerations(step * dt, start, turned)
        slots = []
        for name, arrangement, acceleration in zip(
            ("rotor", "casing"), self._arrangements, (rotor, casing), strict=True
        ):
            x, v = getattr(start, name), getattr(start, f"{name}_velocity")
            before = x - dt * v + 0.5 * dt**2 * acceleration
            slots.append(arrangement.pack(np.array([before, x, np.zeros_like(x)])))
        arrays = zeros("State", self._sizes())
        arrays |= {"rotor": slots[0], "casing": slots[1]}
        if problem.drive is not None:
            self._start_drive(arrays, torque, turned._replace(acceleration=rate), start)
        return KernelState(step=step, arrays=arrays)

    def displacements(self, state: KernelState, row: int) -> list[FloatArray]:
        """Return the modal displacements of rotor and casing in a state, one step before it (row 0)
        or at its step (row 1)."""
        return [
            arrangement.unpack(state.arrays[name][row])
            for arrangement, name in zip(self._arrangements, ("rotor", "casing"), strict=True)
        ]

    def accelerations(
        self, time: float, start: Start, turned: Rotation
    ) -> tuple[FloatArray, FloatArray, float, float]:
        """Return the modal accelerations of rotor and casing with the contact forces of the start,
        the torque on a free rotor [N m], and the acceleration of the rotation [rad/s2]."""
        problem = self._problem
        torque, rate = 0.0, turned.acceleration
        if problem.drive is not None:  # its acceleration is found here, with the forces it causes
            turned = turned._replace(acceleration=0.0)
        amplitudes = np.array(
            [load.amplitude(time, turned, problem.speed) for load in problem.loads]
        )
        springs = problem.spring_force(turned.angle, np.concatenate([start.rotor, start.casing]))
        pulls = np.split(springs, [len(start.rotor)])
        pulls[0] = pulls[0] + problem.turning_force(turned, start.rotor, start.rotor_velocity)
        acting, spun = [problem.contact_pull(turned, start)], 0.0
        if (bearings := problem.bearings) is not None:
            motion = (start.rotor, start.rotor_velocity), (start.casing, start.casing_velocity)
            held = bearings.force(turned.angle, turned.speed, *motion)
            acting.append(bearings.pulls(turned.angle, held))
            spun = bearings.torque(turned.angle, start.rotor, held)
        for both in acting:
            pulls = [pull + more for pull, more in zip(pulls, both, strict=True)]
        found = []
        for name, pull in zip(("rotor", "casing"), pulls, strict=True):
            body = getattr(problem, name)
            x, v = getattr(start, name), getattr(start, f"{name}_velocity")
            loads = [getattr(load, name) for load in problem.loads]
            force = amplitudes @ np.reshape(loads, (len(loads), len(x))) + pull
            frequency = np.abs(body.frequency)
            drag = 2.0 * body.damping_ratio * frequency * v + body.dampers.T @ (body.dampers @ v)
            acceleration = force - body.frequency * frequency * x - drag
            if name == "rotor" and problem.drive is not None:
                assert problem.change is not None
                torque, rate, further = problem.drive.acceleration(
                    turned.speed, problem.change, body.centre, (x, v, acceleration), spun
                )
                acceleration = acceleration + further
            found.append(acceleration)
        return found[0], found[1], torque, rate

    def _start_drive(self, arrays: Arrays, torque: float, turned: Rotation, start: Start) -> None:
        """Set the state of a free speed with the torque [N m] and the rotation at a step."""
        problem, dt = self._problem, self._time_step
        assert problem.drive is not None
        assert problem.change is not None
        (angle, speed, rate) = turned
        state = dict.fromkeys(range(lib.DRIVE_NUMBERS), 0.0) | {
            lib.DRIVE_BEFORE: angle - speed * dt + 0.5 * rate * dt**2,
            lib.DRIVE_ANGLE: angle,
            lib.DRIVE_SPEED: speed - 0.5 * dt * rate,
            lib.DRIVE_ACCELERATION: rate,
            lib.DRIVE_SQUARE: (speed - 0.5 * dt * rate) * (speed - 1.5 * dt * rate),
            lib.DRIVE_CENTRE: speed,
            lib.DRIVE_MOMENTUM: -0.5 * dt * torque
            + problem.drive.momentum(speed, problem.change, start.rotor, start.rotor_velocity),
        }
        arrays["drive"][:] = [state[place] for place in range(lib.DRIVE_NUMBERS)]

    def advance(
        self, state: KernelState, steps: int, record_every: int | None = None
    ) -> tuple[KernelState, Chunk, EndReason | None]:
        """Advance by a number of steps; see `Scheme.advance`."""
        every = self._record_every if record_every is None else record_every
        for name, array in state.arrays.items():
            getattr(self._state, name)[...] = array
        most = steps // every + 2
        needed = self.records_casing or self._problem.casing.supports > 0
        columns = self._arrangements[1].entries if needed else 0
        if len(self._records.step) < most or self._records.casing.shape[1] != columns:
            driven = 0 if self._problem.drive is None else most
            sizes = self._sizes() | {
                "records": most,
                "casing_entries": columns,
                "driven_records": driven,
            }
            self._records = Struct("Records", **zeros("Records", sizes))
        status, reached, written = march(
            self._stage,
            self._state,
            self._records,
            self._scratch,
            state.step,
            steps,
            every,
        )
        end = ENDS.get(status)
        arrays = {name: getattr(self._state, name).copy() for name in state.arrays}
        after = KernelState(step=reached, arrays=arrays)
        return after, self._chunk(written, after), end

    def _sizes(self) -> dict[str, int]:
        """Return the lengths of the arrays in state and records, by their names in `kernel.h`."""
        rotor, casing = self._arrangements
        tips, coating = len(self._problem.rotor.tip_angle), self._problem.coating
        copies, bending = self._problem.rotor.copies, self._stage["foreshortening"]
        tracks, rods = (0, 0) if coating is None else coating.strain.shape
        pairs = 0 if self._problem.joints is None else len(self._problem.joints.ends)
        return {
            "pairs": pairs,
            "joint_values": DIRECTIONS * pairs,
            "body_values": 0 if self._problem.joints is None else self._problem.joints.pull.size,
            "joint_sums": lib.JOINT_SUMS,
            "all_joint_sums": lib.JOINT_SUMS * pairs,
            "rotation_numbers": lib.ROTATION_NUMBERS if self._problem.change is not None else 0,
            "drive_numbers": 0 if self._problem.drive is None else lib.DRIVE_NUMBERS,
            "rotor_entries": rotor.entries,
            "casing_entries": casing.entries,
            "tips": tips,
            "copies": copies,
            "components": DIRECTIONS * tips // copies,
            "twice_nodes": 2 * tips // copies,
            "all_components": DIRECTIONS * tips,
            "tracks": tracks,
            "rods": rods,
            "coated_tips": 0 if coating is None else tips,
            "coating_sums": 0 if coating is None else lib.COATING_SUMS,
            "bent_tips": 0 if bending is None else tips,
            "bent_wide": 0 if bending is None else padded(tips),
            "term_lanes": 0 if bending is None else bending.sign.shape[1],
        }

    def _chunk(self, written: int, after: KernelState) -> Chunk:
        """Return a copy of the records written."""
        records, (rotor, casing) = self._records, self._arrangements
        step, work = records.step[:written].copy(), records.work[:written].copy()
        varies = self._problem.change is not None
        modes = self._problem.casing.wall_modes if self.records_casing else 0
        wall = [
            casing.unpack(each[:written])[:, :modes] if modes else np.zeros((written, 0))
            for each in (records.casing, records.casing_velocity)
        ]
        return Chunk(
            step=step,
            time=step * self._time_step,
            rotor_displacement=rotor.unpack(records.rotor[:written]),
            rotor_velocity=rotor.unpack(records.rotor_velocity[:written]),
            casing_displacement=wall[0],
            casing_velocity=wall[1],
            gap=records.gap[:written].copy(),
            contact_impulse=records.impulse[:written].copy(),
            friction_impulse=records.drag[:written].copy(),
            contact_steps=records.touched[:written].astype(np.int64),
            contacts=records.contacts[:written].astype(np.int64),
            energy=records.energy[:written].copy(),
            external_work=work[:, lib.EXTERNAL],
            normal_work=work[:, lib.NORMAL],
            friction_work=work[:, lib.FRICTION],
            damping_work=work[:, lib.DAMPING],
            coupling_work=work[:, lib.PARAMETRIC],
            coating=self._coating_records(written, after),
            closing_work=work[:, lib.CLOSING],
            rotation_angle=records.rotation[:written, lib.ANGLE].copy() if varies else np.zeros(0),
            rotation_speed=records.rotation[:written, lib.SPEED].copy() if varies else np.zeros(0),
            **self._line_records(written),
            **self._drive_records(written),
            **self._node_records(written),
            **self._joint_records(written),
        )

    def _line_records(self, written: int) -> dict[str, FloatArray]:
        """Return the motion of a shaft line and the forces of its bearings, if there is one."""
        problem, records = self._problem, self._records
        bearings = problem.bearings
        if bearings is None or bearings.shaft is None:
            return {}
        of_rotor, of_casing = self._arrangements
        rotor = (
            of_rotor.unpack(records.rotor[:written]),
            of_rotor.unpack(records.rotor_velocity[:written]),
        )
        casing = (
            of_casing.unpack(records.casing[:written]),
            of_casing.unpack(records.casing_velocity[:written]),
        )
        angle = problem.speed * self._time_step * records.step[:written]
        speed = np.full(written, problem.speed)
        if problem.change is not None:
            angle, speed = records.rotation[:written].T
        shaft = bearings.shaft
        force = bearings.force(angle, speed, rotor, casing)[:, : shaft.bearings]
        moved = (casing[0] @ bearings.support.T)[:, : shaft.bearings]
        strained = 0.5 * ((rotor[0] @ shaft.stiffness) * rotor[0]).sum(axis=1)
        return {
            "shaft_displacement": shaft.displacement(angle, rotor[0]),
            "bearing_force": np.stack([force.real, force.imag], axis=2),
            "support_displacement": np.stack([moved.real, moved.imag], axis=2),
            "line_energy": strained + bearings.energy(angle, rotor[0], casing[0]),
        }

    def _drive_records(self, written: int) -> dict[str, FloatArray]:
        """Return the records of a free speed, if it is free."""
        if self._problem.drive is None:
            return {}
        drive = self._records.drive[:written].copy()
        return {
            "angular_momentum": drive[:, lib.DRIVE_MOMENTUM],
            "rotor_energy": self._records.rotor_energy[:written].copy(),
            "drive_work": drive[:, lib.DRIVE_WORK],
            "loss_work": drive[:, lib.DRIVE_LOSS],
            "braking_work": drive[:, lib.DRIVE_CONTACT],
        }

    def _node_records(self, written: int) -> dict[str, FloatArray]:
        """Return motion and forces of contact nodes, with their own flexibility."""
        rotor, records = self._problem.rotor, self._records
        copies, tips, compliance = rotor.copies, len(rotor.tip_angle), rotor.compliance
        contact = rotor.contact
        components, modes = contact.shape
        motion = self._arrangements[0].unpack(records.rotor[:written])
        force = records.force[:written].reshape(written, copies, components)
        moved = motion.reshape(written, copies, modes) @ contact.T
        change = self._problem.change
        if change is not None and change.compliance is not None:
            time = records.step[:written] * self._time_step
            moved = moved + change.compliance.displacement(force, change.course.speed(time))
        elif compliance is not None:
            moved = moved + displacement_by(force, compliance)
        slope = self._problem.slope
        moved, force = (
            in_wall_axes(each.reshape(-1, components).T, -slope).T if np.any(slope) else each
            for each in (moved, force)
        )
        return {
            "contact_displacement": moved.reshape(written, tips, DIRECTIONS),
            "contact_force": force.reshape(written, tips, DIRECTIONS).copy(),
            "axial_impulse": records.axial[:written].copy(),
        }

    def _joint_records(self, written: int) -> dict[str, FloatArray]:
        """Return the records of friction joints, if there are any."""
        joints, records = self._problem.joints, self._records
        if joints is None:
            return {}
        shape = written, len(joints.ends)
        sums = records.joint_sums[:written].reshape(*shape, lib.JOINT_SUMS)
        return {
            "joint_force": records.joint_force[:written].reshape(*shape, DIRECTIONS).copy(),
            "joint_displacement": records.joint_place[:written].reshape(*shape, DIRECTIONS).copy(),
            "joint_steps": sums[..., : lib.JOINT_SLIPPING + 1].copy(),
            "joint_slip": sums[..., lib.JOINT_SLIP].copy(),
            "joint_work": sums[..., lib.JOINT_WORK].copy(),
            "joint_wear": sums[..., lib.JOINT_WEAR].copy(),
            "damper_displacement": records.bodies[:written].reshape(written, -1, 3).copy(),
        }

    def _coating_records(self, written: int, after: KernelState) -> CoatingRecords | None:
        coating, records = self._problem.coating, self._records
        if coating is None:
            return None
        sums = records.coating[:written].copy()
        return CoatingRecords(
            coating_impulse=records.coating_impulse[:written].copy(),
            wear_volume=sums[:, lib.REMOVED],
            wear_dissipated=sums[:, lib.DISSIPATED],
            coating_energy=sums[:, lib.STORED],
            wear_time=np.array([after.step * self._time_step]),
            coating_strain=after.arrays["strain"][None],
        )


def _numbers(problem: ContactProblem, dt: float) -> Struct:
    casing = problem.casing
    per_radian = casing.elements / (2.0 * np.pi)
    return Struct(
        "Numbers",
        time_step=dt,
        angle_per_step=problem.speed * dt,
        elements_per_step=problem.speed * dt * per_radian,
        friction=problem.friction,
        is_signed=float(problem.sliding == "signed"),
        tip_rotation=float(problem.tip_rotation),
        speed=problem.speed,
        displacement_limit=problem.displacement_limit,
        gap_scale=float(np.abs(casing.clearance[:, 0]).min()),
        loads=load_times(problem.loads),
    )

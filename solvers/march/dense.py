"""Schemes with the contact laws "moreau-jean" and "penalty", on dense matrices.

Both integrate velocities with the midpoint rule (see `solvers/kernel/dense.c`). The matrices B_N
and B_T turn normal and friction impulses at the tips into impulses on the coordinates. With
the gap g, its rate u_N and the relative tangential velocity u_T, the contact laws are:

``moreau-jean`` (Jean 1999; Moreau 1988): for a tip whose gap would be closed in the free step,

    0 <= P_N  perp  u_N+ + e u_N- >= 0,      |P_T| <= mu P_N,   P_T = -mu P_N sign(u_T+) if sliding

with the restitution coefficient e. Tips stick and slip. A tip can penetrate by its motion in half a
step at most, and gaps can drift by this amount.

``penalty``: half a step of free motion, the contact impulse, and another half step of free motion,
with

    P_N = h k max(0, -g),      P_T = -mu P_N clip(u_T+ / v_s, -1, 1)

with the time step h, the penalty stiffness k and the speed v_s. Below v_s friction is smaller, so
tips creep instead of sticking. The penalty spring returns its energy, so impacts are elastic. The
time step must resolve the period of a tip on the penalty spring.

The residual of a step is max_j |min(u_N,j+ + e u_N,j-, W_jj P_j)|, divided by the largest velocity.
"""

import numpy as np
import scipy.linalg as la

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel.structs import Struct, dense_march, lib, zeros
from bladewhirl.solvers.march.march import (
    Chunk,
    EndReason,
    KernelState,
    LawError,
    check_time_step,
)
from bladewhirl.solvers.packing.arrangement import load_times
from bladewhirl.solvers.packing.casing import pack_closure

SHARE_OF_STIFFEST = 0.5
"""Largest product of the time step and the frequency of a tip on its penalty spring."""


class _Dense:
    """Base class of the schemes in this module.

    Args:
        problem: contact problem.
        time_step: time step [s].
        record_every: number of steps between records.

    Raises:
        ValueError: the time step is not below the critical step, or too long for the penalty
            stiffness.
    """

    def __init__(self, problem: ContactProblem, time_step: float, record_every: int) -> None:
        check_time_step(problem, time_step)
        self.cyclic = (False, False)
        self._problem, self._dt, self._record_every = problem, time_step, record_every
        self._stage, self._closure = _stage(problem, time_step), pack_closure(problem.closure)
        law = {"restitution": 0.0, "penalty": 0.0, "stick_speed": 0.0} | self._law_numbers()
        self._law = Struct("DenseLaw", friction=problem.friction, **law)
        tips = len(problem.rotor.tip_angle)
        self._sizes = {"modes": len(self._stage.stiffness), "tips": tips, "twice_tips": 2 * tips}

    def _law_numbers(self) -> dict[str, float]:
        """Return the parameters of the contact law, see `kernel.h`."""
        raise NotImplementedError

    def init(self) -> KernelState:
        """Return the state at t = 0."""
        start = self._problem.start
        arrays = zeros("DenseState", self._sizes)
        arrays["displacement"][:] = np.concatenate([start.rotor, start.casing])
        arrays["velocity"][:] = np.concatenate([start.rotor_velocity, start.casing_velocity])
        arrays["sums"][lib.DENSE_GAP] = self._problem.initial_gap()
        return KernelState(step=0, arrays=arrays)

    def advance(
        self, state: KernelState, steps: int, record_every: int | None = None
    ) -> tuple[KernelState, Chunk, EndReason | None]:
        """Advance by a number of steps; see `Scheme.advance`."""
        every = self._record_every if record_every is None else record_every
        arrays = _copy(state.arrays)
        step, last, ended = state.step, state.step + steps, None
        scratch = Struct("DenseScratch", **zeros("DenseScratch", self._sizes))
        structs = self._stage, self._closure, self._law, Struct("DenseState", **arrays), scratch
        records: list[KernelState] = []
        while step < last and ended is None:
            if step % every == 0:
                records.append(KernelState(step=step, arrays=_copy(arrays)))
                arrays["sums"][:] = 0.0
                arrays["sums"][lib.DENSE_GAP] = np.inf
            count = min(every - step % every, last - step)
            done = dense_march(*structs, time_step=self._dt, first=step, steps=count)
            step += done
            if done < count:
                ended = EndReason.DIVERGENT
                if not records or records[-1].step < step:
                    records.append(KernelState(step=step, arrays=_copy(arrays)))
        return KernelState(step=step, arrays=arrays), self._chunk(records), ended

    def _energy(self, state: KernelState) -> float:
        x, v, stage = state.arrays["displacement"], state.arrays["velocity"], self._stage
        waves = np.arange(len(stage.turning_cos)) * stage.speed * state.step * self._dt
        turned = np.tensordot(np.cos(waves), stage.turning_cos, 1)
        turned += np.tensordot(np.sin(waves), stage.turning_sin, 1)
        joined = x[stage.coupled]
        return float(0.5 * (v @ v + x @ (stage.stiffness * x) + joined @ turned @ joined))

    def _chunk(self, records: list[KernelState]) -> Chunk:
        rotor = self._stage.tip_radial.shape[1]
        step = np.array([record.step for record in records], dtype=np.int64)
        values = {
            name: np.reshape(
                [record.arrays[name] for record in records], (len(records), *array.shape)
            )
            for name, array in zeros("DenseState", self._sizes).items()
        }
        gap, impulse, drag, touched = np.moveaxis(values["sums"], 1, 0)
        external, normal, friction, damping, turning, closing = values["work"].T
        return Chunk(
            step=step,
            time=np.asarray(step * self._dt, dtype=np.float64),
            rotor_displacement=values["displacement"][:, :rotor],
            rotor_velocity=values["velocity"][:, :rotor],
            casing_displacement=values["displacement"][:, rotor:],
            casing_velocity=values["velocity"][:, rotor:],
            gap=gap,
            contact_impulse=impulse,
            friction_impulse=drag,
            contact_steps=touched.astype(np.int64),
            contacts=values["counts"][:, lib.STEP_CONTACTS].astype(np.int64),
            energy=np.array([self._energy(record) for record in records]),
            external_work=external,
            normal_work=normal,
            friction_work=friction,
            damping_work=damping,
            coupling_work=turning,
            closing_work=closing,
        )


def _copy(arrays: dict[str, FloatArray]) -> dict[str, FloatArray]:
    return {name: array.copy() for name, array in arrays.items()}


class MoreauJean(_Dense):
    """Scheme with contact impulses and restitution."""

    def _law_numbers(self) -> dict[str, float]:
        return {"restitution": self._problem.law["restitution"]}


class Penalty(_Dense):
    """Scheme with a penalty stiffness and regularised friction.

    Raises:
        LawError: the time step does not resolve the period of a tip on the penalty stiffness;
            the message states the limit.
    """

    def _law_numbers(self) -> dict[str, float]:
        problem, dt = self._problem, self._dt
        tips, wall = problem.rotor.tip_radial, problem.casing.nodal[:, 0]
        squares = sum(np.linalg.eigvalsh(rows @ rows.T).max() for rows in (tips, wall))
        limit = (SHARE_OF_STIFFEST / dt) ** 2 / squares
        stiffness = problem.law["penalty_stiffness"]
        if stiffness > limit:
            raise LawError(
                "penalty_stiffness",
                f"less (penalty stiffness {stiffness:.3g} N/m is above {limit:.3g} N/m,"
                f" the most that a time step of {dt:.3g} s resolves; reduce one of the two)",
            )
        return {"penalty": stiffness, "stick_speed": problem.law["stick_speed"]}


def _stage(problem: ContactProblem, dt: float) -> Struct:
    rotor, casing = problem.rotor, problem.casing
    frequency = np.abs(np.concatenate([rotor.frequency, casing.frequency]))
    ratio = np.concatenate([rotor.damping_ratio, casing.damping_ratio])
    damping = 2.0 * ratio * frequency
    dampers = la.block_diag(rotor.dampers, casing.dampers)
    coupled_by = np.zeros((0, 0)) if rotor.by_velocity is None else rotor.by_velocity
    by_velocity = np.diag(damping) + dampers.T @ dampers
    by_velocity[: len(coupled_by), : len(coupled_by)] += coupled_by
    stiffness = np.concatenate([rotor.stiffness, casing.frequency**2])
    coupled, cosines, sines = _turning(problem)
    loads = [np.concatenate([load.rotor, load.casing]) for load in problem.loads]
    return Struct(
        "DenseStage",
        stiffness=stiffness,
        damping=damping,
        dampers=dampers,
        by_velocity=np.ascontiguousarray(coupled_by),
        inverse=np.linalg.inv(np.diag(1.0 + 0.25 * dt**2 * stiffness) + 0.5 * dt * by_velocity),
        centre=np.hstack([rotor.centre, np.zeros((2, len(casing.frequency)))]),
        circulation=float(rotor.circulation),
        coupled=coupled,
        turning_cos=cosines,
        turning_sin=sines,
        loads=np.reshape(loads, (len(loads), len(stiffness))).astype(np.float64),
        load_times=load_times(problem.loads),
        tip_radial=np.ascontiguousarray(rotor.tip_radial),
        tip_tangential=np.ascontiguousarray(rotor.tip_tangential),
        tip_angle=np.asarray(rotor.tip_angle, dtype=np.float64),
        tip_recess=np.asarray(rotor.tip_recess, dtype=np.float64),
        nodal=np.ascontiguousarray(casing.nodal),
        clearance=np.ascontiguousarray(casing.clearance),
        tip_radius=float(rotor.tip_radius),
        element_length=float(casing.element_length),
        speed=float(problem.speed),
        follows=float(problem.tip_rotation),
        limit=float(problem.displacement_limit),
    )


def _turning(problem: ContactProblem) -> tuple[np.ndarray, FloatArray, FloatArray]:
    """Return the stiffness of springs that connect both frames, as harmonics of the rotor angle.

    Returns:
        numbers of the modes that are coupled, (n,); cosine parts and sine parts of the stiffness,
        (harmonics, n, n) each.
    """
    order = 2 * max(1, *(problem.springs.harmonics if problem.springs else (0,)))
    angles = 2.0 * np.pi / (2 * order + 1) * np.arange(2 * order + 1)
    around = problem.spring_stiffness(angles)
    coupled = np.flatnonzero(np.abs(around).max(axis=(0, 1)))
    waves = np.fft.rfft(around[:, coupled][:, :, coupled], axis=0) / len(angles)
    waves[1:] *= 2.0
    return coupled, np.ascontiguousarray(waves.real), np.ascontiguousarray(-waves.imag)

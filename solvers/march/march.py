"""Contact march: the interface of its scheme, with and without sudden changes of the rotor, and the
loop that yields its records. The scheme is made for one problem and one time step, for which it
factorises its matrices. It computes each state from the previous state only. A march can therefore
be stopped, stored and resumed exactly."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol, TypeVar

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray, absent
from bladewhirl.models.inputs.timing import Timing
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel.structs import lib


class EndReason(Enum):
    """Reason for the end of a march."""

    COMPLETED = "completed"
    DIVERGENT = "divergent"
    FUSED = "fused"  #: the support fused; the march goes on, see `sudden_changes`
    DAMPED = "damped"  #: no further contact is possible, see `FreeMotion`


@dataclass(frozen=True, kw_only=True)
class CoatingRecords:
    """Records of an abradable coating."""

    coating_impulse: FloatArray
    """Part of the normal impulse that acts on the coating [N s], (records, tips)."""
    wear_volume: FloatArray  #: volume removed since the start [m3], (records,)
    wear_dissipated: FloatArray  #: energy dissipated by the removal [J], (records,)
    coating_energy: FloatArray  #: elastic energy of the rods under the tips [J], (records,)
    wear_time: FloatArray  #: time of each profile [s], (profiles,)
    coating_strain: FloatArray  #: plastic strain of each rod, (profiles, tracks, rods)


@dataclass(frozen=True, kw_only=True)
class Chunk:
    """Consecutive records of a march.

    Modes and contact nodes of separate blades are listed blade by blade. Arrays that a stage does
    not have are empty.
    """

    step: IntArray  #: step number n of each record, (records,)
    time: FloatArray  #: time of each record [s], (records,)
    rotor_displacement: FloatArray  #: modal displacements [kg^1/2 m], (records, rotor modes)
    rotor_velocity: FloatArray  #: modal velocities [kg^1/2 m/s], (records, rotor modes)
    casing_displacement: FloatArray  #: modal displacements [kg^1/2 m], (records, casing modes)
    casing_velocity: FloatArray  #: modal velocities [kg^1/2 m/s], (records, casing modes)
    contact_displacement: FloatArray = absent()
    """Radial, tangential and axial displacement of each contact node [m], (records, nodes, 3)."""
    contact_force: FloatArray = absent()
    """Radial, tangential and axial contact force on each contact node [N], (records, nodes, 3)."""
    gap: FloatArray
    """Smallest gap of each contact node since the previous record [m], (records, nodes)."""
    contact_impulse: FloatArray
    """Normal impulse on each contact node since the previous record [N s], (records, nodes)."""
    friction_impulse: FloatArray
    """Friction impulse on each contact node since the previous record, positive towards -theta
    [N s], (records, nodes)."""
    axial_impulse: FloatArray = absent()
    """Axial friction impulse on each node since the previous record [N s], (records, nodes)."""
    contact_steps: IntArray  #: steps with contact since the previous record, (records, nodes)
    contacts: IntArray  #: number of contact nodes in contact at the record, (records,)
    energy: FloatArray
    """Energy of both bodies, of the springs between them and of flexible contact nodes, half a step
    before each record [J], (records,)."""
    external_work: FloatArray  #: work of the loads since the start [J], (records,)
    normal_work: FloatArray  #: work of the normal contact forces [J], (records,)
    closing_work: FloatArray = absent()
    """Part of `normal_work` that stops tips as gaps close [J], (records,)."""
    friction_work: FloatArray  #: work of the friction forces [J], (records,)
    damping_work: FloatArray  #: energy lost by damping [J], (records,)
    coupling_work: FloatArray = absent()
    """Work on the rotor due to its rotation relative to springs and dampers in the static frame
    [J], (records,)."""
    strain_energy: FloatArray = absent()
    """Strain energy of the bladed disk with its shaft springs [J], (records,); empty without sudden
    changes of the rotor."""
    shaft_displacement: FloatArray = absent()
    """Displacement and rotation of each node of a shaft line, static axes [m, rad], (records,
    nodes, 6)."""
    bearing_force: FloatArray = absent()
    """Force of each bearing on the shaft, static axes [N], (records, bearings, 2)."""
    support_displacement: FloatArray = absent()
    """Displacement of the support of each bearing, static axes [m], (records, bearings, 2)."""
    line_energy: FloatArray = absent()
    """Strain energy of a shaft line with the springs of its bearings [J], (records,)."""
    rotation_angle: FloatArray = absent()
    """Angle of the rotor [rad], (records,); empty at constant speed."""
    rotation_speed: FloatArray = absent()
    """Speed of rotation [rad/s], (records,); empty at constant speed."""
    angular_momentum: FloatArray = absent()
    """Angular momentum of the rotor half a step before each record [N m s], (records,); empty if
    the speed is prescribed."""
    rotor_energy: FloatArray = absent()
    """Energy of the rotation, which `energy` lacks, half a step before each record [J], (records,);
    empty as above."""
    drive_work: FloatArray = absent()
    """Work of the torque of the drive since the start [J], (records,); empty as above."""
    loss_work: FloatArray = absent()
    """Energy lost by the torque of losses [J], (records,); empty as above."""
    braking_work: FloatArray = absent()
    """Work of contact forces and static dampers on the rotation [J], (records,); empty as above."""
    joint_force: FloatArray = absent()
    """Normal and two tangential forces of each pair of joint nodes on the next blade [N], (records,
    pairs, 3)."""
    joint_displacement: FloatArray = absent()
    """Displacement of the next blade relative to a blade at each pair, along the normal and two
    tangents [m], (records, pairs, 3)."""
    joint_steps: FloatArray = absent()
    """Number of steps in which each pair was open, stuck and slipping since the previous record,
    (records, pairs, 3)."""
    joint_slip: FloatArray = absent()
    """Distance that each pair slipped since the start [m], (records, pairs)."""
    joint_work: FloatArray = absent()
    """Energy that each pair took from the blades since the start [J], (records, pairs)."""
    joint_wear: FloatArray = absent()
    """Energy that slip of each pair dissipated since the start [J], (records, pairs)."""
    damper_displacement: FloatArray = absent()
    """Radial, tangential and axial displacement of each damper between blades [m], (records,
    dampers, 3)."""
    coating: CoatingRecords | None = None  #: None without a coating

    @property
    def records(self) -> int:
        """Number of records."""
        return len(self.step)

    def beyond(
        self, problem: ContactProblem, arrays: StageArrays, time_step: float
    ) -> tuple[str, str]:
        """Return the place that passed the displacement limit of a contact problem, and its
        displacement, as texts.

        The last record is still within the limit: the place is found from displacements that are
        extrapolated by one step. It is unknown if the motion of the casing is not recorded.
        """
        if not problem.rotor.tip_angle.size:
            return "the shaft at a bearing", ""
        rotor, casing = problem.rotor, problem.casing
        if self.casing_displacement.shape[1] < len(casing.frequency):
            return "a tip or the casing", ""
        rates = [rotor.contact @ rate for rate in rotor.by_copy(self.rotor_velocity[-1])]
        wall = casing.nodal[:, 0]
        tips, wall_moved = self.contact_displacement[-1], wall @ self.casing_displacement[-1]
        ahead = np.abs(tips + time_step * np.reshape(rates, tips.shape))
        wall_ahead = np.abs(wall_moved + time_step * (wall @ self.casing_velocity[-1]))
        if wall_ahead.max(initial=0.0) > ahead.max():
            place = int(wall_ahead.argmax())
            angle = 360.0 * place / len(wall)
            return f"the casing at {angle:.4g}°", f" ({wall_moved[place]:.4g} m radially)"
        node, way = divmod(int(ahead.argmax()), tips.shape[1])
        how = ("radially", "tangentially", "axially")[way]
        of_blade = f"contact node {arrays.node[node]} of " if np.any(arrays.node) else ""
        return f"{of_blade}blade {arrays.blade[node]}", f" ({tips[node, way]:.4g} m {how})"


PartT = TypeVar("PartT")


def joined(chunks: Sequence[PartT]) -> PartT:
    """Join consecutive records of one kind, which are dataclasses. Their fields are arrays, further
    dataclasses of this form, or None."""
    if len(chunks) == 1:
        return chunks[0]
    parts = {name: [getattr(chunk, name) for chunk in chunks] for name in vars(chunks[0])}
    return type(chunks[0])(**{name: _joined(values) for name, values in parts.items()})


def _joined(values: Sequence[Any]) -> Any:
    if values[0] is None:
        return None
    return np.concatenate(values) if isinstance(values[0], np.ndarray) else joined(values)


@dataclass(frozen=True, kw_only=True)
class Statistics:
    """Quality measures of the steps of a march."""

    steps: int = 0  #: number of steps
    contact_steps: int = 0  #: number of steps with contact
    complementarity_residual: float = 0.0
    """Largest residual of all steps (see `CentralDifference`)."""
    lcp_failures: int = 0  #: number of steps whose complementarity problem was not solved exactly
    first_unsolved: int = 0  #: the first of these steps, if there are any
    unsolved_impulse: float = 0.0  #: normal impulse of these steps [N s]
    unsolved_wear: float = 0.0  #: worn volume of these steps [m3]
    fused_step: int = -1  #: step at which the support fused; -1 if it did not


@dataclass(frozen=True, kw_only=True)
class KernelState:
    """State of a march in the kernel between two steps."""

    step: int  #: number of steps n
    arrays: dict[str, FloatArray]  #: arrays of the state of the scheme, see `kernel.h`

    @property
    def statistics(self) -> Statistics:
        """Quality measures since the start."""
        counts = self.arrays["counts"]
        return Statistics(
            steps=self.step,
            contact_steps=int(counts[lib.CONTACT_STEPS]),
            complementarity_residual=float(counts[lib.RESIDUAL]),
            lcp_failures=int(counts[lib.UNSOLVED]),
            first_unsolved=int(counts[lib.FIRST_UNSOLVED]),
            unsolved_impulse=float(counts[lib.UNSOLVED_IMPULSE]),
            unsolved_wear=float(counts[lib.UNSOLVED_WEAR]),
        )


class MarchState(Protocol):
    """Protocol of the state of a march between two steps; its contents depend on sudden changes."""

    @property
    def step(self) -> int:
        """Number of steps since the start."""

    @property
    def statistics(self) -> Statistics:
        """Quality measures of the steps since the start."""


StateT = TypeVar("StateT", bound=MarchState)


class Scheme(Protocol[StateT]):
    """Protocol of a time integration scheme, factorised for one problem and one time step."""

    cyclic: tuple[bool, bool]  #: true for rotor and for casing if harmonics are separate
    records_casing: bool  #: whether the motion of the casing is recorded, where it can be left out

    def init(self) -> StateT:
        """Return the state at t = 0."""

    def advance(
        self, state: StateT, steps: int, record_every: int | None = None
    ) -> tuple[StateT, Chunk, EndReason | None]:
        """Advance by a number of steps, and record at multiples of ``record_every``.

        Args:
            state: state to start from, which is not changed.
            steps: number of steps.
            record_every: number of steps between records; by default as given to the scheme.

        Returns:
            the new state, the records, and the reason of the end, None if the march continues.
        """


PROFILES = 200
"""Number of profiles of a coating in a result, or more if the march is long."""

CHUNK_STEPS = 50_000
"""Number of steps between two yields: few enough for a smooth progress bar, and so many that the
yields take no noticeable time."""


def coating_steps(timing: Timing) -> int:
    """Return the number of steps between two profiles of a coating."""
    every = timing.record_every
    return max(1, min(CHUNK_STEPS, timing.steps // PROFILES + 1) // every) * every


def march(
    scheme: Scheme[StateT],
    timing: Timing,
    state: StateT | None = None,
    is_over: Callable[[Chunk], bool] | None = None,
    chunk_steps: int = CHUNK_STEPS,
) -> Iterator[tuple[StateT, Chunk, EndReason | None]]:
    """Run a march from start to end and yield its state and records in chunks.

    The last step is always recorded, even if it is not at a multiple of the record step.

    The error of free motion is of second order in the time step, also with dampers. The error of
    contact is of first order: contact begins and ends at time steps, and point dampers respond to
    a contact force from the next step on. Repeat a march with half the time step to see the error.

    Args:
        scheme: scheme for the problem and for ``timing.time_step``.
        timing: duration, time step and record step.
        state: state from which to resume; None for the start.
        is_over: function that returns true for a chunk after which the march ends.
        chunk_steps: largest number of steps between two yields.

    Yields:
        the state, the records since the last yield, and the reason of the end, None if the march
        continues.
    """
    if state is None:
        state = scheme.init()
    per_chunk = max(1, chunk_steps // timing.record_every) * timing.record_every
    # A record at step n needs x_{n+1}, so one step follows the last record.
    last, whole = timing.steps + 1, timing.whole_steps + 1
    while state.step < last:
        within_whole = state.step < whole
        steps = (whole if within_whole else last) - state.step
        state, chunk, end = scheme.advance(
            state,
            min(per_chunk - state.step % per_chunk, steps),
            None if within_whole else timing.steps,
        )
        if end is None and state.step >= last:
            end = EndReason.COMPLETED
        if end is None and is_over is not None and is_over(chunk):
            end = EndReason.DAMPED
        yield state, chunk, end
        if end is not None:
            return


def check_time_step(problem: ContactProblem, time_step: float) -> None:
    """Check that a time step is below the stability limit.

    Raises:
        ValueError: the time step is not below the limit; the message states the limit and the
            remedy.
    """
    limit = problem.critical_time_step
    if not time_step < limit:
        raise ValueError(
            f"time step {time_step:.3g} s is at or above the critical step {limit:.3g} s = "
            "2/omega_max; use a smaller step, fewer casing elements or fewer fixed-interface modes"
        )

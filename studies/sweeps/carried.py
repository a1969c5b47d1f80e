"""Sweeps over the speed in which each march starts from the motion at the speed before.

A jump of the response that depends on the direction in which the speed changes, hysteresis, is seen
only in this way. Points of one chain, which differ in speed only, are marched one after the other;
chains are marched in parallel.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal, get_args
from zipfile import BadZipFile

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.files import replacing
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.sweep.dataset import DONE, flag
from bladewhirl.studies.sweeps.starts import begun

CONTINUE = "--continue"

Carry = Literal["up", "down"]  #: direction in which the speed changes

CARRIES: tuple[Carry, ...] = get_args(Carry)

STATES_NAME = "states"
"""Name of the folder with the final state of each march, until the sweep is complete."""

LATE_SHARE = 1.0 / 3.0  #: the state is taken from this fraction of a march, at its end

FEWEST_TURNS = 3.0
"""Smallest number of revolutions of a march, so that the state is from its last revolutions."""

CARRY_RULE = (
    "the march at each speed starts from the displacements and velocities of the march at the"
    " speed before, in the last third of its time, at the record at which the rotor has turned most"
    " nearly by whole revolutions; loads that end, and ramps of loads, act at the first speed only;"
    " after a march that diverged or failed, motion starts anew"
)
"""Text of the rule, which every such sweep contains."""

COMPLETED = flag("end_reason", "completed")


def late_state(stage: Stage, result: xr.Dataset) -> Start:
    """Return the motion of a result that is carried to the next speed, see `CARRY_RULE`.

    The modes of the bladed disk can depend on the speed; the motion of beams is therefore given on
    the free degrees of freedom, see `Stage.fields`.
    """
    time = result["time"].values
    late = np.flatnonzero(time >= (1.0 - LATE_SHARE) * time[-1])[::-1]
    angle = stage.speed * time[late]
    record = int(late[np.abs(angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi))).argmin()])
    motion = {
        name: result[variable][record].values.ravel() if variable in result else np.zeros(0)
        for name, variable in (
            ("rotor", "rotor_displacement"),
            ("rotor_velocity", "rotor_velocity"),
            ("casing", "casing_displacement"),
            ("casing_velocity", "casing_velocity"),
        )
    }
    for name in ("rotor", "rotor_velocity"):
        motion[name] = stage.fields(motion[name])
    return Start(**motion)


def continued(stage: Stage, problem: ContactProblem, state: Start) -> ContactProblem:
    """Return the contact problem of a march that starts from a state, without ramps of its loads,
    and without loads that end."""
    start = replace(
        state,
        rotor=stage.coordinates(state.rotor),
        rotor_velocity=stage.coordinates(state.rotor_velocity),
    )
    return begun(problem, start)


def write_state(path: Path, state: Start) -> None:
    """Write a state, completely or not at all."""
    with replacing(path) as draft, draft.open("wb") as stream:
        np.savez(stream, **vars(state))


def read_state(path: Path) -> Start:
    """Read a state.

    Raises:
        UserError: the file is missing or damaged.
    """
    try:
        with np.load(path, allow_pickle=False) as content:
            return Start(**{name: content[name] for name in content.files})
    except (OSError, ValueError, KeyError, TypeError, BadZipFile, EOFError) as error:
        raise UserError(f"{path}: expected the state at the speed before ({error})") from None


def carry_fault(case: Case) -> str:
    """Return the reason why the motion of a case cannot be carried from speed to speed, as a text
    that completes "expected ..."; an empty text if it can."""
    if case.casing.coating is not None or case.casing.closure is not None:
        return "a casing without casing.coating and casing.closure, which change with time"
    if case.blade_loss is not None or case.shaft.fuse_force is not None:
        return "a case without [blade_loss] and shaft.fuse_force"
    return ""


class Chains:
    """Order of the points of a sweep: along the speed one after the other, other keys in parallel.

    Args:
        shape: number of values of each axis.
        axis: number of the axis of the speed.
        speeds: speeds along this axis.
        carry: direction in which the speed changes.
        state: state of every point as written, (points,).
        end_reason: code of the end of every march as written, (points,).
    """

    def __init__(
        self,
        shape: tuple[int, ...],
        axis: int,
        speeds: FloatArray,
        carry: Carry,
        state: NDArray[np.int8],
        end_reason: NDArray[np.int8],
    ) -> None:
        order = np.argsort(speeds if carry == "up" else -speeds, kind="stable")
        numbers = np.moveaxis(np.arange(state.size).reshape(shape), axis, 0)[order]
        self._chains = numbers.reshape(len(order), -1).T
        done = (state == DONE)[self._chains]
        #: number of finished points of each chain
        self._reached = [int(row.argmin()) if not row.all() else len(row) for row in done]
        self._goes_on = (state == DONE) & (end_reason == COMPLETED)
        self._chain_of = np.zeros(state.size, dtype=np.int64)
        self._chain_of[self._chains] = np.arange(len(self._chains))[:, None]

    def next_points(self) -> Iterator[tuple[int, int | None] | None]:
        """Yield pairs of a point to march and the point from whose state it starts, None for a new
        start. None in place of a pair means that no point can be marched before another one is
        finished."""
        sent = [reached - 1 for reached in self._reached]
        length = self._chains.shape[1]
        while min(self._reached) < length:
            none_ready = True
            for chain, row in enumerate(self._chains):
                at = self._reached[chain]
                if at < length and sent[chain] < at:
                    sent[chain], none_ready = at, False
                    before = int(row[at - 1]) if at and self._goes_on[row[at - 1]] else None
                    yield int(row[at]), before
            if none_ready:
                yield None

    def take(self, number: int, end_reason: int | None) -> None:
        """Store the code of the reason of the end of a point's march; None if the march failed."""
        self._goes_on[number] = end_reason == COMPLETED
        self._reached[self._chain_of[number]] += 1

"""The march compared with a plain compiled program: `python benchmarks/peers/dense_march.py`.

What one writes who compiles the definition of the scheme with numba and stops there: dense products
of all modes, numbers where they fall, no symmetry, no records, no ledger of energy. It marches the
three states of `benchmarks/march.py` from the same numbers; printed are processor times of a step,
with the kernel kept from using symmetry as a third, and how far both marches are apart at the end.
Dampers at points, springs between the bodies and friction by the sign of the sliding are left out,
which these states don't have.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from rich.console import Console
from rich.table import Table

sys.path.append(str(Path(__file__).resolve().parent.parent))

from march import RECORD_EVERY, TIME_STEP, Setting, settings

from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.central_difference import CentralDifference

STEPS = 2000

NEAR = 1e-6
"""Gap of the tips that may touch at the end of a step [m]; the forces move others by far less."""


@njit(cache=True)  # type: ignore[untyped-decorator]
def solved(gap, delassus):  # type: ignore[no-untyped-def]
    """Forces >= 0 that leave no gap < 0: guess which tips touch, put right what is wrong."""
    force = np.zeros(len(gap))
    touching = gap < 0.0
    for _ in range(4 * len(gap)):
        own = np.flatnonzero(touching)
        system, right = np.zeros((len(own), len(own))), np.zeros(len(own))
        for i in range(len(own)):
            right[i] = -gap[own[i]]
            for j in range(len(own)):
                system[i, j] = delassus[own[i], own[j]]
        force[:] = 0.0
        force[own] = np.linalg.solve(system, right)
        left = gap + delassus @ force
        better = np.where(touching, force >= 0.0, left < -1e-15)
        if np.all(better == touching):
            break
        touching = better
    return force


@njit(cache=True)  # type: ignore[untyped-decorator]
def march(stage, loads, load_times, before, now, first, steps, dt):  # type: ignore[no-untyped-def]
    """Advance x_{n-1} and x_n in place; return the contacts of all steps."""
    (square, damping, radial, tangential, recess, nodal, clearance, tip_angle) = stage[:8]
    (speed, friction, length, tip_radius, tip_rotation) = stage[8:]
    tips, modes = radial.shape
    nodes = len(clearance)
    compliance = 1.0 / (1.0 / dt**2 + damping / (2.0 * dt))
    element, weights = np.zeros(tips, dtype=np.int64), np.zeros((tips, 4))
    contacts = 0
    for n in range(first, first + steps):
        force = -square * now
        for load in range(len(loads)):
            end, ramp, frequency, phase = load_times[load]
            if n * dt < end:
                rise = 0.5 - 0.5 * np.cos(np.pi * n * dt / ramp) if n * dt < ramp else 1.0
                force += rise * np.cos(frequency * n * dt + phase) * loads[load]
        free = force + 2.0 * now / dt**2 + (damping / (2.0 * dt) - 1.0 / dt**2) * before
        free *= compliance
        moved, turned, field = (
            radial @ free[:modes],
            tangential @ free[:modes],
            nodal @ free[modes:],
        )
        gap = np.zeros(tips)
        for tip in range(tips):
            angle = tip_angle[tip] + speed * dt * (n + 1)
            if tip_rotation:
                angle += turned[tip] / tip_radius
            place = (angle % (2.0 * np.pi)) * nodes / (2.0 * np.pi)
            e = int(place)
            xi = place - e
            element[tip] = e % nodes
            weights[tip, 0] = 1.0 - 3.0 * xi**2 + 2.0 * xi**3
            weights[tip, 1] = length * xi * (1.0 - xi) ** 2
            weights[tip, 2] = 3.0 * xi**2 - 2.0 * xi**3
            weights[tip, 3] = length * xi**2 * (xi - 1.0)
            gap[tip] = recess[tip] - moved[tip]
            for i in range(4):
                node = (element[tip] + i // 2) % nodes
                gap[tip] += weights[tip, i] * (clearance[node, i % 2] + field[4 * node + i % 2])
        if np.any(gap < 0.0):
            near = np.flatnonzero(gap < NEAR)
            normal, along = np.zeros((len(near), len(now))), np.zeros((len(near), len(now)))
            for row, tip in enumerate(near):
                normal[row, :modes], along[row, :modes] = -radial[tip], -tangential[tip]
                for i in range(4):
                    of = 4 * ((element[tip] + i // 2) % nodes) + i % 2
                    normal[row, modes:] += weights[tip, i] * nodal[of]
                    along[row, modes:] += weights[tip, i] * nodal[of + 2]
            pushed = compliance * (normal + np.sign(speed) * friction * along)
            pressed = solved(gap[near], normal @ pushed.T)
            free += pressed @ pushed
            contacts += int(np.count_nonzero(pressed))
        before[:], now[:] = now, free
    return contacts


@dataclass(frozen=True)
class Plain:
    """A plain march of a problem."""

    stage: tuple[Any, ...]
    loads: np.ndarray[Any, Any]
    times: np.ndarray[Any, Any]

    @classmethod
    def of(cls, given: ContactProblem) -> Plain:
        """Arrays as the definition has them."""
        rotor, casing = given.rotor, given.casing
        frequency = np.r_[rotor.frequency, casing.frequency]
        ratio = np.r_[rotor.damping_ratio, casing.damping_ratio]
        stage = (
            frequency**2, 2.0 * ratio * frequency, rotor.tip_radial, rotor.tip_tangential,
            rotor.tip_recess, casing.nodal.reshape(-1, casing.nodal.shape[-1]),
            casing.clearance, rotor.tip_angle, given.speed, given.friction,
            casing.element_length, rotor.tip_radius, given.tip_rotation,
        )  # fmt: skip
        arrays = (np.ascontiguousarray(a) if isinstance(a, np.ndarray) else a for a in stage)
        return cls(
            tuple(arrays),
            np.array([np.r_[load.rotor, load.casing] for load in given.loads]),
            np.array([[load.end, load.ramp, load.frequency, load.phase] for load in given.loads]),
        )


def compared(setting: Setting, repeat: int) -> tuple[float, ...]:
    """Contacts a step; times of a step [µs] of kernel, the same dense, plain; their difference."""
    every = CentralDifference(setting.problem, TIME_STEP, 1)
    _, chunk, _ = every.advance(setting.state, STEPS + 1)
    path = np.hstack([chunk.rotor_displacement, chunk.casing_displacement])
    dense = CentralDifference(setting.problem, TIME_STEP, RECORD_EVERY, cyclic=False)
    state, _, _ = dense.advance(dense.init(), setting.state.step)
    plain, times, contacts = Plain.of(setting.problem), [], 0
    for _ in range(repeat + 1):  # the first compiles
        before, now = path[0].copy(), path[1].copy()
        marks = [time.thread_time()]
        setting.scheme.advance(setting.state, STEPS)
        marks.append(time.thread_time())
        dense.advance(state, STEPS)
        marks.append(time.thread_time())
        begin = (plain.loads, plain.times, before, now, int(chunk.step[1]))
        contacts = march(plain.stage, *begin, STEPS - 1, TIME_STEP)
        marks.append(time.thread_time())
        times.append(1e6 * np.diff(marks) / STEPS)
    best = np.min(times[1:], axis=0)
    apart = float(np.abs(now - path[STEPS]).max() / np.abs(path[STEPS]).max())
    return contacts / STEPS, *best, apart


def main() -> None:
    """Time all in turn and print the best, which other processes disturb least."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--repeat", type=int, default=20, help="how often everything is timed")
    repeat = parser.parse_args().repeat
    table = Table(title=f"A step, best of {repeat} interleaved timings")
    for column in (
        "state", "contacts a step", "kernel [µs]", "kernel, dense [µs]", "plain numba [µs]",
        "plain / kernel", "differ by",
    ):  # fmt: skip
        table.add_column(column, justify="left" if column == "state" else "right", no_wrap=True)
    for setting, _ in settings():
        contacts, kernel, dense, plain, apart = compared(setting, repeat)
        table.add_row(
            setting.name, f"{contacts:.2f}", f"{kernel:.2f}", f"{dense:.2f}", f"{plain:.2f}",
            f"{plain / kernel:.1f}", f"{apart:.0e}",
        )  # fmt: skip
    Console(width=140).print(table)


if __name__ == "__main__":
    main()

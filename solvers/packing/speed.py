"""Arrays of a speed of rotation that varies over time."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel.structs import Struct, aligned, aligned_copy, lib, padded
from bladewhirl.solvers.packing.arrangement import Arrangement
from bladewhirl.solvers.packing.rotor import modal_matrix

POINTS = 5
"""Number of speeds at which the arrays of a step are computed. Between them they are polynomials of
the speed but for (time step times speed)^5, which is below rounding."""

EQUAL = 1e-13
"""Arrays that differ at most by this fraction of their largest entry do not depend on the speed."""

CROSSING = 1e-11
"""Blocks with entries up to this fraction of the largest entry count as zero."""

PackAt = Callable[[ContactProblem], dict[str, Struct | None]]
"""Function that returns the structs that depend on the speed for a contact problem."""


def pack_speed(
    problem: ContactProblem, arrangement: Arrangement, stage: dict[str, Struct | None], pack: PackAt
) -> Struct | None:
    """Return the speed over time; None if it is constant.

    Arrays of `stage` that depend on the speed become parts of one array, which the kernel computes.

    Args:
        problem: contact problem.
        arrangement: arrangement of the rotor modes.
        stage: structs of the stage at the speed of the problem.
        pack: function that packs the structs that depend on the speed.
    """
    change = problem.change
    if change is None:
        return None
    none = aligned(0)
    points, samples, current = none, aligned((0, 0)), none
    empty = modal_matrix(np.zeros((1, 0, 0)), replace(arrangement, half=0, rows=1, columns=0))
    (stiffening, direct), stiffening4, coriolis = (empty, 0), empty, empty
    if change.rotor is not None:
        low, high = change.course.range
        if problem.drive is not None:  # the range is not known; a polynomial holds beyond it
            low, high = sorted((0.0, 1.5 * problem.speed))
        points = np.linspace(low, high, POINTS)
        if high - low <= EQUAL * abs(problem.speed):
            points = np.array([problem.speed])
        samples, current = _samples(problem, stage, pack, points)
        factor, softening = change.factor[:, None, None], change.rotor.known("stiffness_speed")
        stiffening, direct = _stiffening(factor * softening, arrangement)
        if change.rotor.stiffness_speed4 is not None:
            stiffening4 = modal_matrix(factor * change.rotor.stiffness_speed4, arrangement)
        copies = np.repeat(change.rotor.coriolis[None], len(change.factor), axis=0)
        coriolis = modal_matrix(copies, arrangement)
    factors = [
        (load.order, load.constant, load.by_square, load.by_fourth, load.by_acceleration)
        for load in problem.loads
    ]
    return Struct(
        "Speed",
        base=problem.speed,
        pieces=np.ascontiguousarray(change.course.relative_to(problem.speed).pieces),
        factors=np.reshape(factors, (-1, lib.SPEED_FACTORS)).astype(np.float64),
        points=points,
        samples=samples,
        current=current,
        stiffening=stiffening,
        stiffening4=stiffening4,
        coriolis=coriolis,
        direct=direct,
    )


def pack_drive(problem: ContactProblem, arrangement: Arrangement) -> Struct | None:
    """Return the drive of a free speed; None if the speed is prescribed."""
    drive, rotor = problem.drive, problem.rotor
    if drive is None:
        return None
    none, coupled = aligned(0), len(drive.along) > 0
    still, square = np.zeros(len(rotor.frequency)), problem.speed**2
    held = sum(
        ((load.by_square * square - load.constant) * load.rotor for load in problem.loads), still
    )
    return Struct(
        "Drive",
        inertia=drive.inertia,
        torque=drive.torque,
        loss=drive.loss,
        damping=drive.damping,
        centre=arrangement.pack(rotor.centre) if coupled else aligned((0, 0)),
        along=arrangement.pack(drive.along) if coupled else none,
        across=arrangement.pack(drive.across) if coupled else none,
        held=arrangement.pack(np.asarray(held)) if coupled else none,
    )


def _stiffening(matrices: FloatArray, arrangement: Arrangement) -> tuple[Struct, int]:
    """Return the matrix of the stiffness from that of each copy, and 1 if it is stored without its
    blocks X: those of a cyclic rotor that is symmetric under reflection are zero."""
    packed = modal_matrix(matrices, arrangement)
    blocks = packed.blocks.reshape(-1, 2, lib.ROWS * lib.HALF)
    crossing = np.abs(blocks[:, 1]).max(initial=0.0) > CROSSING * np.abs(blocks).max(initial=0.0)
    if arrangement.half == 0 or crossing:
        return packed, 0
    packed.point_to("blocks", aligned_copy(blocks[:, 0].ravel()))
    return packed, 1


def _samples(
    problem: ContactProblem,
    stage: dict[str, Struct | None],
    pack: PackAt,
    points: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the values of the arrays that depend on the speed at some speeds, (points, size), and
    the array of their present values, (size,), to which the structs of `stage` now point."""
    at_points = [pack(problem.at_speed(float(speed))) for speed in points]
    chosen = list[tuple[Struct, str, list[FloatArray]]]()
    for name in at_points[0]:
        owner = stage[name]
        if owner is None:
            continue
        others = [point[name] for point in at_points]
        for part, field, arrays in _arrays(owner, others):
            spread = max(np.abs(array - arrays[0]).max(initial=0.0) for array in arrays)
            if spread > EQUAL * np.abs(arrays[0]).max(initial=0.0):
                chosen.append((part, field, arrays))
    sizes = [padded(arrays[0].size) for *_, arrays in chosen]
    starts = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
    samples, current = aligned((len(points), starts[-1])), aligned(int(starts[-1]))
    for (part, field, arrays), start in zip(chosen, starts[:-1], strict=True):
        stop, shape = start + arrays[0].size, arrays[0].shape
        samples[:, start:stop] = [array.ravel() for array in arrays]
        current[start:stop] = getattr(part, field).ravel()
        part.point_to(field, current[start:stop].reshape(shape))
    return samples, current


def _arrays(owner: Struct, others: list[Any]) -> Iterator[tuple[Struct, str, list[FloatArray]]]:
    """Yield the arrays of numbers of a struct and of its parts, with those of equal structs."""
    for field, value in owner.contents.items():
        values = [getattr(other, field) for other in others]
        if isinstance(value, Struct):
            yield from _arrays(value, values)
        elif isinstance(value, np.ndarray) and value.dtype == np.float64:
            yield owner, field, values

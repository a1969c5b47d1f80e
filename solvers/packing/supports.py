"""Dampers at points, springs between the bodies and under the shaft."""

from __future__ import annotations

import numpy as np

from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel.arrays import (
    Body,
    DamperEnds,
    Dampers,
    SpringEnds,
    Springs,
)
from bladewhirl.solvers.packing.arrangement import (
    Arrangement,
)


def pack_dampers(
    problem: ContactProblem,
    bodies: tuple[Body, Body],
    arrangements: tuple[Arrangement, Arrangement],
    dt: float,
) -> Dampers | None:
    """Dampers at points of rotor and casing; None without any.

    Args:
        problem: what is marched.
        bodies: rotor and casing.
        arrangements: of the modes of each.
        dt: time step [s].
    """
    ends = []
    given = (problem.rotor.dampers, problem.casing.dampers)
    for rows, body, arrangement in zip(given, bodies, arrangements, strict=True):
        strong = arrangement.pack(rows[rows.any(axis=1)])  # those without strength only cost time
        if body is bodies[0] and problem.rotor.by_velocity is not None:  # its A has them
            strong = strong[:0]
        solve = np.linalg.inv(2.0 * dt * np.eye(len(strong)) + strong * body.c @ strong.T)
        ends.append(DamperEnds(strong, solve))
    return Dampers(*ends) if any(len(end.rows) for end in ends) else None


def pack_springs(
    problem: ContactProblem, arrangements: tuple[Arrangement, Arrangement], dt: float
) -> Springs | None:
    """Springs between the bodies and under the shaft, by harmonic; None without any.

    Args:
        problem: what is marched.
        arrangements: of the modes of rotor and casing.
        dt: time step [s].
    """
    rotor, anisotropy = problem.rotor, problem.rotor.anisotropy
    if problem.springs is None and anisotropy == 0.0:
        return None
    springs = _springs_between(problem.springs, arrangements, problem.speed * dt)
    if anisotropy == 0.0:
        return springs
    first, modes = len(springs.factor), len(rotor.frequency)
    ends = springs.rotor
    return springs._replace(
        nodal_diameter=np.append(springs.nodal_diameter, 1.0),
        factor=np.append(springs.factor, [anisotropy, -anisotropy]),
        rotor=SpringEnds(
            place=np.append(ends.place, np.tile(arrangements[0].entry, 2)),
            wave=np.append(ends.wave, np.repeat([first, first + 1], modes)),
            amplitude=np.append(ends.amplitude, rotor.centre),
        ),
    )


def _springs_between(
    springs: CouplingSprings | None,
    arrangements: tuple[Arrangement, Arrangement],
    angle_per_step: float,
) -> Springs:
    if springs is None:
        none = np.zeros(0, dtype=np.int64)
        ends = SpringEnds(none, none, np.zeros(0))
        return Springs(np.zeros(0), np.zeros(0), ends, ends, angle_per_step)
    modes, harmonics = springs.modes, np.array(springs.modes.harmonics)
    wave = 2 * np.searchsorted(harmonics, modes.nodal_diameter)[modes.entry] + modes.is_sine
    both = []
    for arrangement, on_casing in zip(arrangements, (False, True), strict=True):
        coordinates, numbers = springs.coordinates(on_casing=on_casing)
        amplitude = modes.amplitude[modes.entry][coordinates]
        both.append(SpringEnds(arrangement.entry[numbers], wave[coordinates], amplitude))
    return Springs(
        nodal_diameter=harmonics.astype(np.float64),
        factor=np.repeat(springs.factors, 2),
        rotor=both[0],
        casing=both[1],
        angle_per_step=angle_per_step,
    )

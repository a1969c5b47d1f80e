"""Arrays of the foreshortening of blades."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.solvers.kernel.structs import Struct, aligned, aligned_copy, lib, padded
from bladewhirl.solvers.packing.arrangement import Arrangement, Harmonics, lengthened
from bladewhirl.solvers.packing.rotor import rotor_inverses

FAR = 1e100
"""Gap that is larger than the gap of any tip [m]."""

NEAR = 0.015625
"""A tip is near the wall if its gap without foreshortening is below this fraction of the smallest
clearance."""

MOST_HELD, MOST_UNCHECKED = 32, 256
"""Largest numbers of steps with one linearisation and between two checks of all openings."""

HELD, UNCHECKED = 2.0, 4.0
"""Largest duration of a linearisation and largest time between two checks, both multiplied by the
frequency of the fastest large term."""


def near_gap(problem: ContactProblem) -> float:
    """Return the gap without foreshortening below which a tip is near the wall [m]; infinity
    if gaps can also close as blades bend."""
    shortening = problem.foreshortening
    if shortening is None or (shortening.sign < 0.0).any():
        return np.inf
    removable = float((problem.metal_recess - problem.rotor.tip_recess).max())
    return NEAR * max(float(problem.casing.clearance[:, 0].min()), 0.0) + removable


def held_steps(problem: ContactProblem, dt: float) -> tuple[int, int]:
    """Return the numbers of steps with one linearisation and between two checks of all openings."""
    shortening = problem.foreshortening
    angle = 0.0 if shortening is None else shortening.frequency * dt
    if not angle > 0.0:
        return MOST_HELD, MOST_UNCHECKED
    linearised, unchecked = (
        max(1, int(min(most, share / angle)))
        for most, share in ((MOST_HELD, HELD), (MOST_UNCHECKED, UNCHECKED))
    )
    return linearised, unchecked


def pack_foreshortening(
    problem: ContactProblem, arrangement: Arrangement, dt: float, *, cyclic: bool
) -> Struct | None:
    """Return the foreshortening of the blades; None without foreshortening.

    Args:
        problem: contact problem.
        arrangement: arrangement of the rotor modes.
        dt: time step [s].
        cyclic: use the DFT columns of the modes.
    """
    rotor, shortening = problem.rotor, problem.foreshortening
    if shortening is None:
        return None
    tips, terms, modes = shortening.rows.shape
    (inverse,) = rotor_inverses(rotor, dt)
    rows, weights, spread = _waves(rotor, shortening.rows, arrangement, cyclic=cyclic)
    answers = rows @ inverse.T  # response A^-1 F^T to each row
    flat = answers.reshape(-1, modes)
    crossed = (flat @ rows.reshape(-1, modes).T).reshape(tips, terms, tips, terms)
    felt = (flat @ rotor.tip_radial.T).reshape(tips, terms, tips)
    hold, check = held_steps(problem, dt)
    near = np.full(padded(tips), -FAR)
    near[:tips] = min(near_gap(problem), FAR)
    return Struct(
        "Foreshortening",
        rows=arrangement.pack(rows),
        answers=arrangement.pack(answers[: 0 if rotor.by_velocity is None else tips]),
        own=weights[0],
        across=weights[1],
        spread=spread,
        sign=lengthened(shortening.sign),
        # coordinate of each term of tip m due to a unit force at tip n, (tips n, tips m, lanes)
        by_push=lengthened(np.einsum("ni,mki->nmk", rotor.tip_radial @ inverse.T, rows)),
        by_drag=lengthened(np.einsum("ni,mki->nmk", rotor.tip_tangential @ inverse.T, rows)),
        felt=lengthened(felt.transpose(0, 2, 1)),
        crossed=lengthened(crossed.transpose(0, 2, 1, 3).reshape(-1, terms, terms)),
        near=near,
        order=np.arange(terms),
        hold=hold,
        check=check,
    )


def _waves(
    rotor: ReducedRotor, rows: FloatArray, arrangement: Arrangement, *, cyclic: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the rows F by DFT column if `cyclic` and if the forms of the tips are equal.

    The sign of a row is arbitrary. Blades bend equally in modes of nodal diameter zero, so the rows
    of all tips get the same sign in these modes; without such modes the signs stay unknown.

    Returns:
        rows F, (tips, terms, modes); their weights by DFT column and by partner column,
        (2, terms, rows, columns); value of each column and of its partner at each tip,
        (tips, 2 * columns). Weights and values may be empty.
    """
    tips, terms, _ = rows.shape
    plain = rows, aligned((2, 0, 0, 0)), aligned((0, 0))
    in_phase = np.flatnonzero(rotor.column == 0)
    if not cyclic or not in_phase.size:
        return plain
    harmonics = Harmonics(tips, fold=False, unit=lib.HALF, alone=rotor.by_velocity is not None)
    rows, weights = rows.copy(), aligned((2, terms, arrangement.rows, arrangement.columns))
    for term in range(terms):
        largest = in_phase[np.argmax(np.abs(rows[0, term, in_phase]))]
        rows[:, term] *= np.sign(rows[:, term, [largest]])
        try:
            amplitudes = harmonics.amplitudes(rows[:, term], rotor.column)
        except ValueError:
            return plain
        weights[:, term] = [arrangement.grid(each) for each in amplitudes]
    return rows, weights, aligned_copy(np.hstack([harmonics.shape, harmonics.crossed]))

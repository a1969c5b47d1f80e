"""Arrays of the foreshortening of blades."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel.structs import Struct, aligned, padded
from bladewhirl.solvers.packing.arrangement import Arrangement
from bladewhirl.solvers.packing.body import scheme_inverse
from bladewhirl.solvers.packing.turning import turning_inverse

FAR = 1e100
"""Gap that no tip has [m]."""

NEAR = 0.015625
"""Gap without foreshortening below which a tip is near the wall, over the smallest clearance."""

MOST_HELD, MOST_UNCHECKED = 32, 256
"""Largest numbers of steps with one linearisation, and between checks of all openings."""

HELD, UNCHECKED = 2.0, 4.0
"""Largest duration of a linearisation, and between checks, times the frequency of the fastest large
term."""


def near_gap(problem: ContactProblem) -> float:
    """Return the gap without foreshortening below which a tip is near [m]; infinity if gaps can
    also close as blades bend."""
    shortening = problem.foreshortening
    if shortening is None or (shortening.sign < 0.0).any():
        return np.inf
    removable = float((problem.metal_recess - problem.rotor.tip_recess).max())
    return NEAR * max(float(problem.casing.clearance[:, 0].min()), 0.0) + removable


def held_steps(problem: ContactProblem, dt: float) -> tuple[int, int]:
    """Return the number of steps with one linearisation, and between checks of all openings."""
    shortening = problem.foreshortening
    angle = 0.0 if shortening is None else shortening.frequency * dt
    if not angle > 0.0:
        return MOST_HELD, MOST_UNCHECKED
    held, unchecked = (
        max(1, int(min(most, share / angle)))
        for most, share in ((MOST_HELD, HELD), (MOST_UNCHECKED, UNCHECKED))
    )
    return held, unchecked


def pack_foreshortening(
    problem: ContactProblem, arrangement: Arrangement, dt: float
) -> Struct | None:
    """Return the foreshortening of the blades; None without foreshortening.

    Args:
        problem: contact problem.
        arrangement: arrangement of the rotor modes.
        dt: time step [s].
    """
    rotor, shortening = problem.rotor, problem.foreshortening
    if shortening is None:
        return None
    tips, terms, modes = shortening.rows.shape
    lanes, turning = padded(terms), rotor.by_velocity is not None
    inverse = (
        turning_inverse(rotor.damping, dt)
        if turning
        else np.diag(scheme_inverse(rotor.frequency, rotor.damping_ratio, dt))
    )
    rows = shortening.rows
    answers = rows @ inverse.T  # response A^-1 F^T to each row
    flat = answers.reshape(-1, modes)
    sign = aligned((tips, lanes))
    sign[:, :terms] = shortening.sign

    def by_pair(forces: FloatArray, motions: FloatArray) -> FloatArray:
        """Return the motions (n, m, ...) due to forces, padded by term."""
        pairs = aligned((tips, tips, lanes))
        pairs[..., :terms] = np.einsum("ni,mki->nmk", forces, motions)
        return pairs

    crossed = aligned((tips * tips, terms, lanes))
    crossed[..., :terms] = (
        (flat @ rows.reshape(-1, modes).T)
        .reshape(tips, terms, tips, terms)
        .transpose(0, 2, 1, 3)
        .reshape(tips * tips, terms, terms)
    )
    felt = aligned((tips, tips, lanes))
    felt[..., :terms] = (flat @ rotor.tip_radial.T).reshape(tips, terms, tips).transpose(0, 2, 1)
    hold, check = held_steps(problem, dt)
    near = np.full(padded(tips), -FAR)
    near[:tips] = min(near_gap(problem), FAR)
    return Struct(
        "Foreshortening",
        rows=arrangement.pack(rows),
        answers=arrangement.pack(answers[: tips if turning else 0]),
        sign=sign,
        by_push=by_pair(rotor.tip_radial @ inverse.T, rows),
        by_drag=by_pair(rotor.tip_tangential @ inverse.T, rows),
        felt=felt,
        crossed=crossed,
        near=near,
        order=np.arange(terms),
        hold=hold,
        check=check,
    )

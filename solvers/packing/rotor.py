"""Arrays of the rotor: by harmonic for a cyclic rotor, otherwise dense."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem, ReducedRotor
from bladewhirl.solvers.kernel.structs import Struct, aligned_copy, lib
from bladewhirl.solvers.packing.arrangement import FIT, Arrangement, Harmonics, dense_arrangement
from bladewhirl.solvers.packing.body import (
    by_column,
    by_sliding,
    lengthened,
    pack_body,
    scheme_inverse,
)
from bladewhirl.solvers.packing.turning import turning_inverse


def pack_rotor(problem: ContactProblem, dt: float, *, cyclic: bool) -> tuple[Arrangement, Struct]:
    """Return the arrangement and the arrays of the rotor.

    Args:
        problem: contact problem.
        dt: time step [s].
        cyclic: use the DFT columns of the modes.

    Raises:
        ValueError: modes do not vary as their DFT columns.
    """
    rotor = problem.rotor
    tips, modes = rotor.tip_radial.shape
    if cyclic:
        turning = rotor.by_velocity is not None
        harmonics = Harmonics(tips, fold=False, unit=lib.HALF, alone=turning)
        arrangement = harmonics.arrangement(harmonics.place[rotor.column])
        radial, across = harmonics.amplitudes(rotor.tip_radial, rotor.column)
        if not np.abs(across).max(initial=0.0) <= FIT * np.abs(radial).max(initial=0.0):
            raise ValueError(
                "a cyclic rotor's mode pairs must be aligned to the tips' radial motion"
            )
        tangential, crossed = harmonics.amplitudes(rotor.tip_tangential, rotor.column)
        shape, cross_shape = harmonics.shape, harmonics.crossed
    else:
        arrangement = dense_arrangement(modes)
        radial, tangential, crossed = np.ones(modes), np.zeros(modes), np.ones(modes)
        shape = np.zeros((tips, arrangement.columns))
        cross_shape = np.zeros((tips, arrangement.columns))
        shape[:, :modes], cross_shape[:, :modes] = rotor.tip_radial, rotor.tip_tangential
    pressed, dragged = _answer_at_tips(rotor, dt)
    spread = aligned_copy(shape)
    loads = [load.rotor for load in problem.loads]
    return arrangement, Struct(
        "Rotor",
        body=pack_body(
            rotor.frequency,
            rotor.damping_ratio,
            loads,
            arrangement,
            dt,
            coupled=rotor.by_velocity is not None,
        ),
        radial=arrangement.grid(radial),
        tangential=arrangement.grid(tangential),
        crossed=arrangement.grid(crossed),
        shape=by_column(shape, arrangement),
        cross_shape=by_column(cross_shape, arrangement),
        spread=spread,
        drag_spread=spread if cyclic else aligned_copy(cross_shape),
        half=arrangement.half,
        shared=cyclic,
        w=by_sliding(pressed, dragged, problem.friction),
        position=lengthened(rotor.tip_angle * len(problem.casing.nodal) / (2.0 * np.pi)),
        recess=lengthened(problem.metal_recess),
    )


def _answer_at_tips(rotor: ReducedRotor, dt: float) -> tuple[FloatArray, FloatArray]:
    """Return the radial response of the tips to unit forces at the tips, computed with A^-1.

    Returns:
        response to radial and response to tangential forces, (forces, tips) each.
    """
    if rotor.by_velocity is None:
        inverse = scheme_inverse(rotor.frequency, rotor.damping_ratio, dt)
        radial, tangential = rotor.tip_radial * inverse, rotor.tip_tangential * inverse
    else:
        full = turning_inverse(rotor.damping, dt).T
        radial, tangential = rotor.tip_radial @ full, rotor.tip_tangential @ full
    return radial @ rotor.tip_radial.T, tangential @ rotor.tip_radial.T

"""Arrays of point dampers, of springs between the bodies, of static shaft springs and bearings."""

import numpy as np
from scipy.linalg import block_diag

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.coupling.springs import CouplingSprings
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.kernel.structs import Arrays, Struct, aligned, aligned_copy, padded, zeros
from bladewhirl.solvers.packing.arrangement import Arrangement, scheme_inverse
from bladewhirl.solvers.packing.rotor import rotor_inverses


def pack_dampers(
    problem: ContactProblem,
    bodies: tuple[Struct, Struct],
    arrangements: tuple[Arrangement, Arrangement],
    dt: float,
) -> Struct | None:
    """Return the point dampers of rotor and casing; None if there are none.

    Args:
        problem: contact problem.
        bodies: arrays of rotor and casing.
        arrangements: arrangements of the modes of rotor and casing.
        dt: time step [s].
    """
    ends = []
    given = (problem.rotor.dampers, problem.casing.dampers)
    for rows, body, arrangement in zip(given, bodies, arrangements, strict=True):
        included = body is bodies[0] and problem.rotor.by_velocity is not None  # in the matrix A
        ends.append(damper_ends(rows[:0] if included else rows, body, arrangement, dt))
    if not any(len(end["rows"]) for end in ends):
        return None
    return Struct("Dampers", rotor=ends[0], casing=ends[1])


def damper_ends(rows: FloatArray, body: Struct, arrangement: Arrangement, dt: float) -> Arrays:
    """Return the arrays of the dampers of a body.

    Args:
        rows: rows G of the damping matrix G^T G [s^-1/2], (dampers, modes).
        body: arrays of the body.
        arrangement: arrangement of its modes.
        dt: time step [s].
    """
    strong = arrangement.pack(rows[rows.any(axis=1)])  # without dampers of zero strength
    solve = np.linalg.inv(2.0 * dt * np.eye(len(strong)) + strong * body.c @ strong.T)
    return {"rows": strong, "solve": solve}


def pack_springs(
    problem: ContactProblem, arrangements: tuple[Arrangement, Arrangement]
) -> Struct | None:
    """Return the springs between the bodies and unequal static shaft springs, by harmonic.

    Args:
        problem: contact problem.
        arrangements: arrangements of the modes of rotor and casing.

    Returns:
        the springs, None if there are none.
    """
    rotor, anisotropy = problem.rotor, problem.rotor.anisotropy
    if problem.springs is None and anisotropy == 0.0:
        return None
    springs = _springs_between(problem.springs, arrangements)
    if anisotropy != 0.0:
        first, modes, ends = len(springs["factor"]), len(rotor.frequency), springs["rotor"]
        centre = {
            "place": np.tile(arrangements[0].entry, 2),
            "wave": np.repeat([first, first + 1], modes),
            "amplitude": rotor.centre.ravel(),
        }
        springs["nodal_diameter"] = np.append(springs["nodal_diameter"], 1.0)
        springs["factor"] = np.append(springs["factor"], [anisotropy, -anisotropy])
        springs["rotor"] = {name: np.append(ends[name], centre[name]) for name in ends}
    return Struct("Springs", **springs)


def _springs_between(
    springs: CouplingSprings | None, arrangements: tuple[Arrangement, Arrangement]
) -> Arrays:
    if springs is None:
        return zeros("Springs", {"harmonics": 0, "waves": 0, "moved": 0})
    ends = []
    for arrangement, rows in zip(arrangements, (springs.rotor, springs.casing), strict=True):
        harmonic, part, mode = np.nonzero(rows)
        ends.append(
            {
                "place": arrangement.entry[mode],
                "wave": 2 * harmonic + part,
                "amplitude": rows[harmonic, part, mode],
            }
        )
    return {
        "nodal_diameter": springs.harmonics.astype(np.float64),
        "factor": np.repeat(springs.factors, 2),
        "rotor": ends[0],
        "casing": ends[1],
    }


def pack_bearings(
    problem: ContactProblem, arrangements: tuple[Arrangement, Arrangement], dt: float
) -> Struct | None:
    """Return the bearings; None without them.

    Args:
        problem: contact problem.
        arrangements: arrangements of the modes of rotor and casing.
        dt: time step [s].
    """
    bearings, casing = problem.bearings, problem.casing
    if bearings is None:
        return None
    (inverse,) = rotor_inverses(problem.rotor, dt)
    rotor, support = _ends(bearings.rotor), _ends(bearings.support)
    answer = rotor @ inverse.T
    held = support * scheme_inverse(casing.frequency, casing.damping_ratio, dt)
    stands, ends = 0 if support.any() else len(support), len(rotor)
    flexible = rotor @ answer.T + support @ held.T
    compliance, unit = aligned((ends, padded(ends + 1))), aligned((ends + 1, padded(ends + 1)))
    compliance[:, :ends], unit[:, : ends + 1] = flexible, np.eye(ends + 1)
    inverse = aligned((0, 0))
    if not bearings.damping[:, 1].any():
        skew = np.array([[0.0, -1.0], [1.0, 0.0]])
        dampers = [c.real * np.eye(2) + c.imag * skew for c in bearings.damping[:, 0]]
        drag = block_diag(*dampers) @ flexible / (2.0 * dt)
        inverse = aligned_copy(np.linalg.inv(np.eye(ends) + drag))
    return Struct(
        "Bearings",
        rotor=arrangements[0].pack(rotor),
        answer=arrangements[0].pack(answer),
        casing=arrangements[1].pack(support[stands:]),
        casing_answer=arrangements[1].pack(held[stands:]),
        compliance=compliance,
        unit=unit,
        inverse=inverse,
        stiffness=np.ascontiguousarray(bearings.stiffness).view(np.float64),
        damping=np.ascontiguousarray(bearings.damping).view(np.float64),
        damped=int(bearings.damping.any()),
    )


def _ends(rows: ComplexArray) -> FloatArray:
    """Return rows of displacements along x and y in turn, (2 * bearings, modes)."""
    return np.stack([rows.real, rows.imag], axis=1).reshape(2 * len(rows), -1)


def pack_fuse(problem: ContactProblem, arrangement: Arrangement) -> Struct | None:
    """Return the support of the centre that fuses; None without one."""
    fuse = problem.fuse
    if fuse is None:
        return None
    return Struct(
        "Fuse",
        force=arrangement.pack(fuse.force),
        constant=aligned_copy(fuse.constant),
        limit=fuse.limit,
    )

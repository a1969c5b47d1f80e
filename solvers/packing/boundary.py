"""Arrays of a march with many contact nodes: copies, flexible ring and coating."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.boundary_problem import BoundaryProblem
from bladewhirl.solvers.kernel.structs import Struct, lib, padded
from bladewhirl.solvers.packing.arrangement import Arrangement, lengthened, load_times
from bladewhirl.solvers.packing.casing import coating_law, nodal_response, pack_casing
from bladewhirl.solvers.packing.supports import damper_ends

DIRECTIONS = 3
"""Components of the displacement of a contact node: radial, tangential, axial."""


def pack_boundary(problem: BoundaryProblem, dt: float) -> Struct:
    """Return the constants of the copies, their contact nodes and a rigid wall."""
    frequency, contact = problem.frequency, np.ascontiguousarray(problem.contact)
    squares, damping = frequency**2, 2.0 * problem.damping_ratio * frequency
    inverse = 1.0 / (1.0 / dt**2 + 0.5 * damping / dt)
    compliance, modes = problem.compliance, contact.shape[1]
    response, coupled = np.zeros((0, modes, modes)), np.zeros((0, modes))
    if problem.by_velocity is not None:
        coupled = np.ascontiguousarray(0.5 * (problem.by_velocity + problem.by_velocity.T))
        velocity = 0.5 / dt * problem.by_velocity
        response = np.array([np.linalg.inv(np.diag(1.0 / row) + velocity) for row in inverse])
    if not problem.massless:
        compliance = np.array([(contact * row) @ contact.T for row in inverse])
        if len(response):
            compliance = contact @ response @ contact.T
    weight, before = inverse, 0.5 * damping / dt - 1.0 / dt**2
    if len(response):
        weight, before = np.ones_like(inverse), np.full_like(inverse, -2.0 / dt**2)
    patterns = [load.rotor for load in problem.loads]
    return Struct(
        "Boundary",
        a=weight * (2.0 / dt**2 - squares),
        b=weight * before,
        c=weight,
        response=response,
        coupled=coupled,
        stiffness=squares,
        damping=damping,
        contact=contact,
        columns=np.ascontiguousarray(contact.T),
        normal=np.ascontiguousarray(contact[::DIRECTIONS].T),
        compliance=np.ascontiguousarray(compliance),
        angle=np.ascontiguousarray(problem.angle),
        recess=np.asarray(problem.recess, dtype=np.float64),
        radius=np.asarray(problem.radius, dtype=np.float64),
        wall=_closed(problem.wall),
        load=np.reshape(patterns, (len(patterns), *frequency.shape)).astype(np.float64),
        load_times=load_times(problem.loads),
        massless=float(problem.massless),
        full=float(problem.full_sliding),
        friction=float(problem.friction),
        speed=float(problem.speed),
        time_step=dt,
        limit=float(problem.displacement_limit),
        gap_scale=float(np.abs(problem.wall[:, 0]).mean()),
    )


def pack_ring(problem: BoundaryProblem, dt: float) -> tuple[Arrangement, Struct]:
    """Return the arrangement of the modes of a flexible casing, and its arrays."""
    casing = problem.casing
    assert casing is not None
    loads = [load.casing for load in problem.loads]
    arrangement, arrays = pack_casing(casing, loads, dt, cyclic=casing.by_harmonics)
    nodes, kinds = casing.nodal.shape[:2]
    ends = np.append(np.arange(nodes), 0)
    response = nodal_response(casing, dt)[ends][:, :, ends]
    elements = nodes / (2.0 * np.pi)
    return arrangement, Struct(
        "Ring",
        casing=arrays,
        response=np.ascontiguousarray(response.reshape(2 * (kinds * (nodes + 1),))),
        dampers=damper_ends(casing.dampers, arrays.body, arrangement, dt),
        place=lengthened(problem.angle.ravel() * elements),
        elements_per_step=problem.speed * dt * elements,
    )


def pack_node_coating(problem: BoundaryProblem) -> Struct | None:
    """Return the coating; None if the wall has none."""
    coating, closure = problem.coating, problem.closure
    if coating is None:
        return None
    # The kernel computes the slope of a flexible casing itself.
    steepest = 0.0 if problem.casing is not None else float(np.abs(problem.wall[:, 1]).max())
    if closure is not None:
        steepest += abs(closure.course.largest) * float(np.abs(closure.share[:, 1]).max())
    return Struct(
        "NodeCoating",
        track=coating.track,
        rods=coating.strain.shape[1],
        steepest=steepest,
        **coating_law(coating),
    )


def coating_sizes(coating: Struct | None, problem: BoundaryProblem, group: int) -> dict[str, int]:
    """Return the lengths of the arrays of a coating, zero without a coating."""
    names = "coated_copies coated_tips under coated_group augmented tracks rods coating_sums"
    if coating is None or problem.coating is None:
        return dict.fromkeys(names.split(), 0)
    copies, nodes = problem.angle.shape
    tracks, rods = problem.coating.strain.shape
    return {
        "coated_copies": copies,
        "coated_tips": copies * nodes,
        "under": int(2.0 * coating.half.max()) + 2,
        "coated_group": group,
        "augmented": 2 * group + 1,
        "tracks": tracks,
        "rods": rods,
        "coating_sums": lib.COATING_SUMS,
    }


def ring_sizes(ring: Struct | None, arrangement: Arrangement | None, tips: int) -> dict[str, int]:
    """Return the lengths of the arrays of a ring, zero without a ring."""
    names = (
        "tips wide twice_wide ends tableau sums closed entries casing_entries dampers"
        " all_components twice_tips"
    )
    if ring is None or arrangement is None:
        return dict.fromkeys(names.split(), 0)
    wide = padded(tips)
    return {
        "tips": tips,
        "wide": wide,
        "twice_wide": 2 * wide,
        "ends": lib.HALF * wide,
        "tableau": 2 * tips + 2,
        "sums": padded(arrangement.columns + arrangement.half + lib.LANES),
        "closed": ring.casing.radial.start.shape[1],
        "entries": arrangement.entries,
        "casing_entries": arrangement.entries,
        "dampers": len(ring.dampers.rows),
        "all_components": DIRECTIONS * tips,
        "twice_tips": 2 * tips,
    }


def _closed(values: FloatArray) -> FloatArray:
    """Return values and derivatives on a circle as rows, with the first angle again at the end; the
    derivatives are multiplied by the distance of two angles."""
    angles = len(values)
    rows = np.concatenate([values, values[:1]]).T * [[1.0], [2.0 * np.pi / angles]]
    return np.ascontiguousarray(rows)

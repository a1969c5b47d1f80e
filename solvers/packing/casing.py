"""Arrays of the casing: by harmonic, folded if possible, for a cyclic casing; otherwise dense.
Arrays of its closure and of its coating."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.wall import ReducedCasing, WallClosure
from bladewhirl.solvers.kernel.structs import Struct, aligned, aligned_copy, lib
from bladewhirl.solvers.packing.arrangement import (
    FIT,
    Arrangement,
    Harmonics,
    by_column,
    closed_nodes,
    dense_arrangement,
    folded,
    lengthened,
    pack_body,
    scheme_inverse,
)


def pack_casing(
    casing: ReducedCasing,
    loads: list[FloatArray],
    dt: float,
    *,
    cyclic: bool,
    friction: float | None,
) -> tuple[Arrangement, Struct]:
    """Return the arrangement and the arrays of a casing.

    Args:
        casing: the casing.
        loads: modal forces of each load pattern, (modes,) each.
        dt: time step [s].
        cyclic: whether to treat harmonics separately.
        friction: friction coefficient of nodes that slide in a given direction; None if friction is
            opposite to the slip velocity.
    """
    (_, kinds, modes), moving = casing.nodal.shape, casing.is_flexible
    of_walls = closed_nodes(casing)
    closed = of_walls.ravel()
    if cyclic:
        arrangement, weight, shape = _cyclic_casing(casing)
        # All kinds of nodal values share one array, so that less memory is read.
        shapes = [by_column(shape[closed], arrangement)] * kinds
        spreads = [aligned_copy(shape[closed])] * kinds
        first = np.array([0, len(shapes[0])])
    else:
        arrangement = dense_arrangement(modes)
        weight = np.ones((kinds, modes))
        wide = arrangement.pack(casing.nodal[closed].transpose(1, 0, 2))
        shape, (first, mover) = wide[0], _by_wall(casing)
        rows = [w.reshape(*of_walls.shape, -1)[mover, :, np.arange(modes)] for w in wide]
        shapes, spreads = [*map(lengthened, rows)], [*map(aligned_copy, wide)]
    clearance = lengthened(casing.clearance[closed].T)
    weights, half = [arrangement.grid(w) for w in weight], arrangement.half
    radial, tangential = (
        Struct(
            "NodalField",
            weight=weights[v],
            slope_weight=weights[s],
            half=values,
            slope_half=half - values,
            shape=shapes[v],
            slope_shape=shapes[s],
            spread=spreads[v],
            slope_spread=spreads[s],
            start=start,
        )
        for v, s, values, start in (
            (lib.W_KIND, lib.W_SLOPE, 0, clearance),
            (lib.U_KIND, lib.U_SLOPE, half, aligned(clearance.shape)),
        )
    )
    tables = _compliance(casing, dt, friction, cyclic=cyclic) if moving else np.zeros(0)
    return arrangement, Struct(
        "Casing",
        body=pack_body(casing.frequency, casing.damping_ratio, loads, arrangement, dt),
        radial=radial,
        tangential=tangential,
        fold=folded(shape, arrangement),
        half=half,
        first=first,
        shared=cyclic,
        compliance=aligned_copy(tables.reshape(-1)),
        spacing=1 if cyclic else len(closed) if moving else 0,
        modes=casing.wall_modes,
        nodes=casing.elements,
        element_length=casing.element_length,
    )


def _by_wall(casing: ReducedCasing) -> tuple[IntArray, IntArray]:
    """Return the number of the first mode of each wall, and of all modes, (walls + 1,); and the
    wall that each mode moves, (modes,). Modes that move none, of supports, count to the last."""
    size = np.abs(casing.nodal).max(axis=1).reshape(casing.walls, casing.elements, -1).max(axis=1)
    mover = np.where(size.any(axis=0), size.argmax(axis=0), casing.walls - 1)
    return np.searchsorted(mover, np.arange(casing.walls + 1)), mover


def pack_closure(closure: WallClosure | None) -> Struct | None:
    """Return the closure of the wall; None if the clearance is constant."""
    if closure is None:
        return None
    course = closure.course
    return Struct(
        "Closure",
        share=lengthened(np.vstack([closure.share, closure.share[:1]]).T),
        table=np.reshape(course.table, (-1, 2)).astype(np.float64),
        amount=course.amount,
        rate=1.0 / (course.time_constant or np.inf),
    )


def pack_coating(problem: ContactProblem) -> Struct | None:
    """Return the coating; None if the wall has none."""
    coating = problem.coating
    if coating is None:
        return None
    names = ("thickness", "young_modulus", "yield_stress", "hardening", "limit")
    return Struct(
        "Coating",
        half=np.tile(coating.footprint / coating.arc / 2.0, problem.rotor.copies),
        track=np.tile(coating.track, problem.rotor.copies),
        area=coating.arc * coating.width,
        rods=coating.strain.shape[1],
        **{name: getattr(coating, name) for name in names},
    )


def _cyclic_casing(casing: ReducedCasing) -> tuple[Arrangement, FloatArray, FloatArray]:
    """Return the arrangement, the weights and the shape of a cyclic casing.

    w and u' of a mode vary as its DFT column, w' and u as the partner column. If a harmonic has no
    partner column, a mode with w' and u only is put into the position of the partner.

    Returns:
        arrangement; weights by kind of nodal value, (4, modes); shape, (nodes, columns).
    """
    column, nodal = casing.column, casing.nodal
    harmonics = Harmonics(len(nodal), fold=True, unit=lib.LANES)
    single = harmonics.single[column]
    kinds = range(nodal.shape[1])
    pairs = [harmonics.amplitudes(nodal[:, kind], column) for kind in kinds]
    scales = [max(np.abs(nodal[:, kind]).max(), np.finfo(float).tiny) for kind in kinds]
    # Kinds of nodal values that keep their sign under reflection, and kinds that change it.
    direct, turned = (lib.W_KIND, lib.U_SLOPE), (lib.W_SLOPE, lib.U_KIND)
    size = [np.abs(in_column) / scale for (in_column, _), scale in zip(pairs, scales, strict=True)]
    odd = single & (
        np.maximum(*(size[kind] for kind in turned)) > np.maximum(*(size[kind] for kind in direct))
    )
    weights = []
    for kind, (in_column, across) in zip(kinds, pairs, strict=True):
        out_of_place = odd if kind in direct else single & ~odd
        right, wrong = (in_column, across) if kind in direct else (across, in_column)
        wrong = np.where(single, np.where(out_of_place, in_column, 0.0), wrong)
        if np.abs(wrong).max() > FIT * scales[kind]:
            raise ValueError("a cyclic casing must be symmetric under reflection")
        weights.append(np.where(single, np.where(out_of_place, 0.0, in_column), right))
    place = harmonics.place[column]
    place = np.where(odd, (place + harmonics.half) % (2 * harmonics.half), place)
    return harmonics.arrangement(place), np.array(weights), harmonics.shape


def _compliance(
    casing: ReducedCasing, dt: float, friction: float | None, *, cyclic: bool
) -> FloatArray:
    """Return the displacements of both ends of each element due to unit forces at the ends of each
    element within a time step dt. An end has a value and a slope.

    Returns:
        tables of blocks of 4 x 4 (force, displacement) for every pair of elements, numbered as the
        nodes at which they begin, of which each wall has the first one again, (tables, closed,
        closed, 4, 4), or, for a cyclic casing, for every difference of the numbers of two elements,
        from -nodes to nodes - 1, (tables, 2 * elements, 4, 4). The tables are w for the sliding
        directions -1, 0 and 1; without `friction`, w due to forces along w and u, and u due to
        these forces.
    """
    nodes, kinds, modes = casing.nodal.shape
    rows = casing.nodal.reshape(nodes * kinds, modes)
    forces = rows * scheme_inverse(casing.frequency, casing.damping_ratio, dt)
    response = (forces @ rows.T).reshape(nodes, 2, 2, nodes, 2, 2)  # node, w or u, value or slope
    closed = closed_nodes(casing).ravel()  # no element begins at the last nodes of a wall
    ends = np.column_stack([closed, np.roll(closed, -1)])
    ends = ends[:nodes] if cyclic else ends
    pairs = response[ends[:1] if cyclic else ends][:, :, :, :, ends]
    # force element, end, w or u, slope; displacement element, end, w or u, slope
    tables = pairs.transpose(6, 2, 4, 0, 1, 3, 5, 7).reshape(4, len(ends), -1, 4, 4)
    if friction is not None:
        tables = np.array([tables[0] + s * friction * tables[1] for s in (-1.0, 0.0, 1.0)])
    return np.tile(tables[:, :, 0], (1, 2, 1, 1)) if cyclic else tables

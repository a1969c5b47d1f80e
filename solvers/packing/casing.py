"""Arrays of the casing: by harmonic, folded if possible, for a cyclic casing; otherwise dense.
Arrays of its closure and of its coating."""

import numpy as np

from bladewhirl.meshes.hermite import cubic_weights
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import (
    ContactProblem,
    NodeCoating,
    ReducedCasing,
    WallClosure,
    WallCoating,
)
from bladewhirl.solvers.kernel.structs import Arrays, Struct, aligned, aligned_copy, lib
from bladewhirl.solvers.packing.arrangement import (
    FIT,
    Arrangement,
    Harmonics,
    by_column,
    by_sliding,
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
    friction: float | None = None,
) -> tuple[Arrangement, Struct]:
    """Return the arrangement and the arrays of a casing.

    Args:
        casing: the casing.
        loads: modal forces of each load pattern, (modes,) each.
        dt: time step [s].
        cyclic: whether to treat harmonics separately.
        friction: friction coefficient for the array `compliance`; if None, this array is empty.
    """
    nodes, kinds, modes = casing.nodal.shape
    if cyclic:
        arrangement, weight, shape = _cyclic_casing(casing)
        # All kinds of nodal values share one array, so that less memory is read.
        shapes, spreads = [by_column(shape, arrangement)] * kinds, [aligned_copy(shape)] * kinds
    else:
        arrangement = dense_arrangement(modes)
        weight = np.ones((kinds, modes))
        wide = arrangement.pack(casing.nodal.transpose(1, 0, 2))
        shape = wide[0]
        shapes, spreads = [by_column(w, arrangement) for w in wide], [*map(aligned_copy, wide)]
    clearance = _closed(casing.clearance)
    weights, half = [arrangement.grid(w) for w in weight], arrangement.half
    radial, tangential = (
        Struct(
            "NodalField",
            weight=weights[v],
            slope_weight=weights[s],
            half=first,
            slope_half=half - first,
            shape=shapes[v],
            slope_shape=shapes[s],
            spread=spreads[v],
            slope_spread=spreads[s],
            start=start,
        )
        for v, s, first, start in (
            (lib.W_KIND, lib.W_SLOPE, 0, clearance),
            (lib.U_KIND, lib.U_SLOPE, half, aligned(clearance.shape)),
        )
    )
    blocks = np.zeros(0)
    if friction is not None and not modes:
        blocks = np.zeros((3, lib.HALF, lib.HALF))  # one block for all elements
    elif friction is not None:
        blocks = _compliance(casing, nodal_response(casing, dt), friction, cyclic=cyclic)
    return arrangement, Struct(
        "Casing",
        body=pack_body(casing.frequency, casing.damping_ratio, loads, arrangement, dt),
        radial=radial,
        tangential=tangential,
        fold=folded(shape, arrangement),
        half=half,
        shared=cyclic,
        compliance=aligned_copy(blocks.reshape(-1)),
        spacing=1 if cyclic else nodes if nodes > 1 and modes else 0,
        modes=modes,
        nodes=nodes,
        element_length=casing.element_length,
    )


def _closed(values: FloatArray) -> FloatArray:
    """Return values and slopes at nodes (nodes, 2) as rows, with the first node again at the
    end."""
    return lengthened(values[np.append(np.arange(len(values)), 0)].T)


def pack_closure(closure: WallClosure | None) -> Struct | None:
    """Return the closure of the wall; None if the clearance is constant."""
    if closure is None:
        return None
    course = closure.course
    return Struct(
        "Closure",
        share=_closed(closure.share),
        table=np.reshape(course.table, (-1, 2)).astype(np.float64),
        amount=course.amount,
        rate=1.0 / (course.time_constant or np.inf),
    )


def pack_coating(problem: ContactProblem) -> Struct | None:
    """Return the coating; None if the casing has none."""
    coating, casing = problem.coating, problem.casing
    if not isinstance(coating, WallCoating):
        return None
    rods = len(coating.strain)
    per_element = rods / len(casing.nodal)
    at = (np.arange(rods) + 0.5) / per_element
    element = np.floor(at).astype(np.int64)
    hermite = aligned((4, rods + lib.HALF))  # registers extend beyond the last rod
    hermite[:, :rods] = cubic_weights(at - element, casing.element_length)
    return Struct(
        "Coating",
        hermite=hermite,
        element=element,
        until=np.searchsorted(element, element, side="right"),
        rods_per_element=per_element,
        friction=coating.friction,
        **coating_law(coating),
    )


def coating_law(coating: WallCoating | NodeCoating) -> Arrays:
    """Return the fields that the structs of both kinds of coating have."""
    names = ("thickness", "young_modulus", "yield_stress", "hardening", "limit")
    return {
        "half": coating.footprint / coating.arc / 2.0,
        "area": coating.arc * coating.width,
        **{name: getattr(coating, name) for name in names},
    }


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


def nodal_response(casing: ReducedCasing, dt: float) -> FloatArray:
    """Return the change of w, w', u and u' at each node due to unit forces within a time step dt,
    (nodes, 4, nodes, 4); the first two indices are those of the force."""
    nodes, kinds, modes = casing.nodal.shape
    rows = casing.nodal.reshape(nodes * kinds, modes)
    forces = rows * scheme_inverse(casing.frequency, casing.damping_ratio, dt)
    return np.asarray(forces @ rows.T).reshape(nodes, kinds, nodes, kinds)


def _compliance(
    casing: ReducedCasing, response: FloatArray, friction: float, *, cyclic: bool
) -> FloatArray:
    """Return the response of the four nodal values in each element to unit forces in each element.

    The response is given for the sliding directions -1, 0 and 1.

    Returns:
        blocks of 4 x 4 for every pair of elements, (3, elements, elements, 4, 4); for a cyclic
        casing, a block for every difference of the numbers of two elements, from -nodes to
        nodes - 1, (3, 2 * elements, 4, 4).
    """
    nodes, response = len(casing.nodal), response[:, :, :, :2]
    ends = np.column_stack([np.arange(nodes), np.roll(np.arange(nodes), -1)])
    pressed, dragged = (
        response[ends][:, :, force]
        .reshape(nodes, 4, nodes, 2)[:, :, ends]
        .reshape(nodes, 4, nodes, 4)
        .transpose(2, 0, 1, 3)
        for force in ([lib.W_KIND, lib.W_SLOPE], [lib.U_KIND, lib.U_SLOPE])
    )
    blocks = by_sliding(pressed, dragged, friction)
    return np.tile(blocks[:, :, 0], (1, 2, 1, 1)) if cyclic else blocks

"""Abradable coatings of contact problems: under the tips of beams, or under the contact nodes of a
superelement."""

from collections.abc import Callable, Iterator

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.coating import Coating
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.inputs.fields import MOST
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.stage.wall_coating import WallCoating, rod_angles
from bladewhirl.models.superelements.superelement import Superelement

PER_FOOTPRINT = 4  #: by default, a footprint covers more than this number of rods

SAME = 1e-6
"""Two axial positions closer than this fraction of the radius are one track; a footprint up to this
fraction counts as zero."""

MISPLACED = 0.01
"""Largest axial distance between a track of a worn profile and the track of the contact nodes,
divided by the width of the track."""

FACING, NEAR = 0.7, 0.1
"""A triangle of the surface faces the wall if its normal has at least this radial part, and if it
is not below the contact nodes by more than this fraction of their axial extent."""

LISTED = 8  #: a message lists all axial positions up to this number of them


def coating_of(
    case: Case,
    axial_position: FloatArray,
    radius: FloatArray,
    covered: Callable[[], FloatArray],
    wall_radius: float,
) -> WallCoating | None:
    """Return the coating of the wall; None if there is none.

    There is a track of rods for each axial position of contact nodes, whose outermost nodes are at
    the edges of the blades. The widths of the tracks follow from the axial distances between them,
    see `spacing`.

    Args:
        case: the case.
        axial_position: axial position of each contact node of a copy [m], (nodes,).
        radius: radius of each contact node [m], (nodes,).
        covered: function that returns the arc that each contact node covers [m], (nodes,), if the
            case does not give it.
        wall_radius: radius of the wall [m].

    Raises:
        CaseError: no footprint follows from the geometry, or the tracks of a worn profile are not
            at the axial positions of the contact nodes.
    """
    coating = case.casing.coating
    if coating is None:
        return None
    axial, track = axial_tracks(axial_position, radius)
    if len(axial) > 1:
        width = spacing(axial)
    else:
        width = np.full(1, coating.width or case.casing.wall.width)
    given = coating.footprint
    footprint = covered() if given is None else np.full(len(track), given)
    worn = coating.profile.axial if coating.profile is not None else axial[:0]
    if len(worn) and (len(worn) != len(axial) or (np.abs(worn - axial) > MISPLACED * width).any()):
        expected = (
            f"tracks at the axial positions of the contact nodes, {_listed(axial)},"
            f" not at {_listed(worn)}"
        )
        raise CaseError([case_fault(case, "casing.coating.profile", expected)])
    return WallCoating(
        strain=_worn(coating, 2.0 * np.pi * wall_radius, footprint, case.blades, len(axial)),
        axial=axial,
        width=width,
        track=track,
        footprint=footprint,
        radius=wall_radius,
        hardening=coating.slope,
        thickness=coating.thickness,
        young_modulus=coating.young_modulus,
        yield_stress=coating.yield_stress,
        limit=coating.limit,
    )


def beam_footprint(case: Case, arrays: StageArrays) -> FloatArray:
    """Return the thickness of each blade of beams at its tip [m], (tips,).

    Raises:
        CaseError: no beam ends at a tip.
    """
    ends = arrays.rotor_thickness[:, None] + arrays.rotor_thickness_change[:, None] * [-0.5, 0.5]
    thickness = np.array(
        [ends[arrays.rotor_line == node].min(initial=np.inf) for node in arrays.tip_node]
    )
    if not np.isfinite(thickness).all():
        expected = "a length, because the tips are not ends of beams"
        raise CaseError([case_fault(case, "casing.coating.footprint", expected)])
    return thickness


def node_footprint(
    case: Case, part: Superelement, blade: IntArray, thickness: FloatArray | None = None
) -> FloatArray:
    """Return the arc that each contact node of a superelement covers [m], (nodes,).

    A node covers the arc of the thickness of its blade at its track; nodes of a blade in one track
    share it by the distances between neighbours. Where no thickness is known, a node covers an arc
    by these distances.

    Args:
        case: the case.
        part: the superelement.
        blade: blade of each contact node of a copy, (nodes,).
        thickness: what `tip_thickness` returns.

    Raises:
        CaseError: contact nodes of a blade are at the same angle, so that no footprint follows.
    """
    _, track = axial_tracks(part.contact_position[:, 2], part.contact_radius)
    footprint, along = np.zeros(part.contacts), part.contact_angle * part.contact_radius
    for number in np.unique(blade):
        members = np.flatnonzero(blade == number)
        if thickness is None:
            footprint[members] = spacing(along[members])
            continue
        for place in np.unique(track[members]):
            row = members[track[members] == place]
            share = spacing(along[row]) if len(row) > 1 else np.ones(1)
            footprint[row] = thickness[place] * share / (share.sum() or np.inf)
    if not footprint.min() > SAME * part.contact_radius.max():
        expected = "a length, because contact nodes of a blade are at the same angle"
        raise CaseError([case_fault(case, "casing.coating.footprint", expected)])
    return footprint


def rod_faults(case: Case, coating: WallCoating, speed: float) -> Iterator[Fault]:
    """Yield a fault if a contact node passes a rod in each time step."""
    step = case.march.time_step
    if not abs(speed) * step * coating.radius < coating.arc:
        most = int(2.0 * np.pi / (abs(speed) * step))
        expected = f"at most {most} rods, so that a tip passes less than one rod in a time step"
        yield case_fault(case, "casing.coating.elements", expected)


def tip_thickness(part: Superelement, blades: int) -> FloatArray | None:
    """Return the thickness of the tips along the arc at each track of contact nodes [m], (tracks,):
    the area of the surface that faces the wall, nearest to the track, divided by its width. None if
    the file has no such surface, or its contact nodes have one axial position.

    Args:
        part: superelement with its contact nodes at the edges of the tips.
        blades: number of its blades.
    """
    axial, _ = axial_tracks(part.contact_position[:, 2], part.contact_radius)
    extent = float(np.ptp(axial))
    if part.points is None or part.triangles is None or extent == 0.0:
        return None
    corners = part.points[part.triangles]
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middle = corners.mean(axis=1)
    radius = np.hypot(middle[:, 0], middle[:, 1])
    area *= np.sign((area * middle).sum())  # outwards, in whatever order the corners are
    outward = (area * middle)[:, :2].sum(axis=1) / radius
    faces = outward > FACING * np.linalg.norm(area, axis=1)
    faces &= radius > part.contact_radius.min() - NEAR * extent
    edges = np.concatenate([[-np.inf], 0.5 * (axial[1:] + axial[:-1]), [np.inf]])
    below = outward[faces] @ _share_below(np.sort(corners[faces, :, 2]), edges)
    thickness = np.diff(below) / (blades * spacing(axial))
    return thickness if (thickness > SAME * part.contact_radius.max()).all() else None


def _share_below(corners: FloatArray, levels: FloatArray) -> FloatArray:
    """Return the share of the area of each triangle below each level, (triangles, levels), for the
    heights of its corners in ascending order, (triangles, 3)."""
    low, middle, high = (corners[:, k, None] for k in range(3))
    with np.errstate(divide="ignore", invalid="ignore"):
        rising = (levels - low) ** 2 / ((high - low) * (middle - low))
        falling = 1.0 - (high - levels) ** 2 / ((high - low) * (high - middle))
    within = np.where(levels < middle, rising, falling)
    return np.select([levels <= low, levels >= high], [0.0, 1.0], within)


def _worn(
    coating: Coating, around: float, footprint: FloatArray, blades: int, tracks: int
) -> FloatArray:
    """Return the plastic strain of each rod at the start, (tracks, rods). The default number of
    rods is the same for each blade; it follows from the circumference `around` of the wall and the
    arcs that tips cover [m]."""
    rods = coating.elements or (int(PER_FOOTPRINT * around / footprint.min() / blades) + 1) * blades
    if rods > MOST:
        expected = f"at least {PER_FOOTPRINT * around / MOST:.3g} m, for at most {MOST} rods"
        key, length = "casing.coating.footprint", float(footprint.min())
        raise CaseError([Fault(key=key, value=length, expected=expected)])
    strain = np.zeros((tracks, rods))
    if coating.profile is not None:
        strain += coating.profile.recess(rod_angles(rods)) / coating.thickness
    return strain


def spacing(places: FloatArray) -> FloatArray:
    """Return the length that belongs to each place on a line, in the same shape: half of the sum of
    the distances to its neighbours, so that all lengths together are the extent of the line."""
    order = np.argsort(places, kind="stable")
    gaps = np.diff(places[order])
    parts = 0.5 * (np.append(gaps, 0.0) + np.append(0.0, gaps))
    return np.asarray(parts[np.argsort(order, kind="stable")])


def track_edges(places: FloatArray) -> FloatArray:
    """Return the limits of the tracks at ascending places on a line [m], (tracks + 1,): the middles
    between them, and the first and the last place; the lengths are those of `spacing`."""
    return np.concatenate([places[:1], 0.5 * (places[1:] + places[:-1]), places[-1:]])


def axial_tracks(axial: FloatArray, radius: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the different axial positions of contact nodes [m], (tracks,), ascending, and the
    number of the position at which each node is, (nodes,).

    Args:
        axial: axial position of each node [m], (nodes,).
        radius: radius of each node [m], (nodes,).
    """
    order = np.argsort(axial, kind="stable")
    apart = np.diff(axial[order], prepend=axial[order[0]]) > SAME * radius.max()
    number = np.cumsum(apart)[np.argsort(order, kind="stable")]
    return np.array([axial[number == n].mean() for n in range(int(number.max()) + 1)]), number


def _listed(places: FloatArray) -> str:
    """Return positions in mm as text; of a long list only the number, the first and the last."""
    texts = [f"{1e3 * place:.5g}" for place in places]
    if len(texts) > LISTED:
        return f"{len(texts)} positions from {texts[0]} to {texts[-1]} mm"
    return f"{', '.join(texts)} mm"

"""The abradable coating under the contact nodes of a superelement."""

from collections.abc import Iterator

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.coating import WornProfile
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.inputs.errors import CaseError, Fault
from bladewhirl.models.stage.coating import PER_FOOTPRINT
from bladewhirl.models.stage.contact_problem import NodeCoating, rod_angles
from bladewhirl.models.superelements.superelement import Superelement

SAME = 1e-6
"""Two axial positions closer than this fraction of the radius are one track; a footprint up to this
fraction counts as zero."""

MISPLACED = 0.01
"""A track of a worn profile may be off the track of the contact nodes by this fraction of its
width."""

LISTED = 8
"""A message lists all axial positions up to this number of them."""


def node_coating(
    case: Case, part: Superelement, blade: IntArray, wall_radius: float
) -> NodeCoating | None:
    """Return the coating of the wall; None if there is none.

    There is a track of rods for each axial position of contact nodes. The widths of the tracks and
    the arcs that the nodes cover follow from the distances between neighbours (see `spacing`):
    neighbours of a node are nodes of its blade in the same track, or along the chord if it is alone
    in its track.

    Args:
        case: the case.
        part: the superelement.
        blade: blade of each contact node of a copy, (nodes,).
        wall_radius: radius of the wall [m].

    Raises:
        CaseError: the distances of the nodes give no footprint or no width, or a worn profile has
            other tracks.
    """
    coating = case.casing.coating
    if coating is None:
        return None
    axial, track = axial_tracks(part.contact_position[:, 2], part.contact_radius)
    if len(axial) > 1:
        width = spacing(axial)
    else:
        width = np.full(1, coating.width or case.casing.wall.width)
    footprint = np.full(part.contacts, coating.footprint or 0.0)
    if coating.footprint is None:
        along = part.contact_angle * part.contact_radius
        for number in np.unique(blade):
            members = np.flatnonzero(blade == number)
            footprint[members] = spacing(along[members])
            for place in np.unique(track[members]):
                row = members[track[members] == place]
                if len(row) > 1:
                    footprint[row] = spacing(along[row])
        if not footprint.min() > SAME * wall_radius:
            expected = "a length, because contact nodes of a blade are at the same angle"
            raise CaseError([case_fault(case, "casing.coating.footprint", expected)])
    rods = coating.elements or int(PER_FOOTPRINT * 2 * np.pi * wall_radius / footprint.min()) + 1
    made = NodeCoating(
        strain=np.zeros((len(axial), rods)),
        axial=axial,
        width=width,
        track=track,
        footprint=footprint,
        radius=wall_radius,
        thickness=coating.thickness,
        young_modulus=coating.young_modulus,
        yield_stress=coating.yield_stress,
        hardening=coating.slope,
        limit=coating.limit,
    )
    if coating.profile is not None:
        _check_tracks(case, coating.profile, made)
        made.strain[:] = coating.profile.recess(rod_angles(rods)) / coating.thickness
    return made


def node_coating_faults(case: Case, coating: NodeCoating | None, speed: float) -> Iterator[Fault]:
    """Yield a fault if a node passes a rod in each time step."""
    if coating is None:
        return
    step = case.march.time_step
    if not abs(speed) * step * coating.radius < coating.arc:
        most = int(2.0 * np.pi / (abs(speed) * step))
        expected = (
            f"at most {most} rods, the elements of the coating,"
            " so that a node passes less than one rod in a time step"
        )
        yield case_fault(case, "casing.coating.elements", expected)


def spacing(places: FloatArray) -> FloatArray:
    """Return the part of a line that belongs to each of some places on it, in the same shape: half
    of the distances to both neighbours; at the ends the distance to the only neighbour."""
    if len(places) < 2:
        return np.zeros(len(places))
    order = np.argsort(places, kind="stable")
    gaps = np.diff(places[order])
    parts = 0.5 * (np.append(gaps, gaps[-1]) + np.append(gaps[0], gaps))
    return np.asarray(parts[np.argsort(order, kind="stable")])


def axial_tracks(axial: FloatArray, radius: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the different axial positions of contact nodes [m], ascending, and the number of the
    position of each node.

    Args:
        axial: axial position of each node [m], (nodes,).
        radius: radius of each node [m], (nodes,).
    """
    order = np.argsort(axial, kind="stable")
    apart = np.diff(axial[order], prepend=axial[order[0]]) > SAME * radius.max()
    number = np.cumsum(apart)[np.argsort(order, kind="stable")]
    return np.array([axial[number == n].mean() for n in range(int(number.max()) + 1)]), number


def _check_tracks(case: Case, profile: WornProfile, made: NodeCoating) -> None:
    """Check that the tracks of a worn profile are those of the contact nodes.

    Raises:
        CaseError: the numbers of tracks differ, or a track is elsewhere.
    """
    axial, worn = made.axial, profile.axial
    if not profile.tracks:
        return
    if len(worn) != len(axial) or (np.abs(worn - axial) > MISPLACED * made.width).any():
        expected = (
            f"tracks at the axial positions of the contact nodes, {_listed(axial)},"
            f" not at {_listed(worn)}"
        )
        raise CaseError([case_fault(case, "casing.coating.profile", expected)])


def _listed(places: FloatArray) -> str:
    """Return positions in mm; number, first and last position of a long list."""
    texts = [f"{1e3 * place:.5g}" for place in places]
    if len(texts) > LISTED:
        return f"{len(texts)} positions from {texts[0]} to {texts[-1]} mm"
    return f"{', '.join(texts)} mm"

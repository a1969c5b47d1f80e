"""Contact nodes at one place, one of which is kept.

Two contact nodes at one place of a wheel make its contact problem degenerate: only the sum of their
forces is determined.
"""

from dataclasses import replace

import numpy as np

from bladewhirl.meshes.coincident import COINCIDENT, near_pairs, places_of
from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError

JOINTS = ("joint_left", "joint_right")  #: nodes of joints, which are all kept


def on_next_sector(position: FloatArray, sectors: int) -> BoolArray:
    """Return which nodes of a sector are also nodes of the next sector, counter-clockwise, (n,).

    Args:
        position: positions of the nodes [m], (n, 3).
        sectors: number of sectors.
    """
    back = rotate(position, -2.0 * np.pi / sectors)
    pairs = near_pairs(back, position, COINCIDENT * float(abs(position).max()))
    return np.isin(np.arange(len(position)), pairs[:, 0])


def with_single_contacts(part: Superelement, kind: str, copies: int) -> Superelement:
    """Return a superelement with one of the contact nodes at each place.

    Nodes on both faces of a sector or blade are kept on the clockwise one.

    Args:
        part: superelement.
        kind: "blade", "sector" or "wheel".
        copies: number of sectors, or of blades of a wheel, whose nodes are listed blade by blade.

    Raises:
        SuperelementError: nodes would be left out on some blades of a wheel only.
    """
    position = part.contact_position
    kept = np.ones(len(position), dtype=np.bool_)
    blades = copies if kind == "wheel" else 1
    if len(position) % blades:
        return part  # the case refuses it
    if kind == "sector" and copies > 1:
        kept = ~on_next_sector(position, copies)
    blade = np.arange(len(position)) * blades // len(position)
    middle = np.array([part.contact_position[blade == n, :2].mean(axis=0) for n in range(blades)])
    ahead = np.angle(np.exp(1j * (part.contact_angle - np.arctan2(*middle[blade].T[::-1]))))
    place = places_of(position, COINCIDENT * float(abs(position).max()))
    order = np.lexsort([ahead.round(9), place])
    kept[np.delete(order, np.unique(place[order], return_index=True)[1])] = False
    joints = [getattr(part, key) for key in JOINTS if getattr(part, key) is not None]
    for each in joints:  # numbers on the first blade
        kept[each.ravel() + len(position) // blades * np.arange(blades)[:, None]] = True
    if kept.all():
        return part
    numbers = np.bincount(blade[kept], minlength=blades)
    if numbers.min() < numbers.max():
        raise SuperelementError(
            f"contact_position: expected nodes at different places; {np.count_nonzero(~kept)} of"
            f" {len(kept)} are at the place of others, on some blades only"
        )
    chosen = {key: getattr(part, key)[kept] for key in ("contact_position", "contact_dofs")}
    place = np.cumsum(kept) - 1
    chosen |= {key: place[each] for key, each in zip(JOINTS, joints, strict=False)}
    return replace(part, **chosen)

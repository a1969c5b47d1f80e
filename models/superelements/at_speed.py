"""A superelement that rotates steadily."""

from dataclasses import replace

import scipy.sparse as sp

from bladewhirl.models.superelements.superelement import Superelement, dense


def at_speed(part: Superelement, omega: float, *, coriolis: bool) -> Superelement:
    """Return a superelement linearised about its state of steady rotation.

    Args:
        part: superelement with the matrix stiffness_speed.
        omega: speed of rotation [rad/s].
        coriolis: keep the matrix of the Coriolis forces, if there is one.
    """
    assert part.stiffness_speed is not None
    rest, change = part.stiffness, part.stiffness_speed
    if sp.issparse(rest) and sp.issparse(change):
        stiffness = sp.csr_array(rest + omega**2 * change)
    else:
        stiffness = dense(rest) + omega**2 * dense(change)
    gyroscopic = part.gyroscopic if coriolis else None
    return replace(part, stiffness=stiffness, gyroscopic=gyroscopic)

"""A superelement that rotates steadily."""

from dataclasses import replace

import scipy.sparse as sp

from bladewhirl.models.superelements.superelement import Superelement, dense


def fixed_at_speed(part: Superelement, omega: float) -> Superelement:
    """Return a superelement that has only the stiffness at a speed [rad/s]."""
    turning = at_speed(part, omega, coriolis=True)
    return replace(turning, stiffness_speed=None, stiffness_speed4=None, speed=omega)


def over_speeds(part: Superelement, highest: float) -> tuple[Superelement, ...]:
    """Return a structure at rest and at half and all of the highest speed [rad/s], with K + Omega^2
    M in place of the stiffness K: the modes are the same, and rotation softens none of them.

    The modes of all three together describe motions at any speed in between, which those at rest
    alone do slowly: 160 modes of each nodal diameter of a sector of solids leave an error of 1e-3
    where stiffening raises a frequency by a hundredth. Without matrices of the change of the
    stiffness, or without a speed, only the structure at rest is returned.
    """
    if part.stiffness_speed is None or highest == 0.0:
        return (part,)
    speeds = 0.5 * highest, highest
    turning = (at_speed(part, omega, coriolis=True) for omega in speeds)
    return part, *(
        replace(each, stiffness=each.stiffness + omega**2 * part.mass)
        for each, omega in zip(turning, speeds, strict=True)
    )


def at_speed(part: Superelement, omega: float, *, coriolis: bool) -> Superelement:
    """Return a superelement linearised about its state of steady rotation.

    Args:
        part: superelement with the matrix stiffness_speed.
        omega: speed of rotation [rad/s].
        coriolis: keep the matrix of the Coriolis forces, if there is one.
    """
    assert part.stiffness_speed is not None
    terms = [part.stiffness, omega**2 * part.stiffness_speed]
    if part.stiffness_speed4 is not None:
        terms.append(omega**4 * part.stiffness_speed4)
    together = all(sp.issparse(term) for term in terms)
    stiffness = sp.csr_array(sum(terms)) if together else sum(map(dense, terms))
    return replace(
        part,
        stiffness=stiffness,
        gyroscopic=part.gyroscopic if coriolis else None,
        softening=0.0 if part.centre_dofs is None else omega**2,
    )

"""March of structures with many contact nodes in a flexible ring, against its symmetries."""

from dataclasses import replace

import numpy as np
import pytest
from boundary_cases import advanced, bladed, casing, ledger


@pytest.mark.parametrize("massless", [True, False])
@pytest.mark.slow
def test_blades_in_a_ring_keep_energy_momentum_and_symmetries(massless: bool) -> None:
    copies, nodes, dt, steps = 22, 9, 4e-6, 250
    ring = casing(44, support=0.0)
    problem = bladed(copies, nodes, massless=massless, ring=ring, sliding="full")
    chunk = advanced(problem, dt, steps)
    force = chunk.contact_force
    assert (force[:, :, 0] < 0.0).any(axis=0).sum() > 40  # nodes in contact
    assert ledger(chunk) < 1e-9
    # Momentum: the wall gets the forces on the nodes with the opposite sign.
    rotor = problem.rotor
    angle = rotor.tip_angle + problem.speed * chunk.time[:, None]
    outward, along = force[:, :, 0], force[:, :, 1]
    pushed = -(np.exp(1j * angle) * (outward + 1j * along)).sum(axis=1)
    impulse = dt * pushed.cumsum()
    nodal = ring.nodal[:, :, :2] @ chunk.casing_velocity[-2, :2]  # rigid translations
    theta = 2.0 * np.pi / len(nodal) * np.arange(len(nodal))
    mass = 7800.0 * 0.05 * 5e-3 * 2.0 * np.pi * ring.radius
    velocity = np.mean(np.exp(1j * theta) * (nodal[:, 0] + 1j * nodal[:, 2]))
    assert mass * velocity == pytest.approx(0.5 * (impulse[-2] + impulse[-1]), rel=1e-5)
    # Turned by a pitch, which is two elements, every blade does the same. The mirror image turns
    # the other way; tangential displacements change their sign.
    flip, compliance = np.tile([1.0, -1.0, 1.0], nodes), rotor.compliance
    flipped = None if compliance is None else flip[:, None] * compliance * flip
    image = replace(
        rotor,
        contact=flip[:, None] * rotor.contact,
        compliance=flipped,
        tip_angle=-rotor.tip_angle,
    )
    mirrored = replace(problem, rotor=image, speed=-problem.speed)
    turned = replace(
        problem, rotor=replace(rotor, tip_angle=rotor.tip_angle + 2.0 * np.pi / copies)
    )
    for other, sign in ((turned, 1.0), (mirrored, -1.0)):
        again = advanced(other, dt, steps).contact_force * [1.0, sign, 1.0]
        assert again == pytest.approx(force, abs=1e-6 * np.abs(force).max())

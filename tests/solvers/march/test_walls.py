"""March of rotors whose contact nodes are inside several flexible rings."""

from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from boundary_cases import advanced, bladed, casing, ledger
from contact_cases import random_problem, run_as_reference

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.wall import ReducedCasing, joined_walls


def within(given: ContactProblem, rings: list[ReducedCasing], wall: list[int]) -> ContactProblem:
    """A problem whose tips are inside several rings; loads and start act on the first."""
    joined, start = joined_walls(rings), given.start
    rest = len(joined.frequency) - len(given.casing.frequency)

    def longer(values: FloatArray) -> FloatArray:
        return np.pad(values, (0, rest))

    return replace(
        given,
        rotor=replace(given.rotor, wall=np.array(wall)),
        casing=joined,
        loads=tuple(replace(load, casing=longer(load.casing)) for load in given.loads),
        start=replace(
            start,
            casing=longer(start.casing),
            casing_velocity=longer(start.casing_velocity),
        ),
    )


@pytest.mark.parametrize("sliding", ["permanent", "signed"])
def test_tips_inside_rings_of_different_radii_march_as_the_reference(
    sliding: Literal["permanent", "signed"],
) -> None:
    given = random_problem(5, tips=6, sliding=sliding, tip_rotation=True)
    larger = random_problem(6, tips=6).casing
    larger = replace(larger, radius=1.3 * larger.radius, clearance=0.7 * given.casing.clearance)
    wall = [0, 1, 1, 0, 1, 0]
    _, chunk = run_as_reference(within(given, [given.casing, larger], wall), 1e-4, 150)
    assert all(chunk.contact_impulse[:, np.array(wall) == number].any() for number in (0, 1))


def twice(one: ContactProblem, rings: list[ReducedCasing]) -> ContactProblem:
    """A problem of separate blades twice, each set inside a ring of its own."""
    rotor, start, flexible = one.rotor, one.start, one.rotor.compliance
    names = ("frequency", "damping_ratio", "centre", "tip_angle", "tip_recess", "column")
    repeated: dict[str, Any] = {name: np.tile(getattr(rotor, name), 2) for name in names}
    both = replace(
        rotor,
        **repeated,
        copies=2 * rotor.copies,
        dampers=np.zeros((0, 2 * len(rotor.frequency))),
        compliance=None if flexible is None else np.concatenate([flexible, flexible]),
        wall=np.repeat([0, 1], len(rotor.tip_angle)),
    )
    moved = ("rotor", "rotor_velocity", "casing", "casing_velocity")
    return replace(
        one,
        rotor=both,
        casing=joined_walls(rings),
        loads=tuple(
            replace(load, rotor=np.tile(load.rotor, 2), casing=np.tile(load.casing, 2))
            for load in one.loads
        ),
        start=replace(start, **{name: np.tile(getattr(start, name), 2) for name in moved}),
    )


DT, STEPS = 4e-6, 120


@pytest.mark.parametrize("massless", [True, False])
def test_equal_rotors_inside_equal_rings_move_as_one(massless: bool) -> None:
    ring = casing(20, support=0.0)
    one = bladed(6, 3, massless=massless, ring=ring, sliding="full")
    alone, together = advanced(one, DT, STEPS), advanced(twice(one, [ring, ring]), DT, STEPS)
    assert ledger(together) < 1e-9
    assert (alone.contact_force[..., 0] < 0.0).any()
    for own in np.split(together.contact_force, 2, axis=1):
        size = np.abs(alone.contact_force).max()
        np.testing.assert_allclose(own, alone.contact_force, rtol=0.0, atol=1e-8 * size)
    assert together.energy == pytest.approx(2.0 * alone.energy, rel=1e-9)


def test_reversed_rotors_inside_different_rings_are_the_mirror_image() -> None:
    ring = casing(20, support=0.0)
    larger = replace(ring, radius=1.2 * ring.radius, clearance=0.5 * ring.clearance)
    problem = twice(bladed(6, 3, massless=True, ring=ring, sliding="full"), [ring, larger])
    rotor, flip = problem.rotor, np.tile([1.0, -1.0, 1.0], 3)
    assert rotor.compliance is not None
    image = replace(
        rotor,
        contact=flip[:, None] * rotor.contact,
        compliance=flip[:, None] * rotor.compliance * flip,
        tip_angle=-rotor.tip_angle,
    )
    mirrored = replace(problem, rotor=image, speed=-problem.speed)
    force = advanced(problem, DT, STEPS).contact_force
    again = advanced(mirrored, DT, STEPS).contact_force * [1.0, -1.0, 1.0]
    first, other = np.split(force, 2, axis=1)
    assert first.any()
    assert other.any()
    assert not np.allclose(first, other)
    np.testing.assert_allclose(again, force, rtol=0.0, atol=1e-8 * np.abs(force).max())

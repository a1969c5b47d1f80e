"""Shafts whose springs differ: static answers, perturbation theory, what stays cyclic."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from bladewhirl.models import Case, dumps_case, read_case, with_values
from bladewhirl.models.case_file import loads
from bladewhirl.models.loads import imbalance_force
from bladewhirl.models.modes import suspension_pair
from bladewhirl.models.stage import Stage, build_stage
from bladewhirl.studies.derived import derive

EXAMPLES = Path(__file__).parents[1] / "examples"
SMALL = {
    "bladed_disk.blades": 8,
    "bladed_disk.elements_per_blade": 3,
    "casing.elements": 12,
    "reduction.fixed_interface_modes": 40,
}


@cache
def stage(x: float, y: float | None) -> Stage:
    """A small stage with these shaft springs."""
    shaft = {"shaft.stiffness": x} | ({} if y is None else {"shaft.stiffness_y": y})
    return build_stage(with_values(Case(), SMALL | shaft))


def test_a_force_at_the_centre_bends_its_own_spring() -> None:
    """Nothing else stands on the ground: F / k along each axis, and none across."""
    rotor = stage(3.4e7, 1.1e7).rotor
    flexible = rotor.centre / rotor.frequency**2 @ rotor.centre.T
    np.testing.assert_allclose(flexible, np.diag([1 / 3.4e7, 1 / 1.1e7]), rtol=1e-9, atol=1e-17)


def test_the_suspension_pair_parts_by_its_share_in_the_springs() -> None:
    """First order: omega^2 changes by the share of the energy in the springs, up and down."""
    e = 1e-4
    modes = stage(3.4e7, None).reduction.modes
    split = stage(3.4e7 * (1 + e), 3.4e7 * (1 - e)).reduction.modes
    pair = suspension_pair(modes)
    square, share = modes.frequency[pair] ** 2, modes.spring_share[pair]
    change = split.frequency[suspension_pair(split)] ** 2 / square - 1.0
    np.testing.assert_allclose(change, np.array([-e, e]) * share, rtol=1e-3)


def test_equal_springs_keep_the_cyclic_path() -> None:
    """Symmetry is found: the same stiffness twice is none that differs."""
    same, unequal = stage(2e7, 2e7), stage(2e7, 2.0001e7)
    assert same.reduction.modes.is_cyclic
    assert not unequal.reduction.modes.is_cyclic
    np.testing.assert_array_equal(
        same.reduction.modes.frequency, stage(2e7, None).reduction.modes.frequency
    )
    np.testing.assert_allclose(
        unequal.reduction.modes.frequency, same.reduction.modes.frequency, rtol=1e-4
    )


def test_modes_that_do_not_move_the_centre_stay() -> None:
    """All but those with one nodal diameter, by the dense path as by the cyclic one."""
    modes, split = stage(3.4e7, None).reduction.modes, stage(3.4e7, 1e7).reduction.modes
    for k in (0, 2, 3, 4):
        np.testing.assert_allclose(
            split.frequency[split.nodal_diameter == k],
            modes.frequency[modes.nodal_diameter == k],
            rtol=1e-9,
        )


def test_the_example_pulls_along_the_softer_spring() -> None:
    case = read_case(EXAMPLES / "unequal_shaft.toml")
    assert loads(dumps_case(case)) == case
    found = build_stage(case)
    assert derive(found).cyclic == {"bladed_disk": False, "casing": True}
    x, y = case.shaft.stiffnesses
    assert x < y
    # The static answer at the clearance speed closes the clearance where the tips go with the hub.
    speed = 0.95 * found.reference_frequency
    force = imbalance_force(found) * (speed / found.speed) ** 2
    assert force / x == pytest.approx(1e-3, rel=1e-3)

"""Shafts whose springs differ: turning with the bladed disk, and standing still."""

import numpy as np
import pytest
from places import EXAMPLES
from stages import SMALL, stage

from bladewhirl.models.case.file import read_case
from bladewhirl.models.modal.modes import suspension_pair
from bladewhirl.models.stage.beams import Beams
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.loads import imbalance_force
from bladewhirl.studies.runs.properties import stage_properties


def on_shaft(x: float, y: float | None, *more: str) -> Beams:
    """A small stage with these shaft springs."""
    other = () if y is None else (f"shaft.stiffness_y={y}",)
    return stage(*SMALL, f"shaft.stiffness={x}", *other, *more)


def test_a_force_at_the_centre_bends_its_own_spring() -> None:
    """Nothing else stands on the ground: F / k along each axis, and none across."""
    rotor = on_shaft(3.4e7, 1.1e7).rotor
    flexible = rotor.centre / rotor.frequency**2 @ rotor.centre.T
    np.testing.assert_allclose(flexible, np.diag([1 / 3.4e7, 1 / 1.1e7]), rtol=1e-9, atol=1e-17)


def test_the_suspension_pair_parts_by_its_share_in_the_springs() -> None:
    """First order: omega^2 changes by the share of the energy in the springs, up and down."""
    e = 1e-4
    modes = on_shaft(3.4e7, None).reduction.modes
    split = on_shaft(3.4e7 * (1 + e), 3.4e7 * (1 - e)).reduction.modes
    pair = suspension_pair(modes)
    square, share = modes.frequency[pair] ** 2, modes.spring_share[pair]
    change = split.frequency[suspension_pair(split)] ** 2 / square - 1.0
    np.testing.assert_allclose(change, np.array([-e, e]) * share, rtol=1e-3)


def test_equal_springs_keep_the_cyclic_path() -> None:
    """Symmetry is found; blades alike on a shaft that is not round are no blades that differ."""
    same, unequal = on_shaft(2e7, 2e7), on_shaft(2e7, 2.0001e7)
    assert same.reduction.modes.is_cyclic
    assert not unequal.reduction.modes.is_cyclic
    messages = "6 equal sectors on springs that differ: dense path"
    assert unequal.symmetry["bladed_disk"] == messages
    np.testing.assert_array_equal(
        same.reduction.modes.frequency, on_shaft(2e7, None).reduction.modes.frequency
    )
    np.testing.assert_allclose(
        unequal.reduction.modes.frequency, same.reduction.modes.frequency, rtol=1e-4
    )


def test_modes_that_do_not_move_the_centre_stay() -> None:
    """All but those with one nodal diameter, by the dense path as by the cyclic one."""
    modes, split = on_shaft(3.4e7, None).reduction.modes, on_shaft(3.4e7, 1e7).reduction.modes
    for k in (0, 2, 3):
        np.testing.assert_allclose(
            split.frequency[split.nodal_diameter == k],
            modes.frequency[modes.nodal_diameter == k],
            rtol=1e-9,
        )


def test_the_example_pulls_along_the_softer_spring() -> None:
    case = read_case(EXAMPLES / "unequal_shaft.toml")
    actual = build_beams(case)
    assert stage_properties(actual)["cyclic"] == {"bladed_disk": False, "casing": True}
    x, y = case.shaft.stiffnesses
    assert x < y
    # The static answer at the clearance speed closes the clearance where the tips go with the hub.
    speed = 0.95 * actual.reference_frequency
    force = imbalance_force(actual) * (speed / actual.speed) ** 2
    assert force / x == pytest.approx(1e-3, rel=1e-3)


def test_bearings_keep_the_mean_in_the_modes() -> None:
    """And the cyclic path: what swings comes in the march alone."""
    actual = on_shaft(3e7, 1e7, "shaft.frame=static")
    assert actual.reduction.modes.is_cyclic
    assert actual.rotor.anisotropy == 1e7
    np.testing.assert_array_equal(actual.rotor.frequency, on_shaft(2e7, None).rotor.frequency)
    held = on_shaft(3e7, 1e7, "shaft.frame=static", "shaft.clamped=true")
    assert held.rotor.anisotropy == 0.0
    assert on_shaft(2e7, None).rotor.anisotropy == 0.0

"""Stages that the points of a sweep share, and those that they may not."""

import pytest
from numpy.testing import assert_array_equal

import bladewhirl as bw
from bladewhirl.studies.sweeps.points import stage_at


@pytest.mark.parametrize("effects", ["none", "centrifugal"])
def test_a_stage_is_that_of_the_speed_of_its_point(effects: str) -> None:
    slow, fast = (
        bw.case_from({"march": {"speed": speed}, "rotation": {"effects": effects}})
        for speed in (0.5, 1.5)
    )
    frequencies = [stage_at(case).arrays.rotor_frequency for case in (slow, fast)]
    for case, found in zip((slow, fast), frequencies, strict=True):
        assert_array_equal(found, bw.build_stage(case).arrays.rotor_frequency)
    assert (frequencies[0] == frequencies[1]).all() == (effects == "none")

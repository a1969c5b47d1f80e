"""Shaft springs sized for the suspension's frequency."""

import re

import numpy as np
import pytest
from stages import SMALL, stage

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import loads, with_values
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.modal.suspension import KEY, with_sized_shaft
from bladewhirl.models.stage.modal import modal_model


@pytest.mark.parametrize("wanted", [60.0, 150.0, 400.0])
def test_the_suspension_is_where_it_is_wanted(wanted: float) -> None:
    modes = modal_model(with_values(Case(), {KEY: wanted})).disks["free"].labelled
    pair = modes.frequency[modes.find("suspension", 1)] / (2.0 * np.pi)
    np.testing.assert_allclose(pair, wanted, rtol=1e-9)


def test_the_paper_s_springs_come_back() -> None:
    """The frequency that 34 MN/m give asks for 34 MN/m."""
    modes = modal_model(Case()).disks["free"].labelled
    actual = float(modes.frequency[modes.find("suspension", 1)[0]] / (2.0 * np.pi))
    shaft = with_sized_shaft(with_values(Case(), {KEY: actual})).shaft
    assert shaft.stiffness == pytest.approx(Case().shaft.stiffness, rel=1e-8)


def test_a_stage_has_the_stiffness_found() -> None:
    """A force at the centre bends the springs by F / k, and results tell k."""
    built = stage(*SMALL, f"{KEY}=120 Hz")
    stiffness = built.case.shaft.stiffness
    rotor = built.rotor
    flexible = rotor.centre / rotor.frequency**2 @ rotor.centre.T
    np.testing.assert_allclose(flexible, np.eye(2) / stiffness, rtol=1e-9, atol=1e-17)
    np.testing.assert_array_equal(built.arrays.shaft_stiffness, stiffness)


@pytest.mark.slow
def test_where_families_repel_no_springs_do() -> None:
    """Between modes that a family and the suspension exchange; limits named are within reach."""
    small = loads("", overrides=SMALL)
    with pytest.raises(CaseError, match=r"at most [\d.]+ Hz or at least") as error:
        with_sized_shaft(with_values(small, {KEY: 45.0}))
    below, above = map(float, re.findall(r"([\d.]+) Hz", str(error.value)))
    assert below < 45.0 < above
    for limit in (0.995 * below, 1.005 * above):
        with_sized_shaft(with_values(small, {KEY: limit}))


def test_what_rounding_hides_is_refused() -> None:
    with pytest.raises(CaseError, match="a frequency above the rounding error"):
        with_sized_shaft(loads("", overrides=[*SMALL, f"{KEY}=1e-3"]))


def test_springs_replace_a_frequency_and_the_reverse() -> None:
    asked = with_values(Case(), {KEY: 300.0})
    given = with_values(asked, {"shaft.stiffness": 1e7}).shaft
    assert (given.stiffness, given.suspension_frequency) == (1e7, None)
    assert with_values(Case(), {"shaft.stiffness": 1e7, KEY: None}).shaft == given
    text = 'shaft.stiffness = "10 MN/m"'
    assert loads(text, overrides=[f"{KEY}=300 Hz"]).shaft == asked.shaft


def test_springs_are_given_once() -> None:
    with pytest.raises(CaseError, match=r"not allowed together with shaft\.stiffness"):
        with_values(Case(), {KEY: 300.0, "shaft.stiffness": 1e7})


def test_springs_that_are_the_default_are_springs_too() -> None:
    both = '[shaft]\nstiffness = "34 MN/m"\nsuspension_frequency = "300 Hz"'
    with pytest.raises(CaseError, match=r"not allowed together with shaft\.stiffness"):
        loads(both)


def test_a_case_is_written_with_the_springs_it_was_given() -> None:
    asked = with_values(Case(), {KEY: 300.0})
    assert "\nstiffness" not in dumps_case(asked).partition("[shaft]")[2].partition("\n[")[0]
    assert loads(dumps_case(asked)) == asked

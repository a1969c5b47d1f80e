"""Large stages say what they take before they are assembled; what the machine can't hold waits."""

import logging

import pytest

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.elements import cost
from bladewhirl.models.elements.build import case_bladed_disk
from bladewhirl.models.elements.cost import (
    DENSE_BYTES,
    DENSE_SECONDS,
    DIAMETER_SECONDS,
    MODAL_BYTES,
    MODAL_SECONDS,
    modal_cost,
    stage_cost,
    tell_cost,
)
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.modal import modal_model


def large(blades: int, elements: int) -> Case:
    disk = {"bladed_disk.blades": blades, "bladed_disk.elements_per_blade": elements}
    return with_values(Case(), disk)


def disk(case: Case) -> Structure:
    return case_bladed_disk(case, clamped=False).structure


@pytest.mark.parametrize(("blades", "elements"), [(22, 1000)])
def test_what_is_large_is_told(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch, blades: int, elements: int
) -> None:
    monkeypatch.setattr(cost, "memory", lambda: 64e9)
    with caplog.at_level(logging.WARNING):
        tell_cost(stage_cost(large(blades, elements)))
    [record] = caplog.records
    assert record.getMessage().startswith("Large stage: 66")
    assert "GB of memory and some" in record.getMessage()


def test_what_is_usual_is_not(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        tell_cost(stage_cost(Case()))
        tell_cost(stage_cost(large(100, 10)))
    assert not caplog.records


@pytest.mark.slow
def test_what_the_machine_cannot_hold_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    case = large(600, 10)
    needed = stage_cost(case)
    monkeypatch.setattr(cost, "memory", lambda: 0.99 * needed.memory)
    with pytest.raises(UserError, match=r"^bladed_disk: expected a smaller stage: 198\d+ degrees"):
        tell_cost(needed)


@pytest.mark.slow
def test_modes_of_blades_that_differ_cost_the_square_of_the_whole(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    alike = large(200, 20)
    differing = with_values(alike, {"bladed_disk.mistuning.stiffness_spread": 0.01})
    one, all_at_once = (modal_cost(disk(case)) for case in (alike, differing))
    assert one.dofs == one.modes == all_at_once.dofs == 200 * 63 + 2
    assert one.memory == MODAL_BYTES * 101 * 63**2
    assert one.time == pytest.approx(101 * (MODAL_SECONDS * 63**3 + DIAMETER_SECONDS))
    assert all_at_once.memory == DENSE_BYTES * one.dofs**2
    assert all_at_once.time == pytest.approx(DENSE_SECONDS * one.dofs**3, rel=1e-5)
    monkeypatch.setattr(cost, "memory", lambda: 0.99 * all_at_once.memory)
    with pytest.raises(UserError, match=r"^bladed_disk: expected a smaller stage: 12602 degrees"):
        modal_model(differing)

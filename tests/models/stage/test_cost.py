"""Large stages say what they take before they are assembled; what the machine can't hold waits."""

from __future__ import annotations

import logging

import pytest

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage import cost
from bladewhirl.models.stage.cost import stage_cost, tell_cost


def large(blades: int, elements: int) -> Case:
    disk = {"bladed_disk.blades": blades, "bladed_disk.elements_per_blade": elements}
    return with_values(Case(), disk)


@pytest.mark.parametrize(("blades", "elements"), [(22, 1000), (2000, 10)])
def test_what_is_large_is_told(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch, blades: int, elements: int
) -> None:
    monkeypatch.setattr(cost, "memory", lambda: 64e9)
    with caplog.at_level(logging.WARNING):
        tell_cost(large(blades, elements))
    [record] = caplog.records
    assert record.getMessage().startswith("Large stage: 66")
    assert "GB of memory and some" in record.getMessage()


def test_what_is_usual_is_not(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        tell_cost(Case())
        tell_cost(large(100, 10))
    assert not caplog.records


def test_what_the_machine_cannot_hold_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    case = large(5000, 10)
    needed = stage_cost(case).memory
    monkeypatch.setattr(cost, "memory", lambda: 0.99 * needed)
    with pytest.raises(UserError, match=r"^bladed_disk: expected a smaller stage: 165\d+ degrees"):
        tell_cost(case)

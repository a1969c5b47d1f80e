"""The table of studies and kinds of stages in the documentation."""

import pytest
import trials
from long_cases import slow_except

ALL = {*trials.ROWS}
NOT_ROUND = "`periodic`, wall that is not round"


@pytest.mark.parametrize(
    ("kind", "expected"),
    slow_except(
        [
            ("beams", ALL - {NOT_ROUND}),
            (
                "copies of a blade",
                {"`campbell`", NOT_ROUND, "with `[blade_loss]`", "with `march.drive`"},
            ),
            ("sector", {"`campbell`", "with `bladed_disk.mistuning`", "with `march.speed_table`"}),
            ("wheel", {"`campbell`", "with `bladed_disk.mistuning`", "with `march.speed_table`"}),
            ("wheel with a hub", {"`critical-speeds`", "`veering`", "`periodic`, imbalance"}),
            ("shaft line", {"`campbell`", "`critical-speeds`", "with `march.speed_table`"}),
        ],
        ("beams", ALL - {NOT_ROUND}),
    ),
)
def test_studies_are_tried_with_stages_that_they_can_take(kind: str, expected: set[str]) -> None:
    assert trials.taken_by(kind) >= expected | {"`modes`", "`response`"}


def test_a_stage_that_cannot_be_taken_is_refused() -> None:
    assert trials.taken_by("shaft line").isdisjoint({"`veering`", "`convergence`"})

"""The table of studies and kinds of stages in the documentation."""

import pytest
import trials

ALL = {*trials.ROWS}
NOT_ROUND = "`periodic`, wall that is not round"


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ("beams", ALL - {NOT_ROUND}),
        pytest.param(
            "copies of a blade",
            {"`campbell`", NOT_ROUND, "with `[blade_loss]`", "with `march.drive`"},
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "sector",
            {"`campbell`", "with `bladed_disk.mistuning`", "with `march.speed_table`"},
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "wheel",
            {"`campbell`", "with `bladed_disk.mistuning`", "with `march.speed_table`"},
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "wheel with a hub",
            {"`critical-speeds`", "`veering`", "`periodic`, imbalance"},
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "shaft line",
            {"`campbell`", "`critical-speeds`", "with `march.speed_table`"},
            marks=pytest.mark.slow,
        ),
    ],
)
def test_studies_are_tried_with_stages_that_they_can_take(kind: str, expected: set[str]) -> None:
    assert trials.taken_by(kind) >= expected | {"`modes`", "`response`"}


def test_a_stage_that_cannot_be_taken_is_refused() -> None:
    assert trials.taken_by("shaft line").isdisjoint({"`veering`", "`convergence`"})

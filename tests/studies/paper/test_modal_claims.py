"""What the source paper says of uncoupled modes, computed for the fan stage (claims 1 to 9)."""

from functools import cache
from typing import Any

import pytest

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.studies.modal.scenarios import whirling_modes
from bladewhirl.studies.paper.modal_numbers import modal_measures


@cache
def measures() -> dict[str, Any]:
    case = Case()
    return modal_measures(case, modal_model(case))


@pytest.mark.parametrize(
    ("name", "value", "tolerance"),
    [
        ("centre_one", 0.975, 0.001),  # the suspension pair
        ("centre_others", 0.0, 1e-8),
        ("shift_others", 0.0, 1e-7),
        ("suspension", 2.527, 5e-4),
        ("shaft_over_blade", 590.1, 0.1),
        ("size", 156, 0),
        ("error_4F", 0.2226, 1e-4),
        ("error_5F", 0.79, 0.01),  # the paper has less than 0.75 % in five families
        ("first_coincidence", 1.055, 5e-4),
        ("suspension_coincidence", 2.582, 5e-4),
        ("standard_lead", 0.0, 1e-7),
        ("inverted_lead", 180.0, 1e-7),
    ],
)
def test_numbers_of_the_fan_stage(name: str, value: float, tolerance: float) -> None:
    assert measures()[name] == pytest.approx(value, abs=tolerance)


def test_claims_on_uncoupled_modes() -> None:
    numbers = measures()
    assert numbers["shift_one"] > 10.0
    assert 1.03 < numbers["suspension"] < numbers["second_family"]
    # 0.83, 0.94 and 1.12 for k = 2, 3, 4 with exact strains and a wall of 10 mm.
    expected = "k = 1 at 1.06, k = 2 at 0.832, k = 3 at 0.94, k = 4 at 1.12"
    assert numbers["crossing_speeds"] == expected
    assert (numbers["standard"], numbers["inverted"]) == ("standard", "inverted")


@pytest.mark.slow
def test_5_with_one_section_for_every_beam() -> None:
    """Known from an independent reduction, in per cent."""
    case = with_values(Case(), {"bladed_disk.disk.thickness": 0.01})
    table_1 = modal_measures(case, modal_model(case))
    expected = {"1F": 0.0002, "suspension": 0.016, "2F": 0.022, "3F": 0.10, "4F": 0.26, "5F": 1.01}
    for family, value in expected.items():
        assert table_1["errors"][family] == pytest.approx(value, rel=0.1), family
    assert table_1["suspension"] == pytest.approx(3.056, abs=5e-4)


@pytest.mark.parametrize("share", [0.0, 0.6, 1.7])
def test_modes_in_step_just_close_the_clearance(share: float) -> None:
    modes = whirling_modes(modal_model(Case()), casing_share=share)
    assert abs(modes.rotor - modes.casing) == pytest.approx(1e-3)
    assert modes.casing == pytest.approx(share * modes.rotor)
    assert modes.speed == pytest.approx(1.055 * modes.frequency, rel=1e-4)
    # Blades are stiff along their span: the tips follow the shaft.
    assert modes.shaft == pytest.approx(modes.rotor, rel=0.01)

"""Abradable coating: the compiled march against the reference, convergence, and refusals."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contact_cases import small_problem, thrown

from bladewhirl.models.case.coating import Coating, WornProfile
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.modal.describe import stage_arrays
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import CoatingRecords

STEP = 2e-6
COATING: dict[str, Any] = {
    "thickness": 5e-3,
    "young_modulus": 1e9,
    "yield_stress": 1e6,
    "hardening": 5e7,
}


def problem(coating: dict[str, Any], **tables: Any) -> ContactProblem:
    """Return a small stage with a coating, whose tips start towards the casing."""
    given = small_problem(casing={"coating": COATING | coating}, **tables)
    return thrown(given, 40.0, spread=0.5)


def worn(given: ContactProblem, dt: float, time: float) -> CoatingRecords:
    scheme = CentralDifference(given, dt, round(time / dt))
    _, chunk, _ = scheme.advance(scheme.init(), round(time / dt) + 1)
    assert chunk.coating is not None
    return chunk.coating


def test_a_halved_step_and_halved_rods_change_the_volume_by_less_than_a_percent() -> None:
    coarse = worn(problem({"elements": 1260}), 1e-6, 1e-3).wear_volume[-1]
    assert coarse > 0.0
    assert worn(problem({"elements": 1260}), 5e-7, 1e-3).wear_volume[-1] == pytest.approx(
        coarse, rel=0.01
    )
    assert worn(problem({"elements": 2520}), 1e-6, 1e-3).wear_volume[-1] == pytest.approx(
        coarse, rel=0.01
    )


def test_a_march_that_continues_from_the_worn_profile_removes_little_at_the_same_depth() -> None:
    given = problem({})
    first = worn(given, STEP, 1e-3)
    assert given.coating is not None
    again = replace(given, coating=replace(given.coating, strain=first.coating_strain[-1]))
    second = worn(again, STEP, 1e-3)
    assert second.wear_volume[-1] < 0.1 * first.wear_volume[-1]


def test_a_profile_of_the_rods_is_read_back_exactly() -> None:
    angle = np.asarray(2.0 * np.pi / 100 * (np.arange(100) + 0.5))
    depth = 1e-3 * np.random.default_rng(1).random(100)
    profile = WornProfile(points=tuple(zip(angle.tolist(), depth.tolist(), strict=True)))
    np.testing.assert_array_equal(profile.recess(angle), depth)
    lobes = WornProfile.model_validate({"lobes": [{"lobes": 3, "amplitude": 1e-3}]})
    np.testing.assert_allclose(lobes.recess(np.array([0.0, np.pi / 3])), [1e-3, 0.0], atol=1e-18)


def test_hardening_follows_from_the_tangent_modulus() -> None:
    plain = Coating(thickness=1e-3, young_modulus=1e9, yield_stress=1e6, tangent_modulus=2e8)
    assert plain.slope == pytest.approx(1e9 * 2e8 / 8e8)


@pytest.mark.parametrize(
    ("coating", "message"),
    [
        ({"thickness": -1e-3}, r"coating.thickness = -0.001: expected a positive number"),
        ({"thickness": 1.0}, "coating.thickness = .*: expected less than the radius of the tips"),
        ({"limit": 1.2}, r"coating.limit = 1.2: expected a number above 0 and up to 1"),
        ({"tangent_modulus": 1e6}, "tangent_modulus = .*: expected either hardening or"),
        ({"profile": {"points": [[0, 1e-3]] * 3}}, "profile.points = .*: expected 8 to"),
        (
            {"profile": {"lobes": [{"lobes": 2, "amplitude": 4.6e-3}]}},
            "a removed depth up to limit",
        ),
    ],
)
def test_a_coating_that_makes_no_sense(coating: dict[str, Any], message: str) -> None:
    with pytest.raises(CaseError, match=message):
        problem(coating)


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"march": {"time_step": 2e-5}}, "march.time_step = .*: expected less than"),
        ({"march": {"time_step": 2e-6, "speed": 9.0}}, "elements = .*: expected at most"),
    ],
)
def test_a_march_that_a_coating_does_not_allow(tables: dict[str, Any], message: str) -> None:
    with pytest.raises(CaseError, match=message):
        problem({"elements": 4000, "young_modulus": 1e11}, **tables)


def test_tips_that_end_no_beam_need_a_footprint(monkeypatch: pytest.MonkeyPatch) -> None:
    def loose(*given: Any, **walls: Any) -> StageArrays:
        return replace(stage_arrays(*given, **walls), tip_node=np.full(5, -1))

    monkeypatch.setattr("bladewhirl.models.stage.beams.stage_arrays", loose)
    with pytest.raises(CaseError, match=r"coating.footprint.*: expected a length, because"):
        problem({})
    assert problem({"footprint": 0.01}).coating is not None

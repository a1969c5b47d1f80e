"""The drawback of tips in a result, against the quadratic form of the march."""

import pytest
from places import EXAMPLES

from bladewhirl.models.case.file import read_case
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.postprocess.fields.drawback import largest_drawback
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory


def test_the_drawback_of_a_result_is_that_of_the_march() -> None:
    changes = ["contact.foreshortening=true", "march.duration=2 ms", "excitation.amplitude=1e4"]
    case = read_case(EXAMPLES / "abradable_coating.toml", [*changes, "excitation.ramp=0"])
    result, _ = march_in_memory(prepare(case))
    given = contact_problem(build_stage(case)).foreshortening
    assert given is not None
    exact = given.opening(result["rotor_displacement"].values).max()
    assert exact > 1e-6
    assert largest_drawback(result) == pytest.approx(exact, rel=1e-6)

"""The drawback of tips in a result, against the quadratic form of the march."""

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from places import EXAMPLES

import bladewhirl as bw
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.foreshortening import Foreshortening
from bladewhirl.postprocess.fields.blades import line_blades
from bladewhirl.postprocess.fields.drawback import largest_drawback
from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory


@pytest.mark.slow
def test_the_drawback_of_a_result_is_that_of_the_march() -> None:
    changes = ["contact.foreshortening=true", "march.duration=2 ms", "excitation.amplitude=1e4"]
    case = bw.read_case(EXAMPLES / "abradable_coating.toml", [*changes, "excitation.ramp=0"])
    result, _ = march_in_memory(prepare(case))
    given = contact_problem(bw.build_stage(case)).foreshortening
    assert given is not None
    exact = given.opening(result["rotor_displacement"].values).max()
    assert exact > 1e-6
    assert largest_drawback(result) == pytest.approx(exact, rel=1e-6)


FACTOR = 7.0


def bent(*changes: str) -> tuple[xr.Dataset, Foreshortening]:
    """Return a result of a small stage with bent blades, and the quadratic form of the march."""
    small = ["bladed_disk.blades=5", "casing.elements=12", "reduction.fixed_interface_modes=10"]
    march = ["march.time_step=2e-6", "march.record_step=2e-6", "march.duration=0.4 ms"]
    start = "initial.tip_displacement=[[0, 0.03], [0, 0.02], [0, 0.01], [0, 0], [0, -0.01]]"
    on = ["contact.foreshortening=true", start]
    case = bw.read_case(EXAMPLES / "fan_stage.toml", [*small, *march, *on, *changes])
    result, _ = march_in_memory(prepare(case))
    given = contact_problem(bw.build_stage(case)).foreshortening
    assert given is not None
    return result.assign_attrs(case=bw.dumps_case(case)), given


def enlarged(result: xr.Dataset, records: list[int]) -> EnlargedStage:
    return EnlargedStage(result, np.array(records), factor=FACTOR, pieces=4, per_element=40)


def radii(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.linalg.norm(points, axis=-1))


@pytest.mark.parametrize("around", [False, True])
def test_tips_are_drawn_back_by_the_opening_of_the_gap(around: bool) -> None:
    """The drawn drawback is the opening of the march, enlarged as all displacements are."""
    records = [0, 50, 199]
    result, given = bent(f"contact.tip_rotation={str(around).lower()}")
    opening = given.opening(result["rotor_displacement"].values[records])
    assert opening.max() > 2e-4
    stage, straight = (enlarged(each, records) for each in (result, result.assign_attrs(case="")))
    tip, lines = result["tip_node"].values, result["rotor_line"].values
    blade = np.unique(lines[line_blades(result) == 0])
    blade = blade[np.argsort(radii(result["rotor_point"].values[blade]))]
    for index, opened in enumerate(opening):
        places = [each.points(index) for each in (straight, stage)]
        drawn = radii(places[0]) - radii(places[1])
        along = stage.body.stations(drawn)
        np.testing.assert_allclose(drawn[tip], FACTOR * opened, rtol=1e-4, atol=1e-9)
        np.testing.assert_allclose(along[:, [0, -1]], drawn[lines], atol=1e-15)
        assert (np.diff(drawn[blade]) > 0.0).all()  # from root to tip


def test_the_largest_drawback_is_the_largest_opening_along_the_blades() -> None:
    result, given = bent("contact.tip_rotation=false")
    exact = given.opening(result["rotor_displacement"].values).max()
    assert exact > 2e-4
    assert largest_drawback(result) == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("around", [False, True])
def test_the_drawn_gap_is_the_recorded_gap(around: bool) -> None:
    """Without foreshortening in the picture, the gap of the first blade would be wrong by 20 %."""
    result, _ = bent(f"contact.tip_rotation={str(around).lower()}")
    stage = enlarged(result, [0])
    tips, wall = stage.contact_nodes(0), stage.wall(0)[:, 0]
    angle = np.arctan2(tips[:, 1], tips[:, 0]) + stage.turns[0]
    facing = np.interp(angle, np.arctan2(wall[:, 1], wall[:, 0]), radii(wall), period=2 * np.pi)
    gap = (facing - radii(tips)) / FACTOR
    np.testing.assert_allclose(gap, result["gap"].values[0], atol=1e-8)
    assert np.ptp(gap) > 2e-4

"""Symbols of springs, supports and masses: where they stand and what they follow."""

from typing import Any

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.pictures.drawing import Drawing, Picture
from bladewhirl.postprocess.pictures.symbols import BESIDE, FOUNDATION, HATCHES, TEETH

R = synthetic.TIP_RADIUS
ZIGZAG, GROUND = TEETH + 1, HATCHES + 1  # strokes of one
SHAFT = 2  # springs of the shaft


def supported(**motion: Any) -> xr.Dataset:
    """A result with a radial spring at 0, a tangential one at 90 degrees, a strut at 180."""
    result = synthetic.resting(**motion)
    each = {
        "support_kind": np.array(["spring", "spring", "strut"]),
        "support_angle": np.pi / 2 * np.arange(3),
        "support_radial_stiffness": np.array([1e6, 0.0, 2e6]),
        "support_tangential_stiffness": np.array([0.0, 1e6, 0.0]),
    }
    return result.assign({name: ("support", values) for name, values in each.items()}).assign(
        support_reach=(("support", "axis"), np.array([[0, 0], [0, 0], [-0.1, 0.05]])),
        mass_node=("mass", result["tip_node"].values[[0, 11]]),
        point_mass=("mass", [0.1, 0.1]),
    )


def picture(result: xr.Dataset, factor: float = 20.0) -> Picture:
    return Drawing(result, np.array([0]), exaggeration=factor).picture(0)


def outer(result: xr.Dataset, angle: float, factor: float = 20.0) -> Array:
    """Place of the wall's outer surface at rest, as drawn."""
    radius = R + factor * synthetic.CLEARANCE + 0.010
    return radius * np.array([np.cos(angle), np.sin(angle)])


def test_springs_lead_from_the_wall_outward_and_along() -> None:
    result = supported()
    springs = picture(result).symbols.springs.reshape(-1, ZIGZAG, 2, 2)
    assert len(springs) == 2 + SHAFT
    start, end = springs[:, 0, 0], springs[:, -1, 1]
    np.testing.assert_allclose(start[0], outer(result, 0.0), atol=1e-9)
    way = (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
    np.testing.assert_allclose(way[:2], [[1, 0], [-1, 0]], atol=1e-12)
    assert np.linalg.norm(start[1]) > np.linalg.norm(outer(result, np.pi / 2))
    np.testing.assert_allclose(start[2:], 0.0, atol=1e-12)


def test_a_strut_has_its_length_and_every_end_its_ground() -> None:
    result = supported()
    seen = picture(result).symbols
    strut = seen.struts[-1]
    np.testing.assert_allclose(strut[0], outer(result, np.pi), atol=1e-9)
    np.testing.assert_allclose(strut[1] - strut[0], [-0.1, 0.05])
    ground = seen.ground.reshape(-1, GROUND, 2, 2)
    assert len(ground) == 3 + SHAFT
    np.testing.assert_allclose(ground[2, 0].mean(axis=0), strut[1])


def test_feet_move_and_the_ground_stands_clear_of_the_casing() -> None:
    rest, moved = (
        picture(
            supported(casing_displacement=(shift, 0, 0, 0), rotor_displacement=(0, shift, 0, 0, 0))
        ).symbols
        for shift in (0.0, 5e-4)
    )
    start, end = (s.springs.reshape(-1, ZIGZAG, 2, 2)[:, [0, -1], [0, 1]] for s in (rest, moved))
    np.testing.assert_allclose((end - start)[:2, 0], [[0.01, 0.0]] * 2, atol=1e-6)
    np.testing.assert_allclose((end - start)[:2, 1], [[0.01, 0.0], [0.0, 0.0]], atol=1e-6)
    np.testing.assert_allclose((end - start)[2:, 0], [[0.0, 0.01]] * 2, atol=1e-9)
    ground = (moved.ground - rest.ground).reshape(-1, GROUND, 2, 2)
    np.testing.assert_allclose(ground[0] - [0.01, 0.0], 0.0, atol=1e-6)
    np.testing.assert_allclose(ground[1:], 0.0, atol=1e-9)
    np.testing.assert_allclose(moved.masses - rest.masses, [[0.0, 0.01]] * 2, atol=1e-9)


def test_a_uniform_support_is_spread_around() -> None:
    result = synthetic.synthetic_result(records=1).assign(casing_foundation=((), 1e6))
    springs = picture(result).symbols.springs.reshape(-1, ZIGZAG, 2, 2)
    assert len(springs) == FOUNDATION + SHAFT
    foot = springs[:FOUNDATION, 0, 0]
    turned = np.unwrap(np.arctan2(foot[:, 1], foot[:, 0]))
    np.testing.assert_allclose(np.diff(turned), 2 * np.pi / FOUNDATION, rtol=0.05)


def test_springs_and_links_of_the_rotor_join_its_nodes() -> None:
    plain = synthetic.resting(records=1)
    tips = plain["tip_node"].values
    result = plain.assign(
        rotor_spring=(("rotor_spring", "end"), np.array([[tips[0], tips[1]], [tips[5], -1]])),
        rotor_link=(("rotor_link", "end"), np.array([[tips[3], 0]])),
    )
    seen = picture(result).symbols
    points = result["rotor_point"].values
    springs = seen.springs.reshape(-1, ZIGZAG, 2, 2)[SHAFT:]
    np.testing.assert_allclose(springs[0, 0, 0], points[tips[5]])
    assert np.linalg.norm(springs[0, -1, 1]) > R
    np.testing.assert_allclose(springs[1, [0, -1], [0, 1]], points[tips[:2]])
    np.testing.assert_allclose(seen.struts[0], points[[0, tips[3]]], atol=1e-12)


DASHPOT = 6  # strokes of a damper


def damped(result: xr.Dataset) -> xr.Dataset:
    """A damper in every support and one along the shaft's x."""
    return result.assign(
        support_radial_damping=("support", np.array([1e3, 0.0, 5e2])),
        support_tangential_damping=("support", np.array([0.0, 1e3, 5e2])),
        shaft_stiffness=("axis", np.array([3e7, 4e7])),
        shaft_damping=("axis", np.array([1e3, 0.0])),
        shaft_frame=((), "rotating"),
    )


def test_a_damper_stands_beside_its_spring_and_leads_the_same_way() -> None:
    seen = picture(damped(supported())).symbols
    dampers = seen.dampers.reshape(-1, DASHPOT, 2, 2)
    start, end = dampers[:, 0, 0], dampers[:, -1, 1]
    assert len(dampers) == 3 + 1
    way = (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
    strut = np.array([-0.1, 0.05])
    expected = [[1, 0], [-1, 0], strut / np.linalg.norm(strut), [-1, 0]]
    np.testing.assert_allclose(way, expected, atol=1e-9)
    np.testing.assert_allclose(end[2] - start[2], strut)
    springs = seen.springs.reshape(-1, ZIGZAG, 2, 2)[:2, 0, 0]
    aside = np.linalg.norm(np.vstack([springs, [seen.struts[-1, 0]]]) - start[:3], axis=1)
    wall = np.linalg.norm(outer(supported(), 0.0))
    np.testing.assert_allclose(aside, BESIDE * np.array([wall, R, wall]), rtol=0.1)
    assert len(seen.ground.reshape(-1, GROUND, 2, 2)) == 3 + 3 + SHAFT + 1


@pytest.mark.parametrize("stand", ["rotating", "static"])
@pytest.mark.parametrize("frame", ["rotating", "static"])
def test_bearings_that_stand_still_do_so_in_pictures(stand: str, frame: str) -> None:
    """In their own frame they don't turn between two records; in the other by the rotor's angle.
    Dampers turn with the bladed disk always."""
    result = damped(supported()).assign(shaft_frame=((), stand))
    first, later = (
        Drawing(result, np.array([record]), exaggeration=20.0, frame=frame).picture(0).symbols  # type: ignore[arg-type]
        for record in (0, 1)
    )
    springs = len(supported()["support"]) - 1  # those of the casing come first
    angle = synthetic.SPEED * synthetic.RECORD_STEP

    def turned(before: Array, after: Array, strokes: int) -> float:
        way = [shape.reshape(-1, strokes, 2, 2)[:, -1, 1] for shape in (before, after)]
        turns = [np.arctan2(each[:, 1], each[:, 0]) for each in way]
        return float(np.mod(turns[1] - turns[0] + np.pi, 2 * np.pi).mean() - np.pi)

    shaft = slice(springs * ZIGZAG, None)
    by_springs = turned(first.springs[shaft], later.springs[shaft], ZIGZAG)
    by_damper = turned(first.dampers[-DASHPOT:], later.dampers[-DASHPOT:], DASHPOT)
    sign = {"static": 1.0, "rotating": -1.0}[frame]
    assert by_springs == pytest.approx(0.0 if stand == frame else sign * angle, abs=1e-9)
    assert by_damper == pytest.approx(0.0 if frame == "rotating" else angle, abs=1e-9)

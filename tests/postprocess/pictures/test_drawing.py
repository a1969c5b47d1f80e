"""The geometry of pictures: true about contact and thickness at any exaggeration."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.fields.enlarged import magnify, round_factor
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.pictures.drawing import Drawing, arrows

FACTOR = 40.0
SAGITTA = 0.010**2 / 8 / 0.25 * 1.5  # of a blade's end, which is cut along the wall [m]


def draw(result: xr.Dataset, *, record: int = 0, exaggeration: float = FACTOR) -> Drawing:
    return Drawing(result, np.array([record]), exaggeration=exaggeration)


def distance_to(line: Array, points: Array) -> Array:
    """Smallest distance of each point to a closed polyline."""
    start, end = line[:-1], line[1:]
    along = end - start
    share = np.einsum("psi,si->ps", points[:, None] - start, along) / np.sum(along**2, axis=1)
    foot = start + np.clip(share, 0, 1)[..., None] * along
    nearest: Array = np.linalg.norm(points[:, None] - foot, axis=-1).min(axis=1)
    return nearest


class TestMagnify:
    points = np.array([[0.0, 0.0], [0.2, 0.0], [0.0, -0.3]])

    def test_a_small_rotation_becomes_a_large_one(self) -> None:
        small = 0.01 * np.column_stack([-self.points[:, 1], self.points[:, 0]])
        drawn = magnify(self.points, small, np.zeros(2), 100.0)
        cos, sin = np.cos(1.0), np.sin(1.0)
        turned = self.points @ np.array([[cos, sin], [-sin, cos]])
        np.testing.assert_allclose(drawn, turned, atol=1e-15)


class TestContact:
    def test_rest_shows_the_magnified_clearance(self) -> None:
        seen = draw(synthetic.resting()).picture(0)
        np.testing.assert_allclose(np.linalg.norm(seen.tips, axis=1), synthetic.TIP_RADIUS)
        inner = np.linalg.norm(seen.casing.sides[0, :, 0], axis=1)
        np.testing.assert_allclose(inner, synthetic.TIP_RADIUS + FACTOR * synthetic.CLEARANCE)

    @pytest.mark.parametrize("record", [0, 1])
    def test_a_shift_by_the_clearance_touches_in_one_point(self, record: int) -> None:
        angle = 2 * np.pi * 3 / 22  # towards blade 3, in rotating axes
        shift = synthetic.CLEARANCE * np.array([np.cos(angle), np.sin(angle)])
        seen = draw(synthetic.resting(rotor_displacement=[*shift, 0, 0, 0]), record=record).picture(
            0
        )
        gaps = distance_to(seen.casing.sides[0, :, 0], seen.tips)
        assert gaps[3] == pytest.approx(0.0, abs=1e-5)  # chords of the drawn circle
        assert np.all(np.delete(gaps, 3) > 0.02 * FACTOR * synthetic.CLEARANCE)
        inside = np.linalg.norm(seen.tips, axis=1)
        assert inside.max() <= synthetic.TIP_RADIUS + FACTOR * synthetic.CLEARANCE + 1e-12

    def test_a_bent_blade_swings_on_an_arc(self) -> None:
        seen = draw(synthetic.resting(rotor_displacement=[0, 0, 0, 2e-3, 0])).picture(
            0
        )  # 80 mm as drawn, on a radius of 250
        np.testing.assert_allclose(np.linalg.norm(seen.tips, axis=1), synthetic.TIP_RADIUS)
        swing = np.arctan2(seen.tips[0, 1], seen.tips[0, 0])
        assert swing == pytest.approx(FACTOR * 2e-3 / synthetic.TIP_RADIUS)

    def test_no_corner_of_a_blade_is_nearer_to_a_tilted_wall_than_its_tip(self) -> None:
        """A shift and an ovalisation tilt the drawn wall by up to 0.25 against the ends."""
        result = synthetic.resting(
            rotor_displacement=[1e-4, 0, 0, 0, 0], casing_displacement=[3e-4, 0, 4e-4, 3e-4]
        )
        for exaggeration in (1.0, FACTOR):
            seen = draw(result, exaggeration=exaggeration).picture(0)
            angle = np.arctan2(*np.moveaxis(seen.casing.sides[0, :, 0], -1, 0)[::-1])
            inner = np.linalg.norm(seen.casing.sides[0, :, 0], axis=-1)

            def gap(points: Array, angle: Array = angle, inner: Array = inner) -> Array:
                at = np.arctan2(points[..., 1], points[..., 0])
                wall = np.interp(at, angle, inner, period=2 * np.pi)
                return np.asarray(wall - np.linalg.norm(points, axis=-1))

            ends = np.flatnonzero(np.isin(result["rotor_line"].values[:, 1], result["tip_node"]))
            ends = ends[result["rotor_part"].values[ends] == "blades"]
            corners = seen.rotor.sides[ends, -1]
            np.testing.assert_allclose(gap(corners), gap(seen.tips)[:, None] + [0, 0], atol=2e-5)


class TestRibbons:
    result = synthetic.resting(
        rotor_displacement=[5e-4, -3e-4, 1e-3, 2e-3, 1e-3],
        casing_displacement=[2e-4, 0, 5e-4, 3e-4],
    )

    @pytest.mark.parametrize("exaggeration", [1.0, FACTOR])
    def test_thickness_is_true(self, exaggeration: float) -> None:
        seen = draw(self.result, exaggeration=exaggeration).picture(0)
        for ribbon, thickness in (
            (seen.rotor, self.result.rotor_thickness.values[:, None]),
            (seen.casing, 0.010),
        ):
            sides = ribbon.sides[:, 1:-1]  # the ends are cut or mitred
            across = sides[:, :, 1] - sides[:, :, 0]
            width = np.linalg.norm(across, axis=-1)
            np.testing.assert_allclose(width, np.broadcast_to(thickness, width.shape))
            along = np.diff(sides.mean(axis=2), axis=1)
            along /= np.linalg.norm(along, axis=-1)[..., None]
            middle = (across[:, 1:] + across[:, :-1]) / 2
            assert np.abs(np.sum(along * middle, axis=-1)).max() < 0.03 * width.min()


def test_rotating_picture_is_the_static_one_turned_back() -> None:
    result = synthetic.synthetic_result()
    record = np.array([int(np.argmax(result.contacts.values))])
    static, turning = (
        Drawing(result, record, frame=frame).picture(0) for frame in ("static", "rotating")
    )
    angle = synthetic.SPEED * float(result.time[record[0]])
    to_rotating = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]).T
    for mine, theirs in (
        (turning.rotor.sides, static.rotor.sides),
        (turning.casing.sides, static.casing.sides),
        (turning.tips, static.tips),
        (turning.shaft, static.shaft),
        (turning.mark, static.mark),
        (turning.forces, static.forces),
    ):
        np.testing.assert_allclose(mine, theirs @ to_rotating, atol=1e-12)
    assert turning.forces.any()
    blade = np.arctan2(turning.mark[1], turning.mark[0])
    assert abs(blade) < np.pi / 22  # the first blade lies near the rotating x axis


@pytest.mark.parametrize("growth", [0.0, 0.2e-3])
def test_a_short_blade_touches_where_it_does_in_the_run(growth: float) -> None:
    """Growth of a cold clearance leaves less room for all."""
    recess, blade = 0.3e-3, 5
    result = synthetic.resting()
    tip = int(result["tip_node"].values[blade])
    result["rotor_point"][tip] *= 1.0 - recess / synthetic.TIP_RADIUS
    unit = result["rotor_point"].values[tip] / (synthetic.TIP_RADIUS - recess)
    result["tip_recess"] -= growth
    result["tip_recess"][blade] += recess
    result["contact_radius"][blade] -= recess
    rest = draw(result).picture(0)
    inner = synthetic.TIP_RADIUS - growth + FACTOR * synthetic.CLEARANCE
    gaps = inner - np.linalg.norm(rest.tips, axis=1)
    expected = np.full(22, FACTOR * (synthetic.CLEARANCE - growth))
    expected[blade] += FACTOR * recess
    np.testing.assert_allclose(gaps, expected)
    np.testing.assert_allclose(draw(result).nodes[result["tip_node"].values], rest.tips)
    result["rotor_displacement"][:, :2] = (synthetic.CLEARANCE - growth + recess) * unit
    touching = draw(synthetic.with_moved_tips(result)).picture(0)
    assert np.linalg.norm(touching.tips[blade]) == pytest.approx(inner)
    lines = result["rotor_line"].values
    end = touching.rotor.sides.mean(axis=2)[np.flatnonzero(lines[:, 1] == tip)[0], -1]
    np.testing.assert_allclose(end, touching.tips[blade], atol=SAGITTA)


def test_reach_contains_all_points() -> None:
    result = synthetic.synthetic_result(records=60, shaft_radius=1.1e-3)
    drawing = Drawing(result, np.arange(0, 60, 7), exaggeration=50.0)
    stage, contact = drawing.reach()
    seen = [drawing.picture(i) for i in range(len(drawing))]
    assert all(np.linalg.norm(p.casing.sides, axis=-1).max() <= stage for p in seen)
    touching = [np.linalg.norm(p.tips[p.forces.any(axis=1)], axis=1) for p in seen]
    assert contact == pytest.approx(np.concatenate(touching).max())


@pytest.mark.parametrize(
    ("clearance", "largest", "factor"),
    [
        (1e-3, 1e-3, 50),  # a tenth of the radius
        (1e-3, 4e-3, 20),  # 31 would do
        (1e-3, 0.3, 1),
        (0.0, 1e-4, 1000),
        (1e-20, 0.0, 1e9),  # the largest factor that may be given
        (0.0, 0.0, 1),
    ],
)
def test_automatic_factor(clearance: float, largest: float, factor: float) -> None:
    assert round_factor(0.5, (0.1, clearance), (0.25, largest)) == factor


def test_arrows_end_on_the_tips_and_scale_with_the_force() -> None:
    tips = np.array([[0.5, 0.0], [0.0, 0.5], [-0.5, 0.0]])
    forces = np.array([[-200.0, 0.0], [0.0, 0.0], [50.0, -50.0]])
    outline = arrows(tips, forces, 1e-3, 0.01)
    np.testing.assert_allclose(outline[[0, 2], 3], tips[[0, 2]])
    tails = outline[:, [0, 6]].mean(axis=1)
    np.testing.assert_allclose(tips - tails, 1e-3 * forces, atol=1e-15)
    np.testing.assert_allclose(outline[1], np.tile(tips[1], (7, 1)))

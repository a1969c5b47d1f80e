"""Pictures and series of a shaft line with two wheels, each in a wall of its own."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from solid_meshes import fan_sector, whole

import bladewhirl as bw
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.superelements.file import write_superelement
from bladewhirl.postprocess.fields.point_stresses import PointStresses
from bladewhirl.postprocess.fields.rigid_wall import with_wall
from bladewhirl.postprocess.fields.wheels import of_wheel
from bladewhirl.postprocess.paraview.rotor_parts import RotorParts
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.shaft_line import _further_wheels
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

BLADES, FACTOR, AHEAD = 3, 5.0, -0.3
LAST = np.array([5])


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """Two wheels at 0.6 m and 0.3 m that weight presses into rigid walls of unequal clearance."""
    file = tmp_path_factory.mktemp("wheels") / "fan.npz"
    steel: dict[str, Any] = {"young_modulus": 2.1e11, "poisson_ratio": 0.3, "density": 7850.0}
    mesh = whole(fan_sector(BLADES), BLADES)
    write_superelement(file, mesh3d(mesh, **steel, hub="root", hub_at="-5 mm"))
    fan = {"file": str(file), "copies": BLADES}
    case = bw.case_from(
        {
            "bladed_disk": {"superelement": fan},
            "shaft_line": {
                "segments": [{"length": 0.6, "outer_diameter": 0.04, "elements": 2}],
                "bearings": [{"position": at, "stiffness": 1e6} for at in (0.0, 0.6)],
                "wheel": {"position": 0.6},
                "wheels": [{"position": 0.3, "superelement": fan, "casing": {"clearance": 4e-4}}],
            },
            "gravity": {"acceleration": [0.0, -3e4], "start": "unbent"},
            "casing": {"type": "rigid", "clearance": 1e-4},
            "reduction": {"free_interface_modes": 12},
            "march": {
                **{"speed": "900 rad/s", "time_step": 1e-6},
                **{"duration": 5e-4, "record_step": 1e-4},
            },
        }
    )
    return march_in_memory(prepare(case))[0]


def test_all_wheels_are_drawn_with_one_factor(result: xr.Dataset) -> None:
    drawing = Drawing(result, LAST, exaggeration=FACTOR, frame="rotating")
    assert [solid.shows for solid in drawing.solids[:4]] == ["disk", "disk", "wall", "wall"]
    chosen = Drawing(result, LAST)._body.stages
    assert chosen[0].factor == chosen[1].factor
    picture, nodes = drawing.picture(0), np.split(np.arange(4 * BLADES), 2)
    body: Any = drawing._body
    for number, stage in enumerate(body.stages):
        wheel = of_wheel(result, number)
        moved = wheel["contact_displacement"].values[LAST[0]]
        places = stage.contact_nodes(0)
        np.testing.assert_allclose(places[:, 2] - FACTOR * moved[:, 2], wheel["axial_position"])
        gap = (np.hypot(*stage.wall(0)[0, 0]) - np.hypot(*places[:, :2].T)) / FACTOR
        expected = wheel["clearance"].values[0] + wheel["tip_recess"].values - moved[:, 0]
        second = FACTOR * (moved**2).sum(axis=1).max() / wheel["contact_radius"].values.min()
        np.testing.assert_allclose(gap, expected, atol=second)
        apart = stage.nodes[:, None] - stage.rest
        assert np.linalg.norm(apart, axis=-1).min(axis=1).max() < 1e-9
    force = np.linalg.norm(picture.pushes, axis=1)
    assert all(force[own].any() for own in nodes)
    values = drawing.colouring.points[0, :, 0]
    assert len(values) == sum(len(picture.solids[number].points) for number in (0, 1))
    np.testing.assert_array_equal(picture.solids[1].values, values[len(picture.solids[0].points) :])


def test_stress_is_that_of_the_first_wheel_under_all_forces(result: xr.Dataset) -> None:
    shown = Drawing(result, LAST, colour="stress").colouring.points[0, :, 0]
    points = result.sizes["point"]
    np.testing.assert_array_equal(shown[:points], PointStresses(result).at(LAST)[0])
    assert shown[:points].any()
    assert np.isnan(shown[points:]).all()


def test_a_series_has_the_parts_of_all_wheels(result: xr.Dataset) -> None:
    parts = RotorParts(with_wall(result), LAST, surface=False, rotating=True, exaggeration=FACTOR)
    (grids,) = parts.grids()
    assert set(grids) == {"rotor", "casing", "contact", "shaft", "bearings"}
    rotor, contact = grids["rotor"], grids["contact"]
    half = len(rotor.points) // 2
    np.testing.assert_allclose(
        rotor.points[half:], rotor.points[:half] + np.array([0.0, 0.0, AHEAD])
    )
    cells = rotor.cells[0].data
    np.testing.assert_array_equal(cells[len(cells) // 2 :], cells[: len(cells) // 2] + half)
    blade = rotor.cell_data["blade"][0].reshape(2, -1)
    np.testing.assert_array_equal(blade[1], blade[0] + BLADES)
    drawn = contact.points + contact.point_data["warp"]
    np.testing.assert_allclose(drawn, parts.tips(int(LAST[0])))


def test_a_file_without_a_surface_leaves_its_wheel_out(result: xr.Dataset) -> None:
    bare = result.drop_vars([name for name in result.variables if "further_" in str(name)])
    picture = Drawing(bare, LAST).picture(0)
    assert len(picture.tips) == 2 * BLADES
    assert [solid.shows for solid in Drawing(bare, LAST).solids[:2]] == ["disk", "wall"]


def test_a_wheel_without_a_wall_is_drawn_as_a_disk(result: xr.Dataset) -> None:
    """The second wheel loses its wall and its contact nodes."""
    both = Drawing(result, LAST, exaggeration=FACTOR).picture(0)
    one = of_wheel(result, 0).drop_vars("wheel")
    drawing = Drawing(one, LAST, exaggeration=FACTOR, colour="gap")
    assert [solid.shows for solid in drawing.solids[:4]] == ["disk", "disk", "wall", None]
    picture = drawing.picture(0)
    assert len(picture.tips) == 2 * BLADES
    # but for the difference of clearances, by which the blades in the wall are shorter
    difference = FACTOR * 3e-4
    np.testing.assert_allclose(
        picture.solids[1].points, both.solids[1].points, atol=1.01 * difference
    )
    parts = [
        RotorParts(with_wall(each), LAST, surface=False, rotating=False, exaggeration=FACTOR)
        for each in (result, one)
    ]
    (whole, bare) = ({**next(each.grids())}["rotor"] for each in parts)
    for name in ("displacement", "velocity", "deformation"):
        np.testing.assert_array_equal(bare.point_data[name], whole.point_data[name])
    assert set(bare.cell_data["blade"][0]) == {-1, *range(BLADES)}


def test_the_view_of_the_line_has_disks_of_the_size_of_all_wheels(result: xr.Dataset) -> None:
    ((position, radius),) = _further_wheels(result, [{"position": 0.3}])
    assert position == 0.3
    assert radius == pytest.approx(np.hypot(*result["point"].values[:, :2].T).max())

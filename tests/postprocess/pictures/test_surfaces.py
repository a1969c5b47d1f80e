"""Pictures and pages of superelements: surfaces of triangles in the wall."""

import inspect
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import xarray as xr
from PIL import Image
from rod_blade import blade, tables
from scipy.spatial.distance import pdist
from web_pages import page, part

import bladewhirl as bw
from bladewhirl.meshes.plane import unit
from bladewhirl.postprocess.fields.kinematics import ViewError, contact_forces
from bladewhirl.postprocess.fields.points import points_of
from bladewhirl.postprocess.fields.rigid_wall import with_wall
from bladewhirl.postprocess.paraview.parts import StageParts
from bladewhirl.postprocess.pictures.appearance import time_text
from bladewhirl.postprocess.pictures.bodies import OPEN_EDGE, TOWARDS, WALL_STATIONS
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.offscreen import stage_view
from bladewhirl.postprocess.pictures.render import strongest_contact
from bladewhirl.postprocess.pictures.solids import METAL
from bladewhirl.postprocess.pictures.web_page import FULL, render_page
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

CLEARANCE, LOBE, PHASE, CLOSURE = 3e-4, 3.1e-4, 0.3, 4e-5  # of `tables`
RADIUS, FACTOR = 0.3, 20.0
RECORDS = np.array([3, 40, 90])
SMALL = (320, 240)


def marched(folder: Path, copies: int) -> xr.Dataset:
    """Result of separate blades in an oval wall."""
    file = folder / "rods.npz"
    bw.write_superelement(file, blade())
    table = {"superelement": {"file": str(file), "copies": copies}}
    case = bw.case_from(tables(file, bladed_disk=table, march__duration=0.012))
    return march_in_memory(prepare(case))[0]


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    return marched(tmp_path_factory.mktemp("three"), 3)


@pytest.fixture(scope="module")
def single(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    return marched(tmp_path_factory.mktemp("single"), 1)


def series(dataset: xr.Dataset, records: Any, *, rotating: bool = True) -> list[Any]:
    parts = StageParts(with_wall(dataset), records, surface=False, rotating=rotating)
    return [*parts.grids()]


@pytest.mark.parametrize("frame", ["static", "rotating"])
def test_the_drawn_gap_is_the_factor_times_the_gap(three: xr.Dataset, frame: Any) -> None:
    drawing = Drawing(three, RECORDS, exaggeration=FACTOR, frame=frame)
    stage: Any = drawing._stage  # before the projection, which shortens distances
    for index, record in enumerate(RECORDS):
        nodes, wall = stage.contact_nodes(index), stage.wall(index)[:, 0]
        moved = three["contact_displacement"].values[record]
        time = float(three["time"][record])
        ahead = float(three.attrs["speed"]) * time
        at = np.arctan2(nodes[:, 1], nodes[:, 0]) + ahead
        clearance = CLEARANCE + LOBE * np.cos(2 * (at - PHASE))
        clearance -= CLOSURE * (1.0 - np.exp(-time / 2e-3))
        drawn = np.interp(
            at, np.arctan2(wall[:, 1], wall[:, 0]), np.hypot(*wall.T), period=2 * np.pi
        )
        gap = (drawn - np.hypot(nodes[:, 0], nodes[:, 1])) / FACTOR
        np.testing.assert_allclose(gap, clearance - moved[:, 0], atol=2e-7)
        rest = three["axial_position"].values
        np.testing.assert_allclose(nodes[:, 2], rest + FACTOR * moved[:, 2], atol=1e-15)


def test_points_swing_along_arcs_and_have_the_true_colour(three: xr.Dataset) -> None:
    drawing = Drawing(three, RECORDS, exaggeration=FACTOR, frame="rotating")
    stage: Any = drawing._stage
    for index, grids in enumerate(series(three, RECORDS)):
        mesh = grids["rotor"]
        moved = mesh.point_data["displacement"]
        values = drawing.picture(index).solids[0].values
        np.testing.assert_allclose(values, np.linalg.norm(moved, axis=1), rtol=1e-12)
        drawn, rest = stage.points(index), mesh.points
        out = rest[:, :2] / np.hypot(*rest[:, :2].T)[:, None]
        radial = np.sum(moved[:, :2] * out, axis=1)
        radius = np.hypot(*rest[:, :2].T) + FACTOR * radial
        np.testing.assert_allclose(np.hypot(*drawn[:, :2].T), radius, rtol=1e-12)
    assert drawing.largest_displacement >= values.max()


def test_forces_in_space_keep_their_size(three: xr.Dataset) -> None:
    record = strongest_contact(three)
    picture = Drawing(three, np.array([record])).picture(0)
    force = contact_forces(three, np.array([record]))[0]
    assert force.shape == (9, 3)
    total = Drawing(three, np.array([record])).total_force
    assert total == pytest.approx([np.linalg.norm(force, axis=1).sum()])
    whole = np.linalg.norm(force.reshape(3, 3, 3).sum(axis=1), axis=1)
    assert whole.max() > 0.0
    np.testing.assert_allclose(picture.blade_forces, whole, rtol=1e-12)
    assert 0.0 < np.linalg.norm(picture.forces, axis=1).max() < whole.max()  # inclined to the view


def test_a_single_blade_fills_the_picture_in_rotating_axes(
    single: xr.Dataset, three: xr.Dataset
) -> None:
    near, around = Drawing(single, RECORDS), Drawing(single, RECORDS, frame="static")
    assert (near.frame, near.around) == ("rotating", False)
    assert near.reach()[0] < 0.15 * RADIUS < RADIUS < around.reach()[0]
    assert Drawing(three, RECORDS).frame == "static"
    # The wall at its clearance, in axes in which it turns backward.
    walls = [near.picture(index).solids[1].points[::4, :2] for index in range(len(RECORDS))]
    assert np.abs(walls[0] - walls[1]).max() > 1e-4
    assert np.linalg.norm(walls[0][-1] - walls[1][-1]) < 0.05 * RADIUS


@pytest.mark.parametrize("view", ["oblique", "axial", "side"])
def test_the_wall_is_open_in_front_of_the_tips(three: xr.Dataset, view: Any) -> None:
    """No point of the wall lies nearer to the viewer than the tips and in front of their circle."""
    drawing = Drawing(three, RECORDS, exaggeration=FACTOR, view=view)
    across = np.hypot(*unit(np.array(TOWARDS[view]))[:2])
    for index in range(len(RECORDS)):
        seen = drawing.picture(index)
        disk, wall, *edges, hub = seen.solids
        assert np.isnan(hub.values).all()  # separate blades stand on a hub
        assert len(edges) == (0 if view == "axial" else 2)  # of the wall where it is open
        if edges:
            assert max(edge.points[:, 2].max() for edge in edges) > across * RADIUS
        assert len(wall.points) == 4 * WALL_STATIONS
        depth = wall.points[:, 2].max()
        assert (depth > across * RADIUS) == (view == "axial")
        # Drawn points have the distances that points in space have.
        stage: Any = drawing._stage
        drawn, points = disk.points, stage.points(index)
        assert pdist(drawn) == pytest.approx(pdist(points))
    with pytest.raises(bw.ViewError, match="view must be one of oblique, axial, side"):
        Drawing(three, RECORDS, view=cast(Any, "top"))


def test_from_the_side_no_wall_is_in_front_of_the_tip_of_a_blade(single: xr.Dataset) -> None:
    drawing = Drawing(single, np.array([0]), exaggeration=1.0, view="side")
    picture, body = drawing.picture(0), cast(Any, drawing._body)
    tips = body._placed(body.stage.contact_nodes(0), 0.0)
    assert picture.solids[1].points[:, 2].max() < tips[:, 2].min() + 1e-3 * RADIUS


def test_without_a_coating_there_is_no_wear(single: xr.Dataset) -> None:
    with pytest.raises(ViewError, match="so nothing can be worn"):
        Drawing(single, RECORDS, colour="wear")


def test_surfaces_without_motion_are_light(three: xr.Dataset) -> None:
    shade = Drawing(three, RECORDS).colouring.disk.colours(0.0)
    assert min(shade[:3]) == 1.0


@pytest.mark.parametrize(
    ("step", "text"), [(1e-3, "t = 0.7 ms"), (1e-4, "t = 0.7 ms"), (2e-5, "t = 0.72 ms")]
)
def test_times_have_the_decimals_of_the_records(step: float, text: str) -> None:
    assert time_text(0.72e-3 if step < 1e-4 else 0.7e-3, step) == text


THICKNESS, WORN = 1e-3, (0.3, 0.1)  # of a coating; shares that are removed from two tracks
LIMIT = 0.9  # share of the thickness at which a tip touches the metal


def worn(dataset: xr.Dataset) -> xr.Dataset:
    """The result with a coating of two tracks, each of which is worn in one half."""
    tables = f"""[casing.coating]
thickness = {THICKNESS}
young_modulus = 1e9
yield_stress = 1e6
[casing.closure]
amount = {CLOSURE}
time_constant = 2e-3
"""
    strain = np.outer(WORN, np.arange(100) < 50)
    nodes = dataset.sizes["contact_node"]
    return dataset.assign_attrs(case=tables).assign(
        wear_time=("wear_time", [0.0]),
        coating_strain=(("wear_time", "track", "rod"), strain[None]),
        axial_position=("contact_node", np.resize([-0.01, 0.01], nodes)),
    )


def test_the_gap_of_a_coated_wall_is_that_to_the_coating(single: xr.Dataset) -> None:
    result = worn(single)
    coated, plain = (Drawing(each, RECORDS, colour="gap").colouring for each in (result, single))
    assert [each.name for each in (coated, plain)] == ["gap to the coating", "gap at the tip"]
    angle = (
        single["tip_angle"].values + single.attrs["speed"] * single["time"].values[RECORDS, None]
    )
    share = np.where(angle % (2 * np.pi) < np.pi, np.resize(WORN, len(angle.T)), 0.0)
    left = THICKNESS * (LIMIT - share)
    np.testing.assert_allclose(plain.nodes - coated.nodes, left, rtol=1e-9)
    assert 0.0 < share.mean() < max(WORN)


def test_each_track_of_a_coating_is_as_thick_as_the_layer_less_its_own_wear(
    single: xr.Dataset,
) -> None:
    result = worn(single)
    drawing = Drawing(result, RECORDS, exaggeration=FACTOR, colour="wear")
    _, wall, *strips = drawing.picture(2).solids
    assert [solid.shows for solid in drawing.solids] == ["disk", None, *["wall"] * 4]
    for strip, share in zip(strips, (*WORN, 0.0, 0.0), strict=True):
        corner = strip.points.reshape(-1, 4, 3)
        thickness = np.linalg.norm(corner[:, 3] - corner[:, 0], axis=1)
        at = np.unique(np.round(thickness / (FACTOR * THICKNESS), 2))
        assert set(at) <= {LIMIT, round(LIMIT - share, 2)}
        shown = np.unique(strip.values[np.isfinite(strip.values)])
        assert set(np.round(shown / THICKNESS, 6)) <= {0.0, share}
        assert np.isfinite(strip.values).any() == (share > 0.0)
    assert wall.points.reshape(-1, 4, 3)[:, 0, :2] == pytest.approx(
        strips[2].points.reshape(-1, 4, 3)[:, 3, :2], abs=1e-9
    )


def test_the_series_has_the_wall_as_a_solid_and_the_wear_of_each_track(
    single: xr.Dataset,
) -> None:
    """Points at rest have their true size; tips touch the drawn wall where they touch the wall."""
    (grids,) = StageParts(
        with_wall(worn(single)), RECORDS[2:], surface=False, rotating=False, exaggeration=FACTOR
    ).grids()
    casing, coating = grids["casing"], grids["coating"]
    corner = np.hypot(*casing.points[:, :2].T).reshape(-1, 4)
    clearance = corner[:, 0] - LIMIT * THICKNESS - single["contact_radius"].values.max()
    assert clearance.max() == pytest.approx(CLEARANCE + LOBE, rel=1e-3)
    assert (corner[:, 1] > corner[:, 0]).all()
    track, cells = coating.cell_data["track"][0], coating.cells[0].data
    for number, share in enumerate(WORN):
        wear = coating.point_data["wear"][cells[track == number]]
        assert set(np.round(np.unique(wear) / THICKNESS, 6)) == {0.0, share}
    assert not coating.point_data["wear"][cells[track == -1]].any()
    whole = coating.point_data["wear"] + coating.point_data["remaining_thickness"]
    assert whole == pytest.approx(LIMIT * THICKNESS)
    plain = StageParts(
        with_wall(single), RECORDS[2:], surface=False, rotating=True, exaggeration=FACTOR
    )
    assert "coating" not in plain.grid_names
    (grids,) = plain.grids()
    nodes, wall = (
        (mesh.points + mesh.point_data["warp"]).reshape(-1, corners, 3)[:, 0, :2]
        for mesh, corners in ((grids["contact"], 1), (grids["casing"], 4))
    )
    angle, radius = np.arctan2(wall[:, 1], wall[:, 0]), np.hypot(*wall.T)
    drawn = np.interp(np.arctan2(nodes[:, 1], nodes[:, 0]), angle, radius, period=2 * np.pi)
    moved = single["contact_displacement"].values[RECORDS[2], :, 0]
    time = float(single["time"][RECORDS[2]])
    ahead = float(single.attrs["speed"]) * time + np.arctan2(nodes[:, 1], nodes[:, 0])
    gap = CLEARANCE + LOBE * np.cos(2 * (ahead - PHASE)) - moved
    gap -= CLOSURE * (1.0 - np.exp(-time / 2e-3))
    assert (drawn - np.hypot(*nodes.T)) / FACTOR == pytest.approx(gap, abs=3e-7)


@pytest.mark.parametrize(
    ("colour", "unit"), [("deformation", "mm"), ("velocity", "m/s"), ("gap", "mm"), ("part", "")]
)
def test_fields_of_surfaces(three: xr.Dataset, colour: Any, unit: str) -> None:
    colouring = Drawing(three, RECORDS, colour=colour, frame="static").colouring
    assert colouring.points.shape == (3, 54, 2)
    assert colouring.disk.unit in (unit, "µm")
    if colour == "velocity":
        both = series(three, np.array([39, 41]), rotating=False)
        before, after = (grids["rotor"] for grids in both)
        moved = after.point_data["displacement"] - before.point_data["displacement"]
        rate = np.linalg.norm(moved, axis=1) / float(three["time"][41] - three["time"][39])
        np.testing.assert_allclose(colouring.points[1, :, 0], rate, atol=0.1 * rate.max())
    if colour == "gap":
        np.testing.assert_array_equal(colouring.nodes, three["gap"].values[RECORDS])
        assert np.isnan(colouring.points).all()  # is known at contact nodes only
    if colour == "part":
        assert list(colouring.parts or {}) == ["bladed disk", "casing"]
        assert np.all(colouring.casing == 1.0)
    else:
        assert np.isnan(colouring.casing).all()  # of a rigid wall


@pytest.mark.parametrize("colour", ["joint-force", "joint-slip", "joint-state"])
def test_both_nodes_of_a_joint_show_its_value(three: xr.Dataset, colour: Any) -> None:
    """Also that of a damper, whose other end is no node; a node of two pairs shows the larger."""
    ends = np.array([[3, 2], [6, 5], [7, -1], [7, 5]])
    force = np.linspace(1.0, 2.0, three.sizes["time"])[:, None, None] * np.arange(1.0, 13.0)
    steps = np.zeros((three.sizes["time"], 4, 3), dtype=np.int64)
    steps[1:, np.arange(4), [0, 1, 2, 1]] = 9
    over = ("time", "joint_pair")
    jointed = three.assign(
        joint_name=("joint_pair", ["shroud"] * 4),
        joint_end=(("joint_pair", "joint_side"), ends),
        joint_force=((*over, "joint_direction"), force.reshape(-1, 4, 3)),
        joint_slip=(over, 1e-6 * force.reshape(-1, 4, 3)[..., 1]),
        joint_steps=((*over, "joint_state"), steps),
    )
    drawing = Drawing(jointed, RECORDS, colour=colour)
    pairs = {
        "joint-force": jointed["joint_force"].values[RECORDS, :, 0],
        "joint-slip": jointed["joint_slip"].values[RECORDS],
        "joint-state": np.where(RECORDS[:, None] > 0, [0.0, 1.0, 2.0, 1.0], np.nan),
    }[colour]
    expected = np.full((3, 9), np.nan)
    expected[:, [3, 2, 6]] = pairs[:, [0, 0, 1]]
    expected[:, 5], expected[:, 7] = pairs[:, [1, 3]].max(axis=1), pairs[:, [2, 3]].max(axis=1)
    np.testing.assert_array_equal(drawing.colouring.nodes, expected)
    shown = [drawing.picture(index).tip_values for index in range(3)]
    assert np.isfinite(np.concatenate(shown)).any()
    assert drawing.discs == ["discs: joints"]
    name = colour.replace("-", "_")
    for index, grids in enumerate(series(jointed, RECORDS)):
        np.testing.assert_array_equal(grids["contact"].point_data[name], expected[index])
    with pytest.raises(ViewError, match=r"the run has no \[\[joint\]\]"):
        Drawing(three, RECORDS, colour=colour)


def test_the_page_has_the_surface_and_its_depth(three: xr.Dataset, tmp_path: Path) -> None:
    path = render_page(three, tmp_path / "a.html", RECORDS)
    about, places, shades = page(path)
    drawing = Drawing(three, RECORDS)
    for index, drawn in enumerate(part(about, places, "surface")):
        picture = drawing.picture(index)
        points = np.concatenate([solid.points for solid in picture.solids])
        scale = drawn[:, 0] @ points[:, 0] / (points[:, 0] @ points[:, 0])
        np.testing.assert_allclose(drawn, scale * points, atol=1.0 / FULL)
        assert scale * drawing.reach()[0] < 1.0
    assert about["ofPoints"] == [f"blade {n}" for n in points_of(three, 1).blade]
    assert about["surfaceShades"] + len(points) == about["nodeShades"] == shades.shape[1] - 9
    assert about["layout"]["casing"][1] == 0  # the wall is a solid
    with_colour = [solid.colour for solid in drawing.solids if not solid.shows]
    assert about["solidColours"] == with_colour == [OPEN_EDGE, OPEN_EDGE, METAL]
    assert shades[0, -10] == len(about["colours"]) + 2  # after those of the scale and of edges
    assert "orbit" not in about  # blades without a common centre
    assert about["marks"]


def test_points_of_a_wheel_have_the_blade_of_the_nearest_contact_node(three: xr.Dataset) -> None:
    wheel = three.isel(copy=[0], rotor_mode=slice(three.sizes["mode"]))
    angles = wheel["tip_angle"].values
    places = 0.2 * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=-1)
    shape = np.zeros((9, 3, three.sizes["mode"]))
    wheel = wheel.drop_dims(["point", "triangle"], errors="ignore").assign(
        point=(("point", "xyz"), places), point_shape=(("point", "xyz", "mode"), shape)
    )
    assert points_of(wheel, 1).blade.tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2]


@pytest.mark.usefixtures("can_draw")
class TestFiles:
    def test_a_still_shows_contact_where_it_is(self, three: xr.Dataset, tmp_path: Path) -> None:
        bw.render(three, tmp_path / "contact.png")
        bw.render(three, tmp_path / "start.png", time=0.0)
        for name, touches in (("contact", True), ("start", False)):
            image = np.asarray(Image.open(tmp_path / f"{name}.png").convert("RGB"), dtype=int)
            stage = image[:, : 3 * image.shape[1] // 4]
            vermilion = np.abs(stage - [0xD5, 0x5E, 0x00]).sum(axis=-1) < 40
            assert (vermilion.sum() > 50) == touches

    def test_a_mark_moves_along_the_time_line(self, single: xr.Dataset) -> None:
        with stage_view(single, Drawing(single, RECORDS), (640, 480)) as picture:
            strips = [picture(index)[463:475, 490:630] for index in range(3)]
        dark = [np.flatnonzero((strip.max(axis=2) < 90).sum(axis=0) > 6).mean() for strip in strips]
        share = np.diff(RECORDS) / np.ptp(RECORDS)
        assert np.diff(dark) / np.ptp(dark) == pytest.approx(share, abs=0.02)

    def test_every_picture_is_drawn_once(self, single: xr.Dataset) -> None:
        drawn: list[str] = []
        drawing = Drawing(single, RECORDS)
        with stage_view(single, drawing, SMALL) as picture:
            window = inspect.getclosurevars(picture).nonlocals["plotter"].render_window
            window.AddObserver("StartEvent", lambda *_: drawn.append("drawn"))
            pictures = [picture(index) for index in (0, 1, 2)]
        assert len(drawn) == len(pictures)
        assert (pictures[0] != pictures[2]).any()

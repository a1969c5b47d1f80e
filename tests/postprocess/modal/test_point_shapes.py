"""Pictures of mode shapes of superelements."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer, refusal
from exported_stages import BLADES, beams, exported
from long_cases import slow_except
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from PIL import Image, ImageSequence
from rod_blade import blade, tables
from solid_meshes import STEEL, TIE, bladed_sector, cantilever

import bladewhirl as bw
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.modal.labels import Body
from bladewhirl.models.modal.whirl_modes import WhirlModes
from bladewhirl.models.stage.matrix_disk import MatrixDisk
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.postprocess.modal.mode_shapes import plot_mode_shapes
from bladewhirl.postprocess.modal.motion import PICTURES, Wave, mode_motion, shapes_dataset
from bladewhirl.postprocess.modal.surface_shapes import facing_triangles
from bladewhirl.postprocess.pictures.appearance import enlargement
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.render import render_animation
from bladewhirl.studies.modal.mode_pictures import plan_pictures

ONE = {"shapes": None, "animate": "1F", "wave": None}
CASES = [("none", "bladed-disk", "1F"), ("full", "bladed-disk", "1F"), ("none", "casing", "1F")]


def test_shapes_of_a_sector_go_on_around_the_wheel(tmp_path: Path) -> None:
    """A turn by one sector mixes the cosine and the sine mode of a pair."""
    model = modal_model(exported(beams("sector"), "sector", tmp_path), count=8)
    modes = model.listed_modes
    pair = np.flatnonzero((modes.nodal_diameter == 2) & (np.array(modes.family) == "1F"))
    disk = model.disk
    assert isinstance(disk, MatrixDisk)
    cosine, sine = disk.points(modes, pair).real.reshape(2, BLADES, -1, 3)
    angle = 2.0 * np.pi / BLADES
    expected = np.cos(2 * angle) * cosine - np.sin(2 * angle) * sine
    assert rotate(cosine, -angle)[1:] == pytest.approx(expected[:-1], abs=1e-12)
    positions = disk.stage.shown_arrays.point.reshape(BLADES, -1, 3)
    assert rotate(positions, -angle)[1:] == pytest.approx(positions[:-1], abs=1e-12)
    assert np.abs(cosine - sine).max() > 0.1 * np.abs(cosine).max()


def test_a_surface_is_coloured_by_displacement(tmp_path: Path) -> None:
    bw.write_superelement(file := tmp_path / "rods.npz", blade())
    case = bw.case_from(tables(file))
    model = modal_model(case, count=3)
    data = shapes_dataset(model, "bladed-disk", np.arange(2)).assign_attrs(title="shapes")
    moved = data["point_shape"].values[..., 0]
    square = data["rotor_frequency"].values[0] ** 2
    inertia = blade().mass @ moved.ravel()  # all coordinates are displacements of points
    assert blade().stiffness @ moved.ravel() == pytest.approx(square * inertia, abs=1.0)
    assert moved.ravel() @ inertia == pytest.approx(1.0)
    assert square * np.abs(inertia).max() > 1e5
    figure = plot_mode_shapes(data, "bladed-disk")
    panels: Any = figure.axes[:2]
    titles = [axes.get_title().splitlines() for axes in panels]
    assert [title[0] for title in titles] == ["1F", "2F"]
    assert [title[1] for title in titles] == data["rotor_tip_motion"].values.tolist()
    faces = next(each for each in panels[0].collections if isinstance(each, Poly3DCollection))
    assert len(data["triangle"]) == 10
    assert len(faces.get_facecolor()) == 10 * 4**4  # in pieces, for smooth colours


def test_of_a_closed_surface_the_side_towards_the_viewer_is_drawn() -> None:
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([half for a, b, c, d in sides for half in ([a, b, c], [a, c, d])])
    for triangles in (faces, faces[:, ::-1]):
        seen, facing = facing_triangles(corners, triangles)
        middle = corners[seen].mean(axis=1)
        # From azimuth -60 degrees and above: the faces x = 1, y = 0 and z = 1.
        assert len(seen) == 6
        assert np.all((middle[:, 0] == 1.0) | (middle[:, 1] == 0.0) | (middle[:, 2] == 1.0))
        assert facing.max() == pytest.approx(np.sin(np.radians(55.0)))
    assert len(facing_triangles(corners, faces[1:])[0]) == 11
    mixed = np.concatenate([faces[:1, ::-1], faces[1:]])
    assert len(facing_triangles(corners, mixed)[0]) == 12


@pytest.mark.slow
def test_the_command_draws_both_bodies(tmp_path: Path) -> None:
    wheel = exported(beams(rotation={"effects": "full"}), "wheel", tmp_path)
    (tmp_path / "case.toml").write_text(bw.dumps_case(wheel), encoding="utf-8")
    given = "modes", tmp_path / "case.toml", "--count", 8, "-o", tmp_path / "shapes"
    answer(*given, "--shapes", "1F:1,suspension,casing:1F:2")
    names = {path.stem for path in (tmp_path / "shapes").glob("*.nc")}
    assert names == {"bladed-disk-shapes", "casing-shapes"}
    line = refusal(*given[:-1], tmp_path / "films", "--animate", "1F:1")
    assert "expected a superelement whose file has points, recovery and triangles" in line


@pytest.mark.parametrize("wave", slow_except(["backward", "forward"], "forward"))
@pytest.mark.parametrize(("effects", "body", "family"), CASES)
def test_waves_travel_as_those_of_its_beams(
    tmp_path: Path, wave: Wave, effects: str, body: Body, family: str
) -> None:
    """Amplitudes of the gaps, and the lag from tip to tip, do not depend on the phase of a mode."""
    case = beams(rotation={"effects": effects})
    amplitudes = []
    for each in (case, exported(case, "wheel", tmp_path)):
        model = modal_model(each, count=30)
        modes = model.listed_modes if body == "bladed-disk" else model.casing_modes
        numbers = modes.find(family, 2)
        if isinstance(modes, WhirlModes):
            named, _ = modes.named_directions(model.speed)
            numbers = np.array([n for n in numbers if named[n] == wave][:1])
        motion = mode_motion(model, body, numbers[:2], wave=wave, title="mode")
        turning = np.exp(-2j * np.pi * np.arange(PICTURES) / PICTURES)
        amplitudes.append(motion["gap"].values.T @ turning)
    beam, wheel = amplitudes
    assert np.abs(wheel) == pytest.approx(np.abs(beam), rel=1e-2)
    assert wheel[1:] / wheel[:-1] == pytest.approx(beam[1:] / beam[:-1], abs=1e-4)


@pytest.mark.slow
def test_films_of_a_blade_move(tmp_path: Path, can_draw: None) -> None:
    bw.write_superelement(tmp_path / "rods.npz", blade())
    model = modal_model(bw.case_from(tables(tmp_path / "rods.npz")), count=2)
    (mode,) = (chosen for chosen, _ in plan_pictures(model, **ONE).films)
    assert (mode.name, mode.stem) == ("1F", "1F")
    motion = mode_motion(model, mode.body, mode.numbers, wave="standing", title="1F")
    half = np.array([0, 1, PICTURES // 2])  # after half a period the blade is on the other side
    with Image.open(render_animation(motion, tmp_path / "1F.gif", half, size=(480, 360))) as film:
        first, *others = (
            np.asarray(each.convert("L"), np.int64)[:, :360]
            for each in ImageSequence.Iterator(film)
        )
    soon, later = (np.count_nonzero(np.abs(each - first) > 50) for each in others)
    assert later > 300 + soon


@pytest.mark.parametrize("kind", ["blade", "sector"])
def test_modes_of_a_file_with_stresses_move(tmp_path: Path, kind: str) -> None:
    """Stresses, and shapes of a first sector, are those of the modes of a march, and left out."""
    mesh = cantilever("hexahedron", (2, 1, 1)) if kind == "blade" else bladed_sector("hexahedron")
    tie = {} if kind == "blade" else TIE
    part = bw.mesh3d(mesh, **STEEL, **tie, contacts=2, stress=True)
    bw.write_superelement(tmp_path / "part.npz", part)
    table = {"file": str(tmp_path / "part.npz"), "kind": kind, "copies": tie.get("copies", 3)}
    given = {"bladed_disk": {"superelement": table}, "casing": {"type": "rigid"}}
    case = bw.case_from(given | {"reduction": {"free_interface_modes": 5}})
    model = modal_model(case, count=4)
    motion = mode_motion(model, "bladed-disk", np.array([0]), wave="standing", title="1F")
    assert not {"stress_shape", "sector_stress_shape", "sector_point_shape"} & set(motion)
    assert np.ptp(motion["rotor_displacement"].values) > 0.0


def test_films_of_modes_are_normalised() -> None:
    """The amplitude of a mode is arbitrary."""
    model = modal_model(beams(), count=20)
    motion = mode_motion(model, "bladed-disk", np.array([3]), wave="standing", title="a mode")
    drawing = Drawing(motion, np.arange(PICTURES))
    colouring = drawing.colouring
    assert (colouring.disk.unit, colouring.disk.limits) == ("\N{EN DASH}", (0.0, 1.0))
    assert colouring.disk.factor * np.abs(colouring.points).max() == pytest.approx(1.0)
    assert "arbitrary" in enlargement(drawing.exaggeration, normalised=drawing.normalised)

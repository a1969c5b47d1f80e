"""Pictures of mode shapes of superelements."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer, refusal
from exported_stages import BLADES, beams, exported
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from rod_blade import blade, tables

import bladewhirl as bw
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.stage.modal_superelement import modal_superelement
from bladewhirl.postprocess.modal.motion import shapes_dataset
from bladewhirl.postprocess.modal.point_shapes import plot_point_shapes


def test_shapes_of_a_sector_go_on_around_the_wheel(tmp_path: Path) -> None:
    """A turn by one sector mixes the cosine and the sine mode of a pair."""
    model = modal_superelement(exported(beams("sector"), "sector", tmp_path), count=8)
    modes = model.listed_modes
    pair = np.flatnonzero((modes.nodal_diameter == 2) & (np.array(modes.family) == "1F"))
    shapes = model.points(pair)
    cosine, sine = shapes.displacement.reshape(2, BLADES, -1, 3)
    angle = 2.0 * np.pi / BLADES
    expected = np.cos(2 * angle) * cosine - np.sin(2 * angle) * sine
    assert rotate(cosine, -angle)[1:] == pytest.approx(expected[:-1], abs=1e-12)
    positions = shapes.position.reshape(BLADES, -1, 3)
    assert rotate(positions, -angle)[1:] == pytest.approx(positions[:-1], abs=1e-12)
    assert np.abs(cosine - sine).max() > 0.1 * np.abs(cosine).max()


def test_a_surface_is_coloured_by_displacement(tmp_path: Path) -> None:
    bw.write_superelement(file := tmp_path / "rods.npz", blade())
    case = bw.case_from(tables(file))
    model = modal_superelement(case, count=3)
    data = shapes_dataset(model, "bladed-disk", np.arange(2)).assign_attrs(title="shapes")
    moved = data["point_shape"].values[0]
    square = data["rotor_frequency"].values[0] ** 2
    inertia = blade().mass @ moved.ravel()  # all coordinates are displacements of points
    assert blade().stiffness @ moved.ravel() == pytest.approx(square * inertia, abs=1.0)
    assert moved.ravel() @ inertia == pytest.approx(1.0)
    assert square * np.abs(inertia).max() > 1e5
    figure = plot_point_shapes(data)
    panels: Any = figure.axes[:2]
    assert [axes.get_title().split("\n")[0] for axes in panels] == ["1F", "2F"]
    faces = next(each for each in panels[0].collections if isinstance(each, Poly3DCollection))
    assert len(faces.get_facecolor()) == len(data["triangle"]) == 10


@pytest.mark.usefixtures("pictures_unsaved")
def test_the_command_draws_both_bodies(tmp_path: Path) -> None:
    wheel = exported(beams(rotation={"effects": "full"}), "wheel", tmp_path)
    (tmp_path / "case.toml").write_text(bw.dumps_case(wheel), encoding="utf-8")
    given = "modes", tmp_path / "case.toml", "--count", 8, "-o", tmp_path / "shapes"
    answer(*given, "--shapes", "1F:1,suspension,casing:1F:2")
    names = {path.stem for path in (tmp_path / "shapes").glob("*.nc")}
    assert names == {"bladed-disk-shapes", "casing-shapes"}
    line = refusal(*given[:-1], tmp_path / "films", "--animate", "1F:1")
    assert "--animate: films of modes show beams" in line

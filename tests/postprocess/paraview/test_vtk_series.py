"""The ParaView series, read back with readers that are not ours."""

import runpy
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from unittest.mock import MagicMock

import meshio
import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import Array, contact_forces
from bladewhirl.postprocess.paraview import parts as vtk_parts
from bladewhirl.postprocess.paraview import series as vtk_series
from bladewhirl.postprocess.paraview.series import export_vtk
from bladewhirl.postprocess.pictures.choices import Frame
from bladewhirl.postprocess.pictures.drawing import Drawing

PARTS = ("rotor", "casing", "contact", "supports")


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return synthetic.synthetic_result()


@pytest.fixture(scope="module")
def series(result: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return export_vtk(result, tmp_path_factory.mktemp("vtk"), frames=21, start=0.1, end=0.2)


def entries(index: Path) -> list[dict[str, str]]:
    root = ET.parse(index).getroot()
    assert root.tag == "VTKFile"
    assert root.attrib["type"] == "Collection"
    return [element.attrib for element in root.iter("DataSet")]


def read(index: Path, name: str, number: int = 0) -> meshio.Mesh:
    """Read a part of the stage at one instant."""
    return meshio.read(index.parent / "frames" / f"{name}_{number:05}.vtu")


def place(
    mesh: meshio.Mesh, field: str = "displacement"
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.asarray(mesh.points + mesh.point_data[field])


def polar(points: Array) -> tuple[Array, Array]:
    return np.arctan2(points[:, 1], points[:, 0]), np.linalg.norm(points[:, :2], axis=1)


def interpolated(angle: Array, around: Array, radius: Array) -> Array:
    return np.asarray(np.interp(angle, around, radius, period=2 * np.pi))


class TestIndex:
    def test_times_are_physical_and_parts_named(self, series: Path) -> None:
        listed = entries(series)
        for number, name in enumerate(PARTS):
            part = [entry for entry in listed if entry["name"] == name]
            assert {entry["part"] for entry in part} == {str(number)}
            times = [float(entry["timestep"]) for entry in part]
            np.testing.assert_allclose(times, np.linspace(0.1, 0.2, 21), atol=1e-12)
        assert all((series.parent / entry["file"]).is_file() for entry in listed)

    def test_killed_while_writing_frames(
        self, result: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        written = []
        write = vtk_series.write_vtu

        def die(path: Path, grid: meshio.Mesh, exaggeration: float) -> None:
            written.append(path)
            if len(written) == 1 + 4 * 3 + 2:  # the mesh, three instants, half of one
                raise KeyboardInterrupt
            write(path, grid, exaggeration)

        monkeypatch.setattr(vtk_series, "write_vtu", die)
        with pytest.raises(KeyboardInterrupt):
            export_vtk(result, tmp_path, frames=10)
        listed = entries(tmp_path / "series.pvd")
        assert len(listed) == 4 * 3
        assert all((tmp_path / entry["file"]).is_file() for entry in listed)

    def test_a_shorter_export_leaves_no_old_frames(
        self, result: xr.Dataset, tmp_path: Path
    ) -> None:
        export_vtk(result, tmp_path, frames=9)
        export_vtk(result, tmp_path, frames=4)
        assert len(entries(tmp_path / "series.pvd")) == 16
        assert len(list((tmp_path / "frames").glob("*.vtu"))) == 16

    def test_other_files_are_kept(self, result: xr.Dataset, tmp_path: Path) -> None:
        (tmp_path / "frames").mkdir()
        theirs = [tmp_path / "frames" / "wing_00000.vtu", tmp_path / "mesh.vtu"]
        theirs[0].write_text("precious")
        export_vtk(result, tmp_path, frames=2)
        assert theirs[0].read_text() == "precious"
        (tmp_path / "manifest.json").unlink()
        with pytest.raises(FileExistsError, match="--overwrite replaces it"):
            export_vtk(result, tmp_path, frames=2)
        export_vtk(result, tmp_path, frames=3, overwrite=True)


class TestFrames:
    @pytest.mark.parametrize("surface", [False, True])
    def test_fields_are_complete_finite_and_the_same_for_lines_and_surfaces(
        self, result: xr.Dataset, tmp_path: Path, surface: bool
    ) -> None:
        index = export_vtk(result, tmp_path, frames=2, surface=surface)
        moving = {"warp": 3, "displacement": 3}
        strained_body = {"velocity": 3, "deformation": 3}
        strained = dict.fromkeys(
            (
                *("radial_displacement", "surface_stress", "axial_strain", "axial_stress"),
                *("bending_strain", "bending_stress"),
            ),
            1,
        )
        body, cells = moving | strained_body | strained, {"part", "blade", "thickness"}
        tips = moving | {"velocity": 3, "gap": 1, "contact_force": 3}
        for name, expected, on_cells in (
            ("rotor", body | {"gap": 1}, cells),
            ("casing", body, cells),
            ("contact", tips, {"blade"}),
            ("supports", moving, {"part"}),
        ):
            mesh = read(index, name, 1)
            components = {
                key: 1 if a.ndim == 1 else a.shape[1] for key, a in mesh.point_data.items()
            }
            assert components == expected
            assert set(mesh.cell_data) == on_cells
            assert all(np.isfinite(array).all() for array in mesh.point_data.values())
            units = {key.split(" [")[0] for key in mesh.field_data} - {"exaggeration"}
            assert units == set(expected)
            assert mesh.field_data["gap [m]" if "gap" in expected else "warp [m]"] == 1.0
            assert float(mesh.field_data["exaggeration"][0]) > 1.0
        blade = read(index, "rotor").cell_data["blade"][0]
        assert set(blade) == {-1, *range(22)}

    @pytest.mark.parametrize("surface", [False, True])
    @pytest.mark.parametrize("rotating", [False, True])
    def test_warp_leads_to_the_places_of_a_picture(
        self, tmp_path: Path, surface: bool, rotating: bool
    ) -> None:
        """And no tip passes the casing on the way there."""
        result = synthetic.synthetic_result(records=100, shaft_radius=0.75e-3)
        record = int(np.argmin(result.gap.values.min(axis=1)))
        assert 0.0 < result.gap.values[record].min() < 0.2 * synthetic.CLEARANCE
        index = export_vtk(
            result,
            tmp_path,
            frames=1,
            start=float(result.time[record]),
            surface=surface,
            rotating=rotating,
            exaggeration=30.0,
        )
        frame: Frame = "rotating" if rotating else "static"
        drawing = Drawing(result, np.array([record]), exaggeration=30.0, frame=frame)
        seen = drawing.picture(0)
        meshes = {name: read(index, name) for name in PARTS}
        np.testing.assert_allclose(place(meshes["contact"], "warp")[:, :2], seen.tips, atol=1e-7)
        springs = place(meshes["supports"], "warp")[:, :2].reshape(-1, 2, 2)
        np.testing.assert_allclose(springs, seen.symbols.springs, atol=1e-7)
        if surface:
            ends = seen.rotor.sides[:, -1].reshape(-1, 2)
            corners = place(meshes["rotor"], "warp")[:, :2]
            assert np.linalg.norm(ends[:, None] - corners, axis=-1).min(axis=1).max() < 2e-4
        inner = np.isin(np.arange(len(meshes["casing"].points)) % 4, [0, 3])
        angle, radius = polar(place(meshes["casing"], "warp")[inner])
        np.testing.assert_allclose(
            radius, interpolated(angle, *polar(seen.casing.sides[0, :-1, 0])), atol=1e-5
        )
        for share in (0.0, 0.3, 1.0, 1.5):
            tips, wall = (
                polar(meshes[name].points + share * meshes[name].point_data["warp"])
                for name in ("contact", "casing")
            )
            room = interpolated(tips[0], wall[0][inner], wall[1][inner]) - tips[1]
            assert room.min() > 0

    def test_gap_and_force_at_the_tips(self, result: xr.Dataset, tmp_path: Path) -> None:
        record = int(np.argmax(result.contacts.values))
        index = export_vtk(result, tmp_path, frames=1, start=float(result.time[record]))
        tips, rotor = (read(index, name) for name in ("contact", "rotor"))
        gap = result.gap.values[record]
        np.testing.assert_allclose(tips.point_data["gap"], gap, rtol=1e-6)
        blade = np.repeat(rotor.cell_data["blade"][0], 2)
        expected = np.where(blade >= 0, gap[blade], synthetic.CLEARANCE)
        np.testing.assert_allclose(rotor.point_data["gap"], expected, rtol=1e-6)
        force = contact_forces(result, np.array([record]))[0]
        assert force.any()
        np.testing.assert_allclose(tips.point_data["contact_force"], force, rtol=1e-6)

    def test_velocity_is_the_rate_of_displacement_in_the_axes_of_the_series(
        self, result: xr.Dataset, tmp_path: Path
    ) -> None:
        for rotating in (False, True):
            index = export_vtk(
                result,
                tmp_path / str(rotating),
                frames=3,
                start=0.1,
                end=0.1 + 2 * synthetic.RECORD_STEP,
                rotating=rotating,
            )
            for name in ("rotor", "casing", "contact"):
                before, now, after = (read(index, name, n).point_data for n in range(3))
                slope = after["displacement"] - before["displacement"]
                slope /= 2 * synthetic.RECORD_STEP
                np.testing.assert_allclose(now["velocity"], slope, atol=5e-3 * np.abs(slope).max())

    def test_a_series_begins_with_the_run(self, result: xr.Dataset, tmp_path: Path) -> None:
        still = result.isel(time=slice(20)).copy(deep=True)
        for body in ("rotor", "casing"):
            still[f"{body}_displacement"][:2] = 0.0
        index = export_vtk(still, tmp_path, frames=20)
        assert float(entries(index)[0]["timestep"]) == 0.0


class TestUndeformedMesh:
    def test_named_sets(self, series: Path, result: xr.Dataset) -> None:
        mesh = meshio.read(series.parent / "mesh.vtu")
        blades, spokes = 22, 22
        counts = {"blades": 4 * blades, "spokes": spokes, "rim": blades, "casing": 40}
        for name, count in counts.items():
            assert mesh.cell_data[name][0].sum() == count
        np.testing.assert_array_equal(mesh.cell_data["rotor"][0] + mesh.cell_data["casing"][0], 1)
        thickness = mesh.cell_data["thickness"][0]
        np.testing.assert_allclose(thickness[mesh.cell_data["spokes"][0] == 1], 0.030)
        np.testing.assert_allclose(thickness[mesh.cell_data["casing"][0] == 1], 0.010)
        tips = np.flatnonzero(mesh.point_data["tips"])
        np.testing.assert_allclose(np.linalg.norm(mesh.points[tips], axis=1), 0.25)
        np.testing.assert_array_equal(mesh.point_data["blade"][tips], np.arange(blades))
        assert np.flatnonzero(mesh.point_data["centre"]) == [int(result.centre_node)]


@pytest.mark.slow
def test_portions_have_no_effect(
    result: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = export_vtk(result, tmp_path / "whole", frames=20)
    monkeypatch.setattr(vtk_parts, "PORTION", 7)
    parts = export_vtk(result, tmp_path / "parts", frames=20)
    assert entries(whole) == entries(parts)
    for entry in entries(whole):
        one, other = (meshio.read(index.parent / entry["file"]) for index in (whole, parts))
        for name, values in one.point_data.items():
            np.testing.assert_allclose(values, other.point_data[name], rtol=1e-5, atol=1e-7)


def coloured_by_deformation(result: xr.Dataset) -> float:
    """Return the largest deformation of the wall [m], which pictures colour."""
    drawing = Drawing(result, np.arange(result.sizes["time"]), colour="deformation")
    return float(drawing.colouring.casing.max())


def test_view_runs_in_paraview(
    result: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the script asks for; `.ci/paraview` runs it in ParaView itself."""
    simple = MagicMock()
    simple.GetParaViewVersion.return_value = (5, 11)
    hardest = int(result["contact_impulse"].values.max(axis=1).argmax())
    result = result.isel(time=slice(max(hardest - 20, 0), hardest + 20))
    folder = export_vtk(result, tmp_path, frames=40, exaggeration=30.0).parent
    monkeypatch.setitem(sys.modules, "paraview", MagicMock(simple=simple))
    monkeypatch.setattr(sys, "argv", ["view.py", "picture.png"])
    runpy.run_path(str(folder / "view.py"))
    simple.PVDReader.assert_called_once_with(
        registrationName="series", FileName=str(folder / "series.pvd")
    )
    force = result.contact_impulse.max("contact_node").values
    shown = simple.GetAnimationScene.return_value.AnimationTime
    assert shown == pytest.approx(float(result.time[int(np.argmax(force))]))
    assert simple.WarpByVector.return_value.Vectors == ["POINTS", "warp"]
    named = {call.kwargs["registrationName"] for call in simple.Calculator.call_args_list}
    assert named == {"deformation of the rotor [mm]", "deformation of the casing [mm]"}
    points = simple.GetColorTransferFunction.return_value.RGBPoints
    assert points[:4] == [0.0, 1.0, 1.0, 1.0]  # zero is white
    largest = 1e3 * coloured_by_deformation(result)
    assert largest <= points[-4] < 1.3 * largest
    assert "30 times as large" in simple.Text.call_args.kwargs["Text"]
    assert simple.SaveScreenshot.call_args.args[0] == "picture.png"

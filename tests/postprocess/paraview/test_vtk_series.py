"""The ParaView series, read back with readers that are not ours."""

import logging
import os
import xml.etree.ElementTree as ET
from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.paraview import series as vtk_series
from bladewhirl.postprocess.paraview.series import SeriesWriter, export_vtk


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


def warp(mesh: meshio.Mesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.asarray(mesh.points + mesh.point_data["displacement"])


class TestIndex:
    def test_times_are_physical_and_parts_named(self, series: Path) -> None:
        listed = entries(series)
        for number, name in enumerate(("rotor", "casing")):
            part = [entry for entry in listed if entry["name"] == name]
            assert {entry["part"] for entry in part} == {str(number)}
            times = [float(entry["timestep"]) for entry in part]
            np.testing.assert_allclose(times, np.linspace(0.1, 0.2, 21), atol=1e-12)
        assert all((series.parent / entry["file"]).is_file() for entry in listed)

    def test_pyvista_opens_it_at_a_time(self, series: Path, result: xr.Dataset) -> None:
        reader = pyvista.PVDReader(series)
        assert len(reader.time_values) == 21
        reader.set_active_time_value(reader.time_values[4])
        rotor, casing = reader.read()
        assert rotor.n_cells == result.sizes["rotor_line"]
        assert np.all(rotor.celltypes == pyvista.CellType.LINE)
        assert casing.n_points == casing.n_cells == 360

    def test_parses_after_every_frame(
        self, result: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        complete = []
        add = SeriesWriter.add

        def add_and_read(self: SeriesWriter, time: float, parts: dict[str, meshio.Mesh]) -> None:
            add(self, time, parts)
            listed = entries(self.index)
            complete.append(len(listed))
            meshio.read(self.folder / listed[-1]["file"])

        monkeypatch.setattr(SeriesWriter, "add", add_and_read)
        export_vtk(result, tmp_path, frames=6)
        assert complete == [2, 4, 6, 8, 10, 12]

    def test_killed_while_writing_the_index(
        self, result: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        writes = []
        replace = os.replace

        def die(source: Path, target: Path) -> None:
            writes.append(target)
            if len(writes) == 7:  # manifest, an empty index, mesh, then an index per frame
                raise KeyboardInterrupt
            replace(source, target)

        monkeypatch.setattr(os, "replace", die)
        with pytest.raises(KeyboardInterrupt):
            export_vtk(result, tmp_path, frames=10)
        assert len(entries(tmp_path / "series.pvd")) == 2 * 3

    def test_a_shorter_export_leaves_no_old_frames(
        self, result: xr.Dataset, tmp_path: Path
    ) -> None:
        export_vtk(result, tmp_path, frames=9)
        export_vtk(result, tmp_path, frames=4)
        assert len(entries(tmp_path / "series.pvd")) == 8
        assert len(list((tmp_path / "frames").glob("*.vtu"))) == 8

    def test_frames_of_others_stay(self, result: xr.Dataset, tmp_path: Path) -> None:
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
    def test_warp_of_a_rigid_translation_is_the_translated_stage(
        self, result: xr.Dataset, tmp_path: Path
    ) -> None:
        moved = result.copy(deep=True)
        moved["rotor_displacement"][:] = np.array([3e-3, -1e-3, 0, 0, 0])
        moved["casing_displacement"][:] = np.array([-2e-3, 5e-4, 0, 0])
        index = export_vtk(moved, tmp_path, frames=5)
        for entry in entries(index):
            mesh = meshio.read(index.parent / entry["file"])
            if entry["name"] == "rotor":
                angle = synthetic.SPEED * float(entry["timestep"])
                to_static = np.array(
                    [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
                )
                expected = (result.rotor_point.values + np.array([3e-3, -1e-3])) @ to_static.T
                np.testing.assert_allclose(warp(mesh)[:, :2], expected, atol=1e-15)
            else:
                radii = np.linalg.norm(warp(mesh) - [-2e-3, 5e-4, 0.0], axis=1)
                np.testing.assert_allclose(radii, result.attrs["casing_radius"], atol=1e-8)

    def test_fields_are_complete_finite_and_named(self, series: Path) -> None:
        both = {"displacement": 3, "velocity": 3, "radial_displacement": 1}
        tips = {"gap": 1, "contact_force": 3}
        for name, expected in (("rotor", both | tips), ("casing", both)):
            mesh = meshio.read(series.parent / "frames" / f"{name}_00003.vtu")
            found = {key: 1 if a.ndim == 1 else a.shape[1] for key, a in mesh.point_data.items()}
            assert found == expected
            assert all(np.isfinite(array).all() for array in mesh.point_data.values())

    def test_gap_and_force_at_the_tips(self, result: xr.Dataset, tmp_path: Path) -> None:
        record = int(np.argmax(result.contacts.values))
        time = float(result.time[record])
        index = export_vtk(result, tmp_path, frames=1, start=time)
        mesh = meshio.read(index.parent / "frames" / "rotor_00000.vtu")
        tips = result.tip_node.values
        np.testing.assert_array_equal(mesh.point_data["gap"][tips], result.gap.values[record])
        away = np.delete(mesh.point_data["gap"], tips)
        np.testing.assert_allclose(away, synthetic.CLEARANCE)
        force = mesh.point_data["contact_force"]
        normal = result.contact_impulse.values[record] / synthetic.RECORD_STEP
        assert normal.max() > 0
        np.testing.assert_allclose(
            np.linalg.norm(force[tips], axis=1), normal * np.hypot(1.0, 0.1), rtol=1e-12
        )
        outward = mesh.points[tips] / synthetic.TIP_RADIUS
        np.testing.assert_allclose(np.sum(force[tips] * outward, axis=1), -normal, atol=1e-12)
        assert not np.delete(force, tips, axis=0).any()

    def test_velocity_and_radial_displacement(self, result: xr.Dataset, tmp_path: Path) -> None:
        index = export_vtk(result, tmp_path, frames=1, start=0.123)
        mesh = meshio.read(index.parent / "frames" / "casing_00000.vtu")
        angle = np.arctan2(mesh.points[:, 1], mesh.points[:, 0])
        w = synthetic.casing_w(angle, result.casing_displacement.values[123])
        w_dot = synthetic.casing_w(angle, result.casing_velocity.values[123])
        outward = mesh.points / result.attrs["casing_radius"]
        velocity = np.sum(mesh.point_data["velocity"] * outward, axis=1)
        np.testing.assert_allclose(
            mesh.point_data["radial_displacement"], w, atol=3e-5 * np.abs(w).max()
        )
        np.testing.assert_allclose(velocity, w_dot, atol=3e-5 * np.abs(w_dot).max())

    def test_rotating_frame_keeps_the_rotor_and_turns_the_casing_back(
        self, result: xr.Dataset, tmp_path: Path
    ) -> None:
        time = 0.25
        static = export_vtk(result, tmp_path / "static", frames=1, start=time)
        turning = export_vtk(result, tmp_path / "turning", frames=1, start=time, rotating=True)
        angle = -synthetic.SPEED * time
        back = np.array(
            [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
        )
        for name in ("rotor", "casing"):
            seen, stood = (
                meshio.read(index.parent / "frames" / f"{name}_00000.vtu")
                for index in (turning, static)
            )
            np.testing.assert_allclose(seen.points, stood.points @ back.T, atol=1e-15)
            np.testing.assert_allclose(warp(seen), warp(stood) @ back.T, atol=1e-15)
            if name == "rotor":
                np.testing.assert_allclose(seen.points[:, :2], result.rotor_point.values)

    def test_a_hint_where_the_turn_is_not_resolved(
        self, result: xr.Dataset, tmp_path: Path, caplog: pytest.LogCaptureFixture
    ) -> None:
        caplog.set_level(logging.INFO)
        export_vtk(result, tmp_path, frames=10, start=0.0, end=0.02)
        assert "revolution" not in caplog.text
        export_vtk(result, tmp_path, frames=10)
        assert "a revolution" in caplog.text


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

    def test_pyvista_reads_it(self, series: Path) -> None:
        mesh = pyvista.read(series.parent / "mesh.vtu")
        assert mesh.n_cells == 22 * 6 + 40
        assert "tips" in mesh.point_data


def test_portions_do_not_show(
    result: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = export_vtk(result, tmp_path / "whole", frames=20)
    monkeypatch.setattr(vtk_series, "PORTION", 7)
    parts = export_vtk(result, tmp_path / "parts", frames=20)
    assert entries(whole) == entries(parts)
    for entry in entries(whole):
        one, other = (meshio.read(index.parent / entry["file"]) for index in (whole, parts))
        np.testing.assert_allclose(warp(one), warp(other), atol=1e-15)

"""Beams and wall as boxes: their volume, how they move, and the stress at their surfaces."""

from collections.abc import Mapping
from pathlib import Path

import meshio
import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.paraview import series as vtk_series
from bladewhirl.postprocess.paraview.series import export_vtk
from bladewhirl.postprocess.paraview.surfaces import Boxes, SurfaceSeries, casing_boxes, rotor_boxes

WIDTH, BLADE = 0.1, 0.010  # of the synthetic stage [m]
RIGID = np.array([3e-3, -1e-3])


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return synthetic.synthetic_result(records=3)


def moved(result: xr.Dataset, **coordinates: list[float]) -> xr.Dataset:
    """The result with the same modal coordinates, of "rotor" or "casing", in all records."""
    copy = result.copy(deep=True)
    for body, values in coordinates.items():
        copy[f"{body}_displacement"][:] = np.array(values)
    return copy


def volume(boxes: Boxes) -> float:
    """Volume inside the faces by the divergence theorem: positive where they look outward."""
    corner = boxes.points()[boxes.quads()]
    middle = corner.mean(axis=1)
    area = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]) / 2
    return float(np.sum(middle * area) / 3)


def corners(result: xr.Dataset, boxes: Boxes) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Displacement of the corners (corner, 2) at the first record, in the body's axes."""
    return np.asarray(boxes.vectors(result, "displacement", np.array([0]))[0])


def test_beams_fill_their_volume(result: xr.Dataset) -> None:
    ends = result["rotor_point"].values[result["rotor_line"].values]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    expected = np.sum(length * result["rotor_thickness"].values) * WIDTH
    assert volume(rotor_boxes(result)) == pytest.approx(expected, rel=1e-12)


def test_the_wall_fills_its_volume(result: xr.Dataset) -> None:
    inner = synthetic.TIP_RADIUS + synthetic.CLEARANCE
    expected = np.pi * ((inner + 0.010) ** 2 - inner**2) * WIDTH
    coarse, fine = (abs(volume(casing_boxes(result, n)) / expected - 1) for n in (200, 800))
    assert fine < 1e-4
    assert coarse / fine == pytest.approx(16, rel=0.01)  # chords: second order


def test_a_rotor_that_moves_as_a_whole(result: xr.Dataset) -> None:
    boxes = rotor_boxes(result)
    shifted = moved(result, rotor=[*RIGID, 0, 0, 0])
    np.testing.assert_allclose(corners(shifted, boxes) - RIGID, 0, atol=1e-15)
    turned = corners(moved(result, rotor=[0, 0, 1e-3, 0, 0]), boxes)
    x, y, _ = boxes.points().T
    np.testing.assert_allclose(turned, 1e-3 * np.column_stack([-y, x]), atol=1e-15)


def test_a_casing_that_moves_as_a_whole(result: xr.Dataset) -> None:
    shifted = corners(moved(result, casing=[*RIGID, 0, 0]), casing_boxes(result))
    np.testing.assert_allclose(shifted - RIGID, 0, atol=2e-8)  # cubics follow a circle


def test_stress_at_both_sides_of_a_bent_blade(result: xr.Dataset) -> None:
    bent = moved(result, rotor=[0, 0, 0, 1e-3, 0])
    boxes = rotor_boxes(bent, pieces=1)
    mesh = SurfaceSeries(bent, boxes, rotating=True).meshes(np.array([0]))[0]
    blade = np.flatnonzero(bent["rotor_part"].values == "blades")[:4]  # on +x, bent towards +y
    stress = mesh.point_data["surface_stress"].reshape(*boxes.shape, 4)[blade]
    span = synthetic.TIP_RADIUS - synthetic.DISK_RADIUS
    share = (boxes.line[blade, :, 0] - synthetic.DISK_RADIUS) / span
    curvature = 1e-3 * 3 * (1 - share) / span**2
    right = synthetic.YOUNG_MODULUS * BLADE / 2 * curvature  # the side on -y is pulled
    size = right.max()
    np.testing.assert_allclose(stress[..., 0], right, atol=1e-6 * size)
    np.testing.assert_allclose(stress[..., 3], right, atol=1e-6 * size)
    np.testing.assert_allclose(stress[..., 1], -right, atol=1e-6 * size)
    y = mesh.points[:, 1].reshape(*boxes.shape, 4)[blade]
    assert np.all(y[..., [0, 3]] < 0)
    np.testing.assert_allclose(
        mesh.point_data["bending_strain"].reshape(*boxes.shape, 4)[blade][..., 2],
        right / synthetic.YOUNG_MODULUS,
        atol=1e-6 * size / synthetic.YOUNG_MODULUS,
    )


SURFACE = {
    "displacement": 3,
    "velocity": 3,
    "radial_displacement": 1,
    "axial_strain": 1,
    "bending_strain": 1,
    "axial_stress": 1,
    "bending_stress": 1,
    "surface_stress": 1,
}
PARTS: Mapping[str, Mapping[str, int]] = {
    "rotor": SURFACE,
    "casing": SURFACE,
    "contact": {"displacement": 3, "gap": 1, "contact_force": 3},
}


class TestSeries:
    def test_parts_and_fields(self, result: xr.Dataset, tmp_path: Path) -> None:
        export_vtk(result, tmp_path, frames=2, surface=True)
        for name, expected in PARTS.items():
            mesh = meshio.read(tmp_path / "frames" / f"{name}_00001.vtu")
            found = {key: 1 if a.ndim == 1 else a.shape[1] for key, a in mesh.point_data.items()}
            assert found == expected
            assert all(np.isfinite(array).all() for array in mesh.point_data.values())

    def test_blades_turn_and_the_casing_stands(self, result: xr.Dataset, tmp_path: Path) -> None:
        export_vtk(result, tmp_path, frames=3, surface=True)
        first, last = (
            {n: meshio.read(tmp_path / "frames" / f"{n}_0000{i}.vtu").points for n in PARTS}
            for i in (0, 2)
        )
        angle = synthetic.SPEED * float(result.time[2])
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        np.testing.assert_allclose(last["rotor"], first["rotor"] @ turn.T, atol=1e-7)
        np.testing.assert_allclose(last["contact"], first["contact"] @ turn.T, atol=1e-7)
        np.testing.assert_array_equal(last["casing"], first["casing"])

    def test_portions_do_not_show(
        self, result: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        seen: list[tuple[int, int]] = []
        export_vtk(result, tmp_path / "whole", frames=3, surface=True)
        monkeypatch.setattr(vtk_series, "PORTION_POINTS", 1)  # one record at a time
        export_vtk(
            result,
            tmp_path / "parts",
            frames=3,
            surface=True,
            progress=lambda done, total: seen.append((done, total)),
        )
        assert seen == [(1, 3), (2, 3), (3, 3)]
        for file in sorted((tmp_path / "whole" / "frames").iterdir()):
            one, other = meshio.read(file), meshio.read(tmp_path / "parts" / "frames" / file.name)
            np.testing.assert_allclose(one.points, other.points, atol=1e-7)
            for name, values in one.point_data.items():
                np.testing.assert_allclose(values, other.point_data[name], rtol=1e-5, atol=1e-12)

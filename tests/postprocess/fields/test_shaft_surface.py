"""A wheel on its shaft line: hub, shaft and bearings are drawn where the result has them."""

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import xarray as xr
from solid_meshes import fan_sector, whole

import bladewhirl as bw
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.superelements.file import write_superelement
from bladewhirl.postprocess.fields.points import points_of
from bladewhirl.postprocess.fields.shaft_surface import AROUND
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.studies.runs.run import run

NODE, HUB, FACTOR, RECORD = 3, -5e-3, 40.0, 7  #: node of the wheel; its hub in its axes [m]


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """A short run with an unbalance; the first bearing has a support."""
    place = tmp_path_factory.mktemp("wheel")
    steel: dict[str, Any] = {"young_modulus": 2.1e11, "poisson_ratio": 0.3, "density": 7850.0}
    part = mesh3d(whole(fan_sector(3), 3), **steel, stress=False, hub="root", hub_at=HUB)
    write_superelement(place / "fan.npz", part)
    (place / "case.toml").write_text(
        """
bladed_disk.superelement = { file = "fan.npz", copies = 3 }
casing = { type = "rigid", clearance = 0.05 }
reduction.free_interface_modes = 24
[march]
speed = "900 rad/s"
time_step = 2e-6
record_step = 2e-4
duration = 2e-3
displacement_limit = 1
[shaft_line]
segments = [{ length = 0.6, outer_diameter = 0.04, elements = 3 }]
wheel.position = 0.6
axial = { position = 0, stiffness = 5e7 }
unbalance = [{ position = 0.6, unbalance = 0.01 }]
[[shaft_line.bearings]]
position = 0
stiffness = 1e7
support = { mass = 1.0, stiffness = 1e7 }
[[shaft_line.bearings]]
position = 0.4
stiffness = 1e7
""",
        encoding="utf-8",
    )
    run(bw.read_case(place / "case.toml"), place / "run", frames=0)
    with bw.open_result(place / "run") as opened:
        return opened.load()


def turned(vectors: Any, angle: float) -> Any:
    """Vectors (..., 3) turned about z, by a matrix."""
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(vectors) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def test_the_bore_of_the_wheel_moves_with_its_node_of_the_shaft(result: xr.Dataset) -> None:
    """As a rigid body about the hub, whose position on the line follows from the stored origin."""
    assert float(result["wheel_origin"]) == pytest.approx(0.6 - HUB)
    points, angle = points_of(result, 1), 900.0 * float(result["time"][RECORD])
    bore = np.isclose(np.hypot(*points.rest[:, :2].T), 0.04, rtol=1e-6)
    moved = points.moved(result["rotor_displacement"].values[RECORD])[bore]
    shaft = result["shaft_displacement"].values[RECORD, NODE]
    shift, tilt = turned(shaft[:3], -angle), turned(shaft[3:], -angle)
    expected = shift + np.cross(tilt, points.rest[bore] - [0.0, 0.0, HUB])
    np.testing.assert_allclose(moved, expected, atol=1e-6 * abs(expected).max())
    assert abs(expected).max() > 1e-6


@pytest.mark.parametrize("frame", ["static", "rotating"])
def test_shaft_and_bearings_are_drawn_at_their_enlarged_positions(
    result: xr.Dataset, frame: Any, tmp_path: Path
) -> None:
    drawing = Drawing(result, np.array([RECORD]), exaggeration=FACTOR, frame=frame)
    body: Any = drawing._body
    shaft, *rings = (
        solid.points @ body._axes + body._focus for solid in drawing.picture(0).solids[-3:]
    )
    back = -900.0 * float(result["time"][RECORD]) * (frame == "rotating")
    moved = turned(result["shaft_displacement"].values[RECORD, :, :3], back)
    place = result["shaft_position"].values - 0.6 + HUB
    middles = np.pad(place[:, None], ((0, 0), (2, 0))) + FACTOR * moved
    sections = shaft.reshape(-1, AROUND, 3)
    np.testing.assert_allclose(sections.mean(axis=1), middles, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(sections - middles[:, None], axis=2), 0.02, rtol=0.05)
    support = turned(np.pad(result["support_displacement"].values[RECORD], ((0, 0), (0, 1))), back)
    assert np.linalg.norm(support[0]) > 1e-7
    assert not support[1].any()
    for ring, node, shift in zip(rings, (0, 2), support, strict=True):
        np.testing.assert_allclose(
            ring.mean(axis=0), [0.0, 0.0, place[node]] + FACTOR * shift, atol=1e-9
        )
    look = {"rotating": frame == "rotating", "exaggeration": FACTOR}
    bw.export_vtk(result, tmp_path, records=np.array([RECORD]), **look)
    for name, drawn in (("shaft", shaft), ("bearings", np.concatenate(rings))):
        mesh = meshio.read(tmp_path / "frames" / f"{name}_00000.vtu")
        np.testing.assert_allclose(mesh.points + mesh.point_data["warp"], drawn, atol=1e-6)

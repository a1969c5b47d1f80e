"""Runs of a shaft line: results, summary, figures, report, resumed marches, sweeps."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from PIL import Image
from shaft_line_case import line_case
from solid_meshes import fan_sector, whole

import bladewhirl as bw
from bladewhirl.models.case.case import case_from
from bladewhirl.models.case.shaft_line import ShaftLine
from bladewhirl.models.inputs.errors import CaseError, UserError
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.superelements.file import write_superelement
from bladewhirl.postprocess.paraview.series import export_vtk
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.shaft_line.rotor import plot_rotor, rotor_of, seen
from bladewhirl.studies.runs.run import resume, run


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run."""
    place = tmp_path_factory.mktemp("line") / "run"
    run(line_case(), place, frames=0)
    return place


def test_a_result_has_the_motion_of_the_line_and_the_forces_of_its_bearings(folder: Path) -> None:
    with bw.open_result(folder) as result:
        moved, force = result["shaft_displacement"], result["bearing_force"]
        assert moved.sizes == {"time": 501, "shaft_node": 5, "shaft_component": 6}
        assert result["bearing_name"].values.tolist() == ["front", "2"]
        assert result.sizes["contact_node"] == 0
        # the line moves by the static sag and turns its sections as it bends
        along = np.gradient(moved.values[0, :, 1], result["shaft_position"].values)
        slope = -moved.sel(shaft_component="rotation_x").values[0]
        np.testing.assert_allclose(along[1:-1], slope[1:-1], atol=0.15 * abs(slope).max())
        # a force of the bearing on the support: stiffness of the bearing times the difference
        support = result["support_displacement"].values[0, 0]
        np.testing.assert_allclose(
            force.values[0, 0], -2e6 * (moved.values[0, 0, :2] - support), rtol=1e-9, atol=1e-9
        )
        assert result["line_energy"].values[0] > 0.0


def test_summary_figures_and_report(folder: Path, tmp_path: Path) -> None:
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert summary["regime"] == "no-contact"
    assert summary["energy_residual"] < 1e-9
    with bw.open_result(folder) as result:
        force = np.hypot(*np.moveaxis(result["bearing_force"].values, 2, 0))
        assert summary["bearing_force_max"] == force.max()
        x, y, *_ = np.moveaxis(result["shaft_displacement"].values, 2, 0)
        assert summary["shaft_radius_max"] == np.hypot(x, y).max()
        _, orbits = RunFigures(result).draw("line-orbits")
        assert orbits["support"].values[:, 0].any()
        _, forces = RunFigures(result).draw("line-bearing-forces")
        np.testing.assert_array_equal(forces["force"].values, force)
        with pytest.raises(bw.UserError, match="tip_angle"):
            RunFigures(result).draw("forces")
    assert "largest force of a bearing" in bw.report(folder).read_text(encoding="utf-8")


def test_a_resumed_run_is_the_same_to_the_last_bit(folder: Path, tmp_path: Path) -> None:
    whole, part = tmp_path / "whole", tmp_path / "part"
    run(line_case(duration=0.03), part, frames=0)
    resume(part, ["march.duration=0.05"], frames=0)
    with bw.open_result(part) as found, bw.open_result(folder) as expected:
        assert not whole.exists()
        for name in ("shaft_displacement", "bearing_force", "coupling_work", "energy"):
            np.testing.assert_array_equal(found[name].values, expected[name].values)


@pytest.mark.slow
def test_a_moved_run_has_copies_of_the_files_of_all_wheels(tmp_path: Path) -> None:
    """Of the wheel, of another one and of the one that has lost a blade, beside the case file."""
    origin, moved, march = tmp_path / "origin", tmp_path / "moved", 'speed = "900 rad/s"'
    origin.mkdir()
    steel: dict[str, Any] = {"young_modulus": 2.1e11, "poisson_ratio": 0.3, "density": 7850.0}
    steel |= {"stress": False, "hub": "root", "hub_at": "-5 mm"}
    mesh, gone = whole(fan_sector(3), 3), "r > 79.9 mm and -30 < angle < 30"
    wheel, left = mesh3d(mesh, **steel), mesh3d(mesh, **steel, lost=gone)
    stiffer = replace(wheel, stiffness=1.1 * wheel.stiffness)
    for name, part in {"first": wheel, "second": stiffer, "left": left}.items():
        write_superelement(origin / f"{name}.npz", part)
    (origin / "case.toml").write_text(
        f"""
bladed_disk.superelement = {{ file = "first.npz", copies = 3 }}
casing = {{ type = "rigid", clearance = 0.05 }}
reduction.free_interface_modes = 12
blade_loss = {{ blade = 2, time = 5e-5, damaged = {{ file = "left.npz" }} }}
march = {{ {march}, time_step = 1e-6, record_step = 1e-5, duration = 1e-4, displacement_limit = 1 }}
[shaft_line]
segments = [{{ length = 0.6, outer_diameter = 0.04, elements = 3 }}]
bearings = [{{ position = 0, stiffness = 1e7 }}, {{ position = 0.4, stiffness = 1e7 }}]
wheel.position = 0.6
wheels = [{{ position = 0.2, superelement = {{ file = "second.npz", copies = 3 }} }}]
axial = {{ position = 0, stiffness = 5e7 }}
""",
        encoding="utf-8",
    )
    run(bw.read_case(origin / "case.toml"), origin / "run", frames=0)
    shutil.move(origin / "run", moved)
    contents = {path.stem: path.read_bytes() for path in origin.glob("*.npz")}
    shutil.rmtree(origin)
    for copy, name in {"superelement": "first", "wheel-2": "second", "damaged": "left"}.items():
        assert (moved / f"{copy}.npz").read_bytes() == contents[name]
    assert str(tmp_path) not in (moved / "case.toml").read_text(encoding="utf-8")
    resume(moved, ["march.duration=4e-4"], frames=0)
    with bw.open_result(moved) as result:
        assert result.sizes["time"] == 41
        assert str(tmp_path) not in result.attrs["case"]


@pytest.mark.slow
def test_a_run_has_the_rings_of_all_wheels(tmp_path: Path) -> None:
    """Two wheels are pressed into rings by gravity; figures have the rings one by one."""
    steel: dict[str, Any] = {"young_modulus": 2.1e11, "poisson_ratio": 0.3, "density": 7850.0}
    part = mesh3d(whole(fan_sector(3), 3), **steel, stress=False, hub="root", hub_at="-5 mm")
    write_superelement(tmp_path / "fan.npz", part)
    ring: dict[str, Any] = {"type": "ring", "clearance": 1e-6}
    fan = {"file": str(tmp_path / "fan.npz"), "copies": 3}
    strut = {"angle": "90 deg", "length": "100 mm", "thickness": "5 mm"}
    case = case_from(
        {
            "bladed_disk": {"superelement": fan},
            "shaft_line": {
                "segments": [{"length": 0.6, "outer_diameter": 0.04, "elements": 3}],
                "bearings": [{"position": at, "stiffness": 1e6} for at in (0.0, 0.4)],
                "wheel": {"position": 0.6},
                "wheels": [
                    {"position": 0.3, "superelement": fan},
                    {
                        "position": 0.2,
                        "superelement": fan,
                        "casing": ring | {"struts": [strut], "wall": {"thickness": 4e-3}},
                    },
                ],
            },
            "gravity": {"acceleration": [0.0, -5000.0], "start": "unbent"},
            "casing": ring | {"elements": 16},
            "reduction": {"free_interface_modes": 12},
            "march": {"speed": "900 rad/s", "time_step": 1e-6, "duration": 4e-4},
        }
    )
    run(case, tmp_path / "run", frames=0)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text(encoding="utf-8"))
    with bw.open_result(tmp_path / "run") as result:
        assert result["wheel"].values.tolist() == [0] * 6 + [2] * 6
        assert result["support_wheel"].values.tolist() == [2]
        first, other = np.split(result["casing_shape"].values[:, 0], 2)
        radial = [rows @ result["casing_displacement"].values.T for rows in (first, other)]
        for wheel, rows in zip((0, 2), radial, strict=True):
            assert rows.any()
            moved = bw.casing_displacement(result, angle="90 deg", wheel=wheel)["displacement"]
            np.testing.assert_allclose(moved.values[:, 0, 0], rows[4], rtol=1e-9, atol=1e-15)
        peak = summary["casing_displacement_max"]["radial"]
        assert peak["wheel"] == (0, 2)[int(np.argmax([np.abs(rows).max() for rows in radial]))]
        assert abs(peak["displacement"]) >= max(np.abs(rows).max() for rows in radial)
        figure, _ = RunFigures(result).draw("casing")
        assert [axes.get_title(loc="left") for axes in figure.axes[:4:2]] == ["wheel 0", "wheel 2"]
        RunFigures(result).draw("card")


def test_a_free_line_is_braked_by_its_losses(tmp_path: Path) -> None:
    case = line_case(drive={"inertia": 0.1, "loss": 0.5}, gravity=False)
    run(case, tmp_path / "run", frames=0)
    with bw.open_result(tmp_path / "run") as result:
        speed, time = result["rotation_speed"].values, result["time"].values
        inertia = 0.1 + 0.06 + 7850.0 * 0.6 * np.pi / 32.0 * 0.04**4
        decay = np.exp(-0.5 / inertia * time)
        np.testing.assert_allclose(speed / speed[0], decay, rtol=2e-3)


def test_gravity_and_a_free_speed_are_refused() -> None:
    with pytest.raises(CaseError, match=r"gravity = .*march.drive"):
        line_case(drive={"inertia": 0.1})


def test_a_time_step_above_the_limit_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"march.time_step = 0.001: .* fewer shaft_line.modes"):
        run(line_case(time_step=1e-3, record_step=1e-3), tmp_path / "run", frames=0)


@pytest.mark.parametrize("rotating", [False, True])
def test_a_series_has_the_surface_of_the_shaft(
    folder: Path, tmp_path: Path, rotating: bool
) -> None:
    """A point on a section moves by the deflection and turns about it."""
    with bw.open_result(folder) as result:
        export_vtk(result, tmp_path, frames=3, rotating=rotating, exaggeration=50.0)
        moved = result["shaft_displacement"].values[-1, 2]
        turned = result.attrs["speed"] * float(result["time"][-1])
    mesh = meshio.read(tmp_path / "frames" / "shaft_00002.vtu")
    section = np.isclose(mesh.points[:, 2], 0.3)
    middle = mesh.point_data["displacement"][section].mean(axis=0)
    of_axis = (moved[0] + 1j * moved[1]) * np.exp(-1j * turned * rotating)
    np.testing.assert_allclose(middle[0] + 1j * middle[1], of_axis, atol=1e-4 * abs(of_axis))
    _, y, _ = mesh.points[section].T
    x = mesh.points[section, 0]
    tilt = (moved[3] + 1j * moved[4]) * np.exp(-1j * turned * rotating)
    along = mesh.point_data["displacement"][section, 2]
    np.testing.assert_allclose(along, tilt.real * y - tilt.imag * x, atol=1e-4 * abs(along).max())
    warp = mesh.point_data["warp"]
    np.testing.assert_allclose(warp, 50.0 * mesh.point_data["displacement"], rtol=1e-5)


def test_stills_and_films_show_the_rotor_and_its_orbits(folder: Path, tmp_path: Path) -> None:
    still = bw.render(folder, tmp_path / "still.png")
    early = bw.render(folder, tmp_path / "early.png", time=0.0)
    film = bw.render(folder, tmp_path / "film.gif", frames=4, exaggeration=100.0)
    with Image.open(still) as one, Image.open(early) as other, Image.open(film) as pictures:
        assert one.size == other.size
        assert np.asarray(one.convert("RGB")).std() > 10.0
        assert (np.asarray(one) != np.asarray(other)).any()
        assert getattr(pictures, "n_frames") == 4  # noqa: B009
    refused: tuple[dict[str, Any], ...] = ({"orbit": True}, {"frame": "rotating"}, {"frames": 4})
    for options in refused:
        with pytest.raises(UserError, match="shaft line"):
            bw.render(folder, tmp_path / "no.png", **options)


def test_a_picture_shows_each_part_where_it_is() -> None:
    disk = {
        "position": 0.3,
        "offset": 0.02,
        "mass": 8.0,
        "polar_inertia": 0.06,
        "diametral_inertia": 0.0302,
    }
    table = line_case().shaft_line
    assert table is not None
    table = ShaftLine(**table.model_dump(exclude_none=True) | {"disks": [disk]})
    rotor = rotor_of(table, np.linspace(0.0, 0.6, 5), title="", wheels=[(0.6, 0.2)])
    [(place, radius, thickness)] = rotor.disks
    assert place == pytest.approx(0.32)
    assert 8.0 * radius**2 / 2.0 == pytest.approx(0.06)
    assert 8.0 * (radius**2 / 4.0 + thickness**2 / 12.0) == pytest.approx(0.0302)
    assert rotor.bearings == (("front", 0.0, True), ("2", 0.6, False))
    assert (rotor.radius == 0.02).all()
    assert rotor.largest == 0.2
    assert seen(0.5, 0.1j) == pytest.approx(0.5 + 0.1j)
    figure = plot_rotor(rotor)
    assert len(figure.axes[0].patches) == 2 * (4 + 1 + 1)

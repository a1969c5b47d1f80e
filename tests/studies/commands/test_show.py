"""`bladewhirl show`: derived figures against closed forms, and its two outputs."""

import json
import tomllib
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from command_line import answer
from PIL import Image
from typer.testing import CliRunner

import bladewhirl as bw
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.studies.commands.cli import app
from bladewhirl.studies.runs.properties import stage_properties

RUNNER = CliRunner()
STEEL = 7800.0
IMBALANCE = '[casing]\nsupport = 7.975e6\n[excitation]\ntype = "imbalance"\n'


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "case.toml"
    path.write_text(IMBALANCE)
    return path


def shown(path: Path, *arguments: str) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(answer("show", path, "--json", *arguments).stdout)
    return document


@pytest.fixture(scope="module")
def derived(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Figures of the default stage under an imbalance."""
    path = tmp_path_factory.mktemp("shown") / "case.toml"
    path.write_text(IMBALANCE)
    return shown(path)["derived"]


def test_masses_frequencies_and_speed(derived: Any) -> None:
    blades, spokes = 22 * 0.45 * 0.1 * 0.01, 22 * 0.05 * 0.1 * 0.03
    rim = 22 * 2 * 0.05 * np.sin(np.pi / 22) * 0.1 * 0.03
    assert derived["bladed_disk_mass"] == pytest.approx(STEEL * (blades + spokes + rim))
    parts = {"blades": blades, "spokes": spokes, "rim": rim}
    assert derived["bladed_disk_parts"] == pytest.approx({k: STEEL * v for k, v in parts.items()})
    assert derived["casing_mass"] == pytest.approx(STEEL * 2 * np.pi * 0.501 * 0.1 * 0.01)
    speed, reference = derived["speed"], derived["reference_frequency"]
    assert speed["normalised"] == pytest.approx(1.05)
    assert speed["rad_per_s"] == pytest.approx(1.05 * reference["rad_per_s"])
    assert speed["rpm"] == pytest.approx(60 * speed["hz"])
    assert speed["hz"] == pytest.approx(speed["rad_per_s"] / 2 / np.pi)
    lowest = {mode["nodal_diameter"]: mode["frequency"] for mode in derived["bladed_disk"]}
    assert sorted(lowest) == list(range(12))
    assert min(lowest, key=lambda k: lowest[k]["hz"]) == 1
    assert lowest[1] == reference
    # Independent computation of this stage: 1F spans 1.000 to 1.028, suspension 2.527.
    assert max(mode["normalised"] for mode in lowest.values()) == pytest.approx(1.028, abs=5e-4)
    assert derived["suspension"]["normalised"] == pytest.approx(2.527, abs=5e-4)
    casing = {mode["nodal_diameter"]: mode["frequency"] for mode in derived["casing"]}
    assert casing[1]["rad_per_s"] == pytest.approx(np.sqrt(7.975e6 / (STEEL * 0.1 * 0.01)))
    assert casing[1]["normalised"] == pytest.approx(4.0, abs=1e-3)


def test_march_and_load(derived: Any) -> None:
    assert derived["imbalance"]["force"] == pytest.approx(34e3 * (1.05 / 0.95) ** 2)
    assert derived["imbalance"]["unbalance"] == pytest.approx(0.59, rel=0.01)
    assert derived["distortion"] is None
    assert derived["dt_over_critical"] == pytest.approx(1e-6 / derived["critical_time_step"])
    assert (derived["steps"], derived["records"]) == (3_000_000, 30_001)
    assert derived["reduction"]["boundary"] == {"tip_radial": 22, "tip_tangential": 22, "centre": 2}
    assert derived["reduction"]["fixed_interface_modes"] == 110
    assert derived["reduction"]["modes"] == 156
    assert 8 * 30_001 * 600 < derived["result_bytes"] < 8 * 30_001 * 800


def test_the_distorted_mode_and_its_static_answer(path: Path) -> None:
    derived = shown(path, "--set", 'excitation={type="casing-distortion"}')["derived"]
    assert derived["imbalance"] is None
    assert derived["distortion"]["static_displacement"] == pytest.approx(5.9e-3, rel=0.01)
    free = ["--set", "casing.support=0", "--set", 'excitation={type="casing-distortion"}']
    answer = shown(path, *free)["derived"]["distortion"]
    assert answer is None or answer["static_displacement"] > 1e3


@pytest.mark.slow
def test_the_suspension_at_speed_is_that_of_modes() -> None:
    # Spin softening: the branch that is 1F at rest has most of its strain energy in the springs.
    soft = {"shaft.stiffness": 6e6, "rotation.effects": "centrifugal", "march.speed": "2300 rpm"}
    small = {"bladed_disk.blades": 8, "bladed_disk.elements_per_blade": 4}
    case = bw.with_values(bw.Case(), {**small, **soft, "reduction.fixed_interface_modes": 40})
    modes = bw.modes(case).sel(body="bladed-disk", centre="free", nodal_diameter=1)
    suspension = modes.sel(family="suspension").isel(number=0)
    properties = stage_properties(build_beams(case))
    assert properties["suspension"]["hz"] == pytest.approx(float(suspension["frequency"]), rel=1e-3)
    share = properties["suspension_spring_share"]
    assert share == pytest.approx(float(suspension["spring_share"]), abs=1e-2)
    assert share > 0.5
    assert str(suspension["family_at_rest"].values) == "1F"


def test_the_case_shown_is_the_case(path: Path) -> None:
    case = bw.case_from(shown(path, "--set", "march.speed=2500 rpm")["case"])
    expected = {
        "casing.support": 7.975e6,
        "excitation": {"type": "imbalance"},
        "march.speed": "2500 rpm",
    }
    assert case == bw.with_values(bw.Case(), expected)


def test_tables(path: Path) -> None:
    table = RUNNER.invoke(app, ["show", str(path)], env={"COLUMNS": "100"}).stdout
    both = RUNNER.invoke(app, ["show", str(path), "--case"], env={"COLUMNS": "100"}).stdout
    assert both.startswith(table)
    assert tomllib.loads(both.removeprefix(table))["casing"]["support"] == 7.975e6
    assert "Casing, full model" in table
    assert "suspension modes, reduced model" in table
    rows = [line.split() for line in table.splitlines()]
    assert ["speed", "1.05", "42.245", "2534.7", "265.43"] in rows
    assert ["imbalance", "[kg", "m]", "0.5895"] in rows
    assert ["time", "step", "/", "critical", "0.214"] in rows
    assert ["modes", "of", "the", "reduced", "model", "156"] in rows
    assert ["1", "40.2335", "1", "1.000"] in rows
    assert ["1", "160.93", "3.9999", "1.000"] in rows


def test_lowest_modes_without_symmetry(path: Path) -> None:
    path.write_text("bladed_disk = { blades = 6, mistuning.stiffness_spread = 0.05 }")
    derived = shown(path)["derived"]
    disk = [mode["frequency"]["hz"] for mode in derived["bladed_disk"]]
    listed = json.loads(answer("modes", path, "--count", "12", "--json").stdout)
    for mode, full in zip(derived["bladed_disk"], listed["bladed_disk"], strict=True):
        assert mode["nodal_diameter"] == full["nodal_diameter"]
        assert mode["purity"] == pytest.approx(full["purity"], abs=1e-3)
    assert len(disk) == 12
    assert disk == sorted(disk)
    assert disk[0] == derived["reference_frequency"]["hz"]
    words = answer("show", path).stdout.partition("purity")[2].split()
    shares = {f"{mode['purity']:.3f}" for mode in derived["bladed_disk"]}
    assert {f"{hertz:.6g}" for hertz in disk} | shares <= set(words)


@pytest.mark.usefixtures("can_draw")
def test_a_drawing_of_the_stage(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    few = ["--set", "reduction.fixed_interface_modes=10"]
    done = answer("show", path, "--json", "--png", *few)
    assert done.stderr == "Wrote case.png.\n"
    json.loads(done.stdout)
    with Image.open(tmp_path / "case.png") as picture:
        image = np.asarray(picture.convert("RGB"), dtype=np.int64)
    blade, disk, casing = (0x00, 0x72, 0xB2), (0x00, 0x9E, 0x73), (0x56, 0xB4, 0xE9)
    stage = image[:, :960]
    row, column = np.indices(stage.shape[:2])
    radius = np.hypot(row - 479.5, column - 479.5)
    reach = [radius[np.all(stage == colour, axis=-1)].max() for colour in (disk, blade, casing)]
    assert reach == sorted(reach)  # rim, blades, casing from the inside out
    assert reach[1] / reach[0] == pytest.approx(0.5 / 0.065, rel=0.03)  # half of the rim's 30 mm
    for name, part_colour in (("blue", blade), ("sky", casing)):
        assert np.all(image[:, 960:] == part_colour, axis=-1).any(), name  # and so in the key


def test_a_mesh_without_sectors_has_as_many_frequencies_as_were_computed(path: Path) -> None:
    answer("mesh", path, "-o", path.with_name("disk.vtu"), "--set", "bladed_disk.blades=3")
    mesh = meshio.read(path.with_name("disk.vtu"))
    farthest = int(np.argmax(mesh.points @ [1.0, 0.3, 0.0]))
    mesh.points[farthest] *= 0.98
    meshio.write(path.with_name("unequal.vtu"), mesh)
    path.write_text('bladed_disk.mesh = { file = "unequal.vtu", tips = "tips" }')
    listed = shown(path)["derived"]["bladed_disk"]
    assert listed
    assert {mode["nodal_diameter"] for mode in listed} == {-1}
    hertz = [mode["frequency"]["hz"] for mode in listed]
    assert hertz == sorted(hertz)

"""`bladewhirl mesh`, and runs of cases with a mesh file: self-contained, and one line a fault."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer, refusal
from places import DATA, EXAMPLES
from stages import steel
from typer.testing import CliRunner

import bladewhirl as bw
from bladewhirl.meshes.files.registry import WRITERS, read_line_mesh
from bladewhirl.studies.commands.cli import app
from bladewhirl.studies.sweeps.axes import make_grid
from bladewhirl.studies.sweeps.plan import plan_sweep, read_plan, write_plan

RUNNER = CliRunner()


def bladewhirl(*arguments: object) -> str:
    return " ".join(answer(*arguments).stdout.split())


def derived(*arguments: object) -> dict[str, Any]:
    computed: dict[str, Any] = json.loads(answer(*arguments).stdout)["derived"]
    return computed


@pytest.mark.parametrize("suffix", [*WRITERS])
def test_a_case_is_written_and_read_as_a_mesh(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"stage{suffix}"
    few = ["--set", "bladed_disk.blades=5"]
    printed = bladewhirl("mesh", EXAMPLES / "fan_stage.toml", *few, "-o", path)
    for part in ("56 nodes, 60 lines", "tips nodes 5", "blades lines 50", f"Wrote {path}."):
        assert part in printed
    assert [*tmp_path.iterdir()] == [path]
    case = tmp_path / "case.toml"
    case.write_text(f'bladed_disk.mesh.file = "{path.name}"')
    modes = ["--set", "reduction.fixed_interface_modes=30", "--json"]
    expected = derived("show", EXAMPLES / "fan_stage.toml", *few, *modes)
    computed = derived("show", case, *modes)
    assert computed["bladed_disk_mass"] == pytest.approx(expected["bladed_disk_mass"], rel=1e-12)
    assert computed["cyclic"] == expected["cyclic"] == {"bladed_disk": True, "casing": True}
    for mode, same in zip(computed["bladed_disk"], expected["bladed_disk"], strict=True):
        assert mode["frequency"]["hz"] == pytest.approx(same["frequency"]["hz"], rel=1e-9)


def test_what_a_deck_of_lines_says_and_is_not_read_is_listed(tmp_path: Path) -> None:
    text = "*NODE\n1, 0, 0\n2, 1, 0\n*ELEMENT, TYPE=B23\n1, 1, 2\n*BOUNDARY\n1, 1, 6\n"
    (tmp_path / "a.inp").write_text(f"{text}*MPC\nPIN, 1, 2\n*STEP\n*FREQUENCY\n5\n*END STEP\n")
    assert bladewhirl("mesh", tmp_path / "a.inp").endswith("not read: 1 *MPC, *BOUNDARY of 1 nodes")


def test_a_mesh_is_converted_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "fan.inp"
    assert "blade tips nodes 12" in bladewhirl("mesh", EXAMPLES / "shrouded_fan.msh", "-o", path)
    before, after = (read_line_mesh(p) for p in (EXAMPLES / "shrouded_fan.msh", path))
    assert np.array_equal(before.points, after.points)
    assert np.array_equal(before.lines, after.lines)
    assert set(after.line_groups) == {"disk", "blades", "shroud"}


def test_files_are_overwritten_by_force_only(tmp_path: Path) -> None:
    path = tmp_path / "fan.vtu"
    path.write_text("precious")
    arguments = ["mesh", EXAMPLES / "shrouded_fan.msh", "-o", path]
    done = RUNNER.invoke(app, [*map(str, arguments)])
    assert (done.exit_code, path.read_text()) == (2, "precious")
    assert done.stderr == f"{path}: already exists; --force overwrites it\n"
    bladewhirl(*arguments, "--force")
    assert len(read_line_mesh(path).lines) == 192


def test_data_that_a_format_cannot_store_are_listed(tmp_path: Path) -> None:
    sketch = bw.Sketch(3)
    sketch.node("centre", 0.0, shared=True)
    sketch.node("tip", 0.5)
    sketch.node("weight", 0.45)
    sketch.member("blades", "centre", "tip", steel(0.01), elements=2)
    sketch.link("tip", "weight")
    sketch.spring("tip", "tip+1", tangential=1e3)
    sketch.set("centre", "centre")
    sketch.set("tips", "tip")
    case = tmp_path / "case.toml"
    case.write_text(bw.dumps_case(bw.Case(sketch=sketch.table)))
    done = answer("mesh", case, "-o", tmp_path / "a.inp")
    left_out = "spring_radial, spring_tangential, spring_rotation, rigid"
    assert done.stderr == f"{tmp_path / 'a.inp'} does not contain {left_out}; .vtu and .msh do.\n"
    assert len(read_line_mesh(tmp_path / "a.inp").lines) == 6


@pytest.mark.parametrize("name", ["out.stl", "no/such/out.vtu"])
def test_faults_of_the_target(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.chdir(tmp_path)
    done = RUNNER.invoke(app, ["mesh", str(EXAMPLES / "shrouded_fan.msh"), "-o", name])
    assert done.exit_code == 2
    [line] = done.stderr.splitlines()
    assert line.startswith(f"{name}: ")
    assert not [*tmp_path.iterdir()]


@pytest.mark.slow
def test_a_sweep_keeps_its_mesh_and_varies_its_sections(tmp_path: Path) -> None:
    elsewhere, begun = tmp_path / "in", tmp_path / "sweep"
    elsewhere.mkdir()
    begun.mkdir()
    for suffix in (".toml", ".msh"):
        shutil.copy(EXAMPLES / f"shrouded_fan{suffix}", elsewhere)
    case = bw.with_values(bw.read_case(elsewhere / "shrouded_fan.toml"), {"march.duration": 1e-3})
    key = "bladed_disk.mesh.sections.blades.thickness"
    grid = make_grid(case, {key: [0.005, 0.006]}, large=False)
    write_plan(plan_sweep(case, grid), begun)
    shutil.rmtree(elsewhere)
    begun.rename(tmp_path / "moved")
    again = read_plan(tmp_path / "moved")
    assert again.case.blades == 12
    values, unit = again.coordinates[key]
    assert (values.tolist(), unit) == ([0.005, 0.006], "m")


def test_solids_are_listed_with_the_next_call(tmp_path: Path) -> None:
    deck = (DATA / "solids" / "two_materials.inp").read_text()
    (tmp_path / "blade.dat").write_text(deck)
    printed = bladewhirl("mesh", tmp_path / "blade.dat")
    for part in (
        "30 nodes, 8 elements C3D8, x 0.2 to 0.3,",
        "in the unit of the file group",
        "root nodes 6",
        "inner elements 4",
        "outer foam 1e+09 0.3 200",
        "--clamped root --contact tip --axis '?' --coriolis -o blade.npz",
    ):
        assert part in printed
    expected = "expected a mesh of lines to write; .* has solids"
    out = tmp_path / "out.vtu"
    assert re.search(expected, refusal("mesh", DATA / "solids" / "blade.msh", "-o", out))


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        (
            "shell.inp",
            "*NODE\n1, 0, 0\n*ELEMENT, TYPE=S4\n1, 1, 1, 1, 1\n",
            "or solids, elements of",
        ),
        (
            "solid.inp",
            "*NODE\n1, 0, 0\n*ELEMENT, TYPE=C3D4\n1, 1, 1, 1, 9\n",
            "solid.inp: expected all nodes of the elements; node 9 of element 1 is not defined",
        ),
        ("a.k", "*KEYWORD\n", ".bdf, .nas, .med, not a deck of LS-DYNA; convert it"),
        ("a.FEM", "BEGIN BULK\n", "not a deck of OptiStruct"),
        ("a.cdb", "/PREP7\n", "solids in NBLOCK and EBLOCK, as CDWRITE writes them"),
        ("a.BDF", "BEGIN BULK\n", "there are none"),
        ("a.msh", "", "a .msh file"),
    ],
)
def test_a_file_that_is_not_read_is_named(
    tmp_path: Path, name: str, text: str, expected: str
) -> None:
    (tmp_path / name).write_text(text)
    assert expected in refusal("mesh", tmp_path / name)

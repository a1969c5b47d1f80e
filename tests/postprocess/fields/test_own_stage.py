"""A stage that a user draws in Python: marched, shown, rerun from what the run left."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from places import ROOT
from typer.testing import CliRunner

import bladewhirl as bw
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import read_case
from bladewhirl.models.geometry.sketch import Sketch
from bladewhirl.models.sections.materials import Material
from bladewhirl.models.sections.rectangular import Section
from bladewhirl.models.stage.stage import build_stage
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.run.summary import summarise
from bladewhirl.studies.commands.cli import app
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

STEEL = Material()


def propeller() -> Sketch:
    """Four swept blades on arms, each with a rigid horn and a mass on it, joined by springs."""
    arm = Section(width=0.08, thickness=0.03, material=STEEL)
    root = Section(width=0.08, thickness=0.012, material=STEEL)
    tip = Section(width=0.05, thickness=0.006, material=STEEL)
    sketch = Sketch(sectors=4)
    sketch.node("hub", 0.0, 0.0, shared=True)
    sketch.node("root", "80 mm", "-20 mm")
    sketch.node("horn", "110 mm", "10 mm")
    sketch.node("tip", "400 mm")
    sketch.member("arms", "hub", "root", arm)
    sketch.member("blades", "root", "tip", [root, tip], elements=6, path=[(0.25, -0.03)])
    sketch.link("root", "horn")
    sketch.mass("horn", "300 g", inertia="2 kg cm2")
    sketch.spring("root", "root+1", radial="2 MN/m", tangential="2 MN/m")
    sketch.set("centre", "hub")
    sketch.set("tips", "tip")
    return sketch


def case(sketch: Sketch) -> Case:
    return sketch.case(
        shaft={"stiffness": "2 MN/m"},
        casing={"elements": 20, "clearance": "0.4 mm", "support": "8 MN/m2"},
        reduction={"fixed_interface_modes": 12},
        excitation={"type": "imbalance", "unbalance": "50 g m", "ramp": 0.0},
        march={"speed": "3000 rpm", "duration": "2 ms"},
    )


def test_march_in_a_few_lines() -> None:
    result, report = march_in_memory(prepare(case(propeller())))
    summary = summarise(result, report)
    assert result.attrs["end_reason"] == "completed"
    assert result.attrs["symmetry"].startswith("bladed disk: 4 equal sectors: cyclic path")
    assert set(result["rotor_part"].values) == {"arms", "blades"}
    assert summary.energy_residual < 1e-8
    assert summary.shaft_radius_max > 1e-7


def test_the_same_stage_with_every_sector_drawn_out() -> None:
    """One sector turned four times, and all four drawn as if nothing were known of them."""
    tuned = propeller()
    found = build_stage(case(tuned))
    table = tuned.table
    whole = Sketch()
    whole.node("hub", 0.0, shared=True)
    for n in range(4):
        cos, sin = np.round([np.cos(n * np.pi / 2), np.sin(n * np.pi / 2)])
        for node in table.nodes[1:]:
            x, y = node.at
            whole.node(f"{node.name} {n}", cos * x - sin * y, sin * x + cos * y)
    for n in range(4):
        cos, sin = np.round([np.cos(n * np.pi / 2), np.sin(n * np.pi / 2)])
        arms, blades = table.members
        assert arms.section is not None
        whole.member(f"arm {n}", "hub", f"root {n}", arms.section)
        [(x, y)] = blades.path
        whole.member(
            *(f"blade {n}", f"root {n}", f"tip {n}", blades.stations),
            elements=6,
            path=[(cos * x - sin * y, sin * x + cos * y)],
        )
        whole.link(f"root {n}", f"horn {n}")
        whole.mass(f"horn {n}", "300 g", inertia="2 kg cm2")
        whole.spring(f"root {n}", f"root {(n + 1) % 4}", radial="2 MN/m", tangential="2 MN/m")
    whole.set("centre", "hub")
    whole.set("tips", *(f"tip {n}" for n in range(4)))
    drawn = build_stage(case(whole))
    assert drawn.symmetry["bladed_disk"] == "4 equal sectors: cyclic path"
    np.testing.assert_allclose(
        drawn.reduction.modes.frequency, found.reduction.modes.frequency, rtol=1e-9
    )
    whole.change(0, "blade 1", stiffness=1.01)
    unlike = build_stage(case(whole))
    assert unlike.symmetry["bladed_disk"] == "4 sectors that differ: dense path"
    whole.mass("tip 2", 1e-3)
    whole.move(0, "horn 3", 0.0, -0.12)
    assert build_stage(case(whole)).symmetry["bladed_disk"] == "no sectors: dense path"
    assert drawn.disk.model.mass == pytest.approx(found.disk.model.mass, rel=1e-12)


@pytest.mark.usefixtures("pictures_unsaved")
def test_pictures_of_modes_without_nodal_diameters(tmp_path: Path) -> None:
    """Three blades at odd angles: nothing turns them into each other."""
    from bladewhirl.models.case.file import dumps_case

    steel = Section(width=0.08, thickness=0.02, material=STEEL)
    sketch = Sketch()
    sketch.node("hub", 0.0, shared=True)
    for blade, angle in enumerate((0.0, 1.9, 4.1)):
        sketch.node(f"tip {blade}", 0.4 * np.cos(angle), 0.4 * np.sin(angle))
        sketch.member(f"blade {blade}", "hub", f"tip {blade}", steel, elements=3)
    sketch.set("centre", "hub")
    sketch.set("tips", "tip 0", "tip 1", "tip 2")
    path = tmp_path / "odd.toml"
    path.write_text(dumps_case(case(sketch)))
    folder = tmp_path / "modes"
    done = CliRunner().invoke(
        app, ["modes", str(path), "-o", str(folder), "--no-films", "--count", "3"]
    )
    assert done.exit_code == 0, done.output
    assert (folder / "bladed-disk-shapes.png").is_file()


@pytest.mark.usefixtures("pictures_unsaved")
def test_a_run_of_a_mesh_moves_to_another_place(tmp_path: Path) -> None:
    """Its folder alone is enough to run it again: neither case nor result names the first place."""
    first = tmp_path / "first"
    first.mkdir()
    source = ROOT / "examples" / "shrouded_fan"
    for suffix in (".toml", ".msh"):
        shutil.copy(source.with_suffix(suffix), first)
    short = ["march.duration=1e-3", "reduction.fixed_interface_modes=24"]
    bw.run(read_case(first / "shrouded_fan.toml", short), first / "run", frames=0)
    provenance = json.loads((first / "run" / "provenance.json").read_text())
    content = (first / "shrouded_fan.msh").read_bytes()
    assert provenance["mesh"] == {
        "file": str(first / "shrouded_fan.msh"),
        "sha256": hashlib.sha256(content).hexdigest(),
    }
    moved = tmp_path / "moved"
    shutil.move(first / "run", moved)
    shutil.rmtree(first)
    with open_result(moved) as result:
        text = result.attrs["case"]
        assert 'file = "mesh.msh"' in text
        assert str(tmp_path) not in text
        assert read_case(moved / "case.toml").blades == 12
        (moved / "again.toml").write_text(text)
        again, _ = march_in_memory(prepare(read_case(moved / "again.toml")))
        assert again["energy"].values.any()
        for name in ("rotor_frequency", "rotor_displacement", "energy"):
            np.testing.assert_array_equal(again[name], result[name])

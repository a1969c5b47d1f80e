"""A stage that a user draws in Python: marched, shown, rerun from what the run left."""

import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from command_line import answer
from places import ROOT

import bladewhirl as bw
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

STEEL = bw.Material()


def case(sketch: bw.Sketch) -> bw.Case:
    return sketch.case(
        shaft={"stiffness": "2 MN/m"},
        casing={"elements": 20, "clearance": "0.4 mm", "support": "8 MN/m2"},
        reduction={"fixed_interface_modes": 12},
        excitation={"type": "imbalance", "unbalance": "50 g m", "ramp": 0.0},
        march={"speed": "3000 rpm", "duration": "2 ms"},
    )


@pytest.mark.slow
def test_pictures_of_modes_without_nodal_diameters(tmp_path: Path) -> None:
    """Three blades at odd angles: nothing turns them into each other."""
    from bladewhirl.models.case.template import dumps_case

    steel = bw.Section(width=0.08, thickness=0.02, material=STEEL)
    sketch = bw.Sketch()
    sketch.node("hub", 0.0, shared=True)
    for blade, angle in enumerate((0.0, 1.9, 4.1)):
        sketch.node(f"tip {blade}", 0.4 * np.cos(angle), 0.4 * np.sin(angle))
        sketch.member(f"blade {blade}", "hub", f"tip {blade}", steel, elements=3)
    sketch.set("centre", "hub")
    sketch.set("tips", "tip 0", "tip 1", "tip 2")
    path = tmp_path / "odd.toml"
    path.write_text(dumps_case(case(sketch)))
    folder = tmp_path / "modes"
    answer("modes", path, "-o", folder, "--no-films", "--count", "3")
    assert (folder / "bladed-disk-shapes.png").is_file()


@pytest.mark.slow
def test_a_run_of_a_mesh_moves_to_another_place(tmp_path: Path) -> None:
    """Its folder alone is enough to run it again: neither case nor result names the first place."""
    first = tmp_path / "first"
    first.mkdir()
    source = ROOT / "examples" / "shrouded_fan"
    for suffix in (".toml", ".msh"):
        shutil.copy(source.with_suffix(suffix), first)
    short = ["march.duration=1e-3", "reduction.fixed_interface_modes=24"]
    bw.run(bw.read_case(first / "shrouded_fan.toml", short), first / "run", frames=0)
    provenance = json.loads((first / "run" / "provenance.json").read_text())
    content = (first / "shrouded_fan.msh").read_bytes()
    assert provenance["mesh"] == {
        "file": str(first / "shrouded_fan.msh"),
        "sha256": hashlib.sha256(content).hexdigest(),
    }
    moved = tmp_path / "moved"
    shutil.move(first / "run", moved)
    shutil.rmtree(first)
    with bw.open_result(moved) as result:
        text = result.attrs["case"]
        assert 'file = "mesh.msh"' in text
        assert str(tmp_path) not in text
        assert bw.read_case(moved / "case.toml").blades == 12
        (moved / "again.toml").write_text(text)
        again, _ = march_in_memory(prepare(bw.read_case(moved / "again.toml")))
        assert again["energy"].values.any()
        for name in ("rotor_frequency", "rotor_displacement", "energy"):
            np.testing.assert_array_equal(again[name], result[name])

"""Modes in contact: held tips, clearance consumption, friction that locks."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer, refusal
from exported_stages import beams, exported

import bladewhirl as bw
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.studies.modal.contact_modes import report

BENT = {
    "blades": 5,
    "elements_per_blade": 2,
    "centre_line": [{"span": 0.5, "angle": "6 deg"}, {"span": 1.0, "angle": "20 deg"}],
}


def test_straight_blades_consume_clearance_by_the_second_order() -> None:
    """A tip that moves by a along the tangent is at the radius sqrt(R^2 + a^2)."""
    case = bw.with_values(beams("sector"), {"casing.clearance": "5 mm"})
    modes = bw.contact_modes(case, families=1)
    one = modes.isel(mode=0)
    a, radius = 5e-3, case.bladed_disk.tip_radius
    assert float(one["clearance_consumption"]) == pytest.approx(a / (2.0 * radius), rel=1e-4)
    assert np.isinf(one["locking_friction"])
    rows: Any = report(modes).document["modes_in_contact"]
    assert rows[0]["locking_friction"] is None
    assert float(one["held_frequency"]) == pytest.approx(float(one["frequency"]), rel=1e-6)


@pytest.mark.parametrize("speed", ["100 rad/s", "-100 rad/s"])
def test_bent_blades_lock_in_one_direction(speed: str) -> None:
    """Friction drags tips against the rotation. A tip that moves outward as it is dragged locks
    above the ratio of its radial to its tangential motion."""
    case = beams("blade", bladed_disk=BENT | {"disk_kind": "rigid"}, march={"speed": speed})
    one = bw.contact_modes(case, families=1).isel(mode=0)
    stage = build_beams(case)
    shape = stage.reduction.modes.shapes[:, 0]
    radial, tangential = (
        shape[rows][np.abs(shape[stage.disk.tip_tangential]).argmax()]
        for rows in (stage.disk.tip_radial, stage.disk.tip_tangential)
    )
    outward = -np.sign(stage.speed) * radial * tangential
    expected = abs(radial / tangential) if outward > 0.0 else np.inf
    assert float(one["locking_friction"]) == pytest.approx(expected, rel=1e-5)
    assert float(one["held_frequency"]) > 1.2 * float(one["frequency"])
    assert 0.05 < float(one["clearance_consumption"]) < 0.9


@pytest.mark.parametrize("kind", ["sector", "blade", "wheel"])
def test_superelements_are_in_contact_as_their_beams(kind: str, tmp_path: Path) -> None:
    disk = BENT | ({"disk_kind": "rigid"} if kind == "blade" else {})
    own = beams(kind, bladed_disk=disk)  # type: ignore[arg-type]
    nodes = exported(own, kind, tmp_path)  # type: ignore[arg-type]
    first, second = (bw.contact_modes(each, families=2) for each in (own, nodes))
    if kind == "blade":  # the same for every nodal diameter
        first = first.isel(mode=first["nodal_diameter"].values == 0)
        second = second.isel(mode=second["nodal_diameter"].values == 0)
    assert first.sizes["mode"] == second.sizes["mode"] >= 2
    for name, variable in first.items():
        assert second[name].values == pytest.approx(variable.values, rel=2e-5)


@pytest.mark.parametrize("kind", ["sector", "blade", "wheel"])
def test_modes_touch_a_straight_contour_as_a_cone(kind: str, tmp_path: Path) -> None:
    disk = BENT | ({"disk_kind": "rigid"} if kind == "blade" else {})
    nodes = exported(beams(kind, bladed_disk=disk), kind, tmp_path)  # type: ignore[arg-type]
    contour = [[-0.1, 0.3], [0.1, 0.3 + 0.2 * np.tan(0.05)]]
    cone, own = (
        bw.contact_modes(bw.with_values(nodes, {"casing.type": "rigid"} | wall), families=2)
        for wall in ({"casing.slope": 0.05}, {"casing.contour": contour})
    )
    for name, variable in cone.items():
        assert own[name].values == pytest.approx(variable.values, rel=1e-9)


def test_the_command(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(beams("sector", bladed_disk=BENT)), encoding="utf-8")
    rows = json.loads(answer("modes", file, "--contact", "--json").stdout)["modes_in_contact"]
    assert {row["family"] for row in rows} == {"1F", "2F", "3F"}
    assert all(row["held_frequency_hz"] >= row["frequency_hz"] * (1 - 1e-9) for row in rows)
    assert "expected no -o" in refusal("modes", file, "--contact", "-o", tmp_path / "out")

"""`bladewhirl new --from part.npz`, and the defaults of cases with a superelement."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from command_line import answer, refusal
from long_cases import slow_except
from solid_meshes import SECTORS, STEEL, TIE, bladed_sector, cantilever, wheel_frequencies

import bladewhirl as bw
from bladewhirl.models.case.part_template import FASTEST, LOBES, modes_of
from bladewhirl.models.case.superelement import CLEARANCE, REVOLUTIONS, SPEED, STEPS
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.superelements.critical_step import limits_of
from bladewhirl.models.superelements.superelement import Superelement
from bladewhirl.postprocess.run.hints import ELASTIC
from bladewhirl.studies.runs.properties import stage_properties


@cache
def parts(kind: str) -> Superelement:
    if kind == "sector":
        return bw.mesh3d(bladed_sector("hexahedron"), **STEEL, **TIE, contacts=2, coriolis=True)
    return bw.mesh3d(cantilever("tetra10"), **STEEL, contacts=2)


@pytest.mark.parametrize("kind", slow_except(["sector", "blade"], "blade"))
def test_a_case_for_a_part_runs_as_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    monkeypatch.chdir(tmp_path)
    part = parts(kind)
    bw.write_superelement("part.npz", part)
    Path("cases").mkdir()
    assert (
        answer("new", "cases/part.toml", "--from", "part.npz").stdout
        == "Wrote cases/part.toml, which begins with commands for it.\n"
    )
    text = Path("cases/part.toml").read_text()
    for of_beams in ("elements", "disk_kind", "fixed_interface_modes", "suspension"):
        assert of_beams not in text
    case = bw.read_case("cases/part.toml")
    table = case.bladed_disk.superelement
    assert table is not None
    assert (table.kind, table.copies) == (kind, SECTORS if kind == "sector" else 1)
    assert case.rotation.effects == ("full" if kind == "sector" else "centrifugal")
    radius = part.contact_radius.max()
    assert case.casing.clearance == pytest.approx(CLEARANCE * radius, rel=5e-3)
    short = {"march.revolutions": 3, "march.steps_per_revolution": 1024}
    run = bw.run(bw.with_values(case, short), "run", frames=0)
    assert max(run.summary.contact_share) > 0.0
    assert run.summary.stress_max is not None
    steel = 2.1e11
    assert 0.0 < run.summary.stress_max["bladed_disk"]["stress"] < ELASTIC * steel
    for command in text.splitlines()[:2]:
        assert command.startswith("# bladewhirl ")


@pytest.mark.parametrize("kind", slow_except(["sector", "blade"], "blade"))
def test_the_steps_and_the_friction_of_a_case_suit_its_part(tmp_path: Path, kind: str) -> None:
    part = parts(kind)
    bw.write_superelement(tmp_path / "part.npz", part)
    for speeds in ([], ["--speeds", "0 rpm:4000 rpm"]):
        answer("new", tmp_path / "part.toml", "--from", tmp_path / "part.npz", "--force", *speeds)
        case = bw.read_case(tmp_path / "part.toml")
        stage = cast(Matrices, build_stage(case))
        found = stage_properties(stage)
        assert found["dt_over_critical"] < 1.0
        assert found["coordinates"] == part.size
        assert found["copies"] == case.bladed_disk.count
        assert len(found["contact_nodes"]) == part.contacts
    assert (case.march.steps_per_revolution or 0) > STEPS  # a revolution takes long
    about, locking = limits_of(part, modes_of(part))
    of_stage = min(stage.locking_friction().values(), default=np.inf)
    assert locking == pytest.approx(of_stage, rel=0.2)
    assert case.contact.friction <= 0.6 * of_stage
    assert about == pytest.approx(found["critical_time_step"], rel=0.2)
    reached = f"reach {1e-3 / np.pi / about:.3g} kHz"
    assert reached in (tmp_path / "part.toml").read_text()


def test_the_range_of_speeds_is_taken(tmp_path: Path) -> None:
    bw.write_superelement(tmp_path / "part.npz", parts("sector"))
    case = tmp_path / "part.toml"
    given = ("--from", tmp_path / "part.npz", "--speeds", "8000 rpm:12000 rpm")
    answer("new", case, *given)
    assert bw.read_case(case).march.speed.given == "10000 rpm"
    assert '--over "march.speed=8000 rpm:12000 rpm:400 rpm"' in case.read_text()
    line = refusal("new", tmp_path / "other.toml", "--speeds", "8000 rpm:12000 rpm")
    assert line == "--speeds: not allowed with a case without --from"


def test_a_sector_without_a_number_of_sectors_is_refused(tmp_path: Path) -> None:
    bw.write_superelement(tmp_path / "part.npz", replace(parts("sector"), sectors=None))
    line = refusal("new", tmp_path / "part.toml", "--from", tmp_path / "part.npz")
    assert "expected sectors, the number of sectors of the wheel" in line


@pytest.mark.parametrize(
    ("march", "expected"),
    [
        ({}, {"speed": SPEED, "steps_per_revolution": STEPS, "revolutions": REVOLUTIONS}),
        ({"time_step": 1e-6, "duration": 0.1}, {"steps_per_revolution": None, "duration": 0.1}),
        ({"speed": "0 rpm"}, {"steps_per_revolution": None, "revolutions": None}),
        ({"speed_table": [["0 s", 0.1], ["1 s", 0.2]]}, {"revolutions": None}),
    ],
)
def test_a_case_that_leaves_them_out_has_defaults_of_its_part(
    tmp_path: Path, march: dict[str, Any], expected: dict[str, Any]
) -> None:
    part = parts("sector")
    bw.write_superelement(tmp_path / "part.npz", part)
    tables: dict[str, Any] = {"bladed_disk": {"superelement": {"file": str(tmp_path / "part.npz")}}}
    case = bw.case_from(tables | {"march": march, "rotation": {"effects": "full"}})
    for key, value in expected.items():
        found = getattr(case.march, key)
        assert getattr(found, "given", found) == value
    assert case.casing.clearance == pytest.approx(CLEARANCE * part.contact_radius.max())
    assert bw.case_from(case.model_dump(exclude_none=True)) == case


def test_beams_keep_the_defaults_of_the_paper() -> None:
    case = bw.Case()
    assert (case.march.speed.given, case.march.steps, case.casing.clearance) == (1.05, 3e6, 1e-3)


@pytest.mark.parametrize("scale", [1.0, 4.0])
def test_the_lowest_excited_frequency_sets_the_speed_unless_tips_are_too_fast(
    tmp_path: Path, scale: float
) -> None:
    part = parts("sector")
    stiffer = replace(part, stiffness=scale * part.stiffness)
    bw.write_superelement(tmp_path / "part.npz", stiffer)
    answer("new", tmp_path / "part.toml", "--from", tmp_path / "part.npz")
    of_wheel = 2.0 * np.pi * wheel_frequencies(stiffer, SECTORS, 1)[:, 0]
    radius = part.contact_radius.max()

    def excited(order: int) -> int:
        return min(order % SECTORS, -order % SECTORS)

    orders = range(round(1.0 / SPEED), 40, LOBES)
    order = next(n for n in orders if of_wheel[excited(n)] * radius / n <= FASTEST)
    assert order > orders[0]
    diameter, lowest = excited(order), of_wheel[excited(order)]
    text = (tmp_path / "part.toml").read_text()
    assert bw.read_case(tmp_path / "part.toml").march.speed.value == pytest.approx(
        lowest / order, rel=5e-4
    )
    met = f"{lowest / 2.0 / np.pi:.5g} Hz, the lowest frequency of nodal diameter {diameter}"
    assert f"# order {order} meets {met} at rest\n" in text
    assert f"--orders {','.join(map(str, range(LOBES, order + 1, LOBES)))}\n" in text

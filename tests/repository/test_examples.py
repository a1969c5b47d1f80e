"""Cases in examples/: each marches, and at full length gives what pages of docs/ say."""

import csv
import re
import runpy
from pathlib import Path

import pytest
from long_cases import slow_except
from places import ROOT

import bladewhirl as bw
from bladewhirl.models.case.excitation import NoExcitation
from bladewhirl.models.case.file import read_case, with_values
from bladewhirl.postprocess.run.summary import summarise
from bladewhirl.studies.runs.outputs import Run
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))
QUICK = [
    ROOT / "examples" / f"{name}.toml"
    for name in (
        *("abradable_coating", "curved_blades", "mistuned_blades", "shrouded_blades"),
        *("spinning_fan", "twisted_blade", "unequal_bearings", "unequal_shaft"),
    )
]
"""Examples of different kinds of stages and loads."""


def row_of_the_page(name: str) -> list[str]:
    """What the page's table says of fan stage, casing distortion and imbalance."""
    text = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    (row,) = re.findall(rf"^\| {name} \|(.*)\|$", text, flags=re.MULTILINE)
    return [cell.strip() for cell in row.split("|")]


@pytest.mark.parametrize("path", slow_except(EXAMPLES, *QUICK), ids=lambda path: path.stem)
def test_marches(path: Path) -> None:
    case = with_values(read_case(path), {"march.duration": 3e-3, "march.record_step": 1e-4})
    result, report = march_in_memory(prepare(case))
    assert result.attrs["end_reason"] == "completed"
    assert result.sizes["time"] == 31
    summary = summarise(result, report)
    assert summary.energy_residual <= 1e-8
    moves = float(result["energy"].max()) > 0.0
    loaded = case.excitation != NoExcitation() or case.shaft_line is not None
    assert moves == (loaded or any(case.initial.centre_velocity))


@pytest.mark.parametrize("name", ["twisted_blade", "bladed_disk", "overhung_fan", "shrouded_blade"])
def test_the_script_makes_the_file(name: str) -> None:
    made = runpy.run_path(str(ROOT / "examples" / f"{name}.py"))["part"]
    table = read_case(ROOT / "examples" / f"{name}.toml").bladed_disk.superelement
    assert table is not None
    kept = table.with_hub
    assert made.name == kept.name
    for name in ("contact_position", "contact_dofs", "points", "triangles"):
        assert getattr(made, name) == pytest.approx(getattr(kept, name), rel=1e-12, abs=1e-15)
    for name in made.given(("mass", "stiffness", "recovery", "stress_recovery")):
        largest = abs(getattr(kept, name)).max()
        assert abs(getattr(made, name) - getattr(kept, name)).max() <= 1e-10 * largest


@pytest.mark.slow
def test_the_blades_of_the_shipped_sector_may_differ_and_have_a_stress() -> None:
    case = read_case(ROOT / "examples" / "bladed_disk.toml")
    case = with_values(case, {"bladed_disk.mistuning.stiffness_spread": 0.02})
    listed = bw.modes(case, count=18)
    assert float(listed.purity.min()) < 0.9
    short = with_values(case, {"march.duration": 1e-3, "march.record_step": 1e-4})
    result, _ = march_in_memory(prepare(short))
    assert float(bw.stress_history(result)["peak_stress"].max()) > 1e5


@pytest.fixture(scope="module", params=["fan_stage", "casing_distortion", "imbalance"])
def full(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Run:
    """An example at full length."""
    case = read_case(ROOT / "examples" / f"{request.param}.toml")
    return bw.run(case, tmp_path_factory.mktemp("full") / request.param, frames=0)


@pytest.mark.slow
def test_full_length_gives_what_the_page_says(full: Run) -> None:
    column = ["fan_stage", "casing_distortion", "imbalance"].index(full.directory.name)
    summary = full.summary
    assert row_of_the_page("regime at speed 1.05")[column].replace(" ", "-") == summary.regime
    # Where it diverges the last digit of a force decides when.
    late, far = (0.4, 0.1) if summary.regime == "divergent" else (1e-9, 0.02)
    radius = float(row_of_the_page("largest shaft radius")[column].split()[0]) * 1e-3
    assert summary.shaft_radius_max == pytest.approx(radius, rel=far)
    end = float(row_of_the_page("end of the march")[column].split()[0])
    assert summary.end_time == pytest.approx(end, abs=late)
    touched = row_of_the_page("blades that touched")[column]
    assert f"{sum(share > 0.0 for share in summary.contact_share)} of 22" == touched
    assert summary.energy_residual <= 1e-8
    assert summary.complementarity_residual <= 1e-10


ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.parametrize(("case", "seconds"), [("casing_distortion", 1.5), ("imbalance", 3.0)])
def test_the_march_at_1_05_with_all_effects_is_as_the_page_says(
    case: str, seconds: float, tmp_path: Path
) -> None:
    with (ROOT / "docs" / "rotation_cases.csv").open(encoding="utf-8") as file:
        (row,) = [
            row
            for row in csv.DictReader(file)
            if (row["case"], row["effects"], row["speed"]) == (case, "full", "1.05")
        ]
    changes = {"rotation.effects": "full", "march.speed": 1.05, "march.duration": seconds}
    marched = bw.with_values(bw.read_case(ROOT / "examples" / f"{case}.toml"), changes)
    summary = bw.run(marched, tmp_path / "run", frames=0).summary
    assert summary.regime == row["regime"]
    assert summary.end_time == pytest.approx(float(row["end_time"]), rel=0.02)
    frequency = summary.whirl_frequency_rotating
    assert (frequency or 0.0) == pytest.approx(float(row["whirl_frequency"]), abs=1.0)

"""The cases in examples/: each marches, and at full length gives what docs/paper.md says."""

import re
from pathlib import Path

import pytest
from places import ROOT

import bladewhirl as bw
from bladewhirl.models.case.excitation import NoExcitation
from bladewhirl.models.case.file import read_case, with_values
from bladewhirl.postprocess.run.summary import summarise
from bladewhirl.studies.runs.outputs import Run
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))


def row_of_the_page(name: str) -> list[str]:
    """What the page's table says of fan stage, casing distortion and imbalance."""
    text = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    (row,) = re.findall(rf"^\| {name} \|(.*)\|$", text, flags=re.MULTILINE)
    return [cell.strip() for cell in row.split("|")]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_marches(path: Path) -> None:
    case = with_values(read_case(path), {"march.duration": 3e-3})
    result, report = march_in_memory(prepare(case))
    assert result.attrs["end_reason"] == "completed"
    assert result.sizes["time"] == 31
    assert summarise(result, report).energy_residual <= 1e-8
    moves = float(result["energy"].max()) > 0.0
    assert moves == (case.excitation != NoExcitation() or any(case.initial.centre_velocity))


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

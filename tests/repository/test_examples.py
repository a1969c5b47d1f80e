"""The cases in examples/: each marches, and at full length gives what docs/paper.md says."""

import re
from pathlib import Path

import numpy as np
import pytest
from places import ROOT

import bladewhirl as bw
from bladewhirl.models.case.file import read_case, with_values
from bladewhirl.models.modal.full_stage import modal_stage
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
    assert moves == (case.excitation.type != "none" or any(case.initial.centre_velocity))


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


def test_springs_let_six_modes_grow_until_they_touch() -> None:
    """As fast as the comment in the file says, which is what the stability analysis gives."""
    case = read_case(ROOT / "examples" / "coupled_modes.toml")
    result, report = march_in_memory(prepare(case))
    summary = summarise(result, report)
    assert summary.energy_residual <= 1e-8
    assert summary.regime == "sustained"
    time = result["time"].values
    touched = result["contact_steps"].values.any(axis=1)
    assert time[touched][0] == pytest.approx(1.2, abs=0.05)
    size = np.linalg.norm(result["rotor_displacement"].values, axis=1)
    growing = (time > 0.6) & (time < 1.1)
    rate = np.polyfit(time[growing], np.log(size[growing]), 1)[0]
    assert rate == pytest.approx(6.8654, rel=1e-3)
    assert result["coupling_work"].values[-1] > 0.0


@pytest.mark.parametrize("name", ["casing_on_struts", "shrouded_fan", "unequal_shaft"])
def test_lowest_modes_solve_the_eigenproblem(name: str) -> None:
    stage = modal_stage(read_case(ROOT / "examples" / f"{name}.toml"), 6)
    bodies = ((stage.disk, stage.disk_modes), (stage.casing, stage.casing_modes))
    for body, modes in bodies:
        structure, shapes = body.structure, modes.fields(np.arange(6))
        square = modes.frequency[:6] ** 2
        assert np.all(np.diff(square) >= 0.0)
        np.testing.assert_allclose(shapes.T @ structure.mass @ shapes, np.eye(6), atol=1e-8)
        strain = shapes.T @ structure.stiffness @ shapes
        np.testing.assert_allclose(strain, np.diag(square), atol=1e-6 * square[-1])

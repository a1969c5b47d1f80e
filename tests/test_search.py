"""The search for the values that the paper leaves out."""

from __future__ import annotations

from dataclasses import asdict
from math import pi
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.patches import Rectangle
from typer.testing import CliRunner

from bladewhirl.models.faults import UserError
from bladewhirl.models.modal_stage import modal_stage
from bladewhirl.postprocess.sensitivity_figures import plot_sensitivity, sensitivity_dataset
from bladewhirl.studies import parameter_search
from bladewhirl.studies.claim import Verdict
from bladewhirl.studies.cli import app
from bladewhirl.studies.paper_cases import CASES, changed
from bladewhirl.studies.parameter_search import (
    BRIDGE,
    CONFIRMED_SETS,
    CONTACT_CLAIMS,
    DEFAULT,
    MODAL_CLAIMS,
    SCREENING,
    Judged,
    Search,
    open_search,
)
from bladewhirl.studies.parameter_sets import HOLD, STARTS, UNKNOWNS, ParameterSet
from bladewhirl.studies.search_report import report_text, write_report

RUNNER = CliRunner()


@pytest.mark.parametrize("start", STARTS)
def test_a_set_gives_the_casing_its_frequency_and_mass(start: str) -> None:
    values = STARTS[start]
    stage = modal_stage(changed("modal", values.changes()))
    of_one_diameter = stage.casing_modes.nodal_diameter == 1
    ratio = stage.casing_modes.frequency[of_one_diameter].min() / stage.reference_frequency
    assert ratio == pytest.approx(values.frequency, rel=1e-3)  # as a rigid ring
    assert stage.casing.structure.mass.diagonal().sum() > 0
    wall = changed("modal", values.changes()).casing.wall
    assert wall.width * wall.thickness == pytest.approx(values.mass * 0.1 * 0.01)


@pytest.mark.parametrize("frequency", [0.055, 1.0, 9.7])
@pytest.mark.parametrize("push", ["hit", "hold"])
def test_a_push_swings_a_free_ring_as_far_as_it_says(frequency: float, push: str) -> None:
    """Integrated numerically: m a + k w = F while it acts, its largest or its settled place."""
    values = ParameterSet(frequency=frequency, push=push, swing=2.0, mass=50.0)  # type: ignore[arg-type]
    case = changed("distortion", values.changes())
    load = case.excitation
    assert load.type == "casing-distortion"
    omega = frequency * modal_stage(CASES["modal"]).reference_frequency
    mass = 2 * pi * 0.501 * 7800.0 * 50.0 * 1e-3
    if push == "hold":
        assert load.duration == HOLD
        assert load.modal_force / omega**2 / np.sqrt(mass) == pytest.approx(2e-3, rel=1e-4)
        return
    time = np.linspace(0.0, load.duration + 2 * pi / omega, 200_001)
    forced = load.modal_force / omega**2 * (1 - np.cos(omega * time))
    after = forced - load.modal_force / omega**2 * (1 - np.cos(omega * (time - load.duration)))
    place = np.where(time <= load.duration, forced, after) / np.sqrt(mass)
    assert np.abs(place).max() == pytest.approx(2e-3, rel=0.01)


@pytest.mark.parametrize("scenario", ["distortion", "imbalance"])
def test_the_default_is_that_of_the_examples(scenario: Any) -> None:
    case, given = changed(scenario, STARTS[DEFAULT].changes()), CASES[scenario]
    rounded = {"casing.support": 1e-4, "excitation.modal_force": 0.01}
    for key in STARTS[DEFAULT].changes():
        table, _, name = key.partition(".")
        if name.split(".")[0] in type(getattr(given, table)).model_fields:
            ours, theirs = (attrgetter(key)(each) for each in (case, given))
            assert ours == (pytest.approx(theirs, rel=rounded[key]) if key in rounded else theirs)


def test_the_best_and_the_default_are_confirmed(climbed: Search) -> None:
    confirmed = climbed.confirm()
    assert [each.values for each in confirmed][-1] == STARTS[DEFAULT]
    assert len(confirmed) == 1 + CONFIRMED_SETS


def test_neighbours_differ_in_one_value() -> None:
    start = STARTS["heavy"]
    near = list(start.neighbours())
    tried = sum(len(values) for values in UNKNOWNS.values())
    off_grid = sum(asdict(start)[name] not in values for name, values in UNKNOWNS.items())
    assert len(near) == tried - len(UNKNOWNS) + off_grid
    assert all(len(each.difference(start)) == 1 for each in near)
    assert len(set(near)) == len(near)


def hill(values: ParameterSet, *, confirmed: bool = False) -> Judged:
    """More claims hold the nearer a set is to damping 0.02 and a mass of 400."""
    near = [values.damping == 0.02, values.mass == 400.0]
    verdicts: dict[int, Verdict] = {
        claim: "does not hold" for claim in (*MODAL_CLAIMS, *CONTACT_CLAIMS)
    }
    for claim, met in zip(BRIDGE, [True, *near], strict=True):
        verdicts[claim] = "holds" if met else "partly"
    ours = {claim: f"ours of {claim}" for claim in verdicts}
    return Judged(values=values, confirmed=confirmed, verdicts=verdicts, ours=ours)


@pytest.fixture
def climbed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Search:
    monkeypatch.setattr(Search, "_judge", lambda self, values, confirmed: hill(values))
    search = open_search(tmp_path)
    search.climb(ParameterSet(), rounds=5)
    return search


def test_a_climb_ends_at_the_top(climbed: Search) -> None:
    best = climbed.best(1)[0]
    assert (best.values.damping, best.values.mass) == (0.02, 400.0)
    assert best.rank == (3, 0)
    assert best.bridges
    rounds = 3  # two steps up, and one that finds nothing better
    assert len(climbed.judged) <= 1 + rounds * len(list(ParameterSet().neighbours()))


def test_a_search_goes_on_where_it_was(climbed: Search, monkeypatch: pytest.MonkeyPatch) -> None:
    again = open_search(climbed.directory)
    assert again.judged == climbed.judged

    def refuse(self: Search, values: ParameterSet, *, confirmed: bool) -> Judged:
        raise AssertionError(f"judged again: {values}")

    monkeypatch.setattr(Search, "_judge", refuse)
    assert again.climb(ParameterSet(), rounds=5) == climbed.best(1)[0]


def test_the_report_names_what_flips_a_claim(tmp_path: Path) -> None:
    base, other = ParameterSet(mass=400.0), ParameterSet(mass=400.0, damping=0.02)
    search = Search(directory=tmp_path)
    for values, held in ((base, (6, 33, 22)), (other, (6, 21))):
        verdicts: dict[int, Verdict] = {
            claim: "holds" if claim in held else "does not hold" for claim in (*BRIDGE, 22)
        }
        ours = {claim: f"ours of {claim}" for claim in verdicts}
        search.judged[values, False] = Judged(
            values=values, confirmed=False, verdicts=verdicts, ours=ours
        )
    text = report_text(search)
    assert "* 21 (does not hold: ours of 21): damping ratio 0.02 instead of 0.005." in text
    assert "Claims 6, 21, 33 together hold in 0 of the screened sets." in text
    assert "| screened | 3 | 0 | 6, 33, 22 | damping ratio 0.005 |" in text
    assert "| screened | 2 | 0 | 6, 21 | damping ratio 0.02 |" in text
    assert f"All of them have {base.words({'damping'})}." in text


def test_figures_of_missed_claims(climbed: Search) -> None:
    paths = write_report(climbed, climbed.directory)
    assert paths[0].read_text(encoding="utf-8") == report_text(climbed)
    missed = set(hill(ParameterSet()).verdicts) - set(BRIDGE)
    assert {path.name for path in paths[1:]} == {
        f"sensitivity-claim-{claim}.png" for claim in missed
    }


def test_cells_of_a_sensitivity_figure() -> None:
    rows = {"a": [("1", "holds"), ("2", "partly")], "b": [("x", "")]}
    data = sensitivity_dataset("Claim", rows, {"a": "2", "b": "x"})
    cells = [
        patch for patch in plot_sensitivity(data).axes[0].patches if isinstance(patch, Rectangle)
    ]
    assert len(cells) == 3
    assert [cell.get_linewidth() > 1.0 for cell in cells] == [False, True, True]


def test_a_set_is_judged_by_marches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two milliseconds: nothing has diverged yet, and the soft casing meets 6 and 7."""
    monkeypatch.setattr(parameter_search, "SCREENING", SCREENING | {"march.duration": 2e-3})
    judged = Search(directory=tmp_path).judge(STARTS["soft"])
    assert judged.verdicts[6] == judged.verdicts[7] == "holds"
    assert judged.verdicts[20] == "does not hold"
    assert set(judged.verdicts) == {*MODAL_CLAIMS, *CONTACT_CLAIMS}
    assert open_search(tmp_path).judged == {(STARTS["soft"], False): judged}
    assert not list((tmp_path / "runs").glob("*.nc"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["hard"], "hard: expected soft, supported, heavy"),
        (["--report"], "expected sets that have been judged"),
        (["--workers", "1", "--scheduler", "tcp://x:1"], "--scheduler, --workers"),
    ],
)
def test_faults_end_in_one_line(arguments: list[str], message: str, tmp_path: Path) -> None:
    done = RUNNER.invoke(app, ["search", *arguments, "-o", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert message in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_folder_of_another_version_is_refused(climbed: Search) -> None:
    path = climbed.directory / "search.json"
    path.write_text(path.read_text().replace('"bladewhirl": "', '"bladewhirl": "0.0.'))
    with pytest.raises(UserError, match=r"this one is of 0\.0\."):
        open_search(climbed.directory)

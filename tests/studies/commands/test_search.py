"""The search for the values that the paper leaves out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from math import pi
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from typer.testing import CliRunner

from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.full_stage import modal_stage
from bladewhirl.studies.commands.cli import app
from bladewhirl.studies.paper.cases import CASES, changed
from bladewhirl.studies.paper.claim import CLAIMS, Verdict
from bladewhirl.studies.paper.search.figures import (
    VERDICT_COLOURS,
    plot_overview,
    plot_sensitivity,
    sensitivity_dataset,
)
from bladewhirl.studies.paper.search.parameters import GIVEN, STARTS, UNKNOWNS, ParameterSet
from bladewhirl.studies.paper.search.report import found_by_claim, report_text, write_report
from bladewhirl.studies.paper.search.search import (
    BRIDGE,
    CONFIRMED_SETS,
    CONTACT_CLAIMS,
    DEFAULT,
    MODAL,
    MODAL_CLAIMS,
    SCRUTINIES,
    SLOW_CLAIMS,
    STILL_CLAIMS,
    Judged,
    Level,
    Scrutiny,
    Search,
    open_search,
    search_parameters,
)
from bladewhirl.studies.paper.trials import SURVEYS
from bladewhirl.studies.sweeps.cache import RunStore

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
def test_a_hit_swings_a_free_ring_as_far_as_it_says(frequency: float) -> None:
    """Integrated numerically: m a + k w = F while it acts, its largest place."""
    values = ParameterSet(frequency=frequency, push="hit", swing=2.0, mass=50.0)
    case = changed("distortion", values.changes())
    load = case.excitation
    assert load.type == "casing-distortion"
    omega = frequency * modal_stage(CASES["modal"]).reference_frequency
    mass = 2 * pi * 0.501 * 7800.0 * 50.0 * 1e-3
    time = np.linspace(0.0, load.duration + 2 * pi / omega, 200_001)
    forced = load.modal_force / omega**2 * (1 - np.cos(omega * time))
    after = forced - load.modal_force / omega**2 * (1 - np.cos(omega * (time - load.duration)))
    place = np.where(time <= load.duration, forced, after) / np.sqrt(mass)
    assert np.abs(place).max() == pytest.approx(2e-3, rel=0.01)


def test_a_held_push_is_of_the_papers_force() -> None:
    for frequency in (0.055, 9.7):
        load = changed(
            "distortion", ParameterSet(push="hold", hold=0.3, frequency=frequency).changes()
        ).excitation
        assert load.type == "casing-distortion"
        assert (load.modal_force, load.duration) == (3e4, 0.3)


@pytest.mark.parametrize(
    ("values", "changed_names"),
    [
        (ParameterSet(), ()),
        (ParameterSet(frequency=9.7, push="hold", damping=0.02, ramp=0.0, disk=0.01), ()),
        (
            ParameterSet(friction=0.2, tip_mass=0.1),
            ("friction coefficient", "mass at each tip [kg]"),
        ),
        (ParameterSet(wall=0.04), ("casing thickness [m]",)),
        (ParameterSet(frequency=9.7, swing=1.5), ()),
        (ParameterSet(frequency=9.7, swing=3.0), ("modal force",)),
    ],
)
def test_a_set_knows_what_of_the_paper_it_changes(
    values: ParameterSet, changed_names: tuple[str, ...]
) -> None:
    """The paper's force moves a casing of 9.7 by 1 mm, suddenly applied by twice that."""
    assert values.departures == changed_names


def test_what_the_paper_gives_is_in_the_default_cases() -> None:
    case = CASES["distortion"]
    assert GIVEN["wall"] == case.casing.wall.thickness
    assert GIVEN["friction"] == case.contact.friction
    assert GIVEN["tip_mass"] == case.bladed_disk.tip_mass
    assert all(not start.departures for name, start in STARTS.items() if name != "heavy")


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
    """The best of each group: a mass of 400 changes the paper's section."""
    confirmed = climbed.confirm()
    assert [each.values for each in confirmed][-1] == STARTS[DEFAULT]
    assert len(confirmed) == 1 + 2 * CONFIRMED_SETS
    assert {each.level for each in confirmed} == {"confirmed"}
    groups = [each.faithful for each in confirmed]
    assert groups == [True] * CONFIRMED_SETS + [False] * CONFIRMED_SETS + [True]


def test_a_faithful_climb_changes_nothing_that_the_paper_gives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Search, "_judge", judge_by_hill)
    search = open_search(tmp_path, faithful=True)
    best = search.climb(ParameterSet(), rounds=5)
    assert best.values == ParameterSet(damping=0.02)
    assert all(each.faithful for each in search.judged.values())
    with pytest.raises(UserError, match="--faithful heavy: expected starts that change nothing"):
        search_parameters(search, ["heavy"], rounds=1)


def test_neighbours_differ_in_one_value() -> None:
    start = STARTS["heavy"]
    near = list(start.neighbours())
    used = [name for name in UNKNOWNS if start.uses(name)]
    assert set(UNKNOWNS) - set(used) == {"hold"}  # a hit is not held
    tried = sum(len(UNKNOWNS[name]) for name in used)
    off_grid = sum(asdict(start)[name] not in UNKNOWNS[name] for name in used)
    assert len(near) == tried - len(used) + off_grid
    assert all(len(each.difference(start)) == 1 for each in near)
    assert len(set(near)) == len(near)


def said(values: ParameterSet, level: Level, verdicts: dict[int, Verdict]) -> Judged:
    ours = {claim: f"ours of {claim}" for claim in verdicts}
    return Judged(values=values, level=level, verdicts=verdicts, ours=ours)


def hill(values: ParameterSet, level: Level = "screened") -> Judged:
    """More claims hold the nearer a set is to damping 0.02 and a mass of 400."""
    near = [True, values.damping == 0.02, values.mass == 400.0]
    verdicts: dict[int, Verdict] = dict.fromkeys((*MODAL_CLAIMS, *CONTACT_CLAIMS), "does not hold")
    for claim, met in zip(BRIDGE, near, strict=True):
        verdicts[claim] = "holds" if met else "partly"
    return said(values, level, verdicts)


def judge_by_hill(
    self: Search, sets: list[ParameterSet], level: Level, scrutiny: Scrutiny
) -> list[Judged]:
    return [hill(values, level) for values in sets]


@pytest.fixture
def climbed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Search:
    monkeypatch.setattr(Search, "_judge", judge_by_hill)
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

    def refuse(
        self: Search, sets: list[ParameterSet], level: Level, scrutiny: Scrutiny
    ) -> list[Judged]:
        raise AssertionError(f"judged again: {sets}")

    monkeypatch.setattr(Search, "_judge", refuse)
    assert again.climb(ParameterSet(), rounds=5) == climbed.best(1)[0]


def judged_so(values: ParameterSet, held: tuple[int, ...], level: Level = "screened") -> Judged:
    claims = {"slow": (29,), "still": (5,)}.get(level, (*BRIDGE, 22))
    return said(values, level, {c: "holds" if c in held else "does not hold" for c in claims})


def small_search(directory: Path) -> Search:
    base = STARTS[DEFAULT]
    damped, heavy = replace(base, damping=0.02), replace(base, mass=400.0)
    modal = STARTS[MODAL]
    return Search(
        directory=directory,
        judged={
            (each.values, each.level): each
            for each in (
                judged_so(base, (33, 22)),
                judged_so(damped, (6, 21)),
                judged_so(heavy, BRIDGE),
                judged_so(base, (), "slow"),
                judged_so(damped, (29,), "slow"),
                judged_so(modal, (), "still"),
                judged_so(replace(modal, disk=0.02), (5,), "still"),
                judged_so(base, (33,), "confirmed"),
            )
        },
    )


def test_the_report_names_what_flips_a_claim(tmp_path: Path) -> None:
    text = report_text(small_search(tmp_path))
    assert "3 sets were screened by 4 claims, 6, 21, 22, 33; 2 of them keep every value" in text
    assert "* 21 (does not hold: ours of 21): damping ratio 0.02 instead of 0.001;" in text
    assert "* 5 (does not hold: ours of 5): disk beams [m] 0.02 instead of 0.03." in text
    assert "casing mass over Table 1's 400.0 instead of 1.0." in text
    assert (
        "* 29 (does not hold: ours of 29, by coarse sweeps and steps of 2 µs): damping ratio 0.02"
        " instead of 0.001."
    ) in text
    assert "* 22" not in text  # which the base meets
    assert (
        "Claims 6, 21, 33 together hold in 1 of the screened sets, 0 of which keep what the paper"
        " gives; all of them change casing mass over Table 1's."
    ) in text
    kept, changing = text.split("### ")[1:]
    assert '| confirmed, "light" | 1 | 0 | 33 | damping ratio 0.001 |' in kept
    assert "| screened | 2 | 0 | 6, 21 | damping ratio 0.02 |" in kept
    assert "400" not in kept
    assert "| screened | 3 | 0 | 6, 21, 33 |" in changing


def test_figures_of_missed_claims(tmp_path: Path) -> None:
    search = small_search(tmp_path)
    paths = write_report(search, tmp_path)
    assert paths[0].read_text(encoding="utf-8") == report_text(search)
    assert [path.name for path in paths[1:]] == [
        *(f"sensitivity-claim-{claim}.png" for claim in (5, 6, 21, 29)),
        "sensitivity.png",
    ]
    assert set(found_by_claim(search)) == {5, *BRIDGE, 22, 29}
    overview = xr.open_dataset(tmp_path / "sensitivity.nc")
    assert overview["claim"].values.tolist() == [6, 21, 22, 29, 33]  # 5 is of the modal case
    assert overview["parameter"].values.tolist() == ["damping ratio", "casing mass over Table 1's"]


def cells(figure: Figure) -> list[Rectangle]:
    return [patch for patch in figure.axes[0].patches if isinstance(patch, Rectangle)]


def test_cells_of_a_sensitivity_figure() -> None:
    rows = {"a": [("1", ["holds"]), ("2", ["partly"])], "b": [("x", [""])]}
    data = sensitivity_dataset({5: "Claim."}, rows, {"a": "2", "b": "x"})
    figure = plot_sensitivity(data)
    assert [cell.get_linewidth() > 1.0 for cell in cells(figure)] == [False, True, True]
    assert figure.axes[0].get_title() == "Claim 5: Claim."


def test_columns_of_the_overview() -> None:
    """The base set once, then what differs from it and was tried."""
    rows = {
        "a": [("1", ["holds", ""]), ("2", ["partly", "holds"])],
        "b": [("x", ["partly", "holds"]), ("y", ["", ""]), ("z", ["", "not testable"])],
    }
    data = sensitivity_dataset({5: "Five.", 6: "Six."}, rows, {"a": "2", "b": "x"})
    figure = plot_overview(data)
    labels = [label.get_text() for label in figure.axes[0].get_xticklabels()]
    assert labels == ["base set", "a 1", "b z"]
    wanted = ["partly", "holds", "holds", "", "", "not testable"]  # column by column
    colours = [to_rgba(VERDICT_COLOURS[verdict]) for verdict in wanted]
    assert [cell.get_facecolor() for cell in cells(figure)] == colours


def test_a_set_is_judged_by_marches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two milliseconds: nothing has diverged yet, and the soft casing meets 6 and 7.

    Another hit is no other imbalance: what that says is not asked again.
    """
    short = replace(SCRUTINIES["screened"], changes={"march.duration": 2e-3})
    monkeypatch.setitem(SCRUTINIES, "screened", short)
    search = Search(directory=tmp_path)
    marched: list[int] = []
    make = RunStore.make

    def counted(self: RunStore, cases: Sequence[Case], *_: object) -> None:
        marched.extend(1 for _ in self.missing(cases))
        make(self, cases)

    monkeypatch.setattr(RunStore, "make", counted)
    soft, harder = STARTS["soft"], replace(STARTS["soft"], swing=5.9)
    (judged,) = search.judge([soft])
    assert judged.verdicts[6] == judged.verdicts[7] == "holds"
    assert judged.verdicts[20] == "does not hold"
    assert set(judged.verdicts) == {*MODAL_CLAIMS, *CONTACT_CLAIMS}
    assert open_search(tmp_path).judged == {(soft, "screened"): judged}
    assert len(marched) == 3
    search.judge([harder])
    assert len(marched) == 3 + 2
    search.climb(soft, rounds=0)
    assert [path.name for path in tmp_path.iterdir()] == ["search.json"]


def test_every_claim_belongs_to_one_level() -> None:
    """Claim 16 is on the time step of a march that hardly any of the values change."""
    judged = [*MODAL_CLAIMS, *CONTACT_CLAIMS, *SLOW_CLAIMS, *STILL_CLAIMS]
    assert len(judged) == len(set(judged))
    assert set(CLAIMS) - set(judged) == {16}


def test_neighbours_are_judged_by_what_the_default_misses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[Level, ParameterSet, tuple[int, ...]]] = []

    def judge(
        self: Search, sets: list[ParameterSet], level: Level, scrutiny: Scrutiny
    ) -> list[Judged]:
        asked.extend((level, values, scrutiny.claims) for values in sets)
        verdicts: dict[int, Verdict] = {
            claim: "partly" if claim in (5, 29) else "holds" for claim in scrutiny.claims
        }
        return [said(each, level, verdicts) for each in sets]

    monkeypatch.setattr(Search, "_judge", judge)
    Search(directory=tmp_path).examine()
    assert all(not values.given_changed for _, values, _ in asked)
    assert all(not values.departures for level, values, _ in asked if level == "slow")
    by_level = {
        level: [(values, claims) for each, values, claims in asked if each == level]
        for level in ("slow", "still")
    }
    assert by_level["slow"][0] == (STARTS[DEFAULT], SLOW_CLAIMS)
    assert {claims for _, claims in by_level["slow"][1:]} == {(29,)}
    assert by_level["still"][0] == (STARTS[MODAL], STILL_CLAIMS)
    near = by_level["still"][1:]
    assert {claims for _, claims in near} == {(5,)}
    changed_names = {name for values, _ in near for name in values.difference(STARTS[MODAL])}
    assert changed_names == {"disk", "strain", "frequency"}  # what modes depend on
    assert 9.7 in [values.frequency for values, _ in near]  # a hit would need more force
    tried = [values.damping for values, _ in by_level["slow"]]
    assert 0.002 in tried
    assert 0.0011 not in tried  # for a better fit only


def test_claims_on_sweeps_are_judged_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name = "six modes, distortion"
    monkeypatch.setitem(SURVEYS, name, replace(SURVEYS[name], coarse_step=0.3))
    short = replace(SCRUTINIES["slow"], claims=(36,), changes={"march.duration": 1e-3})
    monkeypatch.setitem(SCRUTINIES, "slow", short)
    (judged,) = Search(directory=tmp_path).judge([STARTS[DEFAULT]], "slow")
    assert judged.verdicts == {36: "does not hold"}  # nothing diverges in a millisecond
    assert (tmp_path / "search.json").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["hard"], "hard: expected soft, supported, light, heavy"),
        (["--report"], 'expected a search from the start "light"'),
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
    text = path.read_text()
    path.write_text(text.replace('"bladewhirl": "', '"bladewhirl": "0.0.'))
    with pytest.raises(UserError, match=r"this one is of 0\.0\."):
        open_search(climbed.directory)
    path.write_text(text.replace('"screened"', '"swept"').replace(' "format": 2,\n', ""))
    with pytest.raises(UserError, match="with None; begin another"):
        open_search(climbed.directory)


def test_a_search_from_elsewhere_has_a_default_to_compare_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Search, "_judge", judge_by_hill)
    search = open_search(tmp_path)
    search_parameters(search, ["heavy"], rounds=0)
    assert {(STARTS["heavy"], "screened"), (STARTS[DEFAULT], "screened")} <= set(search.judged)
    assert [path.name for path in write_report(search, tmp_path)] == ["report.md"]

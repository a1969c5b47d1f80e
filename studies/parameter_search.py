"""Search for the values that the paper leaves out: which set satisfies most claims together.

From a start the search goes to the best of all sets that differ in one value, until none is
better. Sets are screened with coarser time steps and judged once; the best are then confirmed at
the paper's time step over repeats with a slightly different force. Everything judged is kept in
one file, so a search that was interrupted goes on where it was.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import get_args

from bladewhirl.models.faults import UserError
from bladewhirl.studies import run_directory
from bladewhirl.studies.claim import CLAIMS, Finding, Verdict
from bladewhirl.studies.laboratory import Laboratory
from bladewhirl.studies.parameter_sets import STARTS, ParameterSet
from bladewhirl.studies.reproduction import needed_trials
from bladewhirl.studies.run_store import RunStore
from bladewhirl.studies.scorecard import Score
from bladewhirl.studies.sweep_store import write_whole

MODAL_CLAIMS = (6, 7, 8)
CONTACT_CLAIMS = (20, 21, 22, 23, 24, 25, 26, 30, 31, 32, 33, 42, 43, 44)
"""Claims that depend on what is searched and are judged by few marches."""

BRIDGE = (6, 21, 33)
"""First coincidence at 1.05, backward whirl under distortion, contact on the shaft's side."""

SCREENING = {"march.time_step": 2e-6, "march.record_step": 4e-4}
"""Changes of the cases while screening: half of the steps, a quarter of the records."""

CONFIRMED_REPEATS, CONFIRMED_SETS = 3, 2
"""Repeats of a set that is confirmed, and how many of the best are."""

DEFAULT = "supported"
"""Start that the examples of the paper's two scenarios are."""

FILE_NAME = "search.json"


@dataclass(frozen=True, kw_only=True)
class Judged:
    """A set of parameters, and what the claims say of it."""

    values: ParameterSet
    confirmed: bool  #: at the paper's time step over repeats; else screened
    verdicts: Mapping[int, Verdict]  #: by claim
    ours: Mapping[int, str]  #: our value, by claim

    @property
    def rank(self) -> tuple[int, int]:
        """Claims that hold, and that hold in part: the more the better."""
        found = list(self.verdicts.values())
        return found.count("holds"), found.count("partly")

    @property
    def bridges(self) -> bool:
        """Whether it satisfies `BRIDGE`."""
        return all(self.verdicts.get(claim) == "holds" for claim in BRIDGE)


Told = Callable[[Judged], None]


@dataclass(kw_only=True)
class Search:
    """All that has been judged, in one folder."""

    directory: Path
    scheduler: str | None = None  #: address of a dask scheduler; this process marches when None
    told: Told = lambda judged: None
    judged: dict[tuple[ParameterSet, bool], Judged] = field(default_factory=dict)

    def climb(self, start: ParameterSet, rounds: int) -> Judged:
        """The best set reached from a start in so many rounds; all on the way are judged."""
        best = self.judge(start)
        for _ in range(rounds):
            near = [self.judge(values) for values in best.values.neighbours()]
            better = max(near, key=lambda judged: judged.rank)
            if better.rank <= best.rank:
                break
            best = better
        return best

    def confirm(self) -> list[Judged]:
        """Judge the best screened sets, and the default of the paper's two cases, again.

        That is done at the paper's time step over repeats.
        """
        best = [judged.values for judged in self.best(CONFIRMED_SETS)]
        return [
            self.judge(values, confirmed=True) for values in dict.fromkeys([*best, STARTS[DEFAULT]])
        ]

    def best(self, sets: int, *, confirmed: bool = False) -> list[Judged]:
        """The best sets, the best first."""
        found = [judged for judged in self.judged.values() if judged.confirmed == confirmed]
        return sorted(found, key=lambda judged: judged.rank, reverse=True)[:sets]

    def judge(self, values: ParameterSet, *, confirmed: bool = False) -> Judged:
        """Judge a set, if it has not been."""
        key = values, confirmed
        if key not in self.judged:
            self.judged[key] = self._judge(values, confirmed=confirmed)
            self.write()
            self.told(self.judged[key])
        return self.judged[key]

    def _judge(self, values: ParameterSet, *, confirmed: bool) -> Judged:
        store = RunStore(directory=self.directory / "runs", workers=1, scheduler=self.scheduler)
        changes = values.changes() | ({} if confirmed else SCREENING)
        contact = [CLAIMS[number] for number in CONTACT_CLAIMS]
        labs = [
            Laboratory(directory=self.directory, store=store, changes=changes, repeat=repeat)
            for repeat in range(CONFIRMED_REPEATS if confirmed else 1)
        ]
        cases = [case for lab in labs for case in lab.cases(needed_trials(contact))]
        store.make(cases)
        findings: dict[int, list[Finding]] = {number: [] for number in CONTACT_CLAIMS}
        for lab in labs:
            with lab:
                for each in contact:
                    findings[each.number].append(each.judge(lab))
        for case in cases:  # what is known of them is in the file; there would be too many
            store.path(case).unlink(missing_ok=True)
        for number, finding in modal_findings(_without_motion(values)).items():
            findings[number] = [finding]
        scores = {
            number: Score(claim=CLAIMS[number], findings=tuple(found))
            for number, found in sorted(findings.items())
        }
        return Judged(
            values=values,
            confirmed=confirmed,
            verdicts={number: score.verdict for number, score in scores.items()},
            ours={number: score.ours for number, score in scores.items()},
        )

    def write(self) -> None:
        """Write all that has been judged.

        Raises:
            UserError: the folder can't be written.
        """
        document = {
            run_directory.PACKAGE: run_directory.version(),
            "sets": [
                {
                    "confirmed": judged.confirmed,
                    "values": asdict(judged.values),
                    "verdicts": judged.verdicts,
                    "ours": judged.ours,
                }
                for judged in self.judged.values()
            ],
        }
        try:
            self.directory.mkdir(parents=True, exist_ok=True)
            text = json.dumps(document, indent=1, ensure_ascii=False) + "\n"
            write_whole(self.directory / FILE_NAME, text)
        except OSError as error:
            raise UserError(f"{self.directory}: cannot be written ({error.strerror})") from None


def open_search(
    directory: Path, *, scheduler: str | None = None, told: Told | None = None
) -> Search:
    """A search that goes on with what a folder has, or begins in it.

    Raises:
        UserError: the folder holds something else, or a search of another version.
    """
    search = Search(directory=directory, scheduler=scheduler, told=told or (lambda judged: None))
    path = directory / FILE_NAME
    if not path.exists():
        return search
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        made_by = document[run_directory.PACKAGE]
        for row in document["sets"]:
            judged = Judged(
                values=ParameterSet(**row["values"]),
                confirmed=bool(row["confirmed"]),
                verdicts={int(claim): _verdict(name) for claim, name in row["verdicts"].items()},
                ours={int(claim): str(text) for claim, text in row["ours"].items()},
            )
            search.judged[judged.values, judged.confirmed] = judged
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: expected a search ({error!r})") from None
    if made_by != run_directory.version():
        raise UserError(
            f"{path}: expected a search of bladewhirl {run_directory.version()}, this one is of"
            f" {made_by}"
        )
    return search


def search_parameters(search: Search, starts: Iterable[str], rounds: int) -> list[Judged]:
    """Climb from starts by name, then confirm the best and the present default.

    Raises:
        UserError: a start that there is not.
    """
    names = list(starts)
    unknown = [name for name in names if name not in STARTS]
    if unknown:
        raise UserError(f"{', '.join(unknown)}: expected {', '.join(STARTS)}")
    for name in names:
        search.judge(STARTS[name])
    for name in names:
        search.climb(STARTS[name], rounds)
    return search.confirm()


@lru_cache(maxsize=64)
def modal_findings(values: ParameterSet) -> dict[int, Finding]:
    """What the modal claims say of a set."""
    nowhere = Path()
    with Laboratory(
        directory=nowhere, store=RunStore(directory=nowhere), changes=values.changes()
    ) as lab:
        return {number: CLAIMS[number].judge(lab) for number in MODAL_CLAIMS}


def _without_motion(values: ParameterSet) -> ParameterSet:
    """The set with defaults where modes do not depend on it."""
    return replace(
        ParameterSet(),
        disk=values.disk,
        wall=values.wall,
        strain=values.strain,
        frequency=values.frequency,
        mass=values.mass,
    )


def _verdict(name: str) -> Verdict:
    if name not in get_args(Verdict):
        raise ValueError(f"no verdict: {name}")
    return name  # type: ignore[return-value]

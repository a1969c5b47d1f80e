"""Search for the values that the paper leaves out: which set satisfies most claims together.

From a start the search goes to the best of all sets that differ in one value, until none is
better. Sets are screened with coarser time steps and judged once; the best are then confirmed at
the paper's time step over repeats with a slightly different force. Everything judged is kept in
one file, so a search that was interrupted goes on where it was.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from itertools import chain
from pathlib import Path
from shutil import rmtree
from typing import Any, Literal, get_args

from bladewhirl.meshes.files.drafts import write_whole
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.paper.claim import CLAIMS, Finding, Verdict
from bladewhirl.studies.paper.judge import needed_trials
from bladewhirl.studies.paper.scorecard import Score
from bladewhirl.studies.paper.search.parameters import STARTS, ParameterSet
from bladewhirl.studies.paper.trials import Evidence
from bladewhirl.studies.runs import folder as run_directory
from bladewhirl.studies.sweeps.cache import RunStore

MODAL_CLAIMS = (6, 7, 8)
CONTACT_CLAIMS = (20, 21, 22, 23, 24, 25, 26, 30, 31, 32, 33, 42, 43, 44)
"""Claims that depend on what is searched and are judged by few marches."""

BRIDGE = (6, 21, 33)
"""First coincidence at 1.05, backward whirl under distortion, contact on the shaft's side."""

SCREENING = {"march.time_step": 2e-6, "march.record_step": 4e-4}
"""Changes of the cases while screening: half of the steps, a quarter of the records."""

SLOW_CLAIMS = (17, 18, 19, 27, 28, 29, 34, 35, 36, 37, 38, 39, 40, 41, 45, 46)
"""Claims that depend on what is searched and are judged by sweeps or many marches."""

STILL_CLAIMS = (1, 2, 3, 4, 5, 9, 10, 11, 12, 13, 14, 15)
"""The others that no march is needed for. Claim 16, on the time step, is left out of a search: what
is searched hardly changes it."""

FORMAT = 2
"""Of the file; another one was judged by other rules."""

Level = Literal["screened", "slow", "still", "confirmed"]


@dataclass(frozen=True, kw_only=True)
class Scrutiny:
    """How closely a set is looked at."""

    claims: tuple[int, ...]  #: that are judged
    modal: bool = True  #: whether `MODAL_CLAIMS` are judged, too
    changes: Mapping[str, float] = field(default_factory=dict)  #: of the cases
    coarse: bool = False  #: as in `Evidence`
    repeats: int = 1


SCRUTINIES: Mapping[Level, Scrutiny] = {
    "screened": Scrutiny(claims=CONTACT_CLAIMS, changes=SCREENING),
    "slow": Scrutiny(claims=SLOW_CLAIMS, modal=False, changes=SCREENING, coarse=True),
    "still": Scrutiny(claims=STILL_CLAIMS, modal=False),
    "confirmed": Scrutiny(claims=CONTACT_CLAIMS, repeats=3),
}
"""By level."""

CONFIRMED_SETS = 2
"""How many of the best sets are confirmed, of those that keep every value that the paper gives and
of the others."""

SETS_AT_ONCE = 8
"""Sets whose marches are made together; an interrupted search loses no more of them."""

DEFAULT, MODAL = "light", "soft"
"""Starts that the examples are: of the paper's two scenarios, and of modal work."""

BASES: Mapping[Level, str] = {"screened": DEFAULT, "slow": DEFAULT, "still": MODAL}
"""Starts that are changed one value at a time, and how closely what comes of it is looked at."""

FILE_NAME, MARCHES = "search.json", "marches"
"""In the folder of a search: what has been judged, and marches while they are needed."""


@dataclass(frozen=True, kw_only=True)
class Judged:
    """A set of parameters, and what the claims say of it."""

    values: ParameterSet
    level: Level  #: of scrutiny
    verdicts: Mapping[int, Verdict]  #: by claim
    ours: Mapping[int, str]  #: our value, by claim

    @property
    def rank(self) -> tuple[int, int]:
        """Claims that hold, and that hold in part: the more the better."""
        found = list(self.verdicts.values())
        return found.count("holds"), found.count("partly")

    @property
    def faithful(self) -> bool:
        """Whether it keeps every value that the paper gives."""
        return not self.values.departures

    @property
    def bridges(self) -> bool:
        """Whether it satisfies `BRIDGE`."""
        return all(self.verdicts.get(claim) == "holds" for claim in BRIDGE)


Told = Callable[[Judged], None]

Key = tuple[ParameterSet, Level]
"""A set, and how closely it was looked at."""


@dataclass(kw_only=True)
class Search:
    """All that has been judged, in one folder."""

    directory: Path
    scheduler: str | None = None  #: address of a dask scheduler; this process marches when None
    faithful: bool = False  #: whether to try only sets that keep every value that the paper gives
    told: Told = lambda judged: None
    judged: dict[Key, Judged] = field(default_factory=dict)

    def climb(self, start: ParameterSet, rounds: int) -> Judged:
        """The best set reached from a start in so many rounds; all on the way are judged."""
        with self._tidied():
            (best,) = self.judge([start])
            for _ in range(rounds):
                near = self.judge(
                    [v for v in best.values.neighbours() if not (self.faithful and v.departures)]
                )
                better = max(near, key=lambda judged: judged.rank)
                if better.rank <= best.rank:
                    break
                best = better
        return best

    def confirm(self) -> list[Judged]:
        """Judge the best screened sets, and the default of the paper's two cases, again.

        That is done at the paper's time step over repeats.
        """
        best = [
            judged.values
            for faithful in (True, False)
            for judged in self.best(CONFIRMED_SETS, faithful=faithful)
        ]
        with self._tidied():
            return self.judge(list(dict.fromkeys([*best, STARTS[DEFAULT]])), "confirmed")

    def examine(self) -> list[Judged]:
        """Judge the defaults by all claims but 16, and what differs in one value by the missed.

        Only sets are looked at that keep every value that the paper gives.
        """
        found = []
        for level, start in BASES.items():
            base = STARTS[start]
            near = [
                values
                for values in base.neighbours()
                if not values.given_changed and not values.resembles(base)
            ]
            if level == "still":
                near = [each for each in near if _without_motion(each) != _without_motion(base)]
            else:
                near = [each for each in near if not each.departures]
            with self._tidied():
                found += self.judge([base], level)
                missed = tuple(
                    claim for claim, verdict in found[-1].verdicts.items() if verdict != "holds"
                )
                # Screened sets are ranked, by all claims; the others take long.
                only = None if level == "screened" else missed
                for values in near:
                    found += self.judge([values], level, only=only)
        return found

    def best(
        self, sets: int, level: Level = "screened", *, faithful: bool | None = None
    ) -> list[Judged]:
        """The best sets, the best first.

        Args:
            sets: how many.
            level: of scrutiny.
            faithful: of those that keep every value that the paper gives, or of those that do
                not; of all when None.
        """
        found = [
            judged
            for judged in self.judged.values()
            if judged.level == level and faithful in (None, judged.faithful)
        ]
        return sorted(found, key=lambda judged: judged.rank, reverse=True)[:sets]

    def judge(
        self,
        sets: Sequence[ParameterSet],
        level: Level = "screened",
        *,
        only: Container[int] | None = None,
    ) -> list[Judged]:
        """Judge sets, those of them that have not been.

        Args:
            sets: to judge.
            level: of scrutiny.
            only: claims of that level that are judged; all when None.
        """
        left = [values for values in dict.fromkeys(sets) if (values, level) not in self.judged]
        scrutiny = SCRUTINIES[level]
        if only is not None:
            scrutiny = replace(scrutiny, claims=tuple(c for c in scrutiny.claims if c in only))
        for first in range(0, len(left), SETS_AT_ONCE):
            for judged in self._judge(left[first : first + SETS_AT_ONCE], level, scrutiny):
                self.judged[judged.values, level] = judged
                self.told(judged)
            self.write()
        return [self.judged[values, level] for values in sets]

    def _judge(
        self, sets: Sequence[ParameterSet], level: Level, scrutiny: Scrutiny
    ) -> list[Judged]:
        """Make the marches of all sets, then judge one after the other."""
        marches = self.directory / MARCHES
        store = RunStore(directory=marches, workers=1, scheduler=self.scheduler)
        repeated = {
            values: [
                Evidence(
                    directory=marches,
                    store=store,
                    changes=values.changes() | dict(scrutiny.changes),
                    coarse=scrutiny.coarse,
                    repeat=repeat,
                )
                for repeat in range(scrutiny.repeats)
            ]
            for values in sets
        }
        claims = [CLAIMS[number] for number in scrutiny.claims]
        names = needed_trials(claims)
        store.make(
            [
                case
                for evidence in chain.from_iterable(repeated.values())
                for case in evidence.cases(names)
            ]
        )
        return [self._verdicts(values, own, level, scrutiny) for values, own in repeated.items()]

    @staticmethod
    def _verdicts(
        values: ParameterSet, repeated: Sequence[Evidence], level: Level, scrutiny: Scrutiny
    ) -> Judged:
        modal = modal_findings(_without_motion(values)) if scrutiny.modal else {}
        findings = {number: [finding] for number, finding in modal.items()}
        for evidence in repeated:
            with evidence:
                for number in scrutiny.claims:
                    findings.setdefault(number, []).append(CLAIMS[number].judge(evidence))
        scores = {
            number: Score(claim=CLAIMS[number], findings=tuple(found))
            for number, found in sorted(findings.items())
        }
        return Judged(
            values=values,
            level=level,
            verdicts={number: score.verdict for number, score in scores.items()},
            ours={number: score.ours for number, score in scores.items()},
        )

    @contextmanager
    def _tidied(self) -> Iterator[None]:
        """Marches and sweeps are shared by sets, and thrown away at the end.

        What is known of them is in the file; there would be too many.
        """
        yield
        rmtree(self.directory / MARCHES, ignore_errors=True)

    def write(self) -> None:
        """Write all that has been judged.

        Raises:
            UserError: the folder can't be written.
        """
        document = {
            run_directory.PACKAGE: run_directory.version(),
            "format": FORMAT,
            "sets": [
                {
                    "level": judged.level,
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
    directory: Path,
    *,
    scheduler: str | None = None,
    faithful: bool = False,
    told: Told | None = None,
) -> Search:
    """A search that goes on with what a folder has, or begins in it.

    Raises:
        UserError: the folder holds something else, or a search of another version.
    """
    search = Search(
        directory=directory,
        scheduler=scheduler,
        faithful=faithful,
        told=told or (lambda judged: None),
    )
    path = directory / FILE_NAME
    if not path.exists():
        return search
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        made_by = document[run_directory.PACKAGE], document.get("format")
        if made_by != (run_directory.version(), FORMAT):
            raise UserError(
                f"{path}: expected a search of bladewhirl {run_directory.version()} with format"
                f" {FORMAT}, this one is of {made_by[0]} with {made_by[1]}; begin another"
            )
        for row in document["sets"]:
            judged = Judged(
                values=ParameterSet(**row["values"]),
                level=_named(row["level"], Level),
                verdicts={
                    int(claim): _named(name, Verdict) for claim, name in row["verdicts"].items()
                },
                ours={int(claim): str(text) for claim, text in row["ours"].items()},
            )
            search.judged[judged.values, judged.level] = judged
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: expected a search ({error!r})") from None
    return search


def search_parameters(
    search: Search, starts: Iterable[str], rounds: int, *, every_claim: bool = False
) -> list[Judged]:
    """Climb from starts by name, then confirm the best and the present default.

    Args:
        search: to go on with.
        starts: names of `STARTS`.
        rounds: steps from each to a better neighbour.
        every_claim: whether to `Search.examine` the defaults, too.

    Raises:
        UserError: a start that there is not, or that changes what the paper gives.
    """
    names = list(starts)
    unknown = [name for name in names if name not in STARTS]
    if unknown:
        raise UserError(f"{', '.join(unknown)}: expected {', '.join(STARTS)}")
    changing = [name for name in names if STARTS[name].departures] if search.faithful else []
    if changing:
        raise UserError(f"--faithful {', '.join(changing)}: expected starts that change nothing")
    search.judge([STARTS[name] for name in dict.fromkeys([DEFAULT, *names])])
    for name in names:
        search.climb(STARTS[name], rounds)
    if every_claim:
        search.examine()
    return search.confirm()


@lru_cache(maxsize=64)
def modal_findings(values: ParameterSet) -> dict[int, Finding]:
    """Findings of the modal claims on a set."""
    nowhere = Path()
    with Evidence(
        directory=nowhere, store=RunStore(directory=nowhere), changes=values.changes()
    ) as evidence:
        return {number: CLAIMS[number].judge(evidence) for number in MODAL_CLAIMS}


def _without_motion(values: ParameterSet) -> ParameterSet:
    """The set with defaults where modes do not depend on it."""
    return replace(
        ParameterSet(),
        disk=values.disk,
        wall=values.wall,
        strain=values.strain,
        frequency=values.frequency,
        mass=values.mass,
        tip_mass=values.tip_mass,
    )


def _named(name: str, kind: Any) -> Any:
    """One of the names of a literal type."""
    if name not in get_args(kind):
        raise ValueError(f"{name}: expected {', '.join(get_args(kind))}")
    return name

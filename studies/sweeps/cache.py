"""Runs of a study: missing runs are marched in parallel, existing runs are used again.

A run is identified by its resolved case and the version of the program, so an interrupted study
continues with the missing runs, and another study can use the same runs.
"""

import hashlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import writing
from bladewhirl.studies.runs import folder
from bladewhirl.studies.sweeps.marching import march_points
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point, Work, march_point

KEY_LENGTH = 16  #: number of characters in the name of a run

Progress = Callable[[int, int], None]  #: called with the numbers of finished runs and of all runs


def run_key(case: Case) -> str:
    """Return the name of the run of a case, which depends on the case and the version of the
    program."""
    text = folder.version() + "\n" + dumps_case(case)
    return hashlib.sha256(text.encode()).hexdigest()[:KEY_LENGTH]


@dataclass(kw_only=True)
class RunStore:
    """Folder with one result file for each case."""

    directory: Path
    workers: int | None = None  #: number of processes, by default one per core; 1: this process
    scheduler: str | None = None  #: address of an existing dask scheduler
    #: reasons of failures by the name of the run
    failures: dict[str, str] = field(default_factory=dict)

    def path(self, case: Case) -> Path:
        """Return the path of the result of a case."""
        return self.directory / f"{run_key(case)}.nc"

    def missing(self, cases: Sequence[Case]) -> list[Case]:
        """Return the cases without a result, each once."""
        named = {run_key(case): case for case in cases}
        return [case for case in named.values() if not self.path(case).exists()]

    def make(self, cases: Sequence[Case], progress: Progress | None = None) -> None:
        """March the cases that have no result yet; failed runs are listed in `failures`.

        Raises:
            UserError: the folder cannot be written, or the scheduler does not answer.
        """
        missing = self.missing(cases)
        if progress is not None:
            progress(0, len(missing))
        if not missing:
            return
        with writing(self.directory):
            self.directory.mkdir(parents=True, exist_ok=True)
        work = Work(
            case=dumps_case(missing[0]), layout=None, histories=str(self.directory.absolute())
        )
        points = [
            Point(
                number=number,
                # Complete tables, because the cases need not have anything in common.
                values=cast(Any, case.model_dump(exclude_none=True)),
                history=self.path(case).name,
            )
            for number, case in enumerate(missing)
        ]
        outcomes: Iterable[tuple[int, Outcome]]
        if self.scheduler is None and self.workers == 1:
            outcomes = ((point.number, march_point(work, point)) for point in points)
        else:
            outcomes = march_points(work, points, scheduler=self.scheduler, workers=self.workers)
        for done, (number, outcome) in enumerate(outcomes, 1):
            if isinstance(outcome, Failure):
                self.failures[run_key(missing[number])] = outcome.reason
            if progress is not None:
                progress(done, len(missing))

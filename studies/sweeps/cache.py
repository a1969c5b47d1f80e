"""Runs of a study, loaded if they exist, otherwise marched in parallel.

A run is known by its resolved case and the version of the program: a study that is interrupted
goes on where it was, and one that asks for the same run again gets it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.runs import folder
from bladewhirl.studies.sweeps.points import Failure, Outcome, Point, Work, march_point
from bladewhirl.studies.sweeps.workers import march_points

KEY_LENGTH = 16
"""Characters of the name of a run."""

Progress = Callable[[int, int], None]
"""Called with runs done and runs in all."""


def run_key(case: Case) -> str:
    """Name of the run of a case: the same for the same case and version."""
    text = folder.version() + "\n" + dumps_case(case)
    return hashlib.sha256(text.encode()).hexdigest()[:KEY_LENGTH]


@dataclass(kw_only=True)
class RunStore:
    """Results by case, in one folder."""

    directory: Path
    workers: int | None = None  #: processes that march; one a core when None, this one when 1
    scheduler: str | None = None  #: address of an existing dask scheduler
    failures: dict[str, str] = field(default_factory=dict)  #: reason by name of the run

    def path(self, case: Case) -> Path:
        """Return the path of the result of a case."""
        return self.directory / f"{run_key(case)}.nc"

    def missing(self, cases: Sequence[Case]) -> list[Case]:
        """Cases without a result, each once."""
        named = {run_key(case): case for case in cases}
        return [case for case in named.values() if not self.path(case).exists()]

    def make(self, cases: Sequence[Case], progress: Progress | None = None) -> None:
        """March the cases that have no result yet; what fails is noted in `failures`.

        Raises:
            UserError: the folder can't be written, or the scheduler does not answer.
        """
        missing = self.missing(cases)
        if progress is not None:
            progress(0, len(missing))
        if not missing:
            return
        try:
            self.directory.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError(f"{self.directory}: cannot be written ({error.strerror})") from None
        work = Work(
            case=dumps_case(missing[0]), layout=None, histories=str(self.directory.absolute())
        )
        points = [
            Point(
                number=number,
                # Whole tables: the cases need not have anything in common.
                values=cast(Any, case.model_dump(exclude_none=True)),
                history=self.path(case).name,
            )
            for number, case in enumerate(missing)
        ]
        for done, (number, outcome) in enumerate(self._marched(work, points), 1):
            if isinstance(outcome, Failure):
                self.failures[run_key(missing[number])] = outcome.reason
            if progress is not None:
                progress(done, len(missing))

    def _marched(self, work: Work, points: Sequence[Point]) -> Iterator[tuple[int, Outcome]]:
        """Yield the outcome of each point; a single process marches them itself."""
        if self.scheduler is None and self.workers == 1:
            return ((point.number, march_point(work, point)) for point in points)
        return march_points(work, points, scheduler=self.scheduler, workers=self.workers)

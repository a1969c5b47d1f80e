"""Maps of the claims that few marches judge over what the paper leaves out, and what survives.

    python -m bladewhirl.studies.paper.search.survival FOLDER JOB...

A job is a name of `JOBS`, a list of sets to march and of the ways to march them. What each march
says of the claims is kept in FOLDER, so that jobs share their marches and go on where they were.
Ways with another instruction set are marched by a process with NUMBA_CPU_NAME=x86-64 and
NUMBA_CPU_FEATURES="", which the caller starts; each process does the ways that it can.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

from bladewhirl.meshes.files.drafts import write_whole
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.postprocess.fields.fields import ViewError
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.run.measures import Motion
from bladewhirl.studies.paper.cases import changed
from bladewhirl.studies.paper.claim import CLAIMS, Finding
from bladewhirl.studies.paper.judge import chosen_claims
from bladewhirl.studies.paper.search.parameters import ParameterSet
from bladewhirl.studies.paper.search.search import SCREENING
from bladewhirl.studies.paper.trials import PERTURBATION, TRIALS, NotTestableError, perturbed
from bladewhirl.studies.sweeps.cache import RunStore, run_key

MARCHES: Mapping[str, tuple[int, ...]] = {
    "distortion at 1.05": (20, 21, 22, 23, 24, 42, 43),
    "distortion at 1.39": (25, 26),
    "imbalance at 1.05": (30, 32, 33, 44),
}
"""Claims that one march judges, by the march."""

PORTABLE = os.environ.get("NUMBA_CPU_NAME") == "x86-64"
"""Whether this process marches without the instructions that only some processors have."""


@dataclass(frozen=True, kw_only=True)
class Way:
    """How a set is marched."""

    repeat: float = 0.0  #: relative change of the force over `PERTURBATION`
    changes: tuple[tuple[str, float], ...] = ()  #: of the case
    portable: bool = False


WAYS: Mapping[str, Way] = {
    "screened": Way(changes=tuple(SCREENING.items())),
    "paper's step": Way(),
    "force + 1e-7": Way(repeat=1),
    "force + 1e-3": Way(repeat=1e-3 / PERTURBATION),
    "half the step": Way(changes=(("march.time_step", 5e-7),)),
    "x86-64": Way(portable=True),
}
"""By name."""

SURVIVAL = tuple(WAYS)[1:]

BASE = ParameterSet(frequency=4.0, push="hold", hold=0.01, damping=0.001, ramp=0.1)


@dataclass(frozen=True, kw_only=True)
class Job:
    """Sets, and the ways and marches to judge them by."""

    sets: tuple[ParameterSet, ...]
    ways: tuple[str, ...] = ("screened",)
    marches: tuple[str, ...] = tuple(MARCHES)


def grid(base: ParameterSet = BASE, **values: tuple[Any, ...]) -> tuple[ParameterSet, ...]:
    """All combinations of values."""
    return tuple(
        replace(base, **dict(zip(values, found, strict=True)))
        for found in product(*values.values())
    )


IMBALANCE, PUSH, PUSHES = ("imbalance at 1.05",), ("distortion at 1.05",), tuple(MARCHES)[:2]

CHOSEN = replace(BASE, frequency=2.2839, hold=0.009)
"""In the middle of the sets that satisfy most: a support of 2.6 MN/m2."""

BEFORE = replace(BASE, hold=0.0084)
"""The default before, and beside it a push that is farther from the edge."""

JOBS: Mapping[str, Job] = {
    # How long the stiff casing of the former default is pushed.
    "push": Job(
        sets=grid(
            damping=(0.001, 0.002),
            hold=(0.0078, 0.0084, 0.009, 0.01, 0.012, 0.015, 0.02, 0.03, 0.05, 0.15),
        ),
        marches=PUSH,
    ),
    # Softer casings: the motion grows slower, after pushes of any length.
    "softer": Job(
        sets=grid(frequency=(1.5, 2.0), damping=(0.001, 0.0015, 0.002), hold=(0.006, 0.009, 0.015))
        + grid(frequency=(2.5,), damping=(0.001, 0.002), hold=(0.006, 0.009, 0.015))
        + grid(frequency=(3.0,), hold=(0.006, 0.009, 0.015)),
        marches=PUSH,
    ),
    "fine": Job(
        sets=grid(frequency=(1.75, 2.0), damping=(0.0012, 0.0014, 0.0016), hold=(0.011, 0.013))
        + grid(frequency=(2.25,), damping=(0.0012, 0.0014), hold=(0.011, 0.013))
        + grid(frequency=(1.5, 1.75), damping=(0.001, 0.0012, 0.0014), hold=(0.01,))
        + grid(frequency=(2.5,), damping=(0.001, 0.0012), hold=(0.01, 0.012)),
        marches=PUSH,
    ),
    "centre": Job(
        sets=grid(frequency=(2.0, 2.25), damping=(0.0008, 0.001, 0.0012), hold=(0.009, 0.0095))
        + grid(frequency=(2.0, 2.25), hold=(0.01,))
        + grid(frequency=(2.35,), hold=(0.009, 0.0095)),
        marches=PUSH,
    ),
    "other speed": Job(
        sets=grid(frequency=(2.25,), damping=(0.001, 0.0012), hold=(0.009, 0.01)),
        marches=("distortion at 1.39",),
    ),
    "imbalance": Job(
        sets=grid(frequency=(1.5, 2.5, 3.0), damping=(0.002, 0.003))
        + grid(frequency=(1.0, 2.0), damping=(0.001, 0.002, 0.003))
        + grid(frequency=(4.0, 5.0, 6.0), damping=(0.001, 0.002)),
        marches=IMBALANCE,
    ),
    "ramps": Job(
        sets=grid(frequency=(1.75, 2.0), damping=(0.0012, 0.0016, 0.002), ramp=(0.02, 0.05))
        + grid(frequency=(2.25,), damping=(0.001, 0.0012), ramp=(0.02, 0.05))
        + grid(frequency=(2.5,), damping=(0.001, 0.0012, 0.0015), ramp=(0.05, 0.1))
        + grid(frequency=(2.15, 2.25), ramp=(0.1,)),
        marches=IMBALANCE,
    ),
    "chosen": Job(sets=(CHOSEN,), ways=tuple(WAYS)),
    "before": Job(sets=(BEFORE, BASE), ways=SURVIVAL, marches=PUSH),
}
"""By name."""


def case_of(values: ParameterSet, march: str, way: Way) -> Case:
    """Case of a march of a set."""
    trial = TRIALS[march]
    case = changed(trial.load, {**values.changes(), **trial.changes})
    case = with_values(case, dict(way.changes))
    return perturbed(case, way.repeat) if way.repeat else case  # type: ignore[arg-type]


def judged(folder: Path, march: str, case: Case, *, portable: bool) -> dict[str, Any] | None:
    """What a march says, from the file or marched now; None where another process has to."""
    path = folder / f"{run_key(case)}{'-x86-64' if portable else ''}.json"
    if path.exists():
        return dict(json.loads(path.read_text(encoding="utf-8")))
    if portable is not PORTABLE:
        return None
    store = RunStore(directory=folder / f"marches-{os.getpid()}", workers=1)
    store.make([case])
    if store.failures:
        raise SystemExit(f"{march}: {store.failures}")
    with open_result(store.path(case)) as result:
        motion = Motion(result)
        found = {str(number): _finding(number, motion) for number in MARCHES[march]}
        document = {
            "end": motion.end,
            "regime": motion.regime.name,
            "energy": motion.energy(*motion.late),
            "findings": found,
        }
    store.path(case).unlink()
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps(document, indent=1) + "\n")
    return document


def _finding(number: int, motion: Motion) -> dict[str, str]:
    try:
        finding = CLAIMS[number].evaluate(motion)
    except (NotTestableError, ViewError) as error:
        finding = Finding(ours="–", obstacle=str(error).rstrip("."))
    return {"verdict": finding.verdict, "ours": finding.ours, "why": finding.why}


def work(folder: Path, job: Job) -> Iterator[str]:
    """A line for each set and way, marched if need be."""
    for values, name in product(job.sets, job.ways):
        way = WAYS[name]
        words = []
        for march in job.marches:
            case = case_of(values, march, way)
            document = judged(folder, march, case, portable=way.portable)
            if document is None:
                words.append(f"{march}: left to the other process")
                continue
            short = " ".join(
                f"{number}{ {'holds': '+', 'partly': '~'}.get(one['verdict'], '-') }"
                for number, one in document["findings"].items()
            )
            last = list(document["findings"].values())
            words.append(
                f"{document['regime'][:3]} {document['end']:.3f} {short} [{last[0]['ours']}]"
            )
        told = {k: v for k, v in asdict(values).items() if v != asdict(BASE)[k]}
        yield f"{name} {told}: {' | '.join(words)}"


def main(arguments: list[str]) -> None:
    """Do the jobs."""
    chosen_claims([])
    folder, *names = arguments
    for name in names:
        print(f"== {name}", flush=True)
        for line in work(Path(folder), JOBS[name]):
            print(line, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

"""Time of the parts of a whole run: `python benchmarks/whole_run.py`.

Runs `bladewhirl run examples/imbalance.toml` for 3 s and for 0.02 s of marched time without a
ParaView series, each in a process of its own, and adds up the processor time of each part; a part
that calls another is not charged for it. The best of some turns counts, since what else the machine
does only ever adds.
"""

from __future__ import annotations

import argparse
import functools
import json
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import _bootstrap, import_module
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

CASE = Path(__file__).resolve().parent.parent / "examples" / "imbalance.toml"
DURATIONS = (3.0, 0.02)  # s

IMPORTS, MARCH, REST, WHOLE = "imports", "march", "rest", "whole run"

PARTS = {
    "models.case.file:read_case": "case",
    "models.stage.stage:build_stage": "build",
    "solvers.march.central_difference:CentralDifference.advance": MARCH,
    "solvers.march.recorder:Recorder.__init__": "writing",
    "solvers.march.recorder:Recorder.write": "writing",
    "solvers.march.recorder:Recorder.close": "writing",
    "solvers.march.checkpoint:write_checkpoint": "writing",
    "postprocess.fields.result:open_result": "opening",
    "postprocess.plotting.style:save_figure": "figures",
    "postprocess.shaft.orbits:plot_orbit": "figures",
    "postprocess.energy.strain:plot_energy": "figures",
    "postprocess.shaft.orbits:shaft_orbit": "data of figures",
    "postprocess.energy.strain:strain_energies": "data of figures",
    "postprocess.run.summary:summarise": "summary",
    "studies.runs.prepare:prepare_stage": "packing and loading the kernel",
    "studies.runs.recorded_march:march_to_file": "writing",
}
"""Part of each function; those that others import come first."""


class Clock:
    """Processor time by part; nested parts are counted once."""

    def __init__(self) -> None:
        self.spent: Counter[str] = Counter()
        self._stack = [REST]
        self._since = 0.0  #: processor time [s]

    @contextmanager
    def charged(self, part: str) -> Iterator[None]:
        """Charge a part with the time until the end of the block."""
        self._settle()
        self._stack.append(part)
        try:
            yield
        finally:
            self._settle()
            self._stack.pop()

    def _settle(self) -> None:
        now = time.process_time()
        self.spent[self._stack[-1]] += now - self._since
        self._since = now

    def watch(self, function: str, part: str) -> None:
        """Charge a part with the calls of a function, "module:Class.name"."""
        module, _, path = function.partition(":")
        owner: Any = import_module(f"bladewhirl.{module}")
        *classes, name = path.split(".")
        for inner in classes:
            owner = getattr(owner, inner)
        setattr(owner, name, self.charging(part, getattr(owner, name)))

    def charging(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the function, whose calls are charged to a part."""

        @functools.wraps(function)
        def charging(*args: Any, **kwargs: Any) -> Any:
            with self.charged(part):
                return function(*args, **kwargs)

        return charging


def probe(arguments: list[str], answer: Path) -> None:
    """Run the command line in this process and leave the time of its parts."""
    clock = Clock()
    load: Callable[..., Any] = _bootstrap._find_and_load  # what an import statement calls
    _bootstrap._find_and_load = clock.charging(IMPORTS, load)
    for function, part in PARTS.items():
        clock.watch(function, part)
    from bladewhirl.studies.commands.cli import main

    try:
        sys.argv = ["bladewhirl", *arguments]
        with clock.charged(REST):
            main()
    except SystemExit as end:
        if end.code:
            raise
    parts = dict(clock.spent) | {WHOLE: clock.spent.total()}
    answer.write_text(json.dumps(parts), encoding="utf-8")


def parts_of_run(duration: float) -> dict[str, float]:
    """Return the processor time of each part of a run of some length [s] in its own process [s]."""
    with tempfile.TemporaryDirectory() as scratch:
        answer = Path(scratch) / "parts.json"
        arguments = [
            str(CASE), "-o", f"{scratch}/run", "--frames", "0",
            "--set", f"march.duration={duration}",
        ]  # fmt: skip
        subprocess.run(
            [sys.executable, __file__, "--probe", str(answer), "run", *arguments],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            check=True,
        )
        parts: dict[str, float] = json.loads(answer.read_text(encoding="utf-8"))
        return parts


def main() -> None:
    """Run in turn and print the best of each part."""
    if sys.argv[1:2] == ["--probe"]:
        probe(sys.argv[3:], Path(sys.argv[2]))
        return
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--repeat", type=int, default=3, help="turns")
    parser.add_argument("--durations", type=float, nargs="+", default=DURATIONS, help="[s]")
    given = parser.parse_args()
    parts_of_run(min(given.durations))
    turns = [
        {duration: parts_of_run(duration) for duration in given.durations}
        for _ in range(given.repeat)
    ]
    table = Table("processor time [s]", title=f"bladewhirl run {CASE.name}, best of {given.repeat}")
    best = {}
    for duration in given.durations:
        table.add_column(f"{duration:g} s", justify="right")
        best[duration] = {
            part: min(turn[duration].get(part, 0.0) for turn in turns)
            for part in (IMPORTS, *dict.fromkeys(PARTS.values()), REST, WHOLE)
        }
    for part in best[given.durations[0]]:
        table.add_row(part, *(f"{parts[part]:.2f}" for parts in best.values()))
    ratios = (parts[WHOLE] / parts[MARCH] for parts in best.values())
    table.add_row("whole run / march", *(f"{ratio:.2f}" for ratio in ratios))
    Console().print(table)


if __name__ == "__main__":
    main()

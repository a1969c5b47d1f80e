"""Time of the parts of a whole run: `python benchmarks/whole_run.py [--against DIR]`.

Runs `bladewhirl run examples/imbalance.toml` for 3 s and for 0.02 s of marched time without a
ParaView series, each in a process of its own, and adds up the processor time of each part, all
threads'; a part that calls another is not charged for it. With `--against DIR` another version
takes turns with this one: DIR is a folder that holds its package, as
`pip install --no-deps --target DIR` makes. Parts that it keeps elsewhere count as the rest.
The best of some turns counts, since what else the machine does only ever adds.
"""

from __future__ import annotations

import argparse
import functools
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import _bootstrap
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

CASE = Path(__file__).resolve().parent.parent / "examples" / "imbalance.toml"
DURATIONS = (3.0, 0.02)  # s

IMPORTS, REST, WHOLE = "imports", "rest", "whole run"
LOADING, MARCH = "packing and loading the kernel", "march"

PARTS = {
    "case": ["models.case.file:read_case"],
    "build": ["models.stage.stage:build_stage"],
    LOADING: ["studies.runs.prepare:prepare_stage"],
    MARCH: ["solvers.march.central_difference:CentralDifference.advance"],
    "writing": [
        "studies.runs.recorded_march:march_to_file",
        *(f"solvers.march.recorder:Recorder.{name}" for name in ("__init__", "write", "close")),
        "solvers.march.checkpoint:write_checkpoint",
    ],
    "figures": [
        "postprocess.plotting.style:save_figure",
        "postprocess.shaft.orbits:plot_orbit",
        "postprocess.energy.strain:plot_energy",
    ],
    "data of figures": [
        "postprocess.shaft.orbits:shaft_orbit",
        "postprocess.energy.strain:strain_energies",
    ],
    "series for ParaView": ["postprocess.paraview.series:write_series"],
    "summary": ["postprocess.run.summary:summarise"],
    "opening": ["postprocess.fields.result:open_result"],
}
"""Functions of each part, by module; imports are told apart by themselves."""


class Clock:
    """Processor time by part over all threads; nested parts are counted once."""

    def __init__(self) -> None:
        self.spent: Counter[str] = Counter()
        self._running = threading.local()

    @contextmanager
    def charged(self, part: str) -> Iterator[None]:
        """Charge a part with the time of this thread."""
        stack: list[str] = self._running.__dict__.setdefault("stack", [])
        if part == MARCH and stack and stack[-1] == LOADING:
            part = LOADING  # no step yet
        self._settle(stack)
        stack.append(part)
        try:
            yield
        finally:
            self._settle(stack)
            stack.pop()

    def _settle(self, stack: list[str]) -> None:
        now = time.thread_time()
        if stack:
            self.spent[stack[-1]] += now - self._running.since
        self._running.since = now

    def watch(self) -> None:
        """Charge imports from now on, and the functions of `PARTS` as their modules are loaded."""
        load: Callable[..., Any] = _bootstrap._find_and_load  # what an import statement calls
        places: dict[str, list[tuple[str, str]]] = {}
        for part, functions in PARTS.items():
            for function in functions:
                module, _, path = f"bladewhirl.{function}".partition(":")
                places.setdefault(module, []).append((path, part))

        def loading(name: str, *rest: Any) -> Any:
            with self.charged(IMPORTS):
                module = load(name, *rest)
            for path, part in places.pop(name, []):
                owner, _, attribute = path.rpartition(".")
                holder = getattr(module, owner) if owner else module
                setattr(holder, attribute, self._charging(part, getattr(holder, attribute)))
            return module

        _bootstrap._find_and_load = loading

    def _charging(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(function)
        def charging(*args: Any, **kwargs: Any) -> Any:
            with self.charged(part):
                return function(*args, **kwargs)

        return charging


def probe(arguments: list[str], answer: Path) -> None:
    """Run the command line in this process and leave the time of its parts, all threads'."""
    clock = Clock()
    clock.watch()
    from bladewhirl.studies.commands.cli import main

    try:
        sys.argv = ["bladewhirl", *arguments]
        main()
    except SystemExit as end:
        if end.code:
            raise
    whole = time.process_time()
    parts = dict(clock.spent) | {REST: whole - clock.spent.total(), WHOLE: whole}
    answer.write_text(json.dumps(parts), encoding="utf-8")


def parts_of_run(duration: float, frames: int, version: Path | None) -> dict[str, float]:
    """Return the processor time of each part of a run in a separate process [s].

    Args:
        duration: of the march [s].
        frames: of the ParaView series.
        version: folder that holds the package; None for the one that is installed.
    """
    with tempfile.TemporaryDirectory() as scratch:
        answer = Path(scratch) / "parts.json"
        arguments = [
            str(CASE), "-o", f"{scratch}/run", "--frames", str(frames),
            "--set", f"march.duration={duration}",
        ]  # fmt: skip
        subprocess.run(
            [sys.executable, __file__, "--probe", str(answer), "run", *arguments],
            env=os.environ | ({} if version is None else {"PYTHONPATH": str(version)}),
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
    parser.add_argument("--against", type=Path, help="folder with the package of another version")
    parser.add_argument("--repeat", type=int, default=3, help="turns")
    parser.add_argument("--durations", type=float, nargs="+", default=DURATIONS, help="[s]")
    parser.add_argument("--frames", type=int, default=0, help="of the ParaView series")
    given = parser.parse_args()
    versions = {"this": None} | ({"other": given.against.resolve()} if given.against else {})
    found: dict[tuple[float, str], list[dict[str, float]]] = {}
    for version in versions.values():
        parts_of_run(min(given.durations), given.frames, version)
    for _ in range(given.repeat):
        for duration in given.durations:
            for name, version in versions.items():
                taken = parts_of_run(duration, given.frames, version)
                found.setdefault((duration, name), []).append(taken)
    best = {
        column: {part: min(turn.get(part, 0.0) for turn in turns) for part in turns[0]}
        for column, turns in found.items()
    }
    table = Table("processor time [s]", title=f"bladewhirl run {CASE.name}, best of {given.repeat}")
    for duration, name in best:
        table.add_column(f"{duration:g} s, {name}", justify="right")
    for part in (IMPORTS, *PARTS, REST, WHOLE):
        table.add_row(part, *(f"{parts.get(part, 0.0):.2f}" for parts in best.values()))
    ratios = (parts[WHOLE] / parts[MARCH] for parts in best.values())
    table.add_row("whole run / march", *(f"{ratio:.2f}" for ratio in ratios))
    Console().print(table)


if __name__ == "__main__":
    main()

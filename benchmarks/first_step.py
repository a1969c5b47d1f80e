"""Time from the command to the first step: `python benchmarks/first_step.py`.

Runs `bladewhirl run` on a case in a process of its own, first with an empty cache of compiled code
(cold), then again (warm). The first step follows within a few hundredths of a second on the making
of result.nc, which is waited for. Processor time is that of the whole run, figures included; it
suffers less than the clock from what else the machine does.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
COMMAND = [sys.executable, "-c", "from bladewhirl.studies.commands.cli import main; main()", "run"]
DURATION = 0.001  # s
POLL = 0.002  # s


@dataclass(frozen=True, kw_only=True)
class Timing:
    """Seconds of one run."""

    first_step: float
    whole: float
    processor: float


def timing(case: Path, cache: Path, output: Path) -> Timing:
    """Run a case.

    Raises:
        RuntimeError: the run failed.
    """
    before = os.times()
    begin = time.perf_counter()
    short = ["--frames", "0", "--set", f"march.duration={DURATION}"]
    with subprocess.Popen(
        [*COMMAND, str(case), "-o", str(output), *short],
        env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
        stdout=subprocess.DEVNULL,
    ) as running:
        while not (output / "result.nc").exists() and running.poll() is None:
            time.sleep(POLL)
        first_step = time.perf_counter() - begin
    if running.returncode != 0:
        raise RuntimeError(f"{case}: the run ended with exit code {running.returncode}")
    whole, after = time.perf_counter() - begin, os.times()
    spent = after.children_user + after.children_system
    spent -= before.children_user + before.children_system
    return Timing(first_step=first_step, whole=whole, processor=spent)


def main() -> None:
    """Time cold and warm runs in turn; print the best, which other processes disturb least."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--repeat", type=int, default=3, help="how often both are timed")
    parser.add_argument("--case", type=Path, default=EXAMPLES / "casing_distortion.toml")
    arguments = parser.parse_args()
    times: dict[str, list[tuple[float, ...]]] = {"cold": [], "warm": []}
    for _ in range(arguments.repeat):
        with tempfile.TemporaryDirectory() as folder:
            for cache, rows in times.items():
                run = timing(arguments.case, Path(folder, "cache"), Path(folder, cache))
                rows.append(astuple(run))
    table = Table(title=f"From the command to the first step, best of {arguments.repeat}")
    for column in ("cache", "first step [s]", "whole run [s]", "processor, whole run [s]"):
        table.add_column(column, justify="left" if column == "cache" else "right")
    for cache, rows in times.items():
        table.add_row(cache, *(f"{best:.2f}" for best in np.min(rows, axis=0)))
    Console(width=100).print(table)


if __name__ == "__main__":
    main()

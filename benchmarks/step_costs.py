"""Cost of a step over the size of the stage: `python benchmarks/step_costs.py`.

The imbalance case before contact sets in, with more blades, casing elements or modes than the
paper's stage, tuned (marched harmonic by harmonic) and with mistuned blades (the bladed disk
dense, the casing still harmonic by harmonic). Each row takes turns with the paper's stage, and
what counts are its ratios; the best turn counts, in processor time.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

from bladewhirl.models.case.file import read_case
from bladewhirl.studies.runs.prepare import Prepared, prepare

CASE = Path(__file__).resolve().parent.parent / "examples" / "imbalance.toml"
MISTUNED = "bladed_disk.mistuning.stiffness_spread=0.02"
STEPS = 5000

SIZES = (
    (22, 40, 110), (11, 40, 55), (50, 100, 110), (100, 200, 110), (300, 320, 110),
    (22, 160, 110), (22, 320, 110), (22, 40, 22), (22, 40, 220), (100, 40, 340),
)  # fmt: skip
"""Blades, casing elements and fixed-interface modes; the first row is the paper's stage."""


def prepared(size: tuple[int, int, int], *overrides: str) -> Prepared:
    """A march of a stage of that size."""
    blades, elements, modes = size
    keys = (
        f"bladed_disk.blades={blades}",
        f"casing.elements={elements}",
        f"reduction.fixed_interface_modes={modes}",
        "march.time_step=1e-7",
        "march.record_step=1e-5",
        "march.duration=0.001",
    )
    return prepare(read_case(CASE, [*keys, *overrides]))


def microseconds(march: Prepared) -> float:
    """Processor time of a step."""
    begin = march.scheme.init()
    before = time.thread_time()
    march.scheme.advance(begin, STEPS)
    return (time.thread_time() - before) / STEPS * 1e6


def main() -> None:
    """Measure in turn and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--repeat", type=int, default=10, help="turns of each row")
    parser.add_argument("--rows", type=int, default=len(SIZES), help="the first so many")
    given = parser.parse_args()
    table = Table(title=f"A step without contact, best of {given.repeat}")
    for column in (
        "blades", "casing elements", "modes", "tuned [µs]", "of the paper's", "mistuned / tuned",
    ):  # fmt: skip
        table.add_column(column, justify="right")
    papers = prepared(SIZES[0])
    for size in SIZES[: given.rows]:
        marches = (papers, prepared(size), prepared(size, MISTUNED))
        turns = [[microseconds(march) for march in marches] for _ in range(given.repeat)]
        paper, tuned, mistuned = (min(times) for times in zip(*turns, strict=True))
        modes = len(marches[1].problem.rotor.frequency) + len(marches[1].problem.casing.frequency)
        table.add_row(
            *map(str, (*size[:2], modes)), f"{tuned:.2f}", f"{tuned / paper:.2f}",
            f"{mistuned / tuned:.2f}",
        )  # fmt: skip
    Console(width=100).print(table)


if __name__ == "__main__":
    main()

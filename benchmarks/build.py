"""How long stages take to build: `python benchmarks/build.py`.

Building is all from a case to a stage: drawing, assembly, reduction and modes of both bodies. The
paper's stage is to take less than a second, one of 100 blades with 50 elements each less than ten.
The best of some tries counts: the first one pays for what the libraries load.
"""

from __future__ import annotations

import time

from rich.console import Console
from rich.table import Table

from bladewhirl.models.case.file import case_from
from bladewhirl.models.elements.build import case_beam_model, case_bladed_disk
from bladewhirl.models.stage.stage import build_stage

TRIES = 3

STAGES = {
    "the paper's stage": ({}, 1.0),
    "100 blades, 50 elements each": (
        {
            "bladed_disk": {"blades": 100, "elements_per_blade": 50},
            "reduction": {"fixed_interface_modes": 500},
        },
        10.0,
    ),
}
"""Tables of each case, and how long its stage may take [s]."""


def main() -> None:
    """Time the stages and print a table; exit with 1 where one takes too long."""
    table = Table("stage", "symmetry", "draw [s]", "assemble [s]", "build [s]", "limit [s]")
    slow = False
    for name, (tables, limit) in STAGES.items():
        case = case_from(tables)
        best = [float("inf")] * 3
        for _ in range(TRIES):
            marks = [time.perf_counter()]
            case_beam_model(case)
            marks.append(time.perf_counter())
            case_bladed_disk(case, clamped=False)
            marks.append(time.perf_counter())
            stage = build_stage(case)
            marks.append(time.perf_counter())
            taken = [marks[i + 1] - marks[i] for i in range(3)]
            best = [min(pair) for pair in zip(best, taken, strict=True)]
        slow |= best[2] > limit
        found = stage.symmetry["bladed_disk"]
        table.add_row(name, found, *(f"{value:.3f}" for value in best), f"{limit:g}")
    Console().print(table)
    raise SystemExit(slow)


if __name__ == "__main__":
    main()

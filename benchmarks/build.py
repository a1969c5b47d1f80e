"""Time to build stages: `python benchmarks/build.py [--against DIR]`.

Building is all from a case to a stage: drawing, assembly, reduction and modes of both bodies;
beside it stand all modes of the full bodies. With `--against DIR` another version takes turns with
this one, each in a process of its own: DIR is a folder that holds its package, as
`pip install --no-deps --target DIR` makes. Printed is processor time, of the best of some tries,
since the first one pays for what the libraries load. The error of the bladed disk's frequencies,
three a nodal diameter, is relative to Rayleigh quotients in extended precision, of vectors of all
of a block's eigenproblem.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import scipy.linalg as la
from rich.console import Console
from rich.table import Table

FEW = 3
"""Frequencies a nodal diameter."""

STAGES = {
    "the paper's stage": {},
    "100 blades, 50 elements each": {
        "bladed_disk": {"blades": 100, "elements_per_blade": 50},
        "reduction": {"fixed_interface_modes": 500},
    },
    "300 blades, 10 elements each": {
        "bladed_disk": {"blades": 300, "elements_per_blade": 10},
        "reduction": {"fixed_interface_modes": 500},
    },
}
"""Tables of each case."""


def probe(name: str, tries: int) -> dict[str, float]:
    """Processor time of the parts of a stage [s], and the error of its frequencies."""
    from bladewhirl.models.case.file import case_from
    from bladewhirl.models.elements.build import case_bladed_disk
    from bladewhirl.models.modal.frequencies import lowest_frequencies
    from bladewhirl.models.modal.full_stage import modal_stage
    from bladewhirl.models.stage.stage import build_stage

    case = case_from(STAGES[name])

    def best(work: Callable[[], object]) -> float:
        taken = []
        for _ in range(tries):
            before = time.process_time()
            work()
            taken.append(time.process_time() - before)
        return min(taken)

    times = {"build": best(lambda: build_stage(case)), "modes": best(lambda: modal_stage(case))}
    structure = case_bladed_disk(case, clamped=False).structure
    assert structure.layout is not None
    frequencies, errors = lowest_frequencies(structure, FEW), []
    for k, (mass, stiffness) in structure.layout.blocks(structure.mass, structure.stiffness):
        vectors = la.eigh(stiffness, mass)[1][:, :FEW].astype(np.clongdouble)
        strain, inertia = (
            np.sum(vectors.conj() * (matrix.astype(np.clongdouble) @ vectors), axis=0).real
            for matrix in (stiffness, mass)
        )
        errors.append(np.abs(frequencies[k] / np.sort(np.sqrt(strain / inertia)) - 1).max())
    return times | {"error": float(max(errors))}


def main() -> None:
    """Time the stages, one version after the other, and print a table."""
    if sys.argv[1:2] == ["--probe"]:
        print(json.dumps(probe(sys.argv[2], int(sys.argv[3]))))
        return
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--against", type=Path, help="folder with the package of another version")
    parser.add_argument("--repeat", type=int, default=3, help="tries")
    given = parser.parse_args()
    versions: dict[str, dict[str, str]] = {"this": {}}
    if given.against:
        versions["other"] = {"PYTHONPATH": str(given.against.resolve())}
    one_thread = {"OPENBLAS_NUM_THREADS": "1"}
    columns = ("stage", "version", "build [s]", "all modes [s]", "error of frequencies")
    table = Table(*columns, title="processor time")
    for name in STAGES:
        for version, where in versions.items():
            answer = subprocess.run(
                [sys.executable, __file__, "--probe", name, str(given.repeat)],
                env=os.environ | one_thread | where,
                stdout=subprocess.PIPE,
                check=True,
            )
            result = json.loads(answer.stdout)
            table.add_row(
                name, version, f"{result['build']:.2f}", f"{result['modes']:.2f}",
                f"{result['error']:.0e}",
            )  # fmt: skip
    Console(width=100).print(table)


if __name__ == "__main__":
    main()

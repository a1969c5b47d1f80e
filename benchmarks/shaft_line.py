"""Processor time of a step of a shaft line: `python benchmarks/shaft_line.py`.

A fan of solids on a line with unequal bearings is compared with the fan alone on a spring, with the
same number of modes, in timings that alternate; and lines without wheels have more and more nodes,
with the time until they are ready to march. No blade touches the wall.
"""

import argparse
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

import bladewhirl as bw
from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.solvers.march.central_difference import CentralDifference

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "support"))
from solid_meshes import fan_sector, whole

BLADES, STEPS, STEP = 5, 20000, 1e-6
STEEL: dict[str, Any] = {"young_modulus": 2.1e11, "poisson_ratio": 0.3, "density": 7800.0}
MARCH = {"speed": "600 rad/s", "time_step": STEP, "duration": 1.0, "displacement_limit": 1.0}
BEARINGS = [
    {"position": 0.0, "stiffness": [[2e7, 3e6], [-1e6, 1e7]], "damping": 2e3},
    {"position": 0.2, "stiffness": 1e7, "damping": 1e3},
    {"position": 0.4, "stiffness": 1e7, "damping": 1e3},
]


class Timed(NamedTuple):
    """A march that is timed."""

    scheme: CentralDifference
    modes: int
    built: float  #: processor time until it is ready [s]

    def step(self) -> float:
        """Return the processor time of a step [us]."""
        start, state = time.process_time(), self.scheme.init()
        self.scheme.advance(state, STEPS)
        return 1e6 * (time.process_time() - start) / STEPS


def timed(case: Case) -> Timed:
    """Return the march of a case."""
    start = time.process_time()
    problem = contact_problem(build_stage(case))
    built = time.process_time() - start
    return Timed(CentralDifference(problem, STEP, STEPS), len(problem.rotor.frequency), built)


def line(elements: int) -> dict[str, Any]:
    """Return the table of a line of equal elements."""
    shaft = {"length": 0.6, "outer_diameter": 0.04, "elements": elements}
    return {"segments": [shaft], "bearings": BEARINGS}


def fan(file: Path, modes: int, **tables: Any) -> Case:
    """Return the case of a fan in some modes."""
    return case_from(
        {
            "bladed_disk": {"superelement": {"file": str(file), "copies": BLADES}},
            "casing": {"type": "rigid", "clearance": 0.05},
            "reduction": {"free_interface_modes": modes},
            "march": MARCH,
        }
        | tables
    )


def main() -> None:
    """Print the times of steps."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--repeat", type=int, default=20, help="number of timings of each march")
    repeat = parser.parse_args().repeat
    console = Console()
    table = Table("modes", "fan on the line", "fan alone", "difference", title="Step [us]")
    with TemporaryDirectory() as folder:
        file = Path(folder) / "fan.npz"
        mesh = whole(fan_sector(BLADES), BLADES)
        bw.write_superelement(file, bw.mesh3d(mesh, **STEEL, stress=False, hub="root"))
        for modes in (20, 40, 80):
            both = line(3) | {"wheel": {"position": 0.6}}
            on_line = timed(fan(file, modes, shaft_line=both))
            own = {"shaft": {"stiffness": 2e7}, "rotation": {"effects": "full"}}
            alone = timed(fan(file, on_line.modes, **own))
            times = np.array([(on_line.step(), alone.step()) for _ in range(repeat)])
            middle = np.median(np.column_stack([times, times[:, 0] - times[:, 1]]), axis=0)
            table.add_row(str(on_line.modes), *(f"{value:.2f}" for value in middle))
    console.print(table)
    table = Table("nodes", "modes", "step [us]", "ready after [s]", title="Lines without wheels")
    for elements in (6, 100, 300):
        march = timed(case_from({"shaft_line": line(elements), "march": MARCH}))
        step = float(np.median([march.step() for _ in range(repeat)]))
        table.add_row(str(elements + 1), str(march.modes), f"{step:.2f}", f"{march.built:.2f}")
    console.print(table)


if __name__ == "__main__":
    main()

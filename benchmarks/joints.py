"""Computing time of a response with friction joints: `python benchmarks/joints.py`.

The tuned wheel of 24 blades of examples/shrouded_blade.toml has one joint node and 30 modes a
blade. Its periodic motions at 100 speeds around the resonance of sliding joints and above take the
reduction of the blade, the search for the motions, and their multipliers, on one core: once with a
preload at which the joints hardly open, and once with one at which they lift off.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bladewhirl as bw
from bladewhirl.studies.joints import dataset, motions

CASE = Path(__file__).resolve().parent.parent / "examples" / "shrouded_blade.toml"
MODES, FIRST, LAST = 30, 2400.0, 7200.0  #: modes of a blade, and speeds [rpm]
PRELOADS = "100 N", "30 N"


def timed(module: Any, name: str, spent: dict[str, float]) -> None:
    """Add the processor time of a function of a module to a number of that name."""
    function: Callable[..., Any] = getattr(module, name)
    spent[name] = 0.0

    def measured(*arguments: Any, **options: Any) -> Any:
        started = time.process_time()
        try:
            return function(*arguments, **options)
        finally:
            spent[name] += time.process_time() - started

    setattr(module, name, measured)


def main() -> None:
    """Print the processor time of each part."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--points", type=int, default=100, help="number of speeds")
    points = parser.parse_args().points
    step = (LAST - FIRST) / max(points - 1, 1)
    speeds = [f"{FIRST + n * step} rpm" for n in range(points)]
    bw.periodic(bw.read_case(CASE))  # loads libraries
    spent = dict[str, float]()
    timed(motions, "joint_motion", spent)
    timed(dataset, "largest_multiplier", spent)
    print(f"preload  reduction [s]  motions [s]  multipliers [s]  for {points} speeds")
    for preload in PRELOADS:
        values = {"reduction.free_interface_modes": MODES, "joint.shroud.preload": preload}
        case = bw.with_values(bw.read_case(CASE), values)
        spent.update(dict.fromkeys(spent, 0.0))
        started = time.process_time()
        bw.periodic(case, speeds=speeds)
        found, stable = spent.values()
        rest = time.process_time() - started - found - stable
        print(f"{preload:7}  {rest:13.1f}  {found:11.1f}  {stable:15.1f}")


if __name__ == "__main__":
    main()

"""Did a change of the code change what is computed? Not a test: a command for whoever refactors.

    python tests/support/same_results.py make FOLDER            # with one state of the code
    python tests/support/same_results.py make OTHER_FOLDER      # with the other
    python tests/support/same_results.py compare FOLDER OTHER_FOLDER

``make`` runs seven cases for 0.2 s each and a small sweep by the command line alone, draws every
figure of one run, and keeps result files and the data behind the figures. ``compare`` names every
variable and coordinate that is not equal to the last bit, or that one side lacks. Attributes are
left aside. A ``make`` takes some two minutes.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import xarray as xr

ROOT = Path(__file__).parents[2]
SKETCH = ROOT / "tests" / "data" / "sketch_stage.toml"
CASES = [
    *(
        ROOT / "examples" / f"{name}.toml"
        for name in (
            "casing_distortion",
            "imbalance",
            "coupled_modes",
            "shrouded_fan",
            "mistuned_blades",
            "unequal_bearings",
        )
    ),
    SKETCH,
]
DRAWN = "imbalance"
SWEPT = ["--over", "march.speed=1.0:1.1:0.05", "--set", "march.duration=0.2"]


def bladewhirl(*words: object) -> None:
    """Run a command of the program that goes with this interpreter."""
    program = Path(sys.executable).parent / "bladewhirl"
    subprocess.run([program, *map(str, words)], check=True, stdout=subprocess.DEVNULL)


def make(folder: Path) -> None:
    """Run all cases into a folder."""
    for case in CASES:
        run = folder / case.stem
        bladewhirl("run", case, "-o", run, "--set", "march.duration=0.2", "--frames", 3)
    bladewhirl("plot", folder / DRAWN, "all")
    bladewhirl("sweep", ROOT / "examples" / "imbalance.toml", *SWEPT, "-o", folder / "sweep")
    bladewhirl("plot", folder / "sweep", "all")


def differences(first: Path, second: Path) -> list[str]:
    """What two files of data don't have in common."""
    found = []
    with (
        xr.open_dataset(first, decode_times=False) as one,
        xr.open_dataset(second, decode_times=False) as other,
    ):
        for name in sorted({*one.variables, *other.variables}, key=str):
            if name not in one.variables or name not in other.variables:
                found.append(f"{name}: only in {(first, second)[name in other.variables]}")
                continue
            a, b = one[name].values, other[name].values
            same_kind = a.dtype == b.dtype and a.shape == b.shape
            if not same_kind:
                found.append(f"{name}: {a.dtype}{a.shape} and {b.dtype}{b.shape}")
            elif a.dtype.kind in "fc" and not np.array_equal(a, b, equal_nan=True):
                worst = np.nanmax(np.abs(a - b)) / max(np.nanmax(np.abs(a)), 1e-300)
                found.append(f"{name}: differs by {worst:.3g} of its largest value")
            elif a.dtype.kind not in "fc" and not (a == b).all():
                found.append(f"{name}: differs")
    return found


def compare(first: Path, second: Path) -> int:
    """Print what differs between two folders; returns the number of differences."""
    count = 0
    files = {p.relative_to(f) for f in (first, second) for p in f.rglob("*.nc")}
    for name in sorted(files):
        if not (first / name).exists() or not (second / name).exists():
            found = [f"only in {first if (first / name).exists() else second}"]
        else:
            found = differences(first / name, second / name)
        count += len(found)
        for line in found:
            print(f"{name}: {line}")
    print(f"{len(files)} files, {count} differences")
    return count


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["make", folder]:
            make(Path(folder))
        case ["compare", first, second]:
            sys.exit(compare(Path(first), Path(second)) > 0)
        case _:
            sys.exit(__doc__)

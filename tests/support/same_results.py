"""Compare the results of two states of the code to the last bit.

    python tests/support/same_results.py make FOLDER            # with one state of the code
    python tests/support/same_results.py make OTHER_FOLDER      # with the other
    python tests/support/same_results.py compare FOLDER OTHER_FOLDER

``make`` uses the command line alone: seven runs of 0.2 s, a small sweep, the modal studies,
ParaView series, a report, and the figures of one run and of the sweep. ``compare`` names each
variable, JSON value and file of cells that differs or that one side lacks: NetCDF and JSON by
value, CSV, VTK series and the data of HTML pages by their bytes. Attributes, software versions and
texts of the JSON documents are not compared. ``make`` takes three minutes on one core.
"""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from places import DATA, EXAMPLES

IMBALANCE = EXAMPLES / "imbalance.toml"
NAMES = "casing_distortion imbalance coupled_modes shrouded_fan mistuned_blades unequal_bearings"
CASES = [*(EXAMPLES / f"{name}.toml" for name in NAMES.split()), DATA / "sketch_stage.toml"]
SPINNING = "rotation.effects=full"
SWEPT = ["--over", "march.speed=1.0:1.1:0.05", "--set", "march.duration=0.2"]
PAGE_DATA = re.compile(r"<script[^>]*type=.application/json.[^>]*>(.*?)</script>", re.S)


def bladewhirl(*words: object) -> str:
    """Run a command of the program that goes with this interpreter; return its output."""
    program = Path(sys.executable).parent / "bladewhirl"
    done = subprocess.run([program, *map(str, words)], check=True, stdout=subprocess.PIPE)
    return done.stdout.decode()


def keep_json(file: Path, *words: object) -> None:
    """Write the JSON document that a command prints to a file."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(bladewhirl(*words, "--json"))


def make(folder: Path) -> None:
    """Run all commands into a folder."""
    documents = folder / "documents"
    for case in CASES:
        run = folder / case.stem
        keep_json(
            documents / f"run-{case.stem}.json",
            *("run", case, "-o", run, "--set", "march.duration=0.2", "--frames", 3),
        )
        keep_json(documents / f"show-{case.stem}.json", "show", case)
        keep_json(documents / f"modes-{case.stem}.json", "modes", case)
        keep_json(documents / f"spinning-{case.stem}.json", "show", case, "--set", SPINNING)
        bladewhirl("mesh", case, "-o", folder / f"{case.stem}.vtu")
    for effects in ([], ["--set", SPINNING]):
        name = "spinning" if effects else "static"
        keep_json(
            documents / f"campbell-{name}.json",
            *("campbell", IMBALANCE, "-o", folder / f"campbell-{name}"),
            *("--html", folder / f"campbell-{name}.html", *effects),
        )
        keep_json(
            documents / f"stability-{name}.json",
            *("stability", IMBALANCE, "-o", folder / f"stability-{name}", "--no-films"),
            *("--speeds", "0.6:3:0.06", "--kappas", "0:1000:50", *effects),
        )
    keep_json(documents / "veering.json", "veering", IMBALANCE, "-o", folder / "veering")
    run = folder / IMBALANCE.stem
    bladewhirl("plot", run, "all")
    bladewhirl("report", run)
    bladewhirl("export", run, "--surface", "--frames", 2, "-o", folder / "surface")
    bladewhirl("sweep", IMBALANCE, *SWEPT, "-o", folder / "sweep")
    bladewhirl("plot", folder / "sweep", "all")
    bladewhirl("report", folder / "sweep")


def flattened(document: Any, place: str = "") -> dict[str, Any]:
    """Return numbers and truth values of a JSON document by their path; of texts the presence."""
    if not isinstance(document, dict | list):
        return {place: type(document).__name__ if isinstance(document, str) else repr(document)}
    items = document.items() if isinstance(document, dict) else enumerate(document)
    return {
        path: value
        for key, item in items
        if "version" not in str(key)
        for path, value in flattened(item, f"{place}.{key}").items()
    }


def contents(file: Path) -> dict[str, Any]:
    """Return what is compared of a file, by name."""
    if file.suffix == ".nc":
        with xr.open_dataset(file, decode_times=False) as data:
            return {str(name): values.values for name, values in data.variables.items()}
    if file.suffix == ".json":
        return flattened(json.loads(file.read_text()))
    if file.suffix == ".html":
        return {"data of the page": PAGE_DATA.findall(file.read_text())}
    return {"bytes": file.read_bytes()} if file.suffix in {".csv", ".vtu"} else {}


def difference(one: Any, other: Any) -> str:
    """Return in words how two values differ; nothing if they are equal to the last bit."""
    if not isinstance(one, np.ndarray) or not isinstance(other, np.ndarray):
        known = isinstance(one, str) and isinstance(other, str)
        return "" if one == other else f"{one} and {other}" if known else "differs"
    if one.dtype != other.dtype or one.shape != other.shape:
        return f"{one.dtype}{one.shape} and {other.dtype}{other.shape}"
    if one.dtype.kind not in "fc":
        return "" if (one == other).all() else "differs"
    if np.array_equal(one, other, equal_nan=True):
        return ""
    worst = np.nanmax(np.abs(one - other)) / max(np.nanmax(np.abs(one)), 1e-300)
    return f"differs by {worst:.3g} of its largest value"


def compare(*tops: Path) -> int:
    """Print the differences between two folders; return their number."""
    count = 0
    files = {path.relative_to(top) for top in tops for path in top.rglob("*.*") if path.is_file()}
    for file in sorted(files):
        one, other = (contents(top / file) if (top / file).exists() else {} for top in tops)
        for name in sorted({*one, *other}):
            if name in one and name in other:
                words = difference(one[name], other[name])
            else:
                words = f"missing in {tops[name in one]}"
            if words:
                count += 1
                print(f"{file}: {name}: {words}")
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

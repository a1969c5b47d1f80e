"""Compare the results of two states of the code to the last bit.

    python tests/support/same_results.py make FOLDER            # with one state of the code
    python tests/support/same_results.py make OTHER_FOLDER      # with the other
    python tests/support/same_results.py compare FOLDER OTHER_FOLDER

``make`` uses the command line alone: seven runs of 0.2 s, both dense schemes, a small sweep, the
modal studies, the comparison of schemes, ParaView series, a report, and the figures of one run and
of the sweep. ``compare`` names each variable, JSON value and file of cells that differs or that one
side lacks: NetCDF and JSON by value, CSV, VTK series and the data of HTML pages by their bytes.
Attributes, software versions and texts of the JSON documents are not compared. ``make`` takes
three minutes on one core.
"""

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

ROOT = Path(__file__).parents[2]
IMBALANCE = ROOT / "examples" / "imbalance.toml"
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
    ROOT / "tests" / "data" / "sketch_stage.toml",
]
DENSE_SCHEMES = ("moreau-jean", "penalty")
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
    for scheme in DENSE_SCHEMES:
        settings = ["--set", f"march.scheme={scheme}", "--set", "march.duration=0.01"]
        bladewhirl("run", IMBALANCE, "-o", folder / scheme, "--frames", 0, *settings)
    keep_json(documents / "compare.json", "compare", IMBALANCE, "--set", "march.duration=0.005")
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
            *("--speeds", "0.6:3:40", "--kappas", "0:1000:20", *effects),
        )
    keep_json(documents / "veering.json", "veering", IMBALANCE, "-o", folder / "veering")
    run = folder / IMBALANCE.stem
    bladewhirl("plot", run, "all")
    bladewhirl("report", run)
    bladewhirl("export", run, "--surface", "--frames", 2, "-o", folder / "surface")
    bladewhirl("sweep", IMBALANCE, *SWEPT, "-o", folder / "sweep")
    bladewhirl("plot", folder / "sweep", "all")
    bladewhirl("report", folder / "sweep")


def dataset_differences(first: Path, second: Path) -> Iterator[str]:
    """Yield the variables in which two NetCDF files differ."""
    with (
        xr.open_dataset(first, decode_times=False) as one,
        xr.open_dataset(second, decode_times=False) as other,
    ):
        for name in sorted({*one.variables, *other.variables}, key=str):
            if name not in one.variables or name not in other.variables:
                yield f"{name}: only in {(first, second)[name in other.variables]}"
                continue
            a, b = one[name].values, other[name].values
            if a.dtype != b.dtype or a.shape != b.shape:
                yield f"{name}: {a.dtype}{a.shape} and {b.dtype}{b.shape}"
            elif a.dtype.kind in "fc" and not np.array_equal(a, b, equal_nan=True):
                worst = np.nanmax(np.abs(a - b)) / max(np.nanmax(np.abs(a)), 1e-300)
                yield f"{name}: differs by {worst:.3g} of its largest value"
            elif a.dtype.kind not in "fc" and not (a == b).all():
                yield f"{name}: differs"


def flattened(document: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the path and value of each key, number and truth value of a JSON document."""
    if isinstance(document, dict | list):
        items = document.items() if isinstance(document, dict) else enumerate(document)
        for key, value in items:
            yield from flattened(value, f"{place}.{key}")
    else:
        yield place, type(document).__name__ if isinstance(document, str) else document


def json_differences(first: Path, second: Path) -> Iterator[str]:
    """Yield the keys in which two JSON documents differ; texts are compared by presence only."""
    one, other = (dict(flattened(json.loads(f.read_text()))) for f in (first, second))
    for key in sorted({*one, *other}):
        if "version" not in key and repr(one.get(key)) != repr(other.get(key)):
            yield f"{key}: {one.get(key)} and {other.get(key)}"


def byte_differences(first: Path, second: Path) -> Iterator[str]:
    """Yield a line if the bytes of two files differ."""
    if first.read_bytes() != second.read_bytes():
        yield "differs"


def page_differences(first: Path, second: Path) -> Iterator[str]:
    """Yield a line if the JSON blocks of two pages differ."""
    one, other = (PAGE_DATA.findall(f.read_text()) for f in (first, second))
    if one != other:
        yield "its data differ"


COMPARISONS = {
    ".nc": dataset_differences,
    ".json": json_differences,
    ".csv": byte_differences,
    ".vtu": byte_differences,
    ".html": page_differences,
}


def compare(first: Path, second: Path) -> int:
    """Print the differences between two folders; return their number."""
    count = 0
    files = {
        Path(folder, name).relative_to(top)
        for top in (first, second)
        for folder, _, names in os.walk(top)
        for name in names
        if Path(name).suffix in COMPARISONS
    }
    for file in sorted(files):
        if missing := [top for top in (first, second) if not (top / file).exists()]:
            lines = [f"missing in {missing[0]}"]
        else:
            lines = list(COMPARISONS[file.suffix](first / file, second / file))
        count += len(lines)
        for line in lines:
            print(f"{file}: {line}")
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

"""The folder of a run: checks before writing, and content."""

import filecmp
import json
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from hashlib import sha256
from importlib import metadata
from pathlib import Path, PurePosixPath
from platform import platform
from typing import Any, NamedTuple

from bladewhirl.files import json_text, listed, read_object, write_atomically
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.sensors import Sensor
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.table import path_of, value_at
from bladewhirl.solvers.march.checkpoint import CHECKPOINT_NAME
from bladewhirl.solvers.march.schema import RESULT_NAME

CASE_NAME = "case.toml"
PROVENANCE_NAME = "provenance.json"
SUMMARY_NAME = "summary.json"
VTK_NAME = "vtk"
ORBIT_NAME, ENERGY_NAME = "orbit.png", "energy.png"
CONTACT_FIGURES = ("contact-nodes", "tips", "wear-tracks")
"""Names of figures that a run writes into its folder if its contact nodes are recorded."""
SENSORS_NAME = "sensors.nc"
WEAR_NAME = "wear.csv"  #: profile of the coating at the end
REPORT_NAME = "report.html"
HISTORIES_NAME = "histories"  #: name of the folder of full histories of a sweep
FAILURES_NAME = "failures.json"  #: file with the failed points of a sweep, and the reasons

PICTURES = {
    "gif": "animation.gif",
    "mp4": "animation.mp4",
    "png": "still.png",
    "sheet": "sheet.png",
    "html": "page.html",
}
"""Default names of picture files, by kind."""

PACKAGE = "bladewhirl"


def check_free(directory: Path, *, overwrite: bool) -> None:
    """Check that a run may be written into a folder.

    Raises:
        UserError: the path exists and is not an empty folder; with ``overwrite``, it is not a
            folder, or contains something other than a run.
    """
    if not directory.exists() or (directory.is_dir() and not any(directory.iterdir())):
        return
    if not overwrite:
        raise UserError(
            f"{directory}: already exists; --overwrite (in Python overwrite=True) replaces the run"
            " in it, -o names another folder"
        )
    if not directory.is_dir():
        raise UserError(f"{directory}: expected a folder to overwrite, found a file")
    if RESULT_NAME not in listed(directory) and PACKAGE not in read_provenance(directory):
        raise UserError(f"{directory}: expected an empty folder or the folder of a run")


def read_provenance(directory: Path) -> dict[str, Any]:
    """Return the provenance of a run or a sweep; an empty dictionary if it is unknown."""
    return read_object(directory / PROVENANCE_NAME)


def case_files(case: Case) -> dict[str, bytes]:
    """Return the contents of the files needed to run a case again, case.toml and the files of its
    bladed disk and wheels, by name of the file."""
    files = {each.copy: Path(each.file).read_bytes() for each in _sources(case)}
    return {CASE_NAME: portable_case(case).encode()} | files


def march_digest(case: Case) -> str:
    """Return the SHA-256 digest of all input of a march except its duration."""
    march = case.march.model_copy(update={"duration": 1.0, "revolutions": None})
    digest = sha256(version().encode())
    for name, content in case_files(case.model_copy(update={"march": march})).items():
        digest.update(name.encode() + content)
    return digest.hexdigest()


def portable_case(case: Case, folder: str = "") -> str:
    """Return the text of a case that refers to copies of its files instead of the originals;
    `folder` is the path from the folder of the text to the folder of the copies."""
    for source in _sources(case):
        copy = str(PurePosixPath(folder) / source.copy)
        case = _replaced(case, (*path_of(source.key), "file"), copy)
    return dumps_case(case)


def with_originals(case: Case, directory: Path) -> Case:
    """Return the case of a folder with the files of which the folder has copies, where both have
    the same contents: reductions are kept beside these files, not beside the copies."""
    known = read_provenance(directory)
    for source in _sources(case):
        with suppress(KeyError, TypeError, OSError, ValueError):  # unknown, gone, or no path
            original = known[source.name]["file"]
            if filecmp.cmp(original, source.file, shallow=False):
                case = _replaced(case, (*path_of(source.key), "file"), original)
    return case


class Source(NamedTuple):
    """A file from which a case takes its bladed disk or another wheel."""

    key: str  #: dotted key of its table
    name: str  #: name of the copy in the folder of a run, without suffix
    file: str  #: path

    @property
    def copy(self) -> str:
        """Name of the copy in the folder of a run."""
        return self.name + Path(self.file).suffix.lower()


def _sources(case: Case) -> list[Source]:
    names = {f"bladed_disk.{name}": name for name in ("mesh", "superelement")}
    names["blade_loss.damaged"] = "damaged"
    further = () if case.shaft_line is None else case.shaft_line.wheels
    for row in range(len(further)):  # the first wheel is that of [bladed_disk]
        names[f"shaft_line.wheels.{row}.superelement"] = f"wheel-{row + 2}"
    tables = ((key, name, value_at(case, path_of(key))) for key, name in names.items())
    return [Source(key, name, table.file) for key, name, table in tables if table is not None]


def _replaced(table: Any, path: Sequence[str | int], value: str) -> Any:
    """Return a copy of a table or of its rows with another value at a path, which is not checked:
    the file may not be there yet."""
    if not path:
        return value
    part, *rest = path
    if isinstance(table, tuple):
        return tuple(
            _replaced(each, rest, value) if row == part else each for row, each in enumerate(table)
        )
    return table.model_copy(update={part: _replaced(getattr(table, str(part)), rest, value)})


def read_failures(directory: Path, size: float = float("inf")) -> list[dict[str, Any]]:
    """Return the failed points of a sweep, each with "point", "reason" and swept values.

    Raises:
        UserError: the file is damaged, or contains points that the sweep does not have.
    """
    path = directory / FAILURES_NAME
    if not path.exists():
        return []
    try:
        rows = [dict(row) for row in json.loads(path.read_text(encoding="utf-8"))]
        if all(row["reason"] and 0 <= row["point"] < size for row in rows):
            return rows
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        pass
    raise UserError(
        f"{path}: expected the failed points of a sweep; without this file --resume tries them"
        " again"
    )


def write_provenance(directory: Path, case: Case) -> None:
    """Write the provenance of the run: versions, date, computer, and the copied files."""
    provenance: dict[str, Any] = {
        PACKAGE: version(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "python": sys.version.split()[0],
        "platform": platform(),
        "dependencies": _dependencies(),
    }
    for source in _sources(case):
        digest = sha256((directory / source.copy).read_bytes()).hexdigest()
        provenance[source.name] = {"file": source.file, "sha256": digest}
    write_atomically(directory / PROVENANCE_NAME, json_text(provenance))


def version() -> str:
    """Return the version of the installed package."""
    return metadata.version(PACKAGE)


@cache
def _dependencies() -> dict[str, str]:
    """Return the installed version of each dependency; optional dependencies are left out."""
    required = (each for each in metadata.requires(PACKAGE) or [] if "extra ==" not in each)
    names = (re.match(r"[\w.-]+", requirement) for requirement in required)
    return {name[0]: metadata.version(name[0]) for name in names if name is not None}


def sensor_files(sensors: Sequence[Sensor]) -> tuple[str, ...]:
    """Return the names of the files with the signals of sensors: sensors.nc, and a CSV file for
    each sensor."""
    return (SENSORS_NAME, *(f"{sensor.label}.csv" for sensor in sensors)) if sensors else ()


def files_of_run(case: Case) -> tuple[str, ...]:
    """Return the names of the files of a run of a case, without the ParaView series."""
    drawn = (ORBIT_NAME, ENERGY_NAME, *(f"{name}.png" for name in CONTACT_FIGURES))
    figures = [f"{Path(name).stem}{end}" for name in drawn for end in (".png", ".nc")]
    made = (RESULT_NAME, SUMMARY_NAME, PROVENANCE_NAME, CHECKPOINT_NAME)
    worn = () if case.casing.coating is None else (WEAR_NAME,)
    return (*case_files(case), *made, *figures, *worn, *sensor_files(case.sensor))

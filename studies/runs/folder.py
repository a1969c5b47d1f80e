"""The folder of a run: checks before writing, and content."""

import json
import re
import sys
from collections.abc import Sequence
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
    """Return the contents of the files needed to run a case again, case.toml and the mesh file, by
    name of the file."""
    source = _source(case)
    files = {CASE_NAME: portable_case(case).encode()}
    return files if source is None else files | {source.copy: Path(source.file).read_bytes()}


def march_digest(case: Case) -> str:
    """Return the SHA-256 digest of all input of a march except its duration."""
    march = case.march.model_copy(update={"duration": 1.0, "revolutions": None})
    digest = sha256(version().encode())
    for name, content in case_files(case.model_copy(update={"march": march})).items():
        digest.update(name.encode() + content)
    return digest.hexdigest()


def portable_case(case: Case, folder: str = "") -> str:
    """Return the text of a case that refers to a copy of the mesh file instead of the original;
    `folder` is the path from the folder of the text to the folder of the copy."""
    source = _source(case)
    if source is None:
        return dumps_case(case)
    table = getattr(case.bladed_disk, source.key)
    copy = table.model_copy(update={"file": str(PurePosixPath(folder) / source.copy)})
    disk = case.bladed_disk.model_copy(update={source.key: copy})
    return dumps_case(case.model_copy(update={"bladed_disk": disk}))


class Source(NamedTuple):
    """A file from which a case takes its bladed disk."""

    key: str  #: key of its table in [bladed_disk]: "mesh" or "superelement"
    file: str  #: path

    @property
    def copy(self) -> str:
        """Name of the copy in the folder of a run."""
        return self.key + Path(self.file).suffix.lower()


def _source(case: Case) -> Source | None:
    for key in ("mesh", "superelement"):
        table = getattr(case.bladed_disk, key)
        if table is not None:
            return Source(key, table.file)
    return None


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
    """Write the provenance of the run: versions, date, computer, and the copied mesh file."""
    source = _source(case)
    provenance: dict[str, Any] = {
        PACKAGE: version(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "python": sys.version.split()[0],
        "platform": platform(),
        "dependencies": _dependencies(),
    }
    if source is not None:
        digest = sha256((directory / source.copy).read_bytes()).hexdigest()
        provenance[source.key] = {"file": source.file, "sha256": digest}
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

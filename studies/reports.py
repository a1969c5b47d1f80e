"""Reports of what lies in a folder: a run, finished or not."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from bladewhirl.models.faults import UserError
from bladewhirl.postprocess.picture_file import checked_target
from bladewhirl.postprocess.report_page import Page, write_page
from bladewhirl.postprocess.result import RESULT_NAME, open_result
from bladewhirl.postprocess.run_report import run_report
from bladewhirl.studies.report import REPORT_NAME
from bladewhirl.studies.run_directory import PROVENANCE_NAME


def write_report(directory: str | Path, output: str | Path | None = None) -> Path:
    """Write the report of a run as one HTML file that needs no network; returns its path.

    Args:
        directory: of a run.
        output: the file; report.html in the folder when None. An older one is replaced.

    Raises:
        UserError: no run there, or the file can't be written.
    """
    directory = Path(directory)
    target = directory / REPORT_NAME if output is None else Path(output)
    checked_target(target, ".html")
    if not (directory / RESULT_NAME).is_file():
        raise UserError(f"{directory}: expected the folder of a run, with its {RESULT_NAME}")
    with _writing(target):
        target.parent.mkdir(parents=True, exist_ok=True)  # before anything is drawn
    page = _run_page(directory)
    with _writing(target):
        return write_page(page, target)


@contextmanager
def _writing(target: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise UserError(f"{target}: cannot be written ({error.strerror})") from None


def _run_page(directory: Path) -> Page:
    with open_result(directory) as result:
        return run_report(result, _provenance(directory), name=directory.absolute().name)


def _provenance(directory: Path) -> Mapping[str, object] | None:
    """What made it; None where that is not told."""
    try:
        found = json.loads((directory / PROVENANCE_NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None

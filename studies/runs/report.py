"""Report of a folder with a run or a sweep, finished or not."""

import os
from pathlib import Path

from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.plotting.files import checked_target
from bladewhirl.postprocess.reports.page import Page, write_page
from bladewhirl.postprocess.reports.run import run_report
from bladewhirl.postprocess.sweep.dataset import SWEEP_NAME, open_sweep
from bladewhirl.solvers.march.schema import RESULT_NAME
from bladewhirl.studies.runs.folder import (
    HISTORIES_NAME,
    REPORT_NAME,
    read_failures,
    read_provenance,
)


def report(directory: str | Path, output: str | Path | None = None) -> Path:
    """Write the report of a run or a sweep as one HTML file for use offline; return its path.

    Args:
        directory: folder of a run or a sweep, or the history of a point of a sweep. The report of a
            sweep links to those of its points that exist.
        output: path of the file; report.html in the folder, or the name of the history with .html,
            when None. An older file is replaced.

    Raises:
        UserError: the folder contains neither run nor sweep, or the file cannot be written.
    """
    directory = Path(directory)
    target = report_target(directory, None if output is None else Path(output))
    kinds = (make for name, make in PAGES.items() if (directory / name).is_file())
    make = _run_page if directory.is_file() else next(kinds)
    with writing(target):
        target.parent.mkdir(parents=True, exist_ok=True)  # before anything is drawn
    page = make(directory, target)
    with writing(target):
        return write_page(page, target)


def report_target(directory: Path, output: Path | None) -> Path:
    """Return the path of the report of a folder.

    Raises:
        UserError: the folder contains neither run nor sweep, or the file name does not end in
            .html.
    """
    if directory.is_file():
        return checked_target(output or directory.with_suffix(".html"), ".html")
    target = checked_target(directory / REPORT_NAME if output is None else output, ".html")
    if not any((directory / name).is_file() for name in PAGES):
        raise UserError(
            f"{directory}: expected the folder of a run or a sweep, with its {' or '.join(PAGES)}"
        )
    return target


def _run_page(path: Path, target: Path) -> Page:
    with open_result(path) as result:
        folder = path if path.is_dir() else path.parent
        return run_report(result, read_provenance(folder), name=path.absolute().name)


def _sweep_page(directory: Path, target: Path) -> Page:
    from bladewhirl.postprocess.reports.sweep import sweep_report

    failures = []
    for entry in read_failures(directory):
        values = (f"{k} = {v}" for k, v in entry.items() if k not in ("point", "reason"))
        failures.append((", ".join(values), str(entry["reason"])))
    provenance, name = read_provenance(directory), directory.absolute().name
    links = {
        int(path.stem.removeprefix("point_")): os.path.relpath(path, target.parent)
        for path in (directory / HISTORIES_NAME).glob("point_*.html")
    }
    with open_sweep(directory) as sweep:
        return sweep_report(sweep, provenance, failures, name=name, links=links)


PAGES = {RESULT_NAME: _run_page, SWEEP_NAME: _sweep_page}
"""Functions that make the report of a folder, by name of the main file in the folder."""

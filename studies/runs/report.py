"""Report of a folder with a run or a sweep, finished or not."""

from pathlib import Path

from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.postprocess.fields.result import open_result
from bladewhirl.postprocess.plotting.files import checked_target
from bladewhirl.postprocess.reports.page import Page, write_page
from bladewhirl.postprocess.reports.run import run_report
from bladewhirl.postprocess.sweep.dataset import SWEEP_NAME, open_sweep
from bladewhirl.solvers.march.schema import RESULT_NAME
from bladewhirl.studies.runs.folder import REPORT_NAME, read_failures, read_provenance


def report(directory: str | Path, output: str | Path | None = None) -> Path:
    """Write the report of a run or a sweep as one HTML file for use offline; return its path.

    Args:
        directory: folder of a run or a sweep.
        output: path of the file; report.html in the folder when None. An older file is replaced.

    Raises:
        UserError: the folder contains neither run nor sweep, or the file cannot be written.
    """
    directory = Path(directory)
    target = report_target(directory, None if output is None else Path(output))
    make = next(make for name, make in PAGES.items() if (directory / name).is_file())
    with writing(target):
        target.parent.mkdir(parents=True, exist_ok=True)  # before anything is drawn
    page = make(directory)
    with writing(target):
        return write_page(page, target)


def report_target(directory: Path, output: Path | None) -> Path:
    """Return the path of the report of a folder.

    Raises:
        UserError: the folder contains neither run nor sweep, or the file name does not end in
            .html.
    """
    target = checked_target(directory / REPORT_NAME if output is None else output, ".html")
    if not any((directory / name).is_file() for name in PAGES):
        raise UserError(
            f"{directory}: expected the folder of a run or a sweep, with its {' or '.join(PAGES)}"
        )
    return target


def _run_page(directory: Path) -> Page:
    with open_result(directory) as result:
        return run_report(result, read_provenance(directory), name=directory.absolute().name)


def _sweep_page(directory: Path) -> Page:
    from bladewhirl.postprocess.reports.sweep import sweep_report

    failures = []
    for entry in read_failures(directory):
        values = (f"{k} = {v}" for k, v in entry.items() if k not in ("point", "reason"))
        failures.append((", ".join(values), str(entry["reason"])))
    provenance, name = read_provenance(directory), directory.absolute().name
    with open_sweep(directory) as sweep:
        return sweep_report(sweep, provenance, failures, name=name)


PAGES = {RESULT_NAME: _run_page, SWEEP_NAME: _sweep_page}
"""Functions that make the report of a folder, by name of the main file in the folder."""

"""The folder that a command writes figures and data into."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bladewhirl.models.inputs.errors import UserError


def check_figure_folder(folder: Path | None, *, overwrite: bool) -> None:
    """See that figures may be written to a folder; nothing is made yet.

    Raises:
        UserError: it exists and is not to be written into, or is a file.
    """
    if folder is None or not folder.exists():
        return
    if not folder.is_dir():
        raise UserError(f"{folder}: expected a folder, found a file")
    if not overwrite:
        raise UserError(f"{folder}: already exists; --overwrite writes into it")


@contextmanager
def written_to(folder: Path) -> Iterator[Path]:
    """Make the folder; what the system refuses to write is a fault of the user's.

    Raises:
        UserError: naming the folder and the reason.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield folder
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError(f"{error.filename or folder}: cannot be written ({reason})") from None

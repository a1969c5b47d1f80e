"""Files of a folder that belong to the program: its manifest lists them, no others are replaced."""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from bladewhirl.meshes.files.drafts import write_whole

MANIFEST_NAME = "manifest.json"
FILES = "files written by bladewhirl"
"""Key of the list in a manifest."""


def listed(folder: Path) -> set[str]:
    """Return the names listed in the manifest of a folder, with ``/`` in subfolders, if any."""
    try:
        content = json.loads((folder / MANIFEST_NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return set()
    names = content.get(FILES) if isinstance(content, dict) else None
    return {name for name in names if isinstance(name, str)} if isinstance(names, list) else set()


def claim(folder: Path, names: Iterable[str], *, overwrite: bool = False) -> None:
    """List files before they are written into a folder, which is made if it does not exist.

    Args:
        folder: that gets them; its manifest too.
        names: of the files, relative to it.
        overwrite: also those that are there and not the program's.

    Raises:
        FileExistsError: a file is there that the manifest does not list.
    """
    new, known = set(names), listed(folder)
    _refuse_foreign((folder / name for name in sorted(new - known)), overwrite=overwrite)
    text = json.dumps({FILES: sorted(new | known | {MANIFEST_NAME})}, indent=1)
    write_whole(folder / MANIFEST_NAME, text + "\n")


def claim_file(path: Path, *, overwrite: bool = False) -> None:
    """Check one file; a folder without a manifest does not get one.

    Raises:
        FileExistsError: it is there and not listed.
    """
    if (path.parent / MANIFEST_NAME).exists():
        claim(path.parent, [path.name], overwrite=overwrite)
    else:
        _refuse_foreign([path], overwrite=overwrite)


def check_file(path: Path, *, overwrite: bool = False) -> None:
    """Check that a file may be written; nothing is listed yet.

    Raises:
        FileExistsError: it is there and not listed.
    """
    if path.name not in listed(path.parent):
        _refuse_foreign([path], overwrite=overwrite)


def owned(folder: Path) -> Iterator[Path]:
    """Regular files that the manifests of a folder and of those below list; links are never."""
    for place, _, names in os.walk(folder):
        here = Path(place)
        above = [root for root in (here, *here.parents) if root.is_relative_to(folder)]
        lists = [(root, listed(root)) for root in above]
        for name in names:
            path = here / name
            if not path.is_symlink() and any(
                path.relative_to(root).as_posix() in listed_names for root, listed_names in lists
            ):
                yield path


def _refuse_foreign(paths: Iterable[Path], *, overwrite: bool) -> None:
    for path in paths:
        if not overwrite and os.path.lexists(path):
            reason = "it is there, and no manifest says it is bladewhirl's; --overwrite replaces it"
            raise FileExistsError(errno.EEXIST, reason, str(path))

"""Output files: each is written completely or not at all, and the program replaces only its own
files.

A manifest in a folder lists the files that the program wrote there; no other file is replaced or
removed.
"""

import csv
import errno
import json
import os
import re
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TextIO

MANIFEST_NAME = "manifest.json"
FILES = "files written by bladewhirl"  #: key under which a manifest lists files

LARGEST_TEXT, LONGEST_CELL = 2_000_000_000, 1000
"""Largest size of a text file of the user [bytes], and largest length of a cell in it."""

_CODE = re.compile(
    "invalid literal|could not convert|unpack|broadcast|reshape|shape mismatch|index "
)
"""Parts of the messages of Python and NumPy about code."""

PREFIX = ".bladewhirl-"  #: start of the names of the temporary folders in which files are written


def check_regular(file: str | os.PathLike[str]) -> None:
    """Raise an OSError if a path is a pipe or a device, from which reading may never end."""
    if os.path.exists(file) and not (os.path.isfile(file) or os.path.isdir(file)):
        raise OSError(errno.EINVAL, "it is not a regular file", os.fspath(file))


def open_text(file: str | os.PathLike[str], errors: str = "strict") -> TextIO:
    """Open a text file of the user in UTF-8, with or without the byte order mark of Excel.

    Raises:
        OSError: the file is missing, too large, a folder, a pipe or a device.
        ValueError: the path contains a null.
    """
    check_regular(file)
    if os.path.exists(file) and os.path.getsize(file) > LARGEST_TEXT:
        raise OSError(errno.EFBIG, f"it is larger than {LARGEST_TEXT / 1e9:g} GB", os.fspath(file))
    return open(file, encoding="utf-8-sig", errors=errors)


def reason_of(error: Exception) -> str:
    """Return the text of an error of a library on one line; nothing if it is about its code and not
    about the file, such as the name of a missing key."""
    text = " ".join(str(error).split())
    inner = KeyError | IndexError | TypeError | AttributeError | AssertionError | NameError
    return "" if isinstance(error, inner) or _CODE.search(text) else text


def plain(text: str) -> str:
    """Return the text of a number, or of numbers.

    Raises:
        ValueError: it has digits of other scripts or low lines, which Python accepts in numbers.
    """
    if "_" in text or not text.isascii():
        raise ValueError("numbers have other digits than 0 to 9, or low lines")
    return text


def csv_rows(file: str | os.PathLike[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield the number of the last line and the cells of each row of a CSV file of the user; long
    cells raise a `csv.Error`, because patterns take long for them. See `open_text` for errors."""
    with open_text(file) as stream:
        for row in (reader := csv.reader(stream, skipinitialspace=True)):
            if any(len(cell) > LONGEST_CELL for cell in row):
                raise csv.Error(f"line {reader.line_num} has more than {LONGEST_CELL} characters")
            yield reader.line_num, row


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Yield the path of a draft, which replaces the target at the end of the `with` block.

    An error in the block removes the draft. The draft is in a new private folder next to the
    target, so that no link of another user is followed. If the target is a link, the link is
    replaced, not the file to which it points.

    Raises:
        OSError: the target is a folder or a device, or the system refuses.
    """
    if target.exists() and not target.is_file():
        raise OSError(errno.EINVAL, "it is not a regular file", str(target))
    target.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(
        prefix=PREFIX, dir=target.parent, ignore_cleanup_errors=True
    ) as private:
        draft = Path(private) / target.name
        yield draft
        os.replace(draft, target)


def remove_leftovers(folder: Path) -> None:
    """Remove drafts of killed processes from a folder into which no other process writes."""
    for left in folder.glob(f"{PREFIX}*"):
        if left.is_dir() and not left.is_symlink():
            shutil.rmtree(left, ignore_errors=True)


def write_atomically(target: Path, content: str | bytes) -> None:
    """Write a file; text is written in UTF-8. If writing fails, the earlier file is unchanged."""
    with replacing(target) as draft:
        draft.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)


def json_text(document: Any) -> str:
    """Return a document as JSON with floats at full precision; nan and infinity, which JSON cannot
    represent, are null."""
    finite = json.loads(json.dumps(document), parse_constant=lambda constant: None)
    return json.dumps(finite, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def read_object(path: Path) -> dict[str, Any]:
    """Return the object in a JSON file; empty if the file is missing or contains no object."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def packaged_rows(package: str, name: str) -> list[dict[str, str]]:
    """Return the rows of a CSV file in a package, by the headings in its first line."""
    text = resources.files(package).joinpath(name).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


def listed(folder: Path) -> set[str]:
    """Return the names in the manifest of a folder, such as ``vtk/series.pvd``; an empty set if
    there is no manifest."""
    names = read_object(folder / MANIFEST_NAME).get(FILES)
    return {name for name in names if isinstance(name, str)} if isinstance(names, list) else set()


def claim(folder: Path, names: Iterable[str], *, overwrite: bool = False) -> None:
    """Add files that will be written to the manifest of a folder; `names` are relative to the
    folder.

    The folder is made if it does not exist. With `overwrite`, existing files that the manifest does
    not list are accepted.

    Raises:
        FileExistsError: a file exists that the manifest does not list.
        OSError: a folder that the program would make is a symbolic link.
    """
    new, known = set(names), listed(folder)
    _refuse_links(folder, new)
    _refuse_foreign((folder / name for name in sorted(new - known)), overwrite=overwrite)
    text = json.dumps({FILES: sorted(new | known | {MANIFEST_NAME})}, indent=1)
    write_atomically(folder / MANIFEST_NAME, text + "\n")


def claim_file(path: Path, *, overwrite: bool = False) -> None:
    """Check that a file may be written; list it in the manifest of its folder, if there is one.

    Raises:
        FileExistsError: the file exists and is not in the manifest of its folder.
    """
    if (path.parent / MANIFEST_NAME).exists():
        claim(path.parent, [path.name], overwrite=overwrite)
    else:
        _refuse_foreign([path], overwrite=overwrite)


def check_file(path: Path, *, overwrite: bool = False) -> None:
    """Check that a file may be written, without adding it to the manifest.

    Raises:
        FileExistsError: the file exists and is not in the manifest.
    """
    if path.name not in listed(path.parent):
        _refuse_foreign([path], overwrite=overwrite)


def owned(folder: Path) -> Iterator[Path]:
    """Yield the files, except links, that the manifests of a folder and its subfolders list."""
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


def _refuse_links(folder: Path, names: Iterable[str]) -> None:
    """Raise an error if a subfolder that the program would make is a symbolic link."""
    inside = {(folder / name).parent for name in names} - {folder}
    if (folder.parent / MANIFEST_NAME).exists():
        inside.add(folder)
    for place in sorted(inside):
        if place.is_symlink():
            reason = "it is a link to another folder; give the folder itself with -o"
            raise OSError(errno.ELOOP, reason, str(place))


def _refuse_foreign(paths: Iterable[Path], *, overwrite: bool) -> None:
    for path in paths:
        if not overwrite and os.path.lexists(path):
            reason = "it exists, and bladewhirl did not write it; --overwrite replaces it"
            raise FileExistsError(errno.EEXIST, reason, str(path))

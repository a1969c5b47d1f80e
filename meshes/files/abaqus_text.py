"""Text of Abaqus and CalculiX input: keywords, with their parameters and data lines.

Comments are skipped, continued lines are joined, and the files that *INCLUDE and INPUT= name are
read in their places. Numbers may have exponents of Fortran, such as 1.5d-3.
"""

import re
import string
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np

from bladewhirl.files import LARGEST_TEXT, open_text, plain
from bladewhirl.meshes.files.abaqus_keywords import spaced
from bladewhirl.meshes.files.groups import MeshFileError

WITH_INPUT = frozenset(["INCLUDE", "NODE", "ELEMENT", "NSET", "ELSET"])
"""Keywords whose data may be in the file that INPUT= names."""

MOST_FILES = 1000  #: largest number of times that files are read in the place of a keyword
DEEPEST = 20  #: largest number of files of which each names the next

BLANK = string.whitespace + "\x1a"
"""Characters around the content of a line, with that which ends files of some programs."""

SNIFFED = 200  #: number of lines in which the format of a text is recognised


@dataclass
class Card:
    """A keyword with its parameters and the data lines after it."""

    keyword: str
    parameters: dict[str, str]  #: values by the name in capitals, without blanks
    rows: list[list[str]] = field(default_factory=list)
    place: str = ""  #: line and file, for messages

    def needs(self, name: str) -> str:
        """Return the value of a required parameter."""
        if not (value := self.parameters.get(name.replace(" ", ""), "")):
            raise MeshFileError(f"*{self.keyword} with {name}=")
        return value

    @contextmanager
    def located(self) -> Iterator[None]:
        """Add keyword, line and file to the text of errors, of which some have no text."""
        try:
            yield
        except (ValueError, IndexError, KeyError, OverflowError) as error:
            known = isinstance(error, MeshFileError)
            text = error if known else f"an .inp file with valid data under *{self.keyword}"
            raise MeshFileError(f"{text} (*{self.keyword}, {self.place})") from None


def real(text: str) -> float:
    """Return a number, perhaps with an exponent of Fortran such as 1.5d-3."""
    try:
        return float(plain(text).replace("d", "e").replace("D", "e"))
    except ValueError:
        raise MeshFileError(f"a number, got {text!r}") from None


def whole(text: str) -> int:
    """Return a whole number of at most 64 bits."""
    try:
        return int(np.int64(int(plain(text))))
    except (ValueError, OverflowError):
        raise MeshFileError(f"a whole number, got {text!r}") from None


def cards(path: Path, *, follow: bool = True, outside: bool = False) -> Iterator[Card]:
    """Yield the keywords of an .inp file; text before the first one is skipped.

    Args:
        path: path of the file.
        follow: whether the files that it names are read.
        outside: whether these files may be outside the folder of the file.

    Raises:
        MeshFileError: a file cannot be read, or there are no keywords.
    """
    card: Card | None = None
    for line in _Lines(path, follow, outside).of(path, ()):
        if isinstance(line, Card):
            if card is not None:
                yield card
            card = line
        elif card is not None:
            card.rows.append(_parts(line.rstrip(",")))
    if card is None:
        raise MeshFileError("an .inp file, with keywords such as *NODE")
    yield card


def head_of(path: Path) -> list[str]:
    """Return the first lines of a file; nothing if it cannot be read."""
    try:
        with open_text(path, errors="replace") as stream:
            return [line.strip() for line in islice(stream, SNIFFED)]
    except OSError:
        return []


def is_abaqus_text(lines: list[str]) -> bool:
    """Return whether the first line of a file that is no comment is a keyword of Abaqus."""
    first = next((line for line in lines if line and not line.startswith("**")), "")
    return re.match(r"\*\s*[A-Za-z][A-Za-z ]*(,|$)", first) is not None and "*SET," not in first


def _parts(line: str) -> list[str]:
    """Return what commas separate, without quotes; commas in quotes belong to a name."""
    if '"' not in line:
        return [part.strip() for part in line.split(",")]
    pieces = line.split('"')
    pieces[1::2] = [piece.replace(",", "\0") for piece in pieces[1::2]]
    return [part.replace("\0", ",").strip() for part in "".join(pieces).split(",")]


def _card(line: str, place: str) -> Card:
    keyword, *parameters = _parts(line[1:])
    pairs = (parameter.partition("=") for parameter in parameters if parameter)
    values = {"".join(key.upper().split()): value.strip() for key, _, value in pairs}
    return Card(spaced(keyword), values, place=place)


class _Lines:
    """Lines of a file and of the files that it names.

    Args:
        path: path of the file.
        follow: whether the files that it names are read.
        outside: whether these files may be outside the folder of the file.
    """

    def __init__(self, path: Path, follow: bool, outside: bool) -> None:
        self._folder, self._follow, self._outside = path.parent, follow, outside
        self._files = self._bytes = 0

    def of(self, path: Path, before: tuple[Path, ...]) -> Iterator[str | Card]:
        """Yield keywords, with their continued lines, and lines of data without comments."""
        try:
            with open_text(path, errors="replace") as stream:
                text = enumerate((x.strip(BLANK) for x in stream.read().splitlines()), 1)
        except OSError as error:
            named = f" {path.name} for INPUT=" if before else ""
            raise MeshFileError(f"a readable file{named} ({error.strerror})") from None
        lines = ((n, line) for n, line in text if line and not line.startswith("**"))
        for number, line in lines:
            if not line.startswith("*"):
                yield line
                continue
            continued = [line]
            while continued[-1].endswith(","):
                if (following := next(lines, None)) is None:
                    raise MeshFileError("another line: the last line ends with a comma")
                continued.append(following[1])
            card = _card("".join(continued), f"line {number} of {path.name}")
            if card.keyword != "INCLUDE":
                yield card
            reads = card.keyword in WITH_INPUT and "INPUT" in card.parameters
            if reads or card.keyword == "INCLUDE":
                above = (*before, path.resolve())
                with card.located():
                    file = self._named(card, above)
                yield from self.of(file, above)

    def _named(self, card: Card, before: tuple[Path, ...]) -> Path:
        """Return the path of the file that a keyword names, relative to the folder of the mesh or,
        if there is none, to that of the file with the keyword."""
        given = card.needs("INPUT")
        if not self._follow:
            raise MeshFileError(
                f"an .inp file without *{card.keyword}, INPUT=, with all nodes and elements listed"
            )
        folder, name = self._folder.resolve(), given.replace("\\", "/")
        try:
            path, other = ((at / name).resolve() for at in (folder, before[-1].parent))
            if not (self._outside or path.is_relative_to(folder)):
                raise MeshFileError(
                    f"files in the folder of the mesh for INPUT=, not {given};"
                    " outside_files = True allows others"
                )
            if not path.exists() and (self._outside or other.is_relative_to(folder)):
                path = other
            self._bytes += path.stat().st_size
        except MeshFileError:
            raise
        except (OSError, ValueError, RuntimeError) as error:
            raise MeshFileError(f"a readable file {given} for INPUT= ({error})") from None
        self._files += 1
        if path in before:
            raise MeshFileError(f"files that do not include themselves; {given} does")
        if len(before) > DEEPEST:
            raise MeshFileError(f"at most {DEEPEST} files that include one another for INPUT=")
        if self._files > MOST_FILES or self._bytes > LARGEST_TEXT:
            raise MeshFileError(f"at most {MOST_FILES} files and {LARGEST_TEXT:g} bytes for INPUT=")
        return path

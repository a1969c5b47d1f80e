"""Entries of bulk data of Nastran: free, small and large fields, and their continuations."""

import re
from collections.abc import Iterator
from typing import NamedTuple

from bladewhirl.meshes.files.groups import MeshFileError

BEGIN = re.compile(r"^[ \t]*BEGIN[ \t]*(\w*).*$", re.I | re.M)
END = re.compile(r"^[ \t]*ENDDATA\b.*", re.I | re.M | re.S)
INCLUDE = re.compile(r"^[ \t]*INCLUDE\b", re.I | re.M)
PARAMETER = re.compile(r"^[ \t]*PARAM[ \t,*].*$", re.I | re.M)
"""A parameter in free fields, which the case control may also have."""

REPLICATED = re.compile(r"=+|=?\(\d+\)|[*=]\(.*\)")
"""A field that repeats or increases that of the entry before it."""

EXPONENT = re.compile(r"(?<=[\d.])([+-])(?=\d)")
"""Sign of an exponent without a letter, such as 1.5-3."""

SMALL, LARGE = 8, 4  #: number of fields of a line
COLUMNS = 72  #: width of a line of small or large fields without its last field
NAMED = re.compile(r"[A-Z][A-Z0-9]*\*?")


class Entry(NamedTuple):
    """An entry of bulk data."""

    name: str  #: name in capitals
    fields: list[str]  #: text of the fields after the name, in capitals
    line: int  #: number of its first line, from 1

    def text(self, place: int) -> str:
        """Return the text of a field; nothing if it is blank. The first field after the name is
        0."""
        return self.fields[place] if place < len(self.fields) else ""

    def whole(self, place: int, default: int | None = None) -> int:
        """Return a whole number.

        Raises:
            MeshFileError: the field has none, or is blank without a default.
        """
        text = self.text(place)
        if default is not None and not text:
            return default
        if not re.fullmatch(r"[+-]?\d{1,18}", text):
            raise self._error(place, "a whole number")
        return int(text)

    def real(self, place: int, default: float | None = None) -> float:
        """Return a number, perhaps with an exponent without a letter, such as 1.5-3.

        Raises:
            MeshFileError: the field has none, or is blank without a default.
        """
        text = self.text(place)
        if default is not None and not text:
            return default
        try:
            return float(EXPONENT.sub(r"E\1", text.replace("D", "E")))
        except ValueError:
            raise self._error(place, "a number") from None

    def members(self, start: int) -> list[int | str]:
        """Return the numbers and words, such as THRU, of the fields from one on that are not
        blank."""
        return [
            self.whole(place) if one[0] in "+-0123456789" else one
            for place, one in enumerate(self.fields)
            if place >= start and one
        ]

    def _error(self, place: int, expected: str) -> MeshFileError:
        where = f"field {place + 2} of {self.name} (line {self.line})"
        return MeshFileError(f"{expected} in {where}, got {self.text(place)!r}")


def entries(text: str) -> Iterator[Entry]:
    """Yield the entries of bulk data, from BEGIN BULK to ENDDATA, and the parameters before them.

    Args:
        text: text of the file; without BEGIN BULK all of it is bulk data.

    Raises:
        MeshFileError: the file includes others or has several sections of bulk data, entries are
            repeated, or continuations do not follow the lines that they continue.
    """
    text = END.sub("", text)
    if found := INCLUDE.search(text):
        raise MeshFileError(
            f"one file with all bulk data, without INCLUDE (line {_line(text, found.start())})"
        )
    begins = [*BEGIN.finditer(text)]
    if other := [one for one in begins if one[1].upper() != "BULK"] or begins[1:]:
        raise MeshFileError(
            f"one section BEGIN BULK, got {other[0][0].strip()} "
            f"(line {_line(text, other[0].start())})"
        )
    start = begins[0].end() if begins else 0
    for found in PARAMETER.finditer(text[:start]):
        yield from _joined(found[0], _line(text, found.start()))
    yield from _joined(text[start:], _line(text, start))


def _line(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1


def _joined(text: str, first: int) -> Iterator[Entry]:
    """Yield the entries of lines of bulk data, of which the first has the given number."""
    entry, label = None, ""
    for number, raw in enumerate(text.split("\n"), first):
        line = raw.partition("$")[0].expandtabs().rstrip(" \r\x00\x1a").upper()
        if not line.strip():
            continue
        head, fields, end = _fields(line, number)
        if ("=" in line or "(" in line) and any(map(REPLICATED.fullmatch, (head, *fields))):
            raise MeshFileError(f"entries without repetition (=, *(n)) (line {number})")
        if head[:1] in ("", "+", "*"):
            own = head.strip("+* ")
            if entry is None or (own and label and own != label):
                raise MeshFileError(f"continuations after the line they continue (line {number})")
            large = head.startswith("*")
            if not large:  # after a single line of large fields
                entry.fields.extend([""] * (-len(entry.fields) % SMALL))
            entry.fields.extend(fields)
        else:
            if not NAMED.fullmatch(head):
                raise MeshFileError(
                    f"the name of an entry in 8 columns or before a comma, got {head!r}"
                    f" (line {number})"
                )
            if entry is not None:
                yield _trimmed(entry)
            entry = Entry(head.rstrip("*"), fields, number)
        label = end.strip("+* ")
    if entry is not None:
        yield _trimmed(entry)


def _fields(line: str, number: int) -> tuple[str, list[str], str]:
    """Return the first field of a line, its fields with data, and its last field."""
    if "," in line:
        head, *fields = (one.strip() for one in line.split(","))
        size = LARGE if "*" in head else SMALL
        fields, (end, *more) = fields[:size], [*fields[size:], ""]
        if any(more) or re.fullmatch(r"[\d.]\S*", end):
            raise MeshFileError(f"at most {size} fields after the first one (line {number})")
    else:
        head = line[:8].strip()
        size = LARGE if "*" in head else SMALL
        width = (COLUMNS - 8) // size
        fields = [line[at : at + width].strip() for at in range(8, COLUMNS, width)]
        end = line[COLUMNS:80]
    return head, fields + [""] * (size - len(fields)), end


def _trimmed(entry: Entry) -> Entry:
    while entry.fields and not entry.fields[-1]:
        entry.fields.pop()
    return entry

"""Check of the elements of a .mat file of version 5 before SciPy reads it.

The compiled reader of SciPy takes the type of an element as a place in a table without a check, so
that a damaged type makes it read outside this table. Format: MathWorks, MAT-File Format, 2023.
"""

import struct
import zlib
from pathlib import Path

from scipy.io.matlab import matfile_version

from bladewhirl.models.inputs.machine import memory

HEAD, MATRIX, COMPRESSED = 128, 14, 15
"""Size of the head of a file, and types of elements with other elements."""

TYPES = {1, 2, 3, 4, 5, 6, 7, 9, 12, 13, 16, 17, 18}
"""Types of elements with numbers or text."""

ELEMENTS = {4: 4, 5: 6} | dict.fromkeys(range(6, 16), 4)
"""Number of elements of text, a sparse matrix and a full matrix of real numbers, by class."""


def check_tags(file: Path) -> None:
    """Check the types and sizes of all elements of a .mat file.

    Raises:
        ValueError, struct.error, zlib.error: the file is damaged, or empty.
    """
    if matfile_version(file, appendmat=False)[0] != 1:
        return
    content = file.read_bytes()
    order, at = ("<" if content[HEAD - 2 : HEAD] == b"IM" else ">"), HEAD
    while at < len(content):
        kind, size = struct.unpack_from(f"{order}II", content, at)
        if kind == COMPRESSED:
            packed = content[at + 8 : at + 8 + size]
            _check_elements(zlib.decompressobj().decompress(packed, int(min(memory(), 2e9))), order)
        elif kind == MATRIX and at + 8 + size <= len(content):
            _check_elements(content[at : at + 8 + size], order)
        else:
            raise ValueError("a damaged variable")
        at += 8 + size


def _check_elements(content: bytes, order: str) -> None:
    """Check the elements of a variable one after the other, as the reader meets them; a matrix
    counts as its tag followed by other elements."""
    at, missing, begins = 0, 0, False  # elements that a matrix still needs; whether one begins
    while at < len(content):
        kind, size = struct.unpack_from(f"{order}II", content, at)
        at += 8
        if kind == MATRIX and missing <= 0 and not begins:
            begins = size > 0
            continue
        small = kind >> 16  # size of data that are in the tag itself
        kind, size = (kind & 0xFFFF, 0) if small else (kind, -(-size // 8) * 8)
        if kind not in TYPES or small > 4 or (begins and size != 8):
            raise ValueError(f"an element of the unknown type {kind}")
        if begins:  # with the class, and the flag of complex numbers
            (flags,) = struct.unpack_from(f"{order}I", content, at)
            missing = ELEMENTS.get(flags & 0xFF, 0) + (flags >> 11 & 1)
        at, missing, begins = at + size, missing - 1, False
    if missing > 0 or at > len(content):
        raise ValueError("an incomplete variable")

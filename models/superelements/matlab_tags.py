"""Check of the tags in a .mat file of version 5, before SciPy reads the file.

The compiled reader of SciPy takes the type of an element as a place in a table without a check, and
a damaged type makes it read outside this table. Format: MathWorks, MAT-File Format, 2023.
"""

import io
import struct
import zlib
from pathlib import Path
from typing import BinaryIO

from scipy.io.matlab import matfile_version

MATRIX, COMPRESSED, FLAGS = 14, 15, (6, 8)
"""Types of elements with other elements; type and size of the first element of a variable."""

TYPES = {1, 2, 3, 4, 5, 6, 7, 9, 12, 13, 16, 17, 18}
"""Types of elements with numbers or text."""

ELEMENTS = {4: 4, 5: 6} | dict.fromkeys(range(6, 16), 4)
"""Number of elements of text, a sparse matrix and a full matrix of real numbers, by class."""

HEAD, PIECE = 128, 2**20


class _Inflated(io.RawIOBase):
    """Stream of compressed bytes, which are decompressed piece by piece."""

    def __init__(self, packed: bytes) -> None:
        self._engine, self._rest = zlib.decompressobj(), packed

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: memoryview) -> int:  # type: ignore[override] # base: any buffer
        piece = self._engine.decompress(self._rest, len(buffer))
        self._rest = self._engine.unconsumed_tail
        buffer[: len(piece)] = piece
        return len(piece)


def check_tags(file: Path) -> None:
    """Check the types and sizes of all elements of a .mat file.

    Raises:
        ValueError: the file is damaged, or empty.
    """
    if matfile_version(file, appendmat=False)[0] != 1:
        return
    with file.open("rb") as stream:
        order = "<" if stream.read(HEAD)[-2:] == b"IM" else ">"
        while tag := stream.read(8):
            kind, size = struct.unpack(f"{order}II", tag)
            body = stream.read(size)
            if kind not in (MATRIX, COMPRESSED) or len(body) < size:
                raise ValueError("a damaged variable")
            if kind == COMPRESSED:
                _check_elements(io.BufferedReader(_Inflated(body)), order)
            else:
                _check_elements(io.BytesIO(tag + body), order)


def _check_elements(stream: BinaryIO, order: str) -> None:
    """Check elements one after the other, as the reader meets them, to the end of a stream. A
    matrix counts as its tag followed by other elements."""
    missing = 0  # elements that the current matrix still needs
    begins = False
    while tag := stream.read(8):
        kind, size = struct.unpack(f"{order}II", tag)
        if (begins and (kind, size) != FLAGS) or (kind == MATRIX and missing > 0):
            raise ValueError("an incomplete variable")
        if kind == MATRIX:
            begins = size > 0
            continue
        small = kind >> 16  # size of data in the tag itself
        kind, size = (kind & 0xFFFF, 0) if small else (kind, size)
        if kind not in TYPES or small > 4:
            raise ValueError(f"an element of the unknown type {kind}")
        if begins:
            (flags,) = struct.unpack(f"{order}I4x", stream.read(8))
            missing = ELEMENTS.get(flags & 0xFF, 0) + (flags >> 11 & 1)
        else:
            _skip(stream, -(-size // 8) * 8)
        missing, begins = missing - 1, False
    if missing > 0:
        raise ValueError("an incomplete variable")


def _skip(stream: BinaryIO, size: int) -> None:
    while size > 0:
        piece = stream.read(min(size, PIECE))
        if not piece:
            raise ValueError("an incomplete element")
        size -= len(piece)

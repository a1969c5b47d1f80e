"""File objects for HDF5, which can neither close a file after a failed write nor open a truncated
file.

`GuardedFile` writes nothing more to the disk after the first failed write, and stores the error for
`check`. Data that were on the disk at the last `check` change only in the next one, the header of
the file first: a process that is killed between both leaves the earlier state, with data at the end
that nothing refers to. `CutFile` reports a larger size than the file has, so that the existing part
can be read.
"""

import io
import os
from typing import Any

CLAIMED = 2**40
"""Number of bytes that a truncated file reports in addition to its size."""

SMALL = 4096
"""Largest read of internal structures of HDF5 [bytes]; such a read may extend beyond the end."""


HEADER = 96  #: size of the header of HDF5, which has the size of the file [bytes]


class GuardedFile(io.RawIOBase):
    """New file that keeps all data of a failed write and of later writes in memory, and changes of
    existing data until `check`.

    Raises:
        OSError: the file cannot be created.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        super().__init__()
        self._file = open(path, "w+b", buffering=0)  # closed in `close`
        self._at, self._end = 0, 0
        self._settled = 0  # size of the file at the last check
        self._kept: list[tuple[int, bytes]] = []
        self.refusal: OSError | None = None  #: error of the first failed write, if any

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set the position."""
        self._at = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._end}[whence]
        return self._at

    def tell(self) -> int:
        """Return the position."""
        return self._at

    def readinto(self, buffer: Any) -> int:
        """Fill the buffer with the written data, and with zeros where nothing was written."""
        view = memoryview(buffer).cast("B")
        self._file.seek(self._at)
        count = self._file.read(len(view))
        view[: len(count)] = count
        view[len(count) :] = bytes(len(view) - len(count))
        for start, content in self._kept:
            first = max(start, self._at)
            last = min(start + len(content), self._at + len(view))
            if first < last:
                part = content[first - start : last - start]
                view[first - self._at : last - self._at] = part
        self._at += len(view)
        return len(view)

    def write(self, data: Any) -> int:
        """Write data beyond the size at the last check to the file; keep the other data in memory,
        after a failed write all."""
        view = memoryview(data).cast("B")
        old = max(0, min(self._settled - self._at, len(view)))
        if old:
            self._kept.append((self._at, bytes(view[:old])))
        if old < len(view):
            self._put(self._at + old, view[old:])
        self._at += len(view)
        self._end = max(self._end, self._at)
        return len(view)

    def _put(self, start: int, view: memoryview) -> None:
        """Write data to the file, or after a failed write to memory."""
        try:
            if self.refusal is None:
                self._file.seek(start)
                written = 0
                while written < len(view):
                    written += self._file.write(view[written:])
        except OSError as error:
            self.refusal = error
        if self.refusal is not None:
            self._kept.append((start, bytes(view)))

    def _settle(self) -> None:
        """Write the changes of existing data, those of the header first."""
        if self.refusal is None:
            changes, self._kept = self._kept, []
            for start, content in sorted(changes, key=lambda change: change[0] >= HEADER):
                self._put(start, memoryview(content))
            self._settled = self._end

    def truncate(self, size: int | None = None) -> int:
        """Set the size of the file."""
        self._end = self._at if size is None else size
        try:
            if self.refusal is None:
                self._file.truncate(self._end)
        except OSError as error:
            self.refusal = error
        return self._end

    def close(self) -> None:
        """Write the changes of existing data, and close the file."""
        if not self.closed:
            self._settle()
        self._file.close()
        super().close()

    def check(self) -> None:
        """Write the changes of existing data; raise the error of the first failed write, if any.

        Raises:
            OSError: a write failed.
        """
        self._settle()
        if self.refusal is not None:
            raise self.refusal


class CutFile(io.RawIOBase):
    """Readable file that may be shorter than its header states, because its march was killed."""

    mode = "rb"

    def __init__(self, path: str | os.PathLike[str]) -> None:
        super().__init__()
        self._file = open(path, "rb", buffering=0)  # closed in `close`
        self._size = os.fstat(self._file.fileno()).st_size

    def readable(self) -> bool:
        """Return True."""
        return True

    def seekable(self) -> bool:
        """Return True."""
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set the position; the reported end is far beyond the end of the file."""
        if whence == os.SEEK_END:
            return self._file.seek(self._size + CLAIMED + offset)
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        """Return the position."""
        return self._file.tell()

    def readinto(self, buffer: Any) -> int:
        """Fill the buffer with data of the file, and with zeros beyond the end of the file.

        Raises:
            OSError: the data begins beyond the end of the file, or extends beyond the end and is
                larger than `SMALL`.
        """
        view = memoryview(buffer).cast("B")
        at = self._file.tell()
        if at >= self._size or (at + len(view) > self._size and len(view) > SMALL):
            raise OSError(
                f"the file ends at byte {self._size}, but its header states a larger size"
            )
        count = self._file.read(len(view))
        view[: len(count)] = count
        view[len(count) :] = bytes(len(view) - len(count))
        return len(view)

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()

"""Files that are written completely or not at all, without following planted links."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

PREFIX = ".bladewhirl-"
"""Prefix of the private folders of drafts; left-over ones may be removed."""


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Yield a draft that replaces the target when complete and is removed on failure.

    It lies in a new folder beside the target that is the user's alone, so that no link planted
    there is followed. A target that is a link itself gives way, what it leads to does not change.

    Raises:
        OSError: the target is a folder or a device, or the system refuses.
    """
    if target.exists() and not target.is_file():
        raise OSError(errno.EINVAL, "it is no regular file", str(target))
    target.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(
        prefix=PREFIX, dir=target.parent, ignore_cleanup_errors=True
    ) as private:
        draft = Path(private) / target.name
        yield draft
        os.replace(draft, target)


def write_whole(target: Path, content: str | bytes) -> None:
    """Write a file, text in UTF-8, so that it is there whole or as it was."""
    with replacing(target) as draft:
        draft.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)

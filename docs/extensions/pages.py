"""Puts generated parts into pages, and writes pages and drawings that are generated as a whole.

`<!-- generated: NAME -->` stands for a part of `reference.GENERATED`, and
`<!-- drawing: NAME | words -->` for a drawing of `pictures_of_the_model`.
"""

from __future__ import annotations

import re
from pathlib import Path

import gallery
import pictures_of_the_model
import reference
from sphinx.application import Sphinx

_MARK = re.compile(r"^<!-- generated: (\S+) -->$", re.MULTILINE)
_DRAWING = re.compile(r"^<!-- drawing: (\S+) \| (.*?) -->$", re.MULTILINE)


def fill(app: Sphinx, document: str, source: list[str]) -> None:
    """Put in the parts."""
    source[0] = _MARK.sub(lambda match: reference.GENERATED[match[1]](), source[0])
    up = "../" * document.count("/")
    source[0] = _DRAWING.sub(rf"![\2]({up}built/drawings/\1.svg)", source[0])


def write(app: Sphinx) -> None:
    """Write pages of the gallery and drawings."""
    built = Path(app.srcdir) / "built"
    pictures_of_the_model.draw(built / "drawings")
    gallery.write(Path(app.srcdir) / "gallery", built / "gallery")


def setup(app: Sphinx) -> dict[str, bool]:
    """Write before anything is read, fill when a page is read."""
    app.connect("builder-inited", write)
    app.connect("source-read", fill, priority=500)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

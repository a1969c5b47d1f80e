"""Pages with `executed: true` at their head: blocks run when the page is built, output below.

`<!-- picture: FILE | words -->` stands for a picture that the blocks above have made.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from blocks import Session, blocks
from sphinx.application import Sphinx
from sphinx.util.logging import getLogger

_HEAD = re.compile(r"\A---\n.*?^executed: true$.*?^---$", re.MULTILINE | re.DOTALL)
_PICTURE = re.compile(r"^<!-- picture: (\S+) \| (.*?) -->$", re.MULTILINE)

logger = getLogger(__name__)


def execute(app: Sphinx, document: str, source: list[str]) -> None:
    """Run the blocks of a page that asks for it, and put in what they print and draw."""
    if not _HEAD.match(source[0]):
        return
    folder = Path(app.srcdir) / "built" / document
    shutil.rmtree(folder, ignore_errors=True)
    session = Session(folder)
    parts, last = [], 0
    for block in blocks(source[0]):
        if not block.runs:
            continue
        parts.append(source[0][last : block.end])
        last = block.end
        try:
            printed = session.run(block).rstrip()
        except Exception as error:
            logger.warning("a block fails: %s: %s", type(error).__name__, error, location=document)
            return
        if printed:
            parts.append(f"\n{{.output}}\n```text\n{printed}\n```\n")
    text = "".join([*parts, source[0][last:]])
    up = "../" * document.count("/")
    source[0] = _PICTURE.sub(lambda found: f"![{found[2]}]({up}built/{document}/{found[1]})", text)


def setup(app: Sphinx) -> dict[str, bool]:
    """Run when a page is read, after what is generated has been put in."""
    app.connect("source-read", execute, priority=600)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""Code blocks of a page, executed one after the other in a folder.

All ```` ```python ```` blocks share a namespace; lines of ```` ```console ```` blocks are commands.
A comment on the line above a block has these effects:

    <!-- file: stage.toml -->       the block is written to the file, not executed
    <!-- not run: reason -->        the block is not executed, as it needs a cluster, for instance
    <!-- long: reason -->           the block is executed at full length only
    <!-- markdown: reason -->       the output of the block is Markdown and part of the page
    <!-- quiet: reason -->          the output of the block is not shown

`<!-- printed: words -->` beside a sentence asserts that a block above prints these words, so that
numbers in the text remain those of the blocks.

A short run of a page shows that its blocks work: commands march at most `SHORT`, except where the
speed follows a table or each march continues another, sweep two points of each key, follow branches
over a few points, take a few draws and film two frames. Figures are coarse, with panels where they
happen to be. What a short run prints is not compared with the text. Blocks below `long: reason` are
left out, and all blocks of pages with `long: reason` in the front matter.

`python blocks.py PAGE FOLDER` runs a page and prints the outputs of its blocks as a JSON list.
"""

import contextlib
import io
import json
import re
import shlex
import sys
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, cast
from unittest import mock

ROOT = Path(__file__).parents[2]
RUN = ("python", "console")
SHORT = 0.1
"""Longest march of a command in a short run [s]."""

_BLOCK = re.compile(
    r"(?:^<!-- (?P<mark>file|not run|long|markdown|quiet): (?P<argument>[^\n]*?) -->\n)?"
    r"^```(?P<language>\w+)\n(?P<code>.*?)^```$\n?",
    re.MULTILINE | re.DOTALL,
)
LONG = re.compile(r"\A---\n(?:.+\n)*?long: ")
_PRINTED = re.compile(r"^<!-- printed: (.*?) -->$", re.MULTILINE)


@dataclass(frozen=True, kw_only=True)
class Block:
    """A code block of a page."""

    language: str
    code: str
    mark: str  #: "file", "not run", "long", "markdown", "quiet" or empty
    argument: str  #: file name or reason after the mark
    start: int  #: index of the first character in the page
    end: int  #: index after the last character

    @property
    def runs(self) -> bool:
        """True if the block is executed or written to a file."""
        return self.mark == "file" or (self.language in RUN and self.mark != "not run")


def blocks(text: str) -> Iterator[Block]:
    """Yield the code blocks of a page in order."""
    for match in _BLOCK.finditer(text):
        yield Block(
            language=match["language"],
            code=match["code"],
            mark=match["mark"] or "",
            argument=match["argument"] or "",
            start=match.start(),
            end=match.end(),
        )


class Session:
    """Execution of the blocks of one page.

    Args:
        folder: working folder, made if missing; it gets a link to the examples.
        short: make marches, sweeps and films short.
    """

    def __init__(self, folder: Path, *, short: bool = False) -> None:
        self.folder, self.short = folder, short
        self._names: dict[str, Any] = {"__name__": "__main__"}
        folder.mkdir(parents=True, exist_ok=True)
        examples = folder / "examples"
        if not examples.exists():
            examples.symlink_to(ROOT / "examples")

    def run(self, block: Block) -> str:
        """Execute a block, or write it to its file; return the printed output, which is empty if
        the block is left out of a short run.

        Raises:
            RuntimeError: a command failed.
        """
        if self.short and block.mark == "long":
            return ""
        if block.mark == "file":
            (self.folder / block.argument).write_text(block.code, encoding="utf-8")
            return ""
        if block.language == "python":
            return self._python(block.code)
        return "".join(self._command(line) for line in commands(block.code))

    def _python(self, code: str) -> str:
        printed = io.StringIO()
        with contextlib.chdir(self.folder), contextlib.redirect_stdout(printed):
            exec(compile(code, str(self.folder), "exec"), self._names)
        return printed.getvalue()

    def _command(self, line: str) -> str:
        """Run a command of bladewhirl in this process, which saves the time of its imports."""
        from typer.testing import CliRunner

        from bladewhirl.studies.commands.cli import app

        program, *words = shlex.split(line, comments=True)
        if program != "bladewhirl":
            raise RuntimeError(f"{line}: expected a command of bladewhirl")
        with contextlib.chdir(self.folder):
            words = shortened(words) if self.short else words
            done = CliRunner().invoke(app, words, env={"COLUMNS": "88", "NO_COLOR": "1"})
        if done.exit_code:
            raise RuntimeError(
                f"{line}: exit code {done.exit_code}\n{done.stderr}"
            ) from done.exception
        return done.stdout  # progress and hints go to standard error


def commands(code: str) -> list[str]:
    """Return the commands of a block, one per line; a backslash continues a line."""
    lines = code.replace("\\\n", " ").splitlines()
    return [line for line in lines if line.strip() and not line.lstrip().startswith("#")]


def _at_most(limit: int, number: str) -> str:
    """Return a number, at most the limit."""
    return str(min(int(number), limit))


def _ends(over: str) -> str:
    """Return the first and the last of the values of a key, KEY=FIRST:LAST:STEP or KEY=A,B,..."""
    key, values = over.split("=", 1)
    each = values.split(":")[:2] if values.count(":") == 2 else values.split(",")
    return f"{key}={each[0]},{each[-1]}" if ":" not in each[0] else over


def shortened(words: list[str]) -> list[str]:
    """Return the words of a command that marches, sweeps and films little, see above."""
    from bladewhirl import read_case

    kept: dict[str, Callable[[str], str]] = {
        "--frames": partial(_at_most, 2),
        "--points": partial(_at_most, 4),
        "--draws": partial(_at_most, 8),
        "--over": _ends,
    }
    beyond = {"--from", "--to", "--time"} if words[0] in ("render", "export", "plot") else set()
    short, sets = words[:1], []
    for before, word in pairwise(words):
        if before not in beyond and word not in beyond:  # instants may lie beyond a short march
            short.append(kept[before](word) if before in kept else word)
        if before == "--set":
            sets.append(word)
    if words[0] == "run" and "--resume" not in words and "--frames" not in words:
        short += ["--frames", "2"]
    if words[0] in ("run", "sweep") and "--resume" not in words:
        march = read_case(words[1], sets).march
        if any(each.startswith("march.revolutions=") for each in sets):
            short += ["--set", "march.revolutions=1"]
        elif march.duration > SHORT and not (
            march.speed_table or march.run_up or "--continue" in words
        ):
            short += ["--set", f"march.duration={SHORT}"]
    return short


@contextlib.contextmanager
def coarse_figures() -> Iterator[None]:
    """Draw figures with few points and without the layout that keeps texts apart, which takes most
    of their time."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    from bladewhirl.postprocess.plotting.style import STYLE

    with (
        mock.patch.object(ConstrainedLayoutEngine, "execute"),
        mock.patch.dict(cast(dict[str, Any], STYLE), {"savefig.dpi": 30}),
    ):
        yield


def run(text: str, folder: Path, *, short: bool = False) -> list[str]:
    """Run the blocks of a page in a folder; return the printed output of each block.

    Raises:
        RuntimeError: a command failed, or nothing prints the words that the page states.
    """
    from bladewhirl.models.inputs.errors import Hint

    warnings.simplefilter("ignore", Hint)  # commands print hints themselves
    session = Session(folder.resolve(), short=short)
    with coarse_figures() if short else contextlib.nullcontext():
        outputs = [session.run(block) for block in blocks(text) if block.runs]
    everything = " ".join(" ".join(outputs).split())
    for words in [] if short else _PRINTED.findall(text):
        if words not in everything:
            raise RuntimeError(f"no block prints {words!r}:\n{everything}")
    return outputs


if __name__ == "__main__":
    page, folder = map(Path, sys.argv[1:])
    print(json.dumps(run(page.read_text(encoding="utf-8"), folder)))

"""Pages with `executed: true` at their head: blocks run before pages are read, output below.

`<!-- picture: FILE | words -->` stands for a picture that the blocks have made. A page is run again
when it changes or the package does; so are the cases of the verification manual, beside them.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import blocks
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

_HEAD = re.compile(r"\A---\n.*?^executed: true$.*?^---$", re.MULTILINE | re.DOTALL)
_PICTURE = re.compile(r"^<!-- picture: (\S+) \| (.*?) -->$", re.MULTILINE)
LONGEST = ("verification", "tutorials/rotation", "tutorials/sweep", "start", "tutorials/case_file")
VERIFIED = ("verified.py", "refinements.py")
_LAYERS = ("bladewhirl", "meshes", "models", "solvers", "postprocess", "studies", "examples")


@dataclass(frozen=True)
class Job:
    """A script that prints a JSON list of texts, for one page."""

    name: str  #: of the page, and of the folder that it writes to
    script: Path
    page: Path
    key: str  #: what its result depends on besides the package


def run_pages(app: Sphinx) -> None:
    """Run the jobs of all pages in processes, one per core, the longest first."""
    source, extensions = Path(app.srcdir), Path(blocks.__file__).parent
    verified = "".join((extensions / name).read_text("utf-8") for name in VERIFIED)
    jobs = [Job("verification", extensions / VERIFIED[0], source / "verification.md", verified)]
    for page in sorted(source.rglob("*.md")):
        if _HEAD.match(text := page.read_text(encoding="utf-8")):
            name = page.relative_to(source).with_suffix("").as_posix()
            jobs.append(Job(name, Path(blocks.__file__), page, text))
    jobs.sort(key=lambda job: LONGEST.index(job.name) if job.name in LONGEST else len(LONGEST))
    state = _state()
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        for done in [pool.submit(_run, job, source, state) for job in jobs]:
            done.result()


def _run(job: Job, source: Path, state: str) -> None:
    folder = source / "built" / job.name
    kept = folder.with_name(f"{folder.name}.json")
    key = hashlib.sha256((state + job.key).encode()).hexdigest()
    if kept.exists() and json.loads(kept.read_text(encoding="utf-8"))["key"] == key:
        return
    shutil.rmtree(folder, ignore_errors=True)
    folders = (str(job.script.parent), os.environ.get("PYTHONPATH", ""))
    done = subprocess.run(
        [sys.executable, job.script, job.page, folder],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, folders))},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise ExtensionError(f"{job.page}: a block fails\n{done.stderr}")
    kept.write_text(json.dumps({"key": key, "printed": json.loads(done.stdout)}), encoding="utf-8")


def printed(source: Path, name: str) -> list[str]:
    """Texts that the job of a page has printed."""
    kept = source / "built" / f"{name}.json"
    texts: list[str] = json.loads(kept.read_text(encoding="utf-8"))["printed"]
    return texts


def _state() -> str:
    """Return a text that identifies the state of the package and its examples."""
    files = (file for layer in _LAYERS for file in (blocks.ROOT / layer).rglob("*.*"))
    sources = (file for file in files if file.suffix in (".py", ".toml", ".csv", ".html"))
    return "\n".join(f"{file} {file.stat().st_mtime_ns}" for file in sorted(sources))


def put_in_output(app: Sphinx, document: str, source: list[str]) -> None:
    """Put below each block what it printed."""
    if not _HEAD.match(source[0]):
        return
    parts, last = [], 0
    running = [block for block in blocks.blocks(source[0]) if block.runs]
    for block, text in zip(running, printed(Path(app.srcdir), document), strict=True):
        parts.append(source[0][last : block.end])
        last = block.end
        if text.strip():
            parts.append(f"\n{{.output}}\n```text\n{text.rstrip()}\n```\n")
    source[0] = "".join([*parts, source[0][last:]])


def put_in_verification(app: Sphinx, document: str, source: list[str]) -> None:
    """Put in the sections of the verification manual."""
    if document == "verification":
        text = "".join(printed(Path(app.srcdir), document))
        source[0] = source[0].replace("<!-- verification -->", text)


def put_in_pictures(app: Sphinx, document: str, source: list[str]) -> None:
    """Show the pictures made by blocks."""
    folder = f"{'../' * document.count('/')}built/{document}"
    source[0] = _PICTURE.sub(rf"![\2]({folder}/\1)", source[0])


def setup(app: Sphinx) -> dict[str, Any]:
    """Run before pages are read; show output before, pictures after generated parts are put in."""
    app.connect("builder-inited", run_pages)
    app.connect("source-read", put_in_output, priority=400)
    app.connect("source-read", put_in_verification)
    app.connect("source-read", put_in_pictures, priority=600)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""Pages with `executed: true` at their head: blocks run before pages are read, output below.

`<!-- picture: FILE | words -->` stands for a picture that the blocks have made. A page is run again
when it changes or the package does.
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
from pathlib import Path
from typing import Any

import blocks
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

_HEAD = re.compile(r"\A---\n.*?^executed: true$.*?^---$", re.MULTILINE | re.DOTALL)
_PICTURE = re.compile(r"^<!-- picture: (\S+) \| (.*?) -->$", re.MULTILINE)
_LAYERS = ("bladewhirl", "meshes", "models", "solvers", "postprocess", "studies", "examples")


def run_pages(app: Sphinx) -> None:
    """Run the pages that ask for it, each in a process of its own, one a core."""
    source = Path(app.srcdir)
    state = _state()
    pages = {
        page: text
        for page in sorted(source.rglob("*.md"))
        if _HEAD.match(text := page.read_text(encoding="utf-8"))
    }
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        jobs = [pool.submit(_run, page, source, state + text) for page, text in pages.items()]
        for job in jobs:
            job.result()


def _run(page: Path, source: Path, state: str) -> None:
    folder = source / "built" / page.relative_to(source).with_suffix("")
    kept = folder.with_name(f"{folder.name}.json")
    key = hashlib.sha256(state.encode()).hexdigest()
    if kept.exists() and json.loads(kept.read_text(encoding="utf-8"))["key"] == key:
        return
    shutil.rmtree(folder, ignore_errors=True)
    command = [sys.executable, blocks.__file__, page, folder]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ExtensionError(f"{page}: a block fails\n{done.stderr}")
    kept.write_text(json.dumps({"key": key, "printed": json.loads(done.stdout)}), encoding="utf-8")


def _state() -> str:
    """What tells one state of the package and its examples from another."""
    files = (file for layer in _LAYERS for file in (blocks.ROOT / layer).rglob("*.*"))
    sources = (file for file in files if file.suffix in (".py", ".toml", ".csv", ".html"))
    return "\n".join(f"{file} {file.stat().st_mtime_ns}" for file in sorted(sources))


def put_in_output(app: Sphinx, document: str, source: list[str]) -> None:
    """Put below each block what it printed."""
    if not _HEAD.match(source[0]):
        return
    kept = Path(app.srcdir) / "built" / f"{document}.json"
    printed: list[str] = json.loads(kept.read_text(encoding="utf-8"))["printed"]
    parts, last = [], 0
    running = [block for block in blocks.blocks(source[0]) if block.runs]
    for block, text in zip(running, printed, strict=True):
        parts.append(source[0][last : block.end])
        last = block.end
        if text.strip():
            parts.append(f"\n{{.output}}\n```text\n{text.rstrip()}\n```\n")
    source[0] = "".join([*parts, source[0][last:]])


def put_in_pictures(app: Sphinx, document: str, source: list[str]) -> None:
    """Show the pictures that blocks have made."""
    folder = f"{'../' * document.count('/')}built/{document}"
    source[0] = _PICTURE.sub(rf"![\2]({folder}/\1)", source[0])


def setup(app: Sphinx) -> dict[str, Any]:
    """Run before pages are read; show output before, pictures after generated parts are put in."""
    app.connect("builder-inited", run_pages)
    app.connect("source-read", put_in_output, priority=400)
    app.connect("source-read", put_in_pictures, priority=600)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""Generated parts of pages: output of blocks, references, pictures.

The blocks of pages with `executed: true` in the front matter are run before Sphinx reads the pages,
if the page or the package changed since the last run. `<!-- generated: NAME -->` is replaced by the
text NAME of `reference.GENERATED`, `<!-- picture: FILE | words -->` by a picture from the blocks
with an alternative text.
"""

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
import gallery
import notebooks
import reference
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

_HEAD = re.compile(r"\A---\n.*?^executed: true$.*?^---$", re.MULTILINE | re.DOTALL)
_MARK = re.compile(r"^<!-- generated: (\S+) -->$", re.MULTILINE)
_PICTURE = re.compile(r"^<!-- picture: (\S+) \| (.*?) -->$", re.MULTILINE)
LONGEST = ("verification", "tutorials/rotation", "tutorials/sweep", "start", "tutorials/case_file")
_LAYERS = ("bladewhirl", "meshes", "models", "solvers", "postprocess", "studies", "examples")


def run_pages(source: Path) -> None:
    """Run all pages in processes, one per core, the longest first."""
    pages = {
        path.relative_to(source).with_suffix("").as_posix(): path
        for path in sorted(source.rglob("*.md"))
        if _HEAD.match(path.read_text(encoding="utf-8"))
    }
    names = sorted(pages, key=lambda name: (*LONGEST, name).index(name))
    state = _state()
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        runs = [pool.submit(_run, pages[name], source / "built" / name, state) for name in names]
        for run in runs:
            run.result()


def _run(page: Path, folder: Path, state: str) -> None:
    """Run the blocks of a page in a folder, and store their outputs beside the folder."""
    kept = folder.with_name(f"{folder.name}.json")
    key = hashlib.sha256((state + page.read_text(encoding="utf-8")).encode()).hexdigest()
    if kept.exists() and json.loads(kept.read_text(encoding="utf-8"))["key"] == key:
        return
    shutil.rmtree(folder, ignore_errors=True)
    done = subprocess.run(
        [sys.executable, blocks.__file__, page, folder], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise ExtensionError(f"{page}: a block fails\n{done.stderr}")
    kept.write_text(json.dumps({"key": key, "printed": json.loads(done.stdout)}), encoding="utf-8")


def printed(source: Path, name: str) -> list[str]:
    """Return the outputs of the blocks of a page."""
    kept = source / "built" / f"{name}.json"
    texts: list[str] = json.loads(kept.read_text(encoding="utf-8"))["printed"]
    return texts


def _state() -> str:
    """Return a text that identifies the state of the package and its examples."""
    files = (file for layer in _LAYERS for file in (blocks.ROOT / layer).rglob("*.*"))
    sources = (file for file in files if file.suffix in (".py", ".toml", ".csv", ".html"))
    return "\n".join(f"{file} {file.stat().st_mtime_ns}" for file in sorted(sources))


def fill(app: Sphinx, document: str, source: list[str]) -> None:
    """Insert outputs, references and pictures into the source of a page."""
    folder, text = Path(app.srcdir), source[0]
    if _HEAD.match(text):
        has_python = any(block.language == "python" for block in blocks.blocks(text) if block.runs)
        link = notebooks.write(document, text, folder / "built/notebooks") if has_python else ""
        text = _with_output(text, printed(folder, document)) + link
    text = _MARK.sub(lambda match: reference.GENERATED[match[1]](), text)
    built = f"{'../' * document.count('/')}built/{document}"
    source[0] = _PICTURE.sub(rf"![\2]({built}/\1)", text)


def _with_output(text: str, outputs: list[str]) -> str:
    """Insert the output of each block below the block; return the text of the page."""
    parts, last = [], 0
    running = [block for block in blocks.blocks(text) if block.runs]
    for block, output in zip(running, outputs, strict=True):
        parts.append(text[last : block.end])
        last = block.end
        if block.mark == "markdown":
            parts.append(f"\n{output}")
        elif output.strip() and block.mark != "quiet":
            parts.append(f"\n{{.output}}\n```text\n{output.rstrip()}\n```\n")
    return "".join([*parts, text[last:]])


def write(app: Sphinx) -> None:
    """Write pages of the gallery, then run all pages."""
    source = Path(app.srcdir)
    gallery.write(source / "gallery")
    run_pages(source)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register `write`, to be called before pages are read, and `fill`, called for each page."""
    app.connect("builder-inited", write)
    app.connect("source-read", fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

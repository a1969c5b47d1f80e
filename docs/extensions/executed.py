"""Generated parts of pages: output of blocks, references, pictures.

The blocks of pages with `executed: true` in the front matter are run before Sphinx reads the pages,
if the page or the package changed since the last run; those with `long: reason` too only at full
length. `<!-- generated: NAME | ARGUMENT -->` is replaced by the text NAME of `reference.GENERATED`,
of which some have arguments, `<!-- picture: FILE | words -->` by the picture FILE that a block has
drawn, with the words as alternative text, or by the words if a short run left the block out.
"""

import hashlib
import json
import multiprocessing
import os
import re
import shutil
import sys
from importlib import import_module
from importlib.util import find_spec
from multiprocessing.connection import wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import blocks
import gallery
import notebooks
import reference
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

_HEAD = re.compile(r"\A---\n.*?^executed: true$.*?^---$", re.MULTILINE | re.DOTALL)
_MARK = re.compile(r"^<!-- generated: (\S+)((?: \| .*?)*) -->$", re.MULTILINE)
_PICTURE = re.compile(r"^<!-- picture: (\S+) \| (.*?) -->$", re.MULTILINE)
LONGEST = (
    *("reference/figures", "verification", "tutorials/superelement", "tutorials/shaft_line"),
    *("tutorials/deck", "start", "tutorials/rotation", "tutorials/joints", "tutorials/periodic"),
)
IMPORTED = (
    *("matplotlib.pyplot", "meshio", "pint", "pyvista.plotting", "skfem", "typer.testing"),
    *("scipy.interpolate", "scipy.optimize", "scipy.signal", "scipy.spatial", "scipy.stats"),
    *("xarray.backends.h5netcdf_", "dask.array", "distributed"),  # xarray uses dask if it is there
    *("bladewhirl.postprocess.pictures.stage", "bladewhirl.postprocess.pictures.web_page"),
    *("bladewhirl.studies.commands.cli", "bladewhirl.studies.runs.outputs"),
    *("bladewhirl.studies.runs.render", "bladewhirl.studies.runs.run"),
    *("bladewhirl.solvers.march.central_difference", "bladewhirl.models.stage.hints"),
)
"""Modules that pages use; they are imported once, before the processes of the pages are forked."""

_LAYERS = ("bladewhirl", "meshes", "models", "solvers", "postprocess", "studies", "examples")


def run_pages(source: Path, *, short: bool) -> None:
    """Run each page in a process of its own, on a core of its own, the longest pages first."""
    pages = {
        path.relative_to(source).with_suffix("").as_posix(): path
        for path in sorted(source.rglob("*.md"))
        if _runs(path.read_text(encoding="utf-8"), short=short)
    }
    state, forks = _state(), sys.platform == "linux"
    context = multiprocessing.get_context("fork" if forks else "spawn")
    for module in IMPORTED if forks else ():
        if find_spec(module.partition(".")[0]):
            import_module(module)
    if forks:  # draw without a display also where a page uses PyVista itself
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    free = [*(os.sched_getaffinity(0) if forks else range(os.cpu_count() or 1))]
    running: dict[Any, tuple[str, int, BaseProcess]] = {}
    waiting = sorted(pages, key=lambda name: (*LONGEST, name).index(name), reverse=True)
    while waiting or running:
        while waiting and free:
            name, core = waiting.pop(), free.pop()
            process = context.Process(
                target=_run, args=(pages[name], source / "built" / name, state, core, short)
            )
            process.start()
            running[process.sentinel] = name, core, process
        for sentinel in wait(list(running)):
            name, core, process = running.pop(sentinel)
            process.join()
            free.append(core)
            if process.exitcode:
                raise ExtensionError(f"{pages[name]}: a block fails, as stated above")


def _runs(text: str, *, short: bool) -> bool:
    """Return whether the blocks of a page are run."""
    return bool(_HEAD.match(text)) and not (short and blocks.LONG.match(text))


def _run(page: Path, folder: Path, state: str, core: int, short: bool) -> None:
    """Run the blocks of a page in a folder, and store their outputs beside the folder.

    A command that starts a process for each core starts only one, because the page has one core.
    """
    kept, text = folder.with_name(f"{folder.name}.json"), page.read_text(encoding="utf-8")
    key = hashlib.sha256(f"{state}{text}{short}".encode()).hexdigest()
    if kept.exists() and json.loads(kept.read_text(encoding="utf-8"))["key"] == key:
        return
    if sys.platform == "linux":
        os.sched_setaffinity(0, [core])
    sys.modules["__main__"] = blocks  # workers of sweeps import this module, and not Sphinx
    shutil.rmtree(folder, ignore_errors=True)
    outputs = blocks.run(text, folder, short=short)
    kept.write_text(json.dumps({"key": key, "printed": outputs}), encoding="utf-8")


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
    runs = _runs(text, short=app.config.short)
    if runs:
        has_python = any(block.language == "python" for block in blocks.blocks(text) if block.runs)
        link = notebooks.write(document, text, folder / "built/notebooks") if has_python else ""
        text = _with_output(text, printed(folder, document)) + link
    text = _MARK.sub(lambda mark: reference.GENERATED[mark[1]](*mark[2].split(" | ")[1:]), text)
    built = f"{'../' * document.count('/')}built/{document}"

    def picture(mark: re.Match[str]) -> str:
        missing = app.config.short and not (folder / "built" / document / mark[1]).exists()
        return f"*{mark[2]}*" if missing else f"![{mark[2]}]({built}/{mark[1]})"

    source[0] = _PICTURE.sub(picture, text)


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
    gallery.write(source / "gallery", app.config.gallery_examples)
    run_pages(source, short=app.config.short)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register `write`, to be called before pages are read, and `fill`, called for each page."""
    app.add_config_value("short", False, "env", bool)
    app.add_config_value("gallery_examples", [], "env", list)
    app.connect("builder-inited", write)
    app.connect("source-read", fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

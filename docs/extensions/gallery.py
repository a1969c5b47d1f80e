"""A page for each case in examples/: drawing, words of its header, key numbers, command."""

from __future__ import annotations

import json
import os
import subprocess
import tomllib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import takewhile
from pathlib import Path
from typing import Any

from blocks import EXECUTABLES, ROOT

EXAMPLES = ROOT / "examples"


def write(pages: Path, drawings: Path) -> None:
    """Write a page for each example, and draw what is not drawn yet or older than its file."""
    drawings.mkdir(parents=True, exist_ok=True)
    examples = sorted(EXAMPLES.glob("*.toml"))
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        shown = list(pool.map(lambda example: _show(example, drawings), examples))
    names = [example.stem for example in examples]
    for example, numbers in zip(examples, shown, strict=True):
        _keep(pages / f"{example.stem}.md", _page(example, numbers))
    rows = "\n".join(
        f"- [![{name}](../built/gallery/{name}.png)]({name}.md) [{_title(name)}]({name}.md)"
        for name in names
    )
    listed = "\n".join(names)
    text = (
        "# Gallery\n\nEach of these is a file in `examples`; the pages are computed when the"
        f" site is built.\n\n{{.gallery}}\n{rows}\n\n```{{toctree}}\n:hidden:\n\n{listed}\n```\n"
    )
    _keep(pages / "index.md", text)


def _keep(page: Path, text: str) -> None:
    """Write a page if it changed, so that Sphinx reads only what is new."""
    page.parent.mkdir(exist_ok=True)
    if not page.exists() or page.read_text(encoding="utf-8") != text:
        page.write_text(text, encoding="utf-8")


def _show(example: Path, drawings: Path) -> dict[str, Any]:
    """The document of `bladewhirl show --json`, kept beside the drawing that it makes."""
    drawing, kept = drawings / f"{example.stem}.png", drawings / f"{example.stem}.json"
    if (
        not (drawing.exists() and kept.exists())
        or drawing.stat().st_mtime < example.stat().st_mtime
    ):
        done = subprocess.run(
            [EXECUTABLES / "bladewhirl", "show", example, "--json", "--png", "-o", drawing],
            check=True,
            capture_output=True,
            text=True,
        )
        kept.write_text(done.stdout, encoding="utf-8")
    found: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8"))
    return found


def _page(example: Path, numbers: dict[str, Any]) -> str:
    name = example.stem
    return (
        f"# {_title(name)}\n\n{_header(example)}\n\n"
        f"![{_title(name)}: the stage](../built/gallery/{name}.png)\n\n"
        f"```console\nbladewhirl run examples/{name}.toml\n```\n\n"
        f"{_table(numbers)}\n\n"
        f"```{{literalinclude}} ../../examples/{name}.toml\n:language: toml\n```\n"
    )


def _title(name: str) -> str:
    return str(tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8"))["title"])


def _header(example: Path) -> str:
    """The comment at the head of the file."""
    lines = example.read_text(encoding="utf-8").splitlines()
    comment = takewhile(lambda line: line.startswith("#"), lines)
    return "\n".join(line.removeprefix("#").removeprefix(" ") for line in comment)


def _table(numbers: dict[str, Any]) -> str:
    rows = [f"| {name} | {value} |" for name, value in _numbers(numbers)]
    return "\n".join(["| | |", "|---|---|", *rows])


def _numbers(numbers: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What `bladewhirl show` says of the stage, in handy units."""
    found = numbers["derived"]
    lowest, speed = found["reference_frequency"], found["speed"]
    casing = min(found["casing"], key=lambda mode: mode["frequency"]["hz"])
    yield "mass of the bladed disk", f"{found['bladed_disk_mass']:.4g} kg"
    yield "mass of the casing", f"{found['casing_mass']:.4g} kg"
    yield "lowest frequency of the bladed disk", f"{lowest['hz']:.4g} Hz"
    yield (
        f"lowest frequency of the casing, k = {casing['nodal_diameter']}",
        f"{casing['frequency']['hz']:.4g} Hz, {casing['frequency']['normalised']:.3g} times that",
    )
    yield "speed", f"{speed['rpm']:.5g} rpm, {speed['normalised']:.4g} times the lowest frequency"

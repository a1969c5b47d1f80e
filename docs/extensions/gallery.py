"""A page for each case in examples/: drawing, words of its header, film, key numbers, command."""

from __future__ import annotations

import io
import json
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stdout
from itertools import repeat, takewhile
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from blocks import ROOT

import bladewhirl as bw
from bladewhirl.studies.commands.cli import app

EXAMPLES = ROOT / "examples"
LONGEST, FRAMES = 0.6, 20  #: march under a load [s], pictures of the film


def write(pages: Path, drawings: Path) -> None:
    """Write a page for each example, and make what is not there yet or older than its file."""
    drawings.mkdir(parents=True, exist_ok=True)
    examples = sorted(EXAMPLES.glob("*.toml"))
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:  # each loads VTK once
        shown = list(pool.map(_show, examples, repeat(drawings)))
    names = [example.stem for example in examples]
    for example, numbers in zip(examples, shown, strict=True):
        _keep(pages / f"{example.stem}.md", _page(example, numbers, drawings))
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
    """Return the document of `bladewhirl show --json`, stored beside the drawing and the film."""
    kept = drawings / f"{example.stem}.json"
    if not kept.exists() or kept.stat().st_mtime < example.stat().st_mtime:
        kept.write_text(shown(example, drawings), encoding="utf-8")
    document: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8"))
    return document


def shown(example: Path, folder: Path) -> str:
    """The document of `bladewhirl show --json`; NAME.png, film and diagrams go to the folder."""
    case, name = bw.read_case(example), example.stem
    if case.excitation.type != "none":
        march(
            bw.with_values(case, {"march.duration": min(case.march.duration, LONGEST)}),
            folder / name,
        )
    elif case.initial.model_fields_set:  # what grows by itself takes its time
        march(case, folder / name)
    if case.rotation.effects != "none":
        _command("campbell", example, "-o", folder / f"{name}-campbell")
    drawing = folder / f"{name}.png"
    drawing.unlink(missing_ok=True)
    return _command("show", example, "--json", "--png", "-o", drawing)


def march(case: bw.Case, place: Path) -> None:
    """Write PLACE.gif, PLACE-orbit.png and PLACE-summary.json."""
    with tempfile.TemporaryDirectory() as scratch:
        run = bw.run(case, Path(scratch) / "run", frames=0)
        bw.render(run, place.with_suffix(".gif"), frames=FRAMES)
        for name in ("orbit.png", "summary.json"):
            shutil.copyfile(run.directory / name, f"{place}-{name}")


def _command(*words: str | Path) -> str:
    printed = io.StringIO()
    with redirect_stdout(printed):
        app([str(word) for word in words], standalone_mode=False)
    return printed.getvalue()


def _page(example: Path, numbers: dict[str, Any], drawings: Path) -> str:
    name = example.stem
    return (
        f"# {_title(name)}\n\n{_header(example)}\n\n"
        f"![{_title(name)}: the stage](../built/gallery/{name}.png)\n\n"
        f"```console\nbladewhirl run examples/{name}.toml\n```\n\n"
        f"{_table(_numbers(numbers))}\n\n{_campbell(name)}{_marched(name, drawings)}"
        f"## The case\n\n{{download}}`{name}.toml <../../examples/{name}.toml>`\n\n"
        f"```{{literalinclude}} ../../examples/{name}.toml\n:language: toml\n```\n"
    )


def _campbell(name: str) -> str:
    """Campbell diagram of an example with rotation effects, whose frequencies change with speed."""
    if bw.read_case(EXAMPLES / f"{name}.toml").rotation.effects == "none":
        return ""
    return (
        f"## Campbell diagram\n\n```console\nbladewhirl campbell examples/{name}.toml\n```\n\n"
        f"![{_title(name)}: Campbell diagram, static frame]"
        f"(../built/gallery/{name}-campbell/campbell-static.png)\n\n"
    )


def _marched(name: str, drawings: Path) -> str:
    """Film, orbit and figures of the march, of an example that has a load."""
    kept = drawings / f"{name}-summary.json"
    if not kept.exists():
        return ""
    summary = json.loads(kept.read_text(encoding="utf-8"))
    return (
        f"## The first {summary['end_time']:.3g} s\n\n"
        f"![{_title(name)}: blades and casing where contact is strongest]"
        f"(../built/gallery/{name}.gif)\n\n{_table(_outcome(summary))}\n\n"
        f"![{_title(name)}: orbit of the shaft](../built/gallery/{name}-orbit.png)\n\n"
    )


def _title(name: str) -> str:
    return bw.read_case(EXAMPLES / f"{name}.toml").title


def _header(example: Path) -> str:
    """The comment at the head of the file."""
    lines = example.read_text(encoding="utf-8").splitlines()
    comment = takewhile(lambda line: line.startswith("#"), lines)
    return "\n".join(line.removeprefix("#").removeprefix(" ") for line in comment)


def _table(values: Iterable[tuple[str, str]]) -> str:
    return "\n".join(["| | |", "|---|---|", *(f"| {name} | {value} |" for name, value in values)])


def _outcome(summary: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Return the outcome of the march in readable units."""
    yield "motion", summary["regime"]
    yield "largest radius of the orbit", f"{1e3 * summary['shaft_radius_max']:.3g} mm"
    yield "blades that touched", str(sum(share > 0 for share in summary["contact_share"]))
    force = summary["contact_force_max"]
    if force:
        yield (
            f"largest contact force over {1e3 * force['averaged_over']:.3g} ms",
            f"{force['force'] / 1e3:.3g} kN, blade {force['blade']}",
        )
    for body, largest in summary["stress_max"].items():
        name = body.replace("_", " ")
        yield f"largest stress of the {name}", f"{abs(largest['stress']) / 1e6:.3g} MPa"


def _numbers(numbers: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Return derived quantities of the stage in readable units."""
    derived = numbers["derived"]
    lowest, speed = derived["reference_frequency"], derived["speed"]
    casing = min(derived["casing"], key=lambda mode: mode["frequency"]["hz"])
    yield "mass of the bladed disk", f"{derived['bladed_disk_mass']:.4g} kg"
    yield "mass of the casing", f"{derived['casing_mass']:.4g} kg"
    yield "lowest frequency of the bladed disk", f"{lowest['hz']:.4g} Hz"
    yield (
        f"lowest frequency of the casing, k = {casing['nodal_diameter']}",
        f"{casing['frequency']['hz']:.4g} Hz, {casing['frequency']['normalised']:.3g} times that",
    )
    yield "speed", f"{speed['rpm']:.5g} rpm, {speed['normalised']:.4g} times the lowest frequency"

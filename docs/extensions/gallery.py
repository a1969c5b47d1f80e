"""A page for each case in examples/: header, drawing, properties, Campbell diagram, film, figures,
and for one of them a branch of periodic motions.

Like other pages, the pages of the gallery contain code blocks that are executed.
"""

from collections.abc import Iterator, Sequence
from itertools import takewhile
from pathlib import Path

from blocks import ROOT

import bladewhirl as bw
from bladewhirl.postprocess.plotting.registry import RUN_FIGURES, FigureKind

BRANCHED, BRANCH = "two_motions", "6600rpm:7700rpm"
"""Name of the example whose page has a branch of periodic motions, and its speeds."""
LONGEST, FRAMES = 0.5, 10
"""Longest duration of a march under a load [s], and number of pictures of a film of beams."""


def write(pages: Path, chosen: Sequence[str] = ()) -> None:
    """Write a page for each example, or for the chosen ones if there are some, and an index page
    that shows what each example does."""
    pages.mkdir(exist_ok=True)
    rows, names = [], []
    every = sorted(path.stem for path in (ROOT / "examples").glob("*.toml"))
    for stem in chosen or every:
        example = ROOT / "examples" / f"{stem}.toml"
        case, name = bw.read_case(example), example.stem
        _keep(pages / f"{name}.md", "\n\n".join(_page(example, case)) + "\n")
        picture = f"[![{name}](../built/gallery/{name}/{_sign(name, case)})]({name}.md)"
        rows.append(f"- {picture} [{case.title}]({name}.md)")
        names.append(name)
    parts = (
        "# Gallery",
        "Each of these is a file in `examples`; the pages are computed when the site is built.",
        "\n".join(["{.gallery}", *rows]),
        "\n".join(["```{toctree}", ":hidden:", "", *names, "```"]),
    )
    _keep(pages / "index.md", "\n\n".join(parts) + "\n")


def _sign(name: str, case: bw.Case) -> str:
    """Return the picture of an example on the index page: the wear tracks of a coating, a film of
    the motion, a Campbell diagram, or the stage if it does not move."""
    if (figure := _figures(case)[-1].name) == "wear-tracks":
        return f"run/{figure}.png"
    if _moves(case):
        return "run/animation.gif"
    return f"{name}.png" if case.rotation.effects == "none" else "campbell/campbell-static.png"


def _moves(case: bw.Case) -> bool:
    """Return true if the page of an example contains a march."""
    loaded = case.excitation != bw.Case().excitation or case.casing.closure is not None
    loaded |= case.shaft_line is not None
    return loaded or bool(case.initial.model_fields_set)


def _keep(page: Path, text: str) -> None:
    """Write a page if its text changed, so that Sphinx reads changed pages only."""
    if not page.exists() or page.read_text(encoding="utf-8") != text:
        page.write_text(text, encoding="utf-8")


def _page(example: Path, case: bw.Case) -> Iterator[str]:
    """Yield the parts of a page."""
    name, file = example.stem, f"examples/{example.name}"
    lines = example.read_text(encoding="utf-8").splitlines()
    header = takewhile(lambda line: line.startswith("#"), lines)
    yield f"---\nexecuted: true\n---\n\n# {case.title}"
    yield "\n".join(line.removeprefix("#").removeprefix(" ") for line in header)
    if case.shaft_line is None:
        yield _picture(f"{name}.png", f"{case.title}: the stage")
        yield _console(f"bladewhirl show {file} --png -o {name}.png")
    else:
        yield _console(f"bladewhirl show {file}", f"bladewhirl modes {file} --count 6 -o modes")
        yield _picture("modes/line-modes.png", "The line in its lowest modes at the speed")
    if case.rotation.effects != "none":
        yield "## Campbell diagram"
        yield _console(f"bladewhirl campbell {file} -o campbell")
        yield _picture("campbell/campbell-static.png", f"{case.title}: Campbell diagram")
    duration = case.march.duration  # a motion that grows without a load needs the whole duration
    if case.excitation != bw.Case().excitation:
        duration = min(duration, LONGEST)
    if _moves(case):
        march = f"bladewhirl run {file} --set march.duration={duration:g} -o run --frames 0"
        yield f"## The first {duration:.3g} s"
        frames = FRAMES if case.bladed_disk.superelement is None else 2 * FRAMES
        yield _console(march, f"bladewhirl render run --gif --frames {frames}")
        yield _picture("run/animation.gif", "Blades and casing where contact is strongest")
        for figure in _figures(case):
            yield _picture(f"run/{figure.name}.png", figure.title)
    if name == BRANCHED:
        yield "## All periodic motions over the speed"
        over = f'bladewhirl periodic {file} --over "march.speed={BRANCH}" --points 14 -o branch'
        at_one = f'bladewhirl periodic {file} --from branch --set "march.speed=7650 rpm" -o motion'
        yield _console(over, at_one, f"bladewhirl render motion --gif --frames {FRAMES}")
        yield _picture("branch/branch.png", "Impulse and amplitude over the speed; multipliers")
        yield _picture("motion/animation.gif", "The small motion beyond the upper fold")
    beside = sorted(example.parent.glob(f"{name}.*"), key=lambda path: path != example)
    links = (
        f"{{download}}`{path.name} <../../examples/{path.name}>`"
        for path in beside
        if path.is_file()  # reductions are kept in a folder beside the file of a sector
    )
    yield f"## The case\n\n{', '.join(links)}"
    yield f"```{{literalinclude}} ../../{file}\n:language: toml\n```"


def _figures(case: bw.Case) -> list[FigureKind]:
    """Return the figures of a run that the page of the example shows."""
    if case.bladed_disk.superelement is None:
        return [RUN_FIGURES["orbit"]]
    names = ("contact-nodes", "tips", *(["wear-tracks"] if case.casing.coating else []))
    return [RUN_FIGURES[name] for name in names]


def _picture(file: str, words: str) -> str:
    return f"<!-- picture: {file} | {words} -->"


def _console(*commands: str) -> str:
    return "\n".join(["```console", *commands, "```"])

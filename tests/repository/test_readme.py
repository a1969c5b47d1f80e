"""README.md and docs/: short, with code that runs, commands and links that exist, references."""

import re
import shlex
import shutil
import tomllib
from functools import cache
from pathlib import Path

import pytest
import reference
import xarray as xr
from blocks import blocks
from places import ROOT
from typer.main import get_command

import bladewhirl as bw
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.template import template
from bladewhirl.studies.commands.cli import app

README = (ROOT / "README.md").read_text(encoding="utf-8")
DOCS = ROOT / "docs"
DOCUMENTS = sorted([*ROOT.glob("*.md"), *DOCS.glob("*.md")])
FOLDERS = ("reference", "theory", "tutorials")
PAGES = [
    ROOT / "README.md",
    *DOCS.glob("*.md"),
    *(p for f in FOLDERS for p in DOCS.glob(f"{f}/*.md")),
]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


GROUP = cache(lambda: get_command(app))  # all commands; 0.2 s


def code(language: str, text: str = README) -> list[str]:
    """Code blocks of a document."""
    return [block.code for block in blocks(text) if block.language == language]


def commands() -> list[list[str]]:
    """Arguments of every bladewhirl command in code blocks and in running text."""
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    shell = "\n".join([*code("sh", text), *code("console", text)]).replace("\\\n", " ")
    lines = shell.replace("&&", "\n").splitlines()
    split = [shlex.split(line, comments=True) for line in lines]
    actual = [words[1:] for words in split if words and Path(words[0]).name == "bladewhirl"]
    return [list(words) for words in dict.fromkeys(map(tuple, actual))]


def test_it_is_short() -> None:
    assert len(README.splitlines()) <= 130
    assert len(README.split()) <= 900


@pytest.mark.parametrize("arguments", commands(), ids=" ".join)
def test_a_command_is_understood(arguments: list[str]) -> None:
    name, *rest = arguments
    group = GROUP()
    parent = group.make_context("bladewhirl", [name], resilient_parsing=True)
    command = group.get_command(parent, name)  # type: ignore[attr-defined]
    assert command is not None
    command.make_context(name, rest, parent=parent)
    for word in rest:
        if word.startswith("examples/"):
            assert (ROOT / word).is_file()


def test_every_command_has_its_row() -> None:
    group = GROUP()
    assert set(re.findall(r"^\| `bladewhirl ([\w-]+)` \|", README, flags=re.MULTILINE)) == set(
        group.commands  # type: ignore[attr-defined]
    )


def test_the_two_commands_install_run_and_test() -> None:
    install = r"python3 -m venv \.venv && \.venv/bin/pip install -e \S+ && \.venv/bin/"
    run, tests = (block.strip() for block in code("sh"))
    assert re.fullmatch(
        install + r"bladewhirl run examples/imbalance\.toml --set march\.duration=1\.0", run
    )
    assert re.fullmatch(install + r"pytest -n auto", tests)


def test_python_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    [text] = code("python")
    shorter = text.replace("march.duration=0.5", "march.duration=0.02")
    assert shorter != text
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    exec(compile(shorter, "README.md", "exec"))
    run = tmp_path / "runs" / "from_python"
    with xr.open_dataset(run / "result.nc") as result:
        assert result.time[-1] == pytest.approx(0.02)
        assert result.sizes["contact_node"] == 22
    assert (run / "my_orbit.csv").read_text().startswith("time,axis,rotating\n")
    assert (run / "my_orbit.png").is_file()


def test_the_mapping_is_that_of_the_example() -> None:
    block, _ = code("toml", (DOCS / "meshes.md").read_text(encoding="utf-8"))
    shown = tomllib.loads(block)["bladed_disk"]["mesh"]
    example = tomllib.loads((ROOT / "examples" / "shrouded_fan.toml").read_text())
    whole = example["bladed_disk"]["mesh"]
    sections = shown.pop("sections")
    assert shown.items() <= whole.items()
    assert sections.items() <= whole["sections"].items()


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(document: Path) -> None:
    for link in re.findall(r"\]\(([^)]+)\)", document.read_text(encoding="utf-8")):
        file = link.partition("#")[0]
        assert link.startswith("https://") or (document.parent / file).exists(), link


def test_every_file_that_contributors_are_sent_to_is_there() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    paths = re.findall(r"`([\w.]+(?:/[\w.]+)+)`", text)
    assert len(paths) >= 15
    assert [path for path in paths if not (ROOT / path).exists()] == []


def test_every_picture_is_shown() -> None:
    shown = {
        (document.parent / link).resolve()
        for document in DOCUMENTS
        for link in re.findall(r"\]\(([^)]+\.(?:png|gif))\)", document.read_text(encoding="utf-8"))
    }
    kept = [*DOCS.glob("*.png"), *DOCS.glob("*.gif"), *DOCS.glob("paper_figures/*.png")]
    assert shown == {path.resolve() for path in kept}


def test_every_dependency_is_explained() -> None:
    page = (DOCS / "developers.md").read_text(encoding="utf-8")
    table = page[page.index("| package | purpose |") :]
    explained = {
        name
        for row in re.findall(r"^\| ([^|]+) \|", table, re.MULTILINE)
        for name in row.strip().split(", ")
    }
    names = {re.split(r"[\[>]", requirement)[0] for requirement in PROJECT["dependencies"]}
    assert names < explained


TEXTS = {
    path.relative_to(DOCS).with_suffix("").as_posix(): path.read_text(encoding="utf-8")
    for path in sorted(DOCS.rglob("*.md"))
    if not {"built", "gallery"} & set(path.relative_to(DOCS).parts)
}


def test_blocks_that_run_are_on_pages_that_the_site_executes() -> None:
    running = {name for name, text in TEXTS.items() if any(block.runs for block in blocks(text))}
    executed = {name for name, text in TEXTS.items() if text.startswith("---\nexecuted: true\n")}
    assert running == executed


@pytest.mark.parametrize("name", TEXTS)
def test_python_of_a_page_is_python(name: str) -> None:
    for code in (block.code for block in blocks(TEXTS[name]) if block.language == "python"):
        compile(code, name, "exec")


def test_every_key_of_the_template_is_in_the_reference() -> None:
    messages = set(re.findall(r"^```\{confval\} (\S+)", reference.case_keys(), flags=re.MULTILINE))
    table = ""
    for line in template().splitlines():
        if actual := re.match(r"\[(\w+)\]", line):
            table = f"{actual[1]}."
        elif actual := re.match(r"(\w+) = ", line):
            assert table + actual[1] in messages


def arguments_of(name: str) -> list[str]:
    """Arguments of the marks of a generated part on all pages."""
    marks = re.findall(
        rf"^<!-- generated: {name} \| (.*) -->$", "\n".join(TEXTS.values()), re.MULTILINE
    )
    return sorted(argument for mark in marks for argument in mark.split(" | "))


def test_every_table_of_a_case_is_on_one_page() -> None:
    assert arguments_of("case-keys") == sorted(Case.model_fields)


def test_every_public_name_is_on_one_page() -> None:
    tour = reference.sections_of_tour()
    names = [name for title in arguments_of("api") for name in tour[title]]
    assert sorted(names) == sorted({*bw.__all__} - {"__version__", "plot"})


def test_every_command_and_option_is_in_the_reference() -> None:
    text = reference.commands()
    assert len(re.findall(r"^## bladewhirl [\w-]+$", text, flags=re.MULTILINE)) == len(
        app.registered_commands
    )
    assert "```{option} --set KEY=VALUE\n" in text
    assert "```{option} -o, --output <path>\n" in text


@pytest.mark.parametrize("name", [name for name in TEXTS if name.startswith("theory/")])
def test_a_page_of_theory_has_a_picture(name: str) -> None:
    assert "<!-- picture: " in TEXTS[name]


@pytest.mark.parametrize("name", [name for name in TEXTS if name.startswith("theory/")])
def test_the_modules_that_hold_an_equation_exist(name: str) -> None:
    modules = re.findall(r"`(\w+(?:/\w+)+\.py)`", TEXTS[name])
    assert modules
    assert [module for module in modules if not (ROOT / module).is_file()] == []

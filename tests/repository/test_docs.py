"""docs/: code blocks run, and reference pages tell of all that there is."""

import re

import pytest
import reference
from blocks import blocks
from places import ROOT

from bladewhirl.models.case.template import template
from bladewhirl.studies.commands.cli import app

DOCS = ROOT / "docs"
PAGES = {
    path.relative_to(DOCS).with_suffix("").as_posix(): path.read_text(encoding="utf-8")
    for path in sorted(DOCS.rglob("*.md"))
    if not {"built", "gallery"} & set(path.relative_to(DOCS).parts)
}


def test_blocks_that_run_are_on_pages_that_the_site_executes() -> None:
    running = {name for name, text in PAGES.items() if any(block.runs for block in blocks(text))}
    executed = {name for name, text in PAGES.items() if text.startswith("---\nexecuted: true\n")}
    assert running == executed


def test_every_key_of_the_template_is_in_the_reference() -> None:
    messages = set(re.findall(r"^```\{confval\} (\S+)", reference.case_keys(), flags=re.MULTILINE))
    table = ""
    for line in template().splitlines():
        if actual := re.match(r"\[(\w+)\]", line):
            table = f"{actual[1]}."
        elif actual := re.match(r"(\w+) = ", line):
            assert table + actual[1] in messages


def test_every_command_and_option_is_in_the_reference() -> None:
    text = reference.commands()
    assert len(re.findall(r"^## bladewhirl [\w-]+$", text, flags=re.MULTILINE)) == len(
        app.registered_commands
    )
    assert "```{option} --set KEY=VALUE\n" in text
    assert "```{option} -o, --output <path>\n" in text


@pytest.mark.parametrize("name", [name for name in PAGES if name.startswith("theory/")])
def test_the_modules_that_hold_an_equation_exist(name: str) -> None:
    modules = re.findall(r"`(\w+(?:/\w+)+\.py)`", PAGES[name])
    assert modules
    assert [module for module in modules if not (ROOT / module).is_file()] == []

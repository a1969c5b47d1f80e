"""The table of rules between keys: every rule is used, and every name in it exists."""

import ast
import builtins
import inspect
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import bladewhirl.models.case
from bladewhirl.models.case import bladed_disk
from bladewhirl.models.case.bladed_disk import BladedDisk
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.check import tables_in
from bladewhirl.models.case.excitation import EXCITATIONS
from bladewhirl.models.case.superelement import SuperelementTable
from bladewhirl.models.inputs import rules
from bladewhirl.models.inputs.rules import Rule, broken, sections
from bladewhirl.models.inputs.table import Table


def tables(table: type[Table]) -> Iterator[type[Table]]:
    """Yield a table class with its bases and all tables in it."""
    yield from table.__mro__[: table.__mro__.index(Table)]
    for field in table.model_fields.values():
        for inner in tables_in(field.annotation):
            yield from tables(inner)


CLASSES = {kind.__name__: kind for kind in tables(Case)}
SCOPES: dict[str, tuple[type[Table], ...]] = {
    "Excitation": (*EXCITATIONS.values(), Case),
    "Case of a superelement": (SuperelementTable, Case),
}


def known(heading: str) -> set[str]:
    """Return all names that expressions under a heading may have."""
    scopes = SCOPES.get(heading) or (CLASSES[heading.split()[0]],)
    names = {*vars(builtins), *vars(rules), "each"}
    for scope in scopes:
        names |= {*scope.model_fields, *dir(scope), *vars(sys.modules[scope.__module__])}
    return names


@pytest.mark.parametrize("heading", sections())
def test_every_name_exists(heading: str) -> None:
    for rule in sections()[heading].rules:
        trees = [ast.parse(text) for text in (rule.condition, f"f{rule.expected!r}")]
        names = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Name)]
        bound = {node.id for node in names if isinstance(node.ctx, ast.Store)}
        assert {node.id for node in names} - bound <= known(heading), rule


def test_every_heading_is_evaluated() -> None:
    folder = Path(inspect.getfile(bladewhirl.models.case)).parent
    code = "".join(path.read_text(encoding="utf-8") for path in folder.glob("*.py"))
    unused = [name for name in sections() if name not in CLASSES and f'broken("{name}"' not in code]
    assert not unused


def test_a_rule_names_the_key_and_the_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    row = Rule("{each}_radius", '["tip", "disk"] if blades > 3 else None', "{each} of {blades:g}")
    monkeypatch.setitem(sections(), "Fans", rules.Section("", [row]))
    found = [fault[:2] for fault in broken("Fans", BladedDisk(blades=5), bladed_disk)]
    assert found == [("tip_radius", "tip of 5"), ("disk_radius", "disk of 5")]
    assert not [*broken("Fans", BladedDisk(blades=3), bladed_disk)]

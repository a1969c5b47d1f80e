"""Rules between keys of a case: the table rules.txt in the folder of this module.

A heading [NAME], with a remark, begins the rules of a class of tables, or of a call of `broken`;
NAME then begins with that of the class. Each row has a key, a condition under which its value is
refused, and the text that completes "expected ...", or a complete text, "not allowed ...",
separated by " | ". Conditions, and what the text has in braces, are expressions of Python. If the
key contains {each}, the condition is a list of names, each of which is a fault.
"""

import ast
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from importlib import resources
from itertools import combinations, pairwise
from math import tau
from types import CodeType
from typing import Any, NamedTuple

SAME_ANGLE = 1e-9  #: difference up to which two angles count as equal [rad]

MISSING = object()


class Rule(NamedTuple):
    """A row of the table."""

    key: str
    condition: str
    expected: str


class _Compiled(NamedTuple):
    condition: CodeType
    expected: CodeType
    names: frozenset[str]  #: names in both, those of comprehensions included


class Inconsistency(NamedTuple):
    """Contradiction between values that are valid by themselves; keys are relative to the table."""

    key: str  #: key to report; a row of an array is a number, as in "sensor.0.blade"
    expected: str  #: text that completes "expected ...", or a complete text, "not allowed ..."
    value: object = None  #: value to show in place of the value of `key`
    place: str = ""  #: name of a part of the table that has no key, shown in place of a key


class Section(NamedTuple):
    """Rules under a heading."""

    remark: str
    rules: list[Rule]


@cache
def sections() -> Mapping[str, Section]:
    """Return all rules, by the names in the headings."""
    found: dict[str, Section] = {}
    text = resources.files(__package__).joinpath("rules.txt").read_text(encoding="utf-8")
    for line in text.splitlines():
        if line.startswith("["):
            name, remark = line[1:].split("]")
            found[name] = Section(remark.strip(), [])
        elif line:
            found[name].rules.append(Rule(*line.split(" | ")))
    return found


def broken(heading: str, *scopes: object) -> Iterator[Inconsistency]:
    """Yield the rules under a heading that values break.

    Args:
        heading: heading in the table; there may be none of that name.
        scopes: tables and modules whose attributes are the names in the expressions; the first one
            that has a name counts, and this module is the last one. All names of a rule are looked
            up before its condition is evaluated.
    """
    for rule in sections()[heading].rules if heading in sections() else ():
        code = _compiled(rule)
        names: dict[str, Any] = {}
        for name in code.names:
            for scope in (*scopes, sys.modules[__name__]):
                if (value := getattr(scope, name, MISSING)) is not MISSING:
                    names[name] = value
                    break
        found = eval(code.condition, names)  # of the table in this folder, not of a user
        for each in (found or ()) if "{each}" in rule.key else [""] * bool(found):
            names["each"] = each
            yield Inconsistency(rule.key.replace("{each}", each), eval(code.expected, names))


def ascending(values: Iterable[float]) -> bool:
    """Return whether each value is larger than the one before it."""
    return all(one < other for one, other in pairwise(values))


def apart(angles: Iterable[float]) -> bool:
    """Return whether angles [rad] are different places on a circle."""
    places = sorted(angle % tau for angle in angles)
    return all(b - a > SAME_ANGLE for a, b in pairwise([*places, *(p + tau for p in places[:1])]))


def among(numbers: Collection[int], count: int) -> bool:
    """Return whether numbers are below a count, and each occurs once."""
    return max(numbers, default=-1) < count and len(set(numbers)) == len(numbers)


def pairs(rows: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
    """Return all pairs of rows."""
    return combinations(rows, 2)


@cache
def _compiled(rule: Rule) -> _Compiled:
    condition = ast.parse(rule.condition, mode="eval")
    expected = ast.parse(f"f{rule.expected!r}", mode="eval")
    nodes = (*ast.walk(condition), *ast.walk(expected))
    return _Compiled(
        condition=compile(condition, rule.key, "eval"),
        expected=compile(expected, rule.key, "eval"),
        names=frozenset(node.id for node in nodes if isinstance(node, ast.Name)),
    )

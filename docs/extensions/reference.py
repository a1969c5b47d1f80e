"""Reference pages in Markdown, generated from the program."""

import ast
import inspect
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Annotated, Any

import licences
import trials
import typer
from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo
from typer.core import TyperGroup
from typer.main import get_command

import bladewhirl as bw
from bladewhirl.meshes.files import (
    abaqus_faces,
    abaqus_keywords,
    abaqus_reader,
    ansys,
    ansys_materials,
    ansys_text,
    nastran_bulk,
)
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.check import FIXED_PHRASES, KINDS, TABLE_ERRORS, tables_in
from bladewhirl.models.inputs.errors import toml_value
from bladewhirl.models.inputs.rules import Rule, Section, sections
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.inputs.units import Speed
from bladewhirl.postprocess.plotting.registry import (
    BRANCH_FIGURES,
    RUN_FIGURES,
    SWEEP_FIGURES,
    FigureKind,
)
from bladewhirl.solvers.march.schema import RESULT, SUMMARY, SWEEP, schema_table
from bladewhirl.studies.commands.cli import app
from bladewhirl.studies.runs.outputs import Run
from bladewhirl.studies.sweeps.sweep import Sweep

PHRASES = (
    FIXED_PHRASES
    | dict.fromkeys(TABLE_ERRORS, "a table")
    | dict.fromkeys(["tuple_type", "list_type"], "an array")
)
"""Description of the expected value, for types of pydantic errors that do not describe it."""


def case_keys(*names: str) -> str:
    """Return the keys of tables of a case, or of all tables, each with expected value, default and
    description.

    Raises:
        KeyError: a case has no such table.
    """
    parts: list[str] = []
    for name in names or Case.model_fields:
        field = Case.model_fields[name]
        tables = [] if name == "sketch" else list(tables_in(field.annotation))
        kinds: dict[type[Table], str] = dict.fromkeys(tables, "")
        kinds |= {table: kind for kind, table in KINDS.get(name, {}).items()}
        parts += [] if kinds else _entries(Case, "", "", [name])
        for table, kind in kinds.items():
            title = f"{name}, type {kind}" if kind else name
            parts.append(f"## [{title}]\n\n{_words(_summary(table))}\n\n")
            suffix = f" ({kind})" if kind else ""
            parts += _entries(table, name, suffix, table.model_fields)
    return "".join(parts)


def rules() -> str:
    """Return a table of the rules between keys for each table of a case."""
    places: dict[str, list[str]] = {"Case": [""], "Excitation": ["excitation"]}
    for key, kinds in KINDS.items():
        places |= {table.__name__: [f"{key}, type {kind}"] for kind, table in kinds.items()}
    _find_places(Case, "", places)
    return "".join(_rules(name, section, places) for name, section in sections().items())


def _find_places(table: type[Table], place: str, places: dict[str, list[str]]) -> None:
    """Add the dotted keys of all tables in a table, by the names of their classes and bases."""
    for attribute, field in table.model_fields.items():
        key = f"{place}.{field.alias or attribute}".removeprefix(".")
        for inner in tables_in(field.annotation):
            for kind in inner.__mro__[: inner.__mro__.index(Table)]:
                known = places.setdefault(kind.__name__, [])
                if not any(place.startswith(f"{key},") or place == key for place in known):
                    known.append(key)
            _find_places(inner, key, places)


def _rules(name: str, section: Section, places: Mapping[str, list[str]]) -> str:
    kind, _, rest = name.partition(" ")
    title = ", ".join(places[kind]).strip() or "Between tables"
    rows = (
        f"| `{rule.key.replace('{each}', 'KEY')}` | `{rule.condition}` | {_expectation(rule)} |\n"
        for rule in section.rules
    )
    remark = f"{section.remark}.\n\n" if section.remark else ""
    table = "| key | refused if | expected |\n|---|---|---|\n" + "".join(rows)
    return f"## {title}{f' {rest}' * bool(rest)}\n\n{remark}{table}\n"


def _expectation(rule: Rule) -> str:
    """Return what a rule expects, with the expressions in the text as code."""
    text = ast.parse(f"f{rule.expected!r}", mode="eval").body
    return "".join(
        f"`{ast.unparse(part.value)}`"
        if isinstance(part, ast.FormattedValue)
        else re.sub(r"([*_<>\[\]$#|{}])", r"\\\1", ast.literal_eval(part))
        for part in (text.values if isinstance(text, ast.JoinedStr) else [text])
    )


def _entries(table: type[Table], place: str, suffix: str, names: Iterable[str]) -> Iterator[str]:
    descriptions = table.descriptions()
    for name in names:
        field = table.model_fields[name]
        key = f"{place}.{name}" if place else name
        yield _entry(key + suffix, field, descriptions.get(name, ""))
        for row in tables_in(field.annotation) if name != "sketch" else ():
            listed = "tuple" in str(field.annotation)
            yield from _entries(row, f"{key}[]" if listed else key, suffix, row.model_fields)


def _entry(key: str, field: FieldInfo, described: str) -> str:
    described = described or _summary(next(tables_in(field.annotation), ""))
    lines = [f"```{{confval}} {key}", f":type: {_quoted(_words(_expected(field)))}"]
    lines.append(f":default: {_quoted(_default(field))}")
    return "\n".join([*lines, "", _words(described), "```", "", ""])


def _quoted(text: str) -> str:
    """Return a text in quotes, as value of an option of a Sphinx directive."""
    return "'" + text.replace("'", "''") + "'"


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "none; the key is required"
    value = field.get_default(call_default_factory=True)
    if isinstance(value, Speed):
        value = value.given
    if value is None or value == ():
        return "left out"
    if isinstance(value, Table):
        value = value.model_dump(exclude_none=True)
    return f"`{toml_value(value)}`"


def _expected(field: FieldInfo) -> str:
    hint: Any = field.annotation
    if field.metadata:
        hint = Annotated[(hint, *field.metadata)]
    try:
        TypeAdapter(hint).validate_python(object())
    except ValidationError as error:
        return _phrase(error.errors()[0])
    return "anything"


def _phrase(error: Any) -> str:
    """Return the description of the value that a pydantic error expected."""
    if phrase := PHRASES.get(error["type"]):
        return phrase
    return re.sub(r" \(neither.*\)", "", str(error["ctx"]["expected"]).replace("'", '"'))


def _summary(thing: object) -> str:
    return (inspect.getdoc(thing) or "").splitlines()[0]


def _words(text: str) -> str:
    """Return text as one line of Markdown with escaped markup."""
    return re.sub(
        r"(?<!`)([*_<>\[\]$#|{}])(?!`)", r"\\\1", " ".join(text.replace(r"\[", "[").split())
    )


def commands() -> str:
    """Return all commands with arguments and options, described as by `--help`."""
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    return "".join(map(_command, group.commands.values()))


def _command(command: Any) -> str:
    name = f"bladewhirl {command.name}"
    context = typer.Context(command, info_name=name)
    usage = command.get_usage(context).removeprefix("Usage: ")
    described = "\n\n".join(_words(part) for part in command.help.split("\n\n"))
    parts = [f"## {name}\n\n```text\n{usage}\n```\n\n{described}\n\n```{{program}} {name}\n```\n\n"]
    for parameter in command.params:
        names, text = parameter.get_help_record(context)
        if parameter.param_type_name == "argument":
            (usage,) = parameter.get_usage_pieces(context)
            parts.append(f"`{usage}`: {_words(text)}\n\n")
        else:
            listed = names.replace(" / ", ", ")
            parts.append(f"```{{option}} {listed}\n\n{_words(text)}\n```\n\n")
    return "".join(parts)


def figures(kinds: Mapping[str, FigureKind], *, drawn: bool) -> str:
    """Return name, function and caption of each figure, with a picture if `drawn`."""
    return "".join(_figure(kind, drawn=drawn) for kind in kinds.values())


def _figure(kind: FigureKind, *, drawn: bool) -> str:
    picture = ""
    if drawn:
        picture = f"<!-- picture: runs/figures/plots/{kind.name}.png | {kind.title} -->\n\n"
    function = kind.name.replace("-", "_")
    called = f"`bladewhirl plot DIR {kind.name}`"
    if function in bw.plot.__all__:
        called += f", `bw.plot.{function}`"
    return f"### {kind.title}\n\n{called}\n\n{_words(kind.caption)}\n\n{picture}"


def api(title: str) -> str:
    """Return directives that document the public names under a title of the docstring of
    bladewhirl.

    Raises:
        KeyError: the docstring has no such title.
    """
    names = sections_of_tour()[title]
    parts = [_documented(f"bladewhirl.{name}", getattr(bw, name)) for name in names]
    return "".join([f"## {title}\n\n```{{eval-rst}}\n", *parts, "```\n"])


def sections_of_tour() -> dict[str, list[str]]:
    """Return the public names in the docstring of bladewhirl, in its order, by the titles there."""
    parts = re.findall(r"^(\w.*)\n((?:    .*\n)+)", inspect.getdoc(bw) or "", re.MULTILINE)
    return {
        title: [
            name for name in re.findall(r"`(\w+)`", text) if name in bw.__all__ and name != "plot"
        ]
        for title, text in parts
    }


def outcomes() -> str:
    """Return directives that document what runs and sweeps return."""
    documented = (
        f".. autoclass:: {kind.__module__}.{kind.__name__}()\n   :members:\n\n"
        for kind in (Run, Sweep)
    )
    return "".join(["```{eval-rst}\n", *documented, "```\n"])


def figure_functions() -> str:
    """Return directives that document the functions of `bladewhirl.plot`."""
    documented = (
        f".. autofunction:: bladewhirl.plot.{name}\n\n" for name in sorted(bw.plot.__all__)
    )
    return "".join(["```{eval-rst}\n.. automodule:: bladewhirl.plot\n\n", *documented, "```\n"])


def _documented(name: str, thing: Any) -> str:
    if not inspect.isclass(thing):
        return f".. autofunction:: {name}\n\n"
    if issubclass(thing, Table):  # its fields are keys of the case file
        return f".. autoclass:: {name}(**keys)\n   :no-members:\n\n"
    options = "   :members:\n" if thing.__name__ == "Sketch" else ""
    return f".. autoclass:: {name}\n{options}\n"


def decks() -> str:
    """Return a table of what is read from each format of decks, taken from the readers."""
    keywords = {
        str(node.value.value)
        for node in ast.walk(ast.parse(inspect.getsource(abaqus_reader)))
        if isinstance(node, ast.MatchValue) and isinstance(node.value, ast.Constant)
    }
    rows = {
        "Abaqus, CalculiX": (
            abaqus_faces.SOLIDS,
            keywords,
            abaqus_keywords.HARMLESS,
            abaqus_keywords.CHANGES_THE_MESH,
        ),
        "Ansys": (
            [f"SOLID{number}" for number in ansys.SOLIDS],
            [*ansys_text.USED.values(), *ansys_materials.CONSTANTS],
            ansys_text.HARMLESS,
            ansys_text.COMMANDS,
        ),
        "Nastran": (
            nastran_bulk.CELLS,
            [name for name in nastran_bulk.USED if name not in nastran_bulk.CELLS],
            nastran_bulk.HARMLESS,
            (*nastran_bulk.OTHER_SOLIDS, "INCLUDE"),
        ),
    }
    heads = ("elements of solids", "other entries that are read", "harmless", "refused")
    parts = []
    for name, listed in rows.items():
        parts.append(f"{name}\n")
        for head, names in zip(heads, listed, strict=True):
            parts.append(f": {head}: {', '.join(f'`{one}`' for one in sorted(names))}\n")
        parts.append("")
    return "\n".join(parts)


GENERATED: dict[str, Callable[..., str]] = {
    "decks": decks,
    "case-keys": case_keys,
    "rules": rules,
    "studies": trials.table,
    "commands": commands,
    "results": partial(schema_table, RESULT),
    "sweeps": partial(schema_table, SWEEP),
    "summary": partial(schema_table, SUMMARY),
    "run-figures": partial(figures, RUN_FIGURES, drawn=True),
    "sweep-figures": partial(figures, SWEEP_FIGURES, drawn=False),
    "branch-figures": partial(figures, BRANCH_FIGURES, drawn=True),
    "api": api,
    "outcomes": outcomes,
    "figure-functions": figure_functions,
    "licences": licences.table,
}
"""Functions that return parts of pages, by the name in `<!-- generated: NAME | ARGUMENT -->`."""

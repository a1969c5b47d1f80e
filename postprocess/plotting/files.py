"""Files of pictures and pages: their names and templates, written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path

from jinja2 import Environment, StrictUndefined

from bladewhirl.postprocess.fields.fields import ViewError


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """A draft beside the target that takes its place when complete and goes when it fails."""
    target.parent.mkdir(parents=True, exist_ok=True)
    draft = target.with_name(f".{target.stem}.part{target.suffix}")
    try:
        yield draft
        os.replace(draft, target)
    finally:
        draft.unlink(missing_ok=True)


def checked_target(path: str | Path, *suffixes: str) -> Path:
    """The path, if it ends in one of the suffixes; else ViewError."""
    target = Path(path)
    if target.suffix.lower() not in suffixes:
        raise ViewError(f"{target} must end in {' or '.join(suffixes)}")
    return target


def filled_template(room: str, name: str, **values: object) -> str:
    """A page from its template: a file in a package, in the language of jinja2; text is escaped.

    Raises:
        jinja2.UndefinedError: the template asks for a value that is not given.
    """
    source = resources.files(room).joinpath(name).read_text("utf-8")
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False}
    return environment.from_string(source).render(**values)

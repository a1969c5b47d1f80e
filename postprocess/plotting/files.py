"""Files of pictures and pages: their names and templates."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from jinja2 import Environment, StrictUndefined

from bladewhirl.postprocess.fields.kinematics import ViewError


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

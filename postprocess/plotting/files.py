"""Files of pictures and pages: their names and templates."""

from __future__ import annotations

import base64
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, StrictUndefined

from bladewhirl.postprocess.fields.kinematics import ViewError


def checked_target(path: str | Path, *suffixes: str) -> Path:
    """The path, if it ends in one of the suffixes; else ViewError."""
    target = Path(path)
    if target.suffix.lower() not in suffixes:
        raise ViewError(f"{target} must end in {' or '.join(suffixes)}")
    return target


def filled_template(room: str, name: str, **values: object) -> str:
    """A page from its template: a file in a package, in the language of jinja2.

    Text is escaped; what goes through `tojson` may stand in a script, arrays in it as `packed`.

    Raises:
        jinja2.UndefinedError: the template asks for a value that is not given.
    """
    source = resources.files(room).joinpath(name).read_text("utf-8")
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "default": packed}
    return environment.from_string(source).render(**values)


def packed(values: Any) -> Any:
    """An array as Plotly reads it: its bytes as text, with type and shape.

    Args:
        values: of numbers; whole ones below 2^31; others are of 4 bytes if of two axes or more.
    """
    if values.dtype.kind not in "fiu":
        return values.tolist()
    if values.dtype == np.int64:
        values = values.astype(np.int32)
    if values.dtype == np.float64 and values.ndim > 1:
        values = values.astype(np.float32)
    return {
        "dtype": values.dtype.str[1:],
        "bdata": base64.b64encode(values.tobytes()).decode("ascii"),
        "shape": ", ".join(map(str, values.shape)),
    }

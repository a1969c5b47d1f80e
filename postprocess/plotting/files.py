"""Suffixes of output files, and HTML pages from templates."""

import base64
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, StrictUndefined

from bladewhirl.postprocess.fields.kinematics import ViewError


def checked_target(path: str | Path, *suffixes: str) -> Path:
    """Return the path if it ends in one of the suffixes; raise ViewError otherwise."""
    target = Path(path)
    if target.suffix.lower() not in suffixes:
        raise ViewError(f"{target} must end in {' or '.join(suffixes)}")
    return target


def filled_template(package: str, name: str, **values: object) -> str:
    """Return an HTML page from a jinja2 template, the file `name` in a package.

    Text is escaped. The filter `tojson` makes values safe in scripts; `packed` converts arrays.

    Raises:
        jinja2.UndefinedError: a value of the template is missing.
    """
    source = resources.files(package).joinpath(name).read_text("utf-8")
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "default": packed}
    return environment.from_string(source).render(**values)


def packed(values: Any) -> Any:
    """Return an array in the format of Plotly: the bytes in base64, the type and the shape.
    Integers must be below 2^31; floating-point numbers in two or more axes become float32."""
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
